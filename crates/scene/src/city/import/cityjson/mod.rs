//! CityJSON 1.0 to 2.0: solids and surfaces of the highest level of detail that each object has.
//!
//! Based on: Ledoux et al., "CityJSON: a compact and easy-to-use encoding of the CityGML data
//! model", 2019, and its specification 2.0.1. Parsed by `serde_json` into plain structures: the
//! crates for CityJSON read version 2.0 alone.
//!
//! A building is its outline raised: walls are upright from its lowest point to the lowest corner of
//! its roof, roof and gables are the file's own. East becomes +x, north -z.

mod building;
mod model;
mod outline;
mod surface;

use super::Source;
use super::assemble::Draft;
use crate::city::import::Tally;
use crate::city::{Ground, GroundKind, Tree};
use crate::{MAX_COORDINATE_M, SceneError};
use glam::{DVec2, DVec3};
use model::{File, Geometry, Head, Object};
use std::collections::BTreeMap;
use surface::Surface;

/// Where a tree's geometry does not say how large it is.
const TREE_HEIGHT_M: f64 = 8.0;
/// A crown's share of the tree's height, where nothing says how wide it is.
const CROWN_OF_HEIGHT: f64 = 0.3;

/// Reads a file.
pub fn parse(source: &Source<'_>) -> Result<Draft, SceneError> {
    let file = read(source)?;
    let crs = file.metadata.reference_system.as_deref();
    if let Some(crs) = crs.filter(|c| in_degrees(c)) {
        let reason = format!("\"{crs}\" counts in degrees; a system in metres is needed");
        return Err(source.error("metadata, referenceSystem", reason));
    }
    check_parents(source, &file.objects)?;
    let stored = world(source, &file)?;
    let reader = Reader::new(source, &file, stored);
    reader.draft(crs)
}

fn read(source: &Source<'_>) -> Result<File, SceneError> {
    let bad = |e: serde_json::Error| {
        let place = format!("line {}, column {}", e.line(), e.column());
        source.error(place, e)
    };
    let head: Head = serde_json::from_slice(source.bytes).map_err(bad)?;
    match head.kind.as_ref().and_then(|k| k.as_str()) {
        Some("CityJSON") => {}
        Some("CityJSONFeature") => {
            let reason = "a sequence of features is not read; join them into one CityJSON";
            return Err(source.error("type", reason));
        }
        _ => return Err(source.error("type", "not \"CityJSON\"; other JSON is not read here")),
    }
    let version = head.version.as_ref().and_then(|v| v.as_str()).unwrap_or("");
    if !model::VERSIONS.iter().any(|known| version.starts_with(known)) {
        let reason = format!("\"{version}\" is not one of {}", model::VERSIONS.join(", "));
        return Err(source.error("version", reason));
    }
    serde_json::from_slice(source.bytes).map_err(bad)
}

/// Codes of EPSG's geographic systems lie from 4000 to 4999; OGC has CRS84.
fn in_degrees(crs: &str) -> bool {
    let code = crs.rsplit(['/', ':']).next().and_then(|c| c.parse::<u32>().ok());
    crs.contains("CRS84")
        || (crs.contains("EPSG") && code.is_some_and(|c| (4000..5000).contains(&c)))
}

/// Parents exist and form no cycle.
fn check_parents(
    source: &Source<'_>,
    objects: &BTreeMap<String, Object>,
) -> Result<(), SceneError> {
    // Objects known to lead to a root.
    let mut sound: std::collections::BTreeSet<&str> = std::collections::BTreeSet::new();
    for id in objects.keys() {
        let mut chain: Vec<&str> = vec![];
        let mut here = Some(id.as_str());
        while let Some(name) = here.filter(|name| !sound.contains(name)) {
            let label = || format!("city object \"{id}\"");
            if chain.len() > MOST_ANCESTORS {
                let reason = format!("its parents form a cycle, or more than {MOST_ANCESTORS}");
                return Err(source.error(label(), reason));
            }
            chain.push(name);
            let Some(object) = objects.get(name) else {
                return Err(
                    source.error(label(), format!("its parent \"{name}\" is not in the file"))
                );
            };
            here = object.parents.first().map(String::as_str);
        }
        sound.extend(chain);
    }
    Ok(())
}

/// Parents above parents.
const MOST_ANCESTORS: usize = 32;

