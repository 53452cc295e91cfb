//! Streets as ribbons along their middle lines, and land below everything.

use super::{Draft, Reader, tags};
use crate::city::{Ground, GroundKind};
use glam::{DVec2, DVec3};

/// Lowest ribbon, metres.
const LOWEST_M: f64 = 0.05;
/// Ribbons cross: each lies this much above the one before, round and round, so that no two that
/// cross are likely to lie in one plane.
const STEP_M: f64 = 1e-3;
const STEPS: u64 = 50;
/// Land is cut into squares of this side, or so many along each side at most.
const LAND_M: f64 = 100.0;
const MOST_SQUARES: f64 = 64.0;
/// Land reaches so far beyond the buildings, metres.
const BEYOND_M: f64 = 50.0;
/// A bend's corner may reach so many half widths from the middle line.
const MOST_MITRE: f64 = 2.0;

/// Width in metres, by the value of `highway`; others are not drawn.
fn width_m(highway: &str) -> Option<(GroundKind, f64)> {
    let street = |width: f64| Some((GroundKind::Street, width));
    match highway {
        "motorway" | "trunk" => street(12.0),
        "primary" | "motorway_link" | "trunk_link" => street(10.0),
        "secondary" | "primary_link" => street(9.0),
        "tertiary" | "secondary_link" => street(8.0),
        "residential" | "unclassified" | "living_street" | "tertiary_link" => street(6.0),
        "service" => street(4.0),
        "pedestrian" => Some((GroundKind::Sidewalk, 5.0)),
        "footway" | "cycleway" | "path" | "steps" | "track" => Some((GroundKind::Sidewalk, 2.0)),
        _ => None,
    }
}

/// Adds a ribbon for each street on the ground.
pub(super) fn add(reader: &mut Reader<'_>) {
    let mut drawn = 0u64;
    for way in reader.data.ways.values() {
        let Some((kind, width)) = way.tags.get("highway").and_then(|h| width_m(h)) else {
            continue;
        };
        let area = way.tags.get("area").is_some_and(|a| a == "yes");
        let under = way.tags.get("tunnel").is_some_and(|t| t != "no")
            || way.tags.get("layer").is_some_and(|l| l.starts_with('-'));
        if area || under {
            reader.tally.add(if area { "streets that are areas" } else { "streets underground" });
            continue;
        }
        let width = way.tags.get("width").and_then(|w| tags::length_m(w)).unwrap_or(width);
        match reader.places(&way.nodes) {
            Ok(line) => {
                let y = LOWEST_M + STEP_M * (drawn % STEPS) as f64;
                let triangles = ribbon(&line, 0.5 * width, y);
                if !triangles.is_empty() {
                    reader.draft.grounds.push(Ground { kind, triangles });
                    drawn += 1;
                }
            }
            Err(reason) => reader.tally.add(format!("streets {reason}")),
        }
    }
}

/// A strip along a line, mitred at its bends, facing up.
fn ribbon(line: &[DVec2], half_width: f64, y: f64) -> Vec<[DVec3; 3]> {
    let mut line = line.to_vec();
    line.dedup_by(|b, a| a.distance(*b) < 1e-3);
    let directions: Vec<DVec2> = line.windows(2).map(|s| (s[1] - s[0]).normalize()).collect();
    let (Some(&first), Some(&last)) = (directions.first(), directions.last()) else {
        return vec![];
    };
    let raised = |p: DVec2| DVec3::new(p.x, y, p.y);
    let rails: Vec<[DVec3; 2]> = line
        .iter()
        .enumerate()
        .map(|(i, &p)| {
            let before = if i == 0 { first } else { directions[i - 1] };
            let after = directions.get(i).copied().unwrap_or(last);
            let across = |d: DVec2| DVec2::new(-d.y, d.x);
            let along = (across(before) + across(after)).try_normalize().unwrap_or(across(after));
            let stretch = 1.0 / along.dot(across(after)).max(1.0 / MOST_MITRE);
            let side = along * (half_width * stretch);
            [raised(p + side), raised(p - side)]
        })
        .collect();
    let mut triangles = vec![];
    for pair in rails.windows(2) {
        let ([a, b], [c, d]) = (pair[0], pair[1]);
        for mut t in [[a, b, d], [a, d, c]] {
            let up = (t[1] - t[0]).cross(t[2] - t[0]).y;
            if up < 0.0 {
                t.swap(1, 2);
            }
            if up != 0.0 {
                triangles.push(t);
            }
        }
    }
    triangles
}

/// Adds squares of land under everything drafted so far.
pub(super) fn add_land(draft: &mut Draft) {
    let mut bounds = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    let mut grow = |p: DVec2| bounds = [bounds[0].min(p), bounds[1].max(p)];
    for building in &draft.buildings {
        building.footprint.bounds().into_iter().for_each(&mut grow);
    }
    let points =
        draft.trees.iter().map(|t| t.position).chain(draft.lamps.iter().map(|l| l.position));
    points.for_each(|p| grow(DVec2::new(p.x, p.z)));
    let [lo, hi] = bounds;
    if lo.x > hi.x {
        return;
    }
    let (lo, hi) = (lo - DVec2::splat(BEYOND_M), hi + DVec2::splat(BEYOND_M));
    let side = LAND_M.max((hi - lo).max_element() / MOST_SQUARES);
    let squares = ((hi - lo) / side).ceil();
    for j in 0..squares.y as u32 {
        for i in 0..squares.x as u32 {
            let corner = |di: u32, dj: u32| {
                let p = lo + DVec2::new(f64::from(i + di), f64::from(j + dj)) * side;
                DVec3::new(p.x, 0.0, p.y)
            };
            let [a, b, c, d] = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
            let triangles = vec![[a, b, c], [a, c, d]];
            draft.grounds.push(Ground { kind: GroundKind::Land, triangles });
        }
    }
}
