//! Lights of one kind side by side, and what they give without a branch: loops that compilers turn
//! into vectors.

mod listed;

pub(crate) use listed::{Listed, Reached};

use crate::{
    Light, PackedNode, Point, World,
    bound::{
        branchless::{greater, lesser},
        packed::{HALF_CHORD, arc_sine},
    },
};
use std::f32::consts::PI;

/// Most lights of a block: 45 KiB, which second-level caches hold.
pub(crate) const BLOCK: usize = 1024;

/// Numbers that are added side by side: loops over fewer are unrolled before they become vectors.
pub(crate) const LANES: usize = 64;

/// A number a light.
pub(crate) type Numbers = [f32; BLOCK];

/// Lights of one kind, those beyond its number dark. One array a number.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// How many are gone through: a multiple of [`LANES`].
    pub used: usize,
    pub intensity: [Numbers; 3],
    position: [Numbers; 3],
    axis: [Numbers; 3],
    /// One over the half angle.
    over_half_angle: Numbers,
    /// What [`Reached`] says; of lights that reach everywhere, anything.
    reach: Numbers,
    /// Which lights they are.
    pub lights: [u32; BLOCK],
}

impl Block {
    pub(crate) const DARK: Self = Self {
        used: 0,
        intensity: [[0.0; BLOCK]; 3],
        position: [[0.0; BLOCK]; 3],
        axis: [[0.0; BLOCK]; 3],
        over_half_angle: [1.0; BLOCK],
        reach: [0.0; BLOCK],
        lights: [0; BLOCK],
    };

    /// Puts the leaf of a light at a place; those behind it, up to the next multiple of [`LANES`], are
    /// dark.
    #[inline(always)]
    pub(crate) fn set(&mut self, place: usize, leaf: &PackedNode, reach: f32) {
        if place.is_multiple_of(LANES) {
            self.used = place + LANES;
            for channel in &mut self.intensity {
                channel[place..place + LANES].fill(0.0);
            }
        }
        for k in 0..3 {
            self.position[k][place] = leaf.position[k];
            self.axis[k][place] = leaf.axis[k];
            self.intensity[k][place] = leaf.intensity[k];
        }
        self.over_half_angle[place] = 1.0 / leaf.half_angle_rad;
        self.reach[place] = reach;
        self.lights[place] = leaf.light;
    }
}

/// The lights of each kind, in their order.
pub(crate) fn blocks(lights: &[Light]) -> [Vec<Block>; 4] {
    let mut kinds = [const { Vec::<Block>::new() }; 4];
    let mut counts = [0; 4];
    for (index, light) in lights.iter().enumerate() {
        let kind = light.emission.code() as usize;
        let place = counts[kind] % BLOCK;
        if place == 0 {
            kinds[kind].push(Block::DARK);
        }
        if let Some(block) = kinds[kind].last_mut() {
            block.set(place, &PackedNode::of(light, index as u32), 0.0);
        }
        counts[kind] += 1;
    }
    kinds
}

/// What each light of a block gives a white point, over its intensity and times π:
/// `cos θ · falloff(φ) / max(distance², clamp²)`, as far as it reaches ([`Reached`], as a number).
#[inline(always)]
pub(crate) fn weigh<const KIND: usize, const REACHED: usize>(
    block: &Block,
    point: &Point,
    clamp_squared: f32,
    weights: &mut Numbers,
) {
    const { assert!(KIND < 4) };
    let used = block.used.min(BLOCK);
    let [ax, ay, az] = &block.axis;
    let [px, py, pz] = &block.position;
    let (at, n) = (point.position, point.normal);
    let over_clamp_squared = 1.0 / clamp_squared;
    for i in 0..used {
        if KIND == DIRECTIONAL {
            weights[i] = positive(-(n.x * ax[i] + n.y * ay[i] + n.z * az[i]));
            continue;
        }
        let (x, y, z) = (px[i] - at.x, py[i] - at.y, pz[i] - at.z);
        let squared = x * x + y * y + z * z;
        // At the very point the product with the normal is 0, and so is all.
        let over_distance = 1.0 / greater(squared, f32::MIN_POSITIVE).sqrt();
        let cosine = positive((n.x * x + n.y * y + n.z * z) * over_distance);
        let along = (ax[i] * x + ay[i] * y + az[i] * z) * over_distance;
        let falloff = match KIND {
            ORIENTED => positive(-along),
            SPOT => {
                // The half chord between the axis and the way to the point, or the way back.
                let turn = if along > 0.0 { -over_distance } else { over_distance };
                let (cx, cy, cz) = (ax[i] + x * turn, ay[i] + y * turn, az[i] + z * turn);
                let half_chord = 0.5 * (cx * cx + cy * cy + cz * cz).sqrt();
                let angle = 2.0 * arc_sine(-greater(-half_chord, -HALF_CHORD));
                let angle = if along > 0.0 { PI - angle } else { angle };
                positive(1.0 - angle * block.over_half_angle[i])
            }
            _ => 1.0,
        };
        // One division less than by the greater of the squares.
        let over_squared = lesser(over_distance * over_distance, over_clamp_squared);
        let left = match REACHED {
            FADED => {
                let ratio = squared * block.reach[i];
                let left = positive(1.0 - ratio * ratio);
                left * left
            }
            CUT if squared > block.reach[i] => 0.0,
            _ => 1.0,
        };
        weights[i] = cosine * falloff * over_squared * left;
    }
}