/// All vertices as the file means them: east, north, up.
fn world(source: &Source<'_>, file: &File) -> Result<Vec<DVec3>, SceneError> {
    let (scale, translate) = file
        .transform
        .as_ref()
        .map_or((DVec3::ONE, DVec3::ZERO), |t| (DVec3::from(t.scale), DVec3::from(t.translate)));
    let mut vertices = Vec::with_capacity(file.vertices.len());
    for (i, &v) in file.vertices.iter().enumerate() {
        let p = DVec3::from(v) * scale + translate;
        // A comparison that a NaN fails.
        if !(p.abs().max_element() <= MAX_COORDINATE_M && p.is_finite()) {
            let reason = format!("{p} m, at most {MAX_COORDINATE_M:e} m is allowed");
            return Err(source.error(format!("vertex {i}"), reason));
        }
        vertices.push(p);
    }
    Ok(vertices)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    file: &'a File,
    /// Scene space.
    vertices: Vec<DVec3>,
    /// Middle and height taken off: east, north, up.
    datum: DVec3,
    /// Highest level of detail among the parts of an object that have geometry.
    parts: BTreeMap<&'a str, f64>,
    cavities: u64,
    flat: u64,
    tally: Tally,
    levels: Tally,
    draft: Draft,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source<'a>, file: &'a File, stored: Vec<DVec3>) -> Self {
        let mut parts: BTreeMap<&str, f64> = BTreeMap::new();
        for part in file.objects.values().filter(|o| !o.geometry.is_empty()) {
            let level = building::best_level(part);
            for parent in &part.parents {
                let known = parts.entry(parent).or_insert(level);
                *known = known.max(level);
            }
        }
        let mut reader = Self {
            parts,
            source,
            file,
            vertices: vec![],
            datum: DVec3::ZERO,
            cavities: 0,
            flat: 0,
            tally: Tally::default(),
            levels: Tally::default(),
            draft: Draft::default(),
        };
        reader.datum = reader.datum(&stored);
        let datum = reader.datum;
        reader.vertices =
            stored.into_iter().map(|p| p - datum).map(|p| DVec3::new(p.x, p.z, -p.y)).collect();
        reader
    }

    /// The middle of what buildings use (of everything, without buildings), to the metre, and their
    /// lowest point.
    fn datum(&self, stored: &[DVec3]) -> DVec3 {
        let of = |buildings: bool| {
            let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for object in self.file.objects.values() {
                if buildings && !is_building(&object.kind) {
                    continue;
                }
                for geometry in &object.geometry {
                    each_index(&geometry.boundaries, &mut |index| {
                        if let Some(&p) = stored.get(index as usize) {
                            bounds = [bounds[0].min(p), bounds[1].max(p)];
                        }
                    });
                }
            }
            bounds
        };
        let found = [of(true), of(false)].into_iter().find(|b| b[0].x <= b[1].x);
        let Some([lo, hi]) = found else { return DVec3::ZERO };
        let middle = (0.5 * (lo + hi)).round();
        DVec3::new(middle.x, middle.y, lo.z)
    }

    fn draft(mut self, crs: Option<&str>) -> Result<Draft, SceneError> {
        let file = self.file;
        for (id, object) in &file.objects {
            let kind = object.kind.as_str();
            match kind {
                _ if is_building(kind) => self.building(id, object)?,
                "Road" | "TransportSquare" | "Bridge" | "BridgePart" => {
                    self.ground(id, object, GroundKind::Street)?;
                }
                "WaterBody" | "Waterway" => self.ground(id, object, GroundKind::Water)?,
                "LandUse" | "TINRelief" | "PlantCover" | "GenericCityObject"
                | "+GenericCityObject" | "Railway" => self.ground(id, object, GroundKind::Land)?,
                "SolitaryVegetationObject" => self.tree(id, object)?,
                other => self.tally.add(format!("objects of type {other}")),
            }
        }
        Ok(self.finish(crs))
    }

    fn finish(self, crs: Option<&str>) -> Draft {
        let Self { source, datum, cavities, flat, tally, levels, mut draft, .. } = self;
        let file = source.file;
        let mut warnings: Vec<String> = levels.sentences(file, "are shown").collect();
        warnings.extend(tally.sentences(file, "are left out"));
        if cavities > 0 {
            warnings.push(format!("{file}: {cavities} inner shells of solids are left out"));
        }
        if flat > 0 {
            warnings.push(format!("{file}: {flat} surfaces without area are left out"));
        }
        draft.warnings.splice(0..0, warnings);
        let system = crs.map_or_else(
            || "a system that the file does not name, taken as metres".into(),
            |crs| format!("the file's own system, {crs}, in metres"),
        );
        draft.projection = format!(
            "Places are in {system}; east {}, north {} and height {} became the origin.",
            datum.x, datum.y, datum.z
        );
        draft
    }

    /// The surfaces of the highest level of detail that can be read.
    fn surfaces(&mut self, id: &str, object: &Object) -> Result<Vec<Surface>, SceneError> {
        let Some((index, geometry)) = self.best(object) else { return Ok(vec![]) };
        let (surfaces, [cavities, flat]) =
            surface::surfaces(geometry, &self.vertices).map_err(|(element, reason)| {
                let place = format!("city object \"{id}\", geometry {index}, {element}");
                self.source.error(place, reason)
            })?;
        self.cavities += cavities;
        self.flat += flat;
        Ok(surfaces)
    }

    /// The first geometry of the highest level, and its number.
    fn best<'o>(&mut self, object: &'o Object) -> Option<(usize, &'o Geometry)> {
        let mut best: Option<(usize, &Geometry)> = None;
        for (i, geometry) in object.geometry.iter().enumerate() {
            match geometry.kind.as_str() {
                "Solid" | "MultiSolid" | "CompositeSolid" | "MultiSurface" | "CompositeSurface" => {
                    if best.is_none_or(|(_, b)| geometry.level() > b.level()) {
                        best = Some((i, geometry));
                    }
                }
                other => self.tally.add(format!("geometries of type {other}")),
            }
        }
        best
    }

    fn ground(&mut self, id: &str, object: &Object, kind: GroundKind) -> Result<(), SceneError> {
        let mut triangles = vec![];
        for surface in self.surfaces(id, object)? {
            for mut t in surface.triangles() {
                // Upright pieces show no ground. Undersides are turned over.
                let up = (t[1] - t[0]).cross(t[2] - t[0]);
                if up.y.abs() <= 1e-3 * up.length() {
                    continue;
                }
                if up.y < 0.0 {
                    t.swap(1, 2);
                }
                triangles.push(t);
            }
        }
        if !triangles.is_empty() {
            self.draft.grounds.push(Ground { kind, triangles });
        }
        Ok(())
    }

    /// From its geometry's bounds, or a reference point and what the attributes say.
    fn tree(&mut self, id: &str, object: &Object) -> Result<(), SceneError> {
        let height = ["height", "measuredHeight"]
            .iter()
            .find_map(|name| object.attributes.get(*name)?.as_f64())
            .filter(|h| (0.1..=200.0).contains(h));
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for surface in self.surfaces(id, object)? {
            for &p in surface.rings.iter().flatten() {
                bounds = [bounds[0].min(p), bounds[1].max(p)];
            }
        }
        let [lo, hi] = bounds;
        let made = if lo.x <= hi.x {
            let size = hi - lo;
            let height_m = if size.y > 0.1 { size.y } else { height.unwrap_or(TREE_HEIGHT_M) };
            let wide = 0.5 * DVec2::new(size.x, size.z).max_element();
            let crown_radius_m = if wide > 0.05 { wide } else { CROWN_OF_HEIGHT * height_m };
            let middle = 0.5 * (lo + hi);
            Tree { position: DVec3::new(middle.x, lo.y, middle.z), height_m, crown_radius_m }
        } else {
            let mut place = None;
            for geometry in object.geometry.iter().filter(|g| g.kind == "GeometryInstance") {
                each_index(&geometry.boundaries, &mut |index| {
                    place = place.or(self.vertices.get(index as usize).copied());
                });
            }
            let Some(position) = place else {
                self.tally.add("trees without a place");
                return Ok(());
            };
            let height_m = height.unwrap_or(TREE_HEIGHT_M);
            Tree { position, height_m, crown_radius_m: CROWN_OF_HEIGHT * height_m }
        };
        self.draft.trees.push(made);
        Ok(())
    }
}

fn is_building(kind: &str) -> bool {
    matches!(kind, "Building" | "BuildingPart")
}

/// Calls `f` for every index, however deep.
fn each_index(value: &serde_json::Value, f: &mut impl FnMut(u64)) {
    match value {
        serde_json::Value::Array(items) => items.iter().for_each(|v| each_index(v, f)),
        other => other.as_u64().into_iter().for_each(f),
    }
}
