//! Party walls: facades that stand against another building.

use crate::city::Building;
use crate::city::inner::union_length;
use glam::DVec2;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Walls this close to each other touch, metres.
const TOUCH_M: f64 = 0.05;
/// A wall is shared where so much of its length is.
const SHARE: f64 = 0.5;
/// Opposite walls: cosine of the angle between one and the other reversed.
const OPPOSITE: f64 = 0.99;

/// Marks facades most of whose length coincides, within a few centimetres, with walls of other
/// buildings that face the other way.
pub fn mark(buildings: &mut [Building]) {
    let walls: Vec<Wall> = buildings
        .iter()
        .enumerate()
        .flat_map(|(b, building)| {
            building.facades.iter().map(move |f| ([f.from, f.to], b as u32)).map(wall)
        })
        .collect();
    let tree = RTree::bulk_load(walls);
    for (index, building) in buildings.iter_mut().enumerate() {
        for facade in &mut building.facades {
            let own = [facade.from, facade.to];
            let mut spans: Vec<[f64; 2]> = tree
                .locate_in_envelope_intersecting(envelope(own, TOUCH_M))
                .filter(|wall| wall.data.1 != index as u32)
                .filter_map(|wall| shared(own, wall.data.0))
                .collect();
            facade.party = union_length(&mut spans) >= SHARE * own[0].distance(own[1]);
        }
    }
}

type Wall = GeomWithData<Rectangle<[f64; 2]>, ([DVec2; 2], u32)>;

fn wall(data: ([DVec2; 2], u32)) -> Wall {
    GeomWithData::new(envelope(data.0, 0.0).into(), data)
}

fn envelope([a, b]: [DVec2; 2], grown: f64) -> AABB<[f64; 2]> {
    AABB::from_corners(
        (a.min(b) - DVec2::splat(grown)).to_array(),
        (a.max(b) + DVec2::splat(grown)).to_array(),
    )
}

/// The stretch of `own`, in metres from its start, that `other` runs along.
fn shared(own: [DVec2; 2], other: [DVec2; 2]) -> Option<[f64; 2]> {
    let length = own[0].distance(own[1]);
    let along = (own[1] - own[0]) / length;
    let against = (other[0] - other[1]).try_normalize()?;
    if along.dot(against) < OPPOSITE {
        return None;
    }
    // Where the other wall, as a line over `own`, stays within reach of it.
    let local = |p: DVec2| DVec2::new((p - own[0]).dot(along), along.perp_dot(p - own[0]));
    let (p, q) = (local(other[1]), local(other[0]));
    let (mut from, mut to) = (p.x.max(0.0), q.x.min(length));
    let slope = (q.y - p.y) / (q.x - p.x);
    if slope == 0.0 {
        if p.y.abs() > TOUCH_M {
            return None;
        }
    } else {
        let at = |y: f64| p.x + (y - p.y) / slope;
        let (a, b) = (at(-TOUCH_M), at(TOUCH_M));
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    (from < to).then_some([from, to])
}
