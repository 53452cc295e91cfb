//! OpenStreetMap PBF: building outlines raised by their height, lamps, trees, streets, water.
//!
//! Based on: the OpenStreetMap wiki, "PBF Format", "Simple 3D Buildings", "Relation:multipolygon".

mod blocks;
mod projection;
mod rings;
mod streets;
mod tags;
mod wire;

use super::assemble::{Draft, DraftBuilding, STOREY_M};
use super::{Source, Tally};
use crate::SceneError;
use crate::city::{Footprint, Ground, GroundKind, StreetLamp, Tree};
use blocks::{Data, Relation, Tags};
use glam::{DVec2, DVec3, Vec3};
use projection::Projection;

/// Height of a lamp without a tag.
const LAMP_M: f64 = 6.0;
/// Radiant intensity of a lamp: warm white.
const LAMP_INTENSITY: Vec3 = Vec3::new(60.0, 42.0, 24.0);
/// Height of a tree without a tag.
const TREE_M: f64 = 8.0;
/// A crown's radius as a share of the tree's height.
const CROWN_OF_HEIGHT: f64 = 0.3;
/// Height of buildings in a file that tells no building's height.
const BUILDING_M: f64 = 2.0 * STOREY_M;
/// Corners that bend an outline by less are left out, metres.
const STRAIGHT_M: f64 = 1e-3;
/// Farthest from the middle that a place may lie: a plane is no map of a country.
const MOST_DEG: f64 = 1.0;
/// Heights of what lies flat, metres: apart, so that nothing lies in one plane with another.
const WATER_M: f64 = 0.02;

/// Reads a file.
pub fn parse(source: &Source<'_>) -> Result<Draft, SceneError> {
    let data = blocks::read(source)?;
    let (middle, farthest) = extent(source, &data)?;
    let projection = Projection::new(middle);
    let mut reader = Reader {
        source,
        data: &data,
        projection,
        tally: Tally::default(),
        draft: Draft::default(),
    };
    reader.draft.projection = format!(
        "The plane that touches WGS 84 at latitude {:.6}, longitude {:.6}; lengths within the extent \
         are at most {:.1e} of themselves too short.",
        middle.x,
        middle.y,
        reader.projection.scale_error(farthest)
    );
    reader.buildings();
    reader.points();
    reader.water();
    streets::add(&mut reader);
    streets::add_land(&mut reader.draft);
    let Reader { tally, mut draft, .. } = reader;
    draft.warnings.extend(tally.sentences(source.file, "are left out"));
    Ok(draft)
}

/// The middle of what is read, and the corner of its bounds farthest from it; degrees.
fn extent(source: &Source<'_>, data: &Data) -> Result<(DVec2, DVec2), SceneError> {
    let shown = |tags: &Tags| tags.contains_key("building");
    let of_relations = data.relations.values().filter(|r| shown(&r.tags));
    let members = of_relations.flat_map(|r| &r.members).filter_map(|m| data.ways.get(&m.way));
    let ways = data.ways.values().filter(|w| shown(&w.tags)).chain(members);
    let corners = ways.flat_map(|w| &w.nodes).chain(data.points.keys());
    let mut bounds = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for place in corners.filter_map(|id| place_deg(data, *id)) {
        bounds = [bounds[0].min(place), bounds[1].max(place)];
    }
    let [lo, hi] = bounds;
    if lo.x > hi.x {
        let reason = "no building, lamp or tree with a place; a city needs one";
        return Err(source.error("file", reason));
    }
    let middle = 0.5 * (lo + hi);
    let across = 0.5 * (hi - lo).max_element();
    if across > MOST_DEG {
        let reason = format!(
            "buildings, lamps and trees lie up to {across:.2} degrees from their middle, at most \
             {MOST_DEG} is allowed: cut out a district"
        );
        return Err(source.error("extent", reason));
    }
    // Meridians lie farthest apart nearest the equator.
    let latitude = if lo.x.abs() < hi.x.abs() { lo.x } else { hi.x };
    Ok((middle, DVec2::new(latitude, hi.y)))
}

