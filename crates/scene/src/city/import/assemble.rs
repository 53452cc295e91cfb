//! From drafts to a city: facades, blocks, boxes.

use super::{LoadedCity, Tally, party, views};
use crate::city::inner::{InnerKnobs, inner_boxes};
use crate::city::{Building, City, Facade, Footprint, Ground, StreetLamp, Tree};
use crate::{Aabb, MAX_COORDINATE_M, SceneError};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Side of the square tiles that serve as blocks, metres.
const TILE_M: f64 = 100.0;
/// Height of a storey where only the building's height is known, metres.
pub(super) const STOREY_M: f64 = 3.0;
/// Most storeys of a building.
const MOST_STOREYS: f64 = 400.0;

/// What a file says of a building.
pub(super) struct DraftBuilding {
    pub id: String,
    pub footprint: Footprint,
    pub base_m: f64,
    pub eaves_m: f64,
    /// Where the file says so.
    pub storeys: Option<u32>,
    /// Above the eaves or at them; `None` for a flat roof.
    pub roof: Option<Vec<[DVec3; 3]>>,
    pub gables: Vec<[DVec3; 3]>,
}

/// What a file says of a city.
#[derive(Default)]
pub(super) struct Draft {
    pub buildings: Vec<DraftBuilding>,
    pub lamps: Vec<StreetLamp>,
    pub trees: Vec<Tree>,
    pub grounds: Vec<Ground>,
    pub projection: String,
    pub warnings: Vec<String>,
}

/// The city of a draft.
pub(super) fn city(file: &str, name: String, draft: Draft) -> Result<LoadedCity, SceneError> {
    let Draft { buildings: drafts, lamps, trees, grounds, projection, mut warnings } = draft;
    let mut city = City { name, lamps, trees, grounds, projection, ..City::default() };
    let mut left_out = Tally::default();
    // Tile by tile, row by row; within a tile in the order of the file.
    let mut tiles: BTreeMap<(i64, i64), Vec<Building>> = BTreeMap::new();
    for draft in drafts {
        let [lo, hi] = draft.footprint.bounds();
        let tile = (0.5 * (lo + hi) / TILE_M).floor();
        match building(draft) {
            Ok(made) => tiles.entry((tile.y as i64, tile.x as i64)).or_default().push(made),
            Err(reason) => left_out.add(format!("buildings {reason}")),
        }
    }
    for members in tiles.into_values() {
        let first = city.buildings.len() as u32;
        city.buildings.extend(members);
        city.blocks.push(first..city.buildings.len() as u32);
    }
    warnings.extend(left_out.sentences(file, "are left out"));
    check(file, &city)?;
    party::mark(&mut city.buildings);
    views::add(&mut city);
    Ok(LoadedCity { city, warnings })
}

fn building(draft: DraftBuilding) -> Result<Building, &'static str> {
    let DraftBuilding { id, footprint, base_m, eaves_m, storeys, roof, gables } = draft;
    let roof = match roof {
        Some(roof) => roof,
        None => flat(&footprint, eaves_m)?,
    };
    let facades: Vec<Facade> =
        footprint.edges().map(|[from, to]| Facade { from, to, party: false }).collect();
    let mut outer = Aabb::EMPTY;
    for corner in &footprint.outer {
        outer = outer
            .grow(DVec3::new(corner.x, base_m, corner.y))
            .grow(DVec3::new(corner.x, eaves_m, corner.y));
    }
    outer = roof.iter().chain(&gables).flatten().fold(outer, |b, &p| b.grow(p));
    let inner = inner_boxes(&footprint, base_m, eaves_m, &InnerKnobs::default());
    let by_height = ((eaves_m - base_m) / STOREY_M).round().clamp(1.0, MOST_STOREYS) as u32;
    let storeys = storeys.unwrap_or(by_height).clamp(1, MOST_STOREYS as u32);
    Ok(Building { id, footprint, base_m, eaves_m, storeys, facades, roof, gables, outer, inner })
}

/// The footprint's triangles at a height.
pub(super) fn flat(footprint: &Footprint, y: f64) -> Result<Vec<[DVec3; 3]>, &'static str> {
    let raised = |p: DVec2| DVec3::new(p.x, y, p.y);
    Ok(footprint.triangulate()?.into_iter().map(|t| t.map(raised)).collect())
}

/// Everything finite and within range, and something there.
fn check(file: &str, city: &City) -> Result<(), SceneError> {
    let bad = |element: String, p: DVec3| {
        let most = MAX_COORDINATE_M;
        SceneError::format(
            file,
            element,
            format!("{p} m from the middle, at most {most:e} m is allowed"),
        )
    };
    let outside = |p: &DVec3| !p.is_finite() || p.abs().max_element() > MAX_COORDINATE_M;
    for b in &city.buildings {
        if let Some(p) = [b.outer.min, b.outer.max].into_iter().find(|p| outside(p)) {
            return Err(bad(format!("building \"{}\"", b.id), p));
        }
    }
    for (i, ground) in city.grounds.iter().enumerate() {
        if let Some(&p) = ground.triangles.iter().flatten().find(|p| outside(p)) {
            return Err(bad(format!("ground {i}"), p));
        }
    }
    let points = city.lamps.iter().map(|l| l.position).chain(city.trees.iter().map(|t| t.position));
    if let Some(p) = points.into_iter().find(|p| outside(p)) {
        return Err(bad("a lamp or a tree".into(), p));
    }
    let ground = city.grounds.iter().any(|g| !g.triangles.is_empty());
    if city.buildings.is_empty() && city.trees.is_empty() && !ground {
        return Err(SceneError::format(
            file,
            "city",
            "no building, no tree and no ground that could be shown; it needs one",
        ));
    }
    Ok(())
}
