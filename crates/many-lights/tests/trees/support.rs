//! Lights to cluster.

use dapple_many_lights::{
    Emission, Light,
    tree::{Build, Representative},
};
use glam::DVec3;
use proptest::prelude::*;

pub const WEIGHTED: Representative = Representative::Weighted;

pub const REPRESENTATIVES: [Representative; 3] =
    [Representative::Weighted, Representative::Nearest, Representative::Random { seed: 7 }];

/// All ways to cluster, with and without weight for directions.
pub fn builds(keys: &[Vec<u32>]) -> Vec<Build<'_>> {
    vec![
        Build::Greedy { spread: 1.0 },
        Build::Greedy { spread: 0.0 },
        Build::LocallyOrdered { spread: 1.0 },
        Build::Original { spread: 3.0 },
        Build::Median,
        Build::Keys(keys),
        Build::SurfaceArea,
    ]
}

pub fn omni(position: DVec3, intensity: f64) -> Light {
    let intensity = DVec3::splat(intensity);
    Light { position, axis: DVec3::Y, intensity, emission: Emission::Omni }
}

pub fn spot(position: DVec3, axis: DVec3) -> Light {
    let emission = Emission::Spot { half_angle_rad: std::f64::consts::FRAC_PI_4 };
    Light { position, axis: axis.normalize(), intensity: DVec3::ONE, emission }
}

/// Repeatable numbers in 0..1.
pub fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Spot lights in a cube of 100 m, axes to all sides.
pub fn cloud(count: usize, seed: u64) -> Vec<Light> {
    let mut next = numbers(seed);
    let mut vector = |scale: f64| DVec3::from_array(std::array::from_fn(|_| next() * scale));
    (0..count)
        .map(|_| {
            let axis = (vector(2.0) - DVec3::ONE).try_normalize().unwrap_or(DVec3::X);
            Light { intensity: vector(5.0), ..spot(vector(100.0), axis) }
        })
        .collect()
}

/// Windows of a row of buildings: equal distances, opposite axes, ties everywhere.
pub fn windows(columns: usize, rows: usize) -> Vec<Light> {
    let window = |i: usize| {
        let (column, row, side) = (i / 2 % columns, i / 2 / columns, (i % 2) as f64);
        let position = DVec3::new(column as f64 * 3.0, row as f64 * 3.0, side * 10.0);
        spot(position, DVec3::Z * (2.0 * side - 1.0))
    };
    (0..2 * columns * rows).map(window).collect()
}

/// Any lights: all kinds, coincident ones, dark ones, opposite axes, small and large coordinates.
pub fn any_lights(most: usize) -> impl Strategy<Value = Vec<Light>> {
    let coordinate =
        prop_oneof![Just(0.0), Just(1.0), -1.0..1.0_f64, -1e-4..1e-4_f64, -1e6..1e6_f64,];
    let position = [coordinate.clone(), coordinate.clone(), coordinate].prop_map(DVec3::from_array);
    let axis = prop_oneof![
        Just(DVec3::X),
        Just(-DVec3::X),
        Just(DVec3::Z),
        [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]
            .prop_map(|a| DVec3::from_array(a).try_normalize().unwrap_or(DVec3::Y)),
    ];
    let brightness = prop_oneof![Just(0.0), Just(1.0), 0.0..10.0_f64, Just(1e-6), Just(1e6)];
    let intensity =
        [brightness.clone(), brightness.clone(), brightness].prop_map(DVec3::from_array);
    let emission = prop_oneof![
        Just(Emission::Omni),
        Just(Emission::Oriented),
        Just(Emission::Spot { half_angle_rad: std::f64::consts::FRAC_PI_4 }),
        (0.01..std::f64::consts::PI).prop_map(|half_angle_rad| Emission::Spot { half_angle_rad }),
        Just(Emission::Directional),
    ];
    let light =
        (position, axis, intensity, emission).prop_map(|(position, axis, intensity, emission)| {
            Light { position, axis, intensity, emission }
        });
    prop::collection::vec(light, 0..=most)
}

/// One path a light, of any lengths.
pub fn any_keys(count: usize) -> impl Strategy<Value = Vec<Vec<u32>>> {
    prop::collection::vec(prop::collection::vec(0..3_u32, 0..5), count)
}
