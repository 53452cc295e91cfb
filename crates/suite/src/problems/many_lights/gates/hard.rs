//! Lights, trees and points at which bounds and cuts are hard to get right.

use super::input::{paths, rng};
use crate::SuiteError;
use dapple_many_lights::{
    BoundForm, Emission, Light, LightTree, Point, radiance,
    tree::{Build, Representative},
};
use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// What distances are not below, metres.
pub const CLAMP_M: f64 = 0.1;

/// Both forms of bounds.
pub const FORMS: [BoundForm; 2] = [BoundForm::Cheap, BoundForm::Walter];

/// Lights, a tree over them, and who is lit.
pub struct Case {
    /// Any.
    pub lights: Vec<Light>,
    /// Any way to cluster them.
    pub tree: LightTree,
    /// In, on, at or far from a cluster.
    pub point: Point,
}

/// Case `number` of a gate, of up to `most` lights.
///
/// # Errors
/// None for these lights.
pub fn case(seed: u64, gate: &str, number: u32, most: usize) -> Result<Case, SuiteError> {
    let mut rng = rng(seed, gate, number);
    let lights = lights(&mut rng, most);
    let tree = tree(&mut rng, &lights)?;
    let point = point(&mut rng, &lights, &tree);
    Ok(Case { lights, tree, point })
}

impl Case {
    /// Radiance by each of the lights.
    pub fn each(&self, clamp_m: f64) -> Vec<DVec3> {
        self.lights.iter().map(|light| radiance(&self.point, light, clamp_m)).collect()
    }

    /// What all lights give.
    pub fn truth(&self) -> DVec3 {
        self.each(CLAMP_M).into_iter().sum()
    }

    /// Lights below a node, itself included.
    pub fn below(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        below(&self.tree, node)
    }
}

/// Lights below a node of a tree, itself included.
pub fn below(tree: &LightTree, node: usize) -> impl Iterator<Item = usize> + '_ {
    let below = &tree.nodes[node..node + tree.nodes[node].size as usize];
    below.iter().filter(|node| node.is_leaf()).map(|leaf| leaf.light as usize)
}

/// A direction; one of few as often as any.
pub fn unit(rng: &mut Pcg64) -> DVec3 {
    let straight = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z];
    if rng.random_bool(0.4) {
        return straight[rng.random_range(0..straight.len())];
    }
    let any = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    any.normalize_or(DVec3::Y)
}

/// Up to `most` lights of all kinds or of one, at a scale of 1e-4 to 1e6 metres: on a coarse grid, so
/// that some coincide, or anywhere; some dark, some very bright; axes often opposite.
pub fn lights(rng: &mut Pcg64, most: usize) -> Vec<Light> {
    let scale = [1e-4, 1.0, 30.0, 1e3, 1e6][rng.random_range(0..5)];
    let spot = |half_angle_rad| Emission::Spot { half_angle_rad };
    let kinds = [
        Emission::Omni,
        Emission::Oriented,
        spot(FRAC_PI_4),
        spot(FRAC_PI_2),
        spot(PI),
        spot(1e-3),
        Emission::Directional,
    ];
    let only = rng.random_bool(0.5).then(|| kinds[rng.random_range(0..kinds.len())]);
    let (main, near) = (unit(rng), rng.random_bool(0.4));
    let count = match rng.random_range(0..10) {
        small @ 0..3 => small.min(most),
        _ => rng.random_range(0..=most),
    };
    let light = |_| {
        let coarse = rng.random_bool(0.3);
        let mut coordinate = || match coarse {
            true => 0.5 * f64::from(rng.random_range(-2..3)),
            false => rng.random_range(-1.0..1.0),
        };
        let position = DVec3::from_array(std::array::from_fn(|_| scale * coordinate()));
        let axis = match near {
            true => (main + 0.1 * unit(rng)).normalize_or(main),
            false => unit(rng),
        };
        let intensity = match rng.random_range(0..8) {
            0 => DVec3::ZERO,
            1 => DVec3::new(0.0, 1e6, 0.0),
            _ => DVec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..10.0))),
        };
        let emission = only.unwrap_or_else(|| kinds[rng.random_range(0..kinds.len())]);
        Light { position, axis, intensity, emission }
    };
    (0..count).map(light).collect()
}

/// A tree, clustered and represented in any way.
///
/// # Errors
/// None for lights that are allowed.
pub fn tree(rng: &mut Pcg64, lights: &[Light]) -> Result<LightTree, SuiteError> {
    let keys = paths(rng, lights.len());
    let spread = [0.0, 1.0, 5.0][rng.random_range(0..3)];
    let builds = [
        Build::Greedy { spread },
        Build::LocallyOrdered { spread },
        Build::Median,
        Build::Keys(&keys),
        Build::SurfaceArea,
    ];
    let representatives = [
        Representative::Weighted,
        Representative::Nearest,
        Representative::Random { seed: rng.random() },
    ];
    let build = builds[rng.random_range(0..builds.len())];
    let representative = representatives[rng.random_range(0..representatives.len())];
    Ok(LightTree::build(lights, build, representative)?)
}

/// A point at a corner, on a face, inside or outside of a cluster's box, or in a light; its normal
/// towards the cluster, grazing, or any.
pub fn point(rng: &mut Pcg64, lights: &[Light], tree: &LightTree) -> Point {
    let nothing = (DVec3::ZERO, DVec3::ONE, DVec3::ZERO);
    let (low, size, middle) = match tree.nodes.len() {
        0 => nothing,
        count => {
            let node = &tree.nodes[rng.random_range(0..count)];
            (node.min, (node.max - node.min).max(DVec3::splat(1e-3)), node.position)
        }
    };
    let share = |rng: &mut Pcg64| match rng.random_range(0..9) {
        0 | 1 => 0.0,
        2 | 3 => 1.0,
        4 | 5 => rng.random_range(0.0..1.0),
        6 | 7 => rng.random_range(-3.0..4.0),
        _ => 10.0_f64.powf(rng.random_range(1.0..4.0)) * rng.random_range(-1.0..1.0),
    };
    let shares = DVec3::new(share(rng), share(rng), share(rng));
    let mut position = low + size * shares;
    if !lights.is_empty() && rng.random_bool(0.15) {
        position = lights[rng.random_range(0..lights.len())].position;
    }
    let towards = (middle - position).normalize_or(DVec3::Z);
    let normal = match rng.random_range(0..4) {
        0 => towards,
        1 => towards.cross(unit(rng)).normalize_or(DVec3::X),
        _ => unit(rng),
    };
    Point {
        position: position.as_vec3(),
        normal: normal.as_vec3().normalize(),
        albedo: Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..=1.0))),
        ..Point::default()
    }
}