/// The sum of products: at most 16 numbers a lane, then lanes by halves, so that little is lost.
#[inline(always)]
pub(crate) fn weighted(weights: &[f32], intensity: &[f32]) -> f32 {
    let mut lanes = [0.0; LANES];
    for (weights, intensity) in weights.chunks_exact(LANES).zip(intensity.chunks_exact(LANES)) {
        for i in 0..LANES {
            lanes[i] += weights[i] * intensity[i];
        }
    }
    for i in 0..LANES / 2 {
        lanes[i] += lanes[i + LANES / 2];
    }
    for i in 0..LANES / 4 {
        lanes[i] += lanes[i + LANES / 4];
    }
    lanes[..LANES / 4].iter().sum()
}

/// Takes away what a point does not see, by a ray to every light that would reach it: their number.
#[inline(never)]
pub(crate) fn hide(weights: &mut Numbers, block: &Block, point: &Point, world: &World) -> u64 {
    let mut rays = 0;
    for (place, weight) in weights[..block.used].iter_mut().enumerate() {
        let gives = |k: usize| point.albedo[k] * block.intensity[k][place] > 0.0;
        if *weight > 0.0 && (0..3).any(gives) {
            rays += 1;
            if !world.sees(point, &world.lights[block.lights[place] as usize]) {
                *weight = 0.0;
            }
        }
    }
    rays
}

#[inline(always)]
fn positive(a: f32) -> f32 {
    greater(a, 0.0)
}

/// [`crate::Emission::code`].
pub(crate) const OMNI: usize = 0;
pub(crate) const ORIENTED: usize = 1;
pub(crate) const SPOT: usize = 2;
pub(crate) const DIRECTIONAL: usize = 3;

/// [`Reached`] as a number.
pub(crate) const EVERYWHERE: usize = 0;
const CUT: usize = 1;
const FADED: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Emission, radiance};
    use glam::{DVec3, Vec3};
    use rand::{RngExt, SeedableRng};

    /// A light of a kind at random, near 0.
    fn light(kind: u32, random: &mut rand_pcg::Pcg32) -> Light {
        let mut vector =
            || DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        let (position, axis) = (3.0 * vector(), vector().normalize());
        let half_angle_rad = random.random_range(0.05..std::f64::consts::PI);
        let emission = Emission::of(kind, half_angle_rad);
        Light { position, axis, intensity: DVec3::new(1.0, 2.0, 3.0), emission }
    }

    fn weights(kind: usize, block: &Block, point: &Point) -> Vec<f32> {
        let mut weights = [f32::NAN; BLOCK];
        match kind {
            OMNI => weigh::<OMNI, EVERYWHERE>(block, point, 0.01, &mut weights),
            ORIENTED => weigh::<ORIENTED, EVERYWHERE>(block, point, 0.01, &mut weights),
            SPOT => weigh::<SPOT, EVERYWHERE>(block, point, 0.01, &mut weights),
            _ => weigh::<DIRECTIONAL, EVERYWHERE>(block, point, 0.01, &mut weights),
        }
        weights[..block.used].to_vec()
    }

    #[test]
    fn lanes_give_what_each_light_gives_by_itself() {
        let mut random = rand_pcg::Pcg32::seed_from_u64(7);
        let mut checked = 0;
        for round in 0..200 {
            let count = 1 + round % 37;
            let lights: Vec<_> = (0..count).map(|i| light(i as u32 % 4, &mut random)).collect();
            let normal = light(0, &mut random).axis.as_vec3().normalize();
            let point = Point { normal, albedo: Vec3::ONE, ..Point::default() };
            let kinds = blocks(&lights);
            for (kind, block) in
                kinds.iter().enumerate().flat_map(|(k, b)| b.iter().map(move |b| (k, b)))
            {
                let weights = weights(kind, block, &point);
                assert!(block.used < 10 + LANES && block.used % LANES == 0);
                for place in 0..block.used {
                    let intensity = block.intensity[1][place];
                    if intensity == 0.0 {
                        continue;
                    }
                    let one = &lights[block.lights[place] as usize];
                    let exact = std::f64::consts::PI * radiance(&point, one, 0.1).y;
                    let got = f64::from(weights[place] * intensity);
                    let most = one.intensity.y / one.position.length_squared().max(0.01);
                    let most = if kind == DIRECTIONAL { one.intensity.y } else { most };
                    // A cone of 0.05 radians magnifies an angle's rounding by 20.
                    assert!((got - exact).abs() < 2e-5 * most, "{one:?}: {got} {exact}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 3000);
    }

    #[test]
    fn at_the_very_light_there_is_nothing() {
        let mut random = rand_pcg::Pcg32::seed_from_u64(8);
        for kind in 0..3 {
            let lights = [Light { position: DVec3::ZERO, ..light(kind, &mut random) }];
            let block = &blocks(&lights)[kind as usize][0];
            let point = Point { normal: Vec3::Y, ..Point::default() };
            assert_eq!(weights(kind as usize, block, &point), vec![0.0; LANES]);
        }
    }
}