fn place_deg(data: &Data, node: i64) -> Option<DVec2> {
    data.nodes.get(&node).map(|n| DVec2::new(n[0] as f64, n[1] as f64) * 1e-9)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    data: &'a Data,
    projection: Projection,
    tally: Tally,
    draft: Draft,
}

/// An outline on the way to a building.
struct Outline<'a> {
    id: String,
    footprint: Footprint,
    tags: &'a Tags,
}

impl<'a> Reader<'a> {
    /// Places of a list of nodes.
    fn places(&self, nodes: &[i64]) -> Result<Vec<DVec2>, &'static str> {
        let place = |id: &i64| {
            let degrees = place_deg(self.data, *id)?;
            Some(self.projection.place(degrees))
        };
        nodes
            .iter()
            .map(place)
            .collect::<Option<_>>()
            .ok_or("with nodes that the file does not hold")
    }

    fn buildings(&mut self) {
        let outlines = self.outlines("buildings", |tags| match tags.get("building") {
            None => false,
            Some(value) => {
                let under = tags.get("location").is_some_and(|l| l == "underground");
                value != "no" && !under
            }
        });
        let height = |tags: &Tags| {
            let levels = || tags.get("building:levels").and_then(|t| tags::levels(t));
            let metres = tags.get("height").and_then(|t| tags::length_m(t));
            metres.or_else(|| levels().map(|n| n * STOREY_M))
        };
        let mut known: Vec<f64> = outlines.iter().filter_map(|o| height(o.tags)).collect();
        known.sort_by(f64::total_cmp);
        let median = known.get(known.len() / 2).copied().unwrap_or(BUILDING_M);
        let guessed = outlines.len() - known.len();
        if guessed > 0 {
            let whence = match known.len() {
                0 => "none has one".to_string(),
                n => format!("the median of the {n} that have one"),
            };
            let file = self.source.file;
            self.draft.warnings.push(format!(
                "{file}: {guessed} buildings without height or levels are {median} m high: {whence}"
            ));
        }
        for Outline { id, footprint, tags } in outlines {
            let top = height(tags).unwrap_or(median);
            let base_m = tags.get("min_height").and_then(|t| tags::length_m(t)).unwrap_or(0.0);
            let base_m = if base_m < top { base_m } else { 0.0 };
            let levels = tags.get("building:levels").and_then(|t| tags::levels(t));
            self.draft.buildings.push(DraftBuilding {
                id,
                footprint,
                base_m,
                eaves_m: top,
                storeys: levels.map(|n| n.ceil() as u32),
                roof: None,
                gables: vec![],
            });
        }
    }

    /// Closed ways and multipolygons with such tags. What cannot be used is counted.
    fn outlines(&mut self, what: &str, wanted: impl Fn(&Tags) -> bool) -> Vec<Outline<'a>> {
        let data = self.data;
        let mut outlines = vec![];
        let mut repeated = std::collections::BTreeSet::new();
        for (id, relation) in data.relations.iter().filter(|(_, r)| wanted(&r.tags)) {
            if relation.tags.get("type").is_none_or(|t| t != "multipolygon") {
                continue;
            }
            repeated.extend(relation.members.iter().map(|m| m.way));
            match self.multipolygon(relation) {
                Ok(found) => {
                    let many = found.len() > 1;
                    for (i, footprint) in found.into_iter().enumerate() {
                        let id = if many {
                            format!("relation/{id}/{i}")
                        } else {
                            format!("relation/{id}")
                        };
                        outlines.push(Outline { id, footprint, tags: &relation.tags });
                    }
                }
                Err(reason) => self.tally.add(format!("{what} (relations) {reason}")),
            }
        }
        for (id, way) in data.ways.iter().filter(|(_, w)| wanted(&w.tags)) {
            if repeated.contains(id) {
                self.tally.add(format!("{what} (ways) that a relation repeats"));
                continue;
            }
            let made = match way.nodes.split_last() {
                Some((last, rest)) if rest.first() == Some(last) => {
                    self.places(rest).and_then(|ring| Footprint::new(&ring, &[], STRAIGHT_M))
                }
                _ => Err("that are not closed"),
            };
            match made {
                Ok(footprint) => {
                    let id = format!("way/{id}");
                    outlines.push(Outline { id, footprint, tags: &way.tags });
                }
                Err(reason) => self.tally.add(format!("{what} (ways) {reason}")),
            }
        }
        outlines
    }

    /// One footprint an outer ring, with the inner rings that lie in it.
    fn multipolygon(&self, relation: &Relation) -> Result<Vec<Footprint>, &'static str> {
        let rings = |inner: bool| {
            let members = relation.members.iter().filter(|m| m.inner == inner);
            let ways = members
                .map(|m| self.data.ways.get(&m.way).map(|w| &w.nodes[..]))
                .collect::<Option<Vec<_>>>()
                .ok_or("with members that the file does not hold")?;
            rings::join(&ways)?.iter().map(|ring| self.places(ring)).collect::<Result<Vec<_>, _>>()
        };
        let (outers, mut holes) = (rings(false)?, rings(true)?);
        let mut found = vec![];
        for outer in &outers {
            let alone = Footprint::new(outer, &[], STRAIGHT_M)?;
            let (own, rest) = holes
                .into_iter()
                .partition(|hole: &Vec<DVec2>| hole.first().is_some_and(|p| alone.contains(*p)));
            holes = rest;
            found.push(Footprint::new(outer, &own, STRAIGHT_M)?);
        }
        match (found.is_empty(), holes.is_empty()) {
            (true, _) => Err("without an outer ring"),
            (_, false) => Err("whose courtyards lie outside"),
            _ => Ok(found),
        }
    }

    fn points(&mut self) {
        let (mut lamps, mut trees) = (0u64, 0u64);
        for (&id, tags) in &self.data.points {
            let Some(place) = place_deg(self.data, id) else { continue };
            let place = self.projection.place(place);
            let height = tags.get("height").and_then(|t| tags::length_m(t));
            if tags.get("highway").is_some_and(|h| h == "street_lamp") {
                lamps += u64::from(height.is_none());
                self.draft.lamps.push(StreetLamp {
                    position: DVec3::new(place.x, height.unwrap_or(LAMP_M), place.y),
                    intensity: LAMP_INTENSITY,
                });
            }
            if tags.get("natural").is_some_and(|n| n == "tree") {
                trees += u64::from(height.is_none());
                let height_m = height.unwrap_or(TREE_M);
                let crown = tags.get("diameter_crown").and_then(|t| tags::length_m(t));
                self.draft.trees.push(Tree {
                    position: DVec3::new(place.x, 0.0, place.y),
                    height_m,
                    crown_radius_m: crown.map_or(CROWN_OF_HEIGHT * height_m, |d| 0.5 * d),
                });
            }
        }
        let file = self.source.file;
        for (count, what, metres) in [(lamps, "street lamps", LAMP_M), (trees, "trees", TREE_M)] {
            if count > 0 {
                let sentence = format!("{file}: {count} {what} without height are {metres} m high");
                self.draft.warnings.push(sentence);
            }
        }
    }

    fn water(&mut self) {
        for outline in self.outlines("waters", |t| t.get("natural").is_some_and(|n| n == "water")) {
            match super::assemble::flat(&outline.footprint, WATER_M) {
                Ok(triangles) => {
                    self.draft.grounds.push(Ground { kind: GroundKind::Water, triangles });
                }
                Err(reason) => self.tally.add(format!("waters {reason}")),
            }
        }
    }
}
