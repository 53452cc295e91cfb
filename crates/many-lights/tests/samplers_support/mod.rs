//! Worlds, settings and comparisons of samplers' tests.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, LightBvh, LightTree, StochasticLightcuts, Technique, World,
    tree::{Build, Representative},
    worlds::{Cloud, Made, cloud},
};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Every kind of emission.
pub const ALL: [Emission; 4] = [
    Emission::Omni,
    Emission::Oriented,
    Emission::Spot { half_angle_rad: 0.25 * PI },
    Emission::Directional,
];

/// Share of pixels that may differ between forms: where rounding makes a draw fall the other way. A
/// number falls within rounding of a limit with a chance of some 1e-6; a pixel draws some 200.
pub const DIFFERING: f64 = 5e-3;

/// Every sampler, with few and more lights.
pub fn every() -> Vec<Technique> {
    let mut all = vec![
        Technique::LightBvh(LightBvh { samples: 1 }),
        Technique::LightBvh(LightBvh { samples: 16 }),
    ];
    for (cut, real_time) in [(1, false), (16, false), (4, true), (16, true)] {
        all.push(Technique::StochasticLightcuts(StochasticLightcuts { cut, real_time }));
    }
    all
}

/// Lights above ground and between walls.
pub fn small(emissions: &[Emission], lights: u32, size: [u32; 2]) -> Made {
    let emissions = emissions.to_vec();
    cloud(&Cloud { lights, emissions, seed: 7, size, frames: 1, origin: DVec3::ZERO })
}

/// The world's lights in halves.
pub fn tree_of(world: &World) -> Arc<LightTree> {
    Arc::new(LightTree::build(&world.lights, Build::Median, Representative::Weighted).unwrap())
}

/// Share of pixels that differ by more than rounding.
pub fn differing(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    let differs = |(a, b): &(&Vec3, &Vec3)| {
        let off = (**a - **b).abs().max_element();
        let rounding = 2e-4 * a.max_element().max(b.max_element());
        // Written so that what is not a number differs.
        !matches!(off.partial_cmp(&rounding), Some(order) if order.is_le())
    };
    a.iter().zip(b).filter(differs).count() as f64 / a.len().max(1) as f64
}
