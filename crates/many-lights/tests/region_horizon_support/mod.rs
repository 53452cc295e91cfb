//! Boxes to draw, and what is hidden by trying.
#![allow(dead_code, reason = "each test takes its part")]

use dapple_many_lights::region::{
    Cuboid, Edge,
    horizon::{Umbra, umbra},
};
use proptest::prelude::*;

/// Upper edges.
pub const EDGES: [Edge; 3] = [Edge::Flat, Edge::Sloped, Edge::Hull];

/// Share of coordinates by which a segment may miss a box and still count as touching it.
const TOUCH: f64 = 1e-10;

/// Cases a property: many, for they are quick.
pub fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4000);
    let max_global_rejects = 4 * cases;
    ProptestConfig {
        cases,
        max_global_rejects,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// A cell, an occluder and a plane.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub cell: Cuboid,
    pub occluder: Cuboid,
    pub plane: f64,
    /// Magnitude of the coordinates.
    pub size: f64,
}

/// Numbers that often coincide.
fn number(low: i32, high: i32) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![(low..=high).prop_map(f64::from), f64::from(low)..=f64::from(high),]
}

/// An interval, now and then a point.
pub fn interval(low: i32, high: i32) -> impl Strategy<Value = [f64; 2]> + Clone {
    (number(low, high), number(low, high)).prop_map(|(a, b)| [a.min(b), a.max(b)])
}

/// Any cell, 3 deep at most and 8 high, at w = 0..3.
pub fn cell() -> impl Strategy<Value = Cuboid> + Clone {
    (interval(0, 8), interval(0, 3), interval(0, 8)).prop_map(|(u, w, h)| Cuboid { u, w, h })
}

/// An occluder that may overlap a cell's depth; feet above, at and below the cell's, and none.
pub fn occluder(nearest: i32) -> impl Strategy<Value = Cuboid> + Clone {
    let foot = prop_oneof![
        3 => Just(f64::NEG_INFINITY),
        1 => number(-3, 3),
    ];
    (interval(-3, 11), interval(nearest, 12), interval(1, 10), foot)
        .prop_map(|(u, w, h, foot)| Cuboid { u, w, h: [foot.min(h[1]), h[1]] })
}

/// A plane at the occluder's far face or behind it.
pub fn scene(nearest: i32) -> impl Strategy<Value = Scene> {
    let behind = prop_oneof![Just(0.0), number(0, 20)];
    (cell(), occluder(nearest), behind).prop_map(|(cell, occluder, behind)| Scene {
        cell,
        occluder,
        plane: occluder.w[1] + behind,
        size: 32.0,
    })
}

/// Times a factor.
pub fn scaled(c: &Cuboid, by: f64) -> Cuboid {
    let times = |side: [f64; 2]| side.map(|x| x * by);
    Cuboid { u: times(c.u), w: times(c.w), h: times(c.h) }
}

/// Left and right exchanged.
pub fn mirrored(c: &Cuboid) -> Cuboid {
    Cuboid { u: [-c.u[1], -c.u[0]], ..*c }
}

impl Scene {
    pub fn scaled(&self, by: f64) -> Self {
        Self {
            cell: scaled(&self.cell, by),
            occluder: scaled(&self.occluder, by),
            plane: self.plane * by,
            size: self.size * by,
        }
    }

    pub fn umbra(&self, edge: Edge) -> Option<Umbra> {
        umbra(&self.cell, &self.occluder, self.plane, edge)
    }

    /// Whether a point of the plane is hidden from one of the cell. The occluder counts as larger by
    /// `grown` of the magnitude.
    pub fn hides_from(&self, from: [f64; 3], u: f64, h: f64, grown: f64) -> bool {
        meets(from, [u, self.plane, h], &self.occluder, grown * self.size)
    }

    /// Whether a point of the plane is hidden from all corners of the cell.
    pub fn is_hidden(&self, u: f64, h: f64, grown: f64) -> bool {
        corners(&self.cell).into_iter().all(|from| self.hides_from(from, u, h, grown))
    }

    /// A point of an umbra's border, or of a cell within it, that is seen: none where it is sound.
    pub fn seen_within(&self, umbra: &Umbra) -> Option<[f64; 2]> {
        let foot = umbra.foot.max(umbra.lowest().min(self.cell.h[0]) - 100.0 * self.size);
        let steps = 16;
        (0..=steps)
            .flat_map(|i| {
                let share = f64::from(i) / f64::from(steps);
                let u = (umbra.u[0] + share * (umbra.u[1] - umbra.u[0])).min(umbra.u[1]);
                let top = umbra.height(u);
                [top, 0.5 * (top + foot), foot].map(|h| [u, h])
            })
            .chain(umbra.vertices())
            .filter(|[u, h]| *h >= foot && *h <= umbra.height(*u))
            .find(|[u, h]| !self.is_hidden(*u, *h, TOUCH))
    }

    /// How many times farther a plane may be than the occluder.
    pub fn magnification(&self) -> f64 {
        let near = self.occluder.w[0].max(self.cell.w[1]).max(self.cell.w[0]);
        let far = self.occluder.w[1].min(self.plane);
        let from = if near > self.cell.w[0] { near - self.cell.w[0] } else { f64::INFINITY };
        (self.plane - self.cell.w[0]) / (far - self.cell.w[1]).min(from)
    }
}

/// The eight corners.
pub fn corners(c: &Cuboid) -> [[f64; 3]; 8] {
    std::array::from_fn(|i| [c.u[i & 1], c.w[i >> 1 & 1], c.h[i >> 2]])
}

/// Whether a segment meets a closed box that is larger by `grown` on each side.
pub fn meets(from: [f64; 3], to: [f64; 3], solid: &Cuboid, grown: f64) -> bool {
    let mut inside = [0.0_f64, 1.0];
    for (axis, [low, high]) in [solid.u, solid.w, solid.h].into_iter().enumerate() {
        let (low, high) = (low - grown, high + grown);
        let (at, along) = (from[axis], to[axis] - from[axis]);
        if along == 0.0 {
            if !(low..=high).contains(&at) {
                return false;
            }
            continue;
        }
        let ends = [(low - at) / along, (high - at) / along];
        inside[0] = inside[0].max(ends[0].min(ends[1]));
        inside[1] = inside[1].min(ends[0].max(ends[1]));
    }
    inside[0] <= inside[1]
}
