//! Random rows of buildings, plane by plane.

use crate::streams::FUSIONS;
use dapple_many_lights::region::fusion::Horizon;
use dapple_many_lights::region::horizon::{Umbra, umbra};
use dapple_many_lights::region::{Cuboid, Edge, Fusion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A cell and what stands behind it.
#[derive(Clone, Debug)]
pub struct Rows {
    pub cell: Cuboid,
    pub boxes: Vec<Cuboid>,
}

/// What feet of buildings are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// The thesis's: nothing passes below.
    Endless,
    /// Level, at 0.
    Level,
    /// Of its own height under every building, up to so many metres.
    Hilly(f64),
}

pub const GROUNDS: [Ground; 4] =
    [Ground::Endless, Ground::Level, Ground::Hilly(0.5), Ground::Hilly(6.0)];

/// Five rows of twelve lots, 12 % of them empty, of 1 to 7 storeys, before a cell of a width.
pub fn rows(seed: u64, width: f64, ground: Ground) -> Rows {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let left = random.random_range(30.0..90.0 - 0.5 * width);
    let low = [0.0, -1e-6, 3.0 * f64::from(random.random_range(0..5))][random.random_range(0..3)];
    let high = low + 3.0 * f64::from(random.random_range(1..5));
    let depth = [0.0, 1.0][random.random_range(0..2)];
    let cell = Cuboid { u: [left, left + width], w: [0.0, depth], h: [low, high] };
    let mut boxes = Vec::new();
    for row in 0..5 {
        for lot in 0..12 {
            if random.random_bool(0.12) {
                continue;
            }
            let u = 10.0 * f64::from(lot);
            let w = 10.0 + 25.0 * f64::from(row);
            let storeys: i32 = random.random_range(1..=7);
            let foot = match ground {
                Ground::Endless => f64::NEG_INFINITY,
                Ground::Level => 0.0,
                Ground::Hilly(most) => random.random_range(0.0..most),
            };
            let base = foot.max(0.0);
            let h = [foot, base + 3.0 * f64::from(storeys)];
            // Some stand back from the street.
            let back = [0.0, 2.0][usize::from(random.random_bool(0.3))];
            boxes.push(Cuboid { u: [u, u + 10.0], w: [w, w + 10.0 - back], h });
        }
    }
    Rows { cell, boxes }
}

impl Rows {
    /// Far faces from the nearest to the farthest.
    pub fn planes(&self) -> Vec<f64> {
        let mut planes: Vec<f64> = self.boxes.iter().map(|b| b.w[1]).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup();
        planes
    }

    /// Shadows on a plane of those that end there.
    pub fn shadows(&self, plane: f64, edge: Edge) -> Vec<Umbra> {
        let ends = self.boxes.iter().filter(|b| b.w[1] == plane);
        ends.filter_map(|b| umbra(&self.cell, b, plane, edge)).collect()
    }

    /// The horizon on each plane after the shadows there have joined it.
    pub fn on_planes(&self, fusion: Fusion, edge: Edge, mut see: impl FnMut(&Horizon, f64)) {
        let mut horizon = Horizon::new(fusion);
        let mut last = None;
        for plane in self.planes() {
            if let Some(last) = last {
                horizon.reproject(&self.cell, last, plane);
            }
            horizon.add(&self.shadows(plane, edge));
            see(&horizon, plane);
            last = Some(plane);
        }
    }
}

#[test]
fn trees_stay_small() {
    for ground in GROUNDS {
        for fusion in FUSIONS {
            let mut most = 0.0_f64;
            for seed in 0..40 {
                let rows = rows(seed, 5.0 + 0.4 * seed as f64, ground);
                let mut added = 0;
                rows.on_planes(fusion, Edge::Flat, |horizon, plane| {
                    added += rows.shadows(plane, Edge::Flat).len();
                    most = most.max(horizon.len() as f64 / added as f64);
                });
            }
            // Each as it is, at most twice, and once more for every foot that it is joined above.
            let least_bound = match (fusion, ground) {
                (Fusion::None, _) | (Fusion::HeightOrdered, Ground::Endless) => 1.0,
                (Fusion::Insertion, _) => 2.0,
                (Fusion::HeightOrdered, _) => 3.0,
            };
            assert!(most <= least_bound, "{fusion:?} {ground:?}: {most} a shadow");
        }
    }
}
