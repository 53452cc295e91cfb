//! The outline of a set of surfaces seen from above.
//!
//! Edges that two surfaces share cancel; what is left are the rings of the outline. Corners are
//! taken together on a grid of a millimetre, the resolution files of this kind have.

use super::surface::Surface;
use crate::city::Footprint;
use crate::city::footprint::signed_area;
use glam::DVec2;
use std::collections::BTreeMap;

/// Corners nearer than this are the same, metres.
const WELD_M: f64 = 1e-3;

type Corner = (i64, i64);

/// The footprints that the surfaces cover, largest first. Surfaces must face one way and meet in
/// whole edges.
///
/// # Errors
/// One clause.
pub fn footprints<'a>(
    surfaces: impl Iterator<Item = &'a Surface>,
) -> Result<Vec<Footprint>, &'static str> {
    let rings = rings(surfaces)?;
    let (mut outers, mut holes) = (vec![], vec![]);
    // The side that is larger in all is the outside: surfaces may all face up or all down.
    let total: f64 = rings.iter().map(|r| signed_area(r)).sum();
    for ring in rings {
        let list = if signed_area(&ring) * total > 0.0 { &mut outers } else { &mut holes };
        list.push(ring);
    }
    outers.sort_by(|a, b| signed_area(b).abs().total_cmp(&signed_area(a).abs()));
    let mut footprints = vec![];
    for outer in outers {
        let alone = Footprint::new(&outer, &[], WELD_M)?;
        let (own, rest) = holes.into_iter().partition(|h: &Vec<DVec2>| alone.contains(middle(h)));
        holes = rest;
        footprints.push(Footprint::new(&outer, &own, WELD_M)?);
    }
    if footprints.is_empty() || !holes.is_empty() {
        return Err("without an outline");
    }
    Ok(footprints)
}

/// The middle of a ring's first edge: on the border of the hole, so inside what is around it.
fn middle(ring: &[DVec2]) -> DVec2 {
    0.5 * (ring[0] + ring[1])
}

fn rings<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> Result<Vec<Vec<DVec2>>, &'static str> {
    let mut place: BTreeMap<Corner, DVec2> = BTreeMap::new();
    // How often an edge is run along, less how often against.
    let mut edges: BTreeMap<(Corner, Corner), i64> = BTreeMap::new();
    for ring in surfaces.flat_map(|s| &s.rings) {
        let corners: Vec<Corner> = ring
            .iter()
            .map(|p| {
                let plan = DVec2::new(p.x, p.z);
                let key = (plan / WELD_M).round();
                let key = (key.x as i64, key.y as i64);
                place.entry(key).or_insert(plan);
                key
            })
            .collect();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            match a.cmp(&b) {
                std::cmp::Ordering::Less => *edges.entry((a, b)).or_default() += 1,
                std::cmp::Ordering::Greater => *edges.entry((b, a)).or_default() -= 1,
                std::cmp::Ordering::Equal => {}
            }
        }
    }
    let mut leaving: BTreeMap<Corner, Vec<Corner>> = BTreeMap::new();
    for ((a, b), count) in edges {
        let (from, to) = if count > 0 { (a, b) } else { (b, a) };
        match count.abs() {
            0 => {}
            1 => leaving.entry(from).or_default().push(to),
            _ => return Err("whose surfaces overlap"),
        }
    }
    let at = |c: Corner| place.get(&c).copied().unwrap_or(DVec2::ZERO);
    let mut rings = vec![];
    while let Some((&start, _)) = leaving.first_key_value() {
        let (mut ring, mut here, mut came) = (vec![], start, None::<Corner>);
        loop {
            let Some(next) = leaving.get_mut(&here) else {
                return Err("whose outline is not closed");
            };
            // Where rings touch, the sharpest turn to the same side keeps each of them simple.
            let chosen = came.map_or(0, |before| sharpest(at(before), at(here), next, &at));
            let to = next.swap_remove(chosen);
            if next.is_empty() {
                leaving.remove(&here);
            }
            ring.push(at(here));
            (came, here) = (Some(here), to);
            if here == start {
                break;
            }
        }
        rings.push(ring);
    }
    Ok(rings)
}

/// The way on that turns most, all turns taken to one side.
fn sharpest(before: DVec2, here: DVec2, next: &[Corner], at: &impl Fn(Corner) -> DVec2) -> usize {
    let back = before - here;
    let turn = |c: &Corner| {
        let d = at(*c) - here;
        back.perp_dot(d).atan2(back.dot(d)).rem_euclid(std::f64::consts::TAU)
    };
    let best = next.iter().enumerate().min_by(|a, b| turn(a.1).total_cmp(&turn(b.1)));
    best.map_or(0, |(i, _)| i)
}
