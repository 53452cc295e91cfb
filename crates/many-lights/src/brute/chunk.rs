//! Lights of one kind, sixteen side by side, and what they give without a branch: loops over lanes
//! that compilers turn into vectors.

use crate::{
    Emission, Light, Point,
    bound::packed::{HALF_CHORD, arc_sine},
};
use std::f32::consts::PI;

/// Lights of a chunk.
pub(super) const LANES: usize = 16;

/// A number a light.
pub(super) type Lanes = [f32; LANES];

/// Sixteen lights of one kind; where there are fewer, the last are dark.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Chunk {
    pub intensity: [Lanes; 3],
    position: [Lanes; 3],
    axis: [Lanes; 3],
    /// One over the half angle.
    over_half_angle: Lanes,
    /// Which lights they are.
    pub lights: [u32; LANES],
}

impl Chunk {
    const DARK: Self = Self {
        intensity: [[0.0; LANES]; 3],
        position: [[0.0; LANES]; 3],
        axis: [[0.0; LANES]; 3],
        over_half_angle: [1.0; LANES],
        lights: [0; LANES],
    };

    fn set(&mut self, lane: usize, index: usize, light: &Light) {
        let axis = light.axis.normalize_or(glam::DVec3::Z).as_vec3().to_array();
        let (position, intensity) = (light.position.as_vec3(), light.intensity.as_vec3());
        for k in 0..3 {
            self.position[k][lane] = position[k];
            self.axis[k][lane] = axis[k];
            self.intensity[k][lane] = intensity[k];
        }
        self.over_half_angle[lane] = (1.0 / light.emission.half_angle_rad()) as f32;
        self.lights[lane] = index as u32;
    }
}

/// The lights of each kind, in their order.
pub(super) fn chunks(lights: &[Light]) -> [Vec<Chunk>; 4] {
    let mut kinds = [const { Vec::<Chunk>::new() }; 4];
    let mut counts = [0; 4];
    for (index, light) in lights.iter().enumerate() {
        let kind = light.emission.code() as usize;
        if counts[kind] % LANES == 0 {
            kinds[kind].push(Chunk::DARK);
        }
        if let Some(chunk) = kinds[kind].last_mut() {
            chunk.set(counts[kind] % LANES, index, light);
        }
        counts[kind] += 1;
    }
    kinds
}

/// What each light of a chunk gives a white point, over its intensity and times π:
/// `cos θ · falloff(φ) / max(distance², clamp²)`.
#[inline(always)]
pub(super) fn weights<const KIND: usize>(
    chunk: &Chunk,
    point: &Point,
    clamp_squared: f32,
) -> Lanes {
    const { assert!(KIND < 4) };
    let [ax, ay, az] = &chunk.axis;
    let n = point.normal;
    let mut weights = [0.0; LANES];
    if KIND == DIRECTIONAL {
        for i in 0..LANES {
            weights[i] = (-(n.x * ax[i] + n.y * ay[i] + n.z * az[i])).max(0.0);
        }
        return weights;
    }
    let [px, py, pz] = &chunk.position;
    let at = point.position;
    for i in 0..LANES {
        let (x, y, z) = (px[i] - at.x, py[i] - at.y, pz[i] - at.z);
        let squared = x * x + y * y + z * z;
        // At the very point the product with the normal is 0, and so is all.
        let over_distance = 1.0 / squared.max(f32::MIN_POSITIVE).sqrt();
        let cosine = ((n.x * x + n.y * y + n.z * z) * over_distance).max(0.0);
        let along = (ax[i] * x + ay[i] * y + az[i] * z) * over_distance;
        let falloff = match KIND {
            ORIENTED => (-along).max(0.0),
            SPOT => {
                // The half chord between the axis and the way to the point, or the way back.
                let turn = if along > 0.0 { -over_distance } else { over_distance };
                let (cx, cy, cz) = (ax[i] + x * turn, ay[i] + y * turn, az[i] + z * turn);
                let chord = (cx * cx + cy * cy + cz * cz).sqrt();
                let angle = 2.0 * arc_sine((0.5 * chord).min(HALF_CHORD));
                let angle = if along > 0.0 { PI - angle } else { angle };
                (1.0 - angle * chunk.over_half_angle[i]).max(0.0)
            }
            _ => 1.0,
        };
        weights[i] = cosine * falloff / squared.max(clamp_squared);
    }
    weights
}

/// [`Emission::code`].
pub(super) const OMNI: usize = 0;
pub(super) const ORIENTED: usize = 1;
pub(super) const SPOT: usize = 2;
pub(super) const DIRECTIONAL: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiance;
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

    #[test]
    fn lanes_give_what_each_light_gives_by_itself() {
        let mut random = rand_pcg::Pcg32::seed_from_u64(7);
        let mut checked = 0;
        for round in 0..200 {
            let count = 1 + round % 37;
            let lights: Vec<_> = (0..count).map(|i| light(i as u32 % 4, &mut random)).collect();
            let normal = light(0, &mut random).axis.as_vec3().normalize();
            let point = Point { normal, albedo: Vec3::ONE, ..Point::default() };
            let kinds = chunks(&lights);
            let held: usize = kinds.iter().map(Vec::len).sum();
            assert!(held * LANES < lights.len() + 4 * LANES);
            for (kind, chunk) in
                kinds.iter().enumerate().flat_map(|(k, c)| c.iter().map(move |c| (k, c)))
            {
                let weights = match kind {
                    OMNI => weights::<OMNI>(chunk, &point, 0.01),
                    ORIENTED => weights::<ORIENTED>(chunk, &point, 0.01),
                    SPOT => weights::<SPOT>(chunk, &point, 0.01),
                    _ => weights::<DIRECTIONAL>(chunk, &point, 0.01),
                };
                for lane in 0..LANES {
                    let intensity = chunk.intensity[1][lane];
                    if intensity == 0.0 {
                        continue;
                    }
                    let one = &lights[chunk.lights[lane] as usize];
                    let exact = std::f64::consts::PI * radiance(&point, one, 0.1).y;
                    let got = f64::from(weights[lane] * intensity);
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
            let chunk = &chunks(&lights)[kind as usize][0];
            let point = Point { normal: Vec3::Y, ..Point::default() };
            let all = match kind {
                0 => weights::<OMNI>(chunk, &point, 0.01),
                1 => weights::<ORIENTED>(chunk, &point, 0.01),
                _ => weights::<SPOT>(chunk, &point, 0.01),
            };
            assert_eq!(all, [0.0; LANES]);
        }
    }
}
