//! Settings as all forms use them.

use crate::{Emission, Light, LightsError, Reservoirs, sample::Random};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Candidates that one reservoir may stand for: exact in f32.
const MOST: u64 = 1 << 24;

/// Greatest radius, pixels: products of coordinates stay within 31 bits.
const FARTHEST: f64 = 16_383.0;

/// Settings in whole numbers, as on a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Plan {
    /// Drawn a pixel.
    pub candidates: u32,
    /// Most that a reservoir of the frame before stands for; 0 where it is not used.
    pub history: u32,
    /// Looked at a pixel.
    pub neighbours: u32,
    /// Columns and rows to each side in which they lie, whole pixels.
    pub radius: i32,
    /// They lie no farther than the square root of this.
    pub radius_squared: i32,
    /// 1 where merging is unbiased.
    pub unbiased: u32,
}

/// Which random numbers of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stream {
    /// Candidates: slot, light, choice of each.
    Candidates,
    /// The choice between this frame's and the one before's.
    Temporal,
    /// Place and choice of each neighbour.
    Spatial,
}

impl Plan {
    /// The settings, once they are within limits.
    ///
    /// # Errors
    /// Reservoirs that would stand for more than 2^24 candidates, or a radius beyond 16,383 pixels.
    pub fn new(settings: &Reservoirs) -> Result<Self, LightsError> {
        let candidates = u64::from(settings.candidates);
        let history = if settings.temporal { u64::from(settings.history) } else { 0 };
        let most = u128::from(candidates)
            * (u128::from(history) + 1)
            * (u128::from(settings.neighbours) + 1);
        if most > u128::from(MOST) {
            let element = "candidates x (history + 1) x (neighbours + 1)";
            return Err(LightsError::value(element, format!("{most} is more than 2^24")));
        }
        if !(0.0..=FARTHEST).contains(&settings.radius_px) {
            let limit = format!("{} is outside 0..=16383 pixels", settings.radius_px);
            return Err(LightsError::value("radius", limit));
        }
        Ok(Self {
            candidates: settings.candidates,
            history: (candidates * history) as u32,
            neighbours: settings.neighbours,
            radius: settings.radius_px as i32,
            radius_squared: (settings.radius_px * settings.radius_px) as i32,
            unbiased: u32::from(settings.unbiased),
        })
    }
}

impl Stream {
    /// Its first state's seed: streams of one pixel have nothing in common.
    pub fn seed(self, seed: u32) -> u32 {
        seed.wrapping_add(0x9e37_79b9_u32.wrapping_mul(self as u32))
    }

    /// The stream of a pixel.
    #[inline]
    pub fn of(self, seed: u32, frame: usize, pixel: usize) -> Random {
        Random::new(self.seed(seed), frame as u32, pixel as u32)
    }
}

/// What lights are drawn in proportion to: luminance of their intensity. More than 0 for every light
/// that gives anything.
pub(crate) fn weights(lights: &[Light]) -> Vec<f64> {
    let near = lights.iter().filter(|l| l.emission != Emission::Directional);
    let (min, max) = near.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), light| {
        (min.min(light.position), max.max(light.position))
    });
    let squared = 0.25 * (max - min).length_squared();
    // A lone lamp has no extent, and no lamp at all has less.
    let area = if squared > 0.0 && squared.is_finite() && max.x >= min.x { squared } else { 1.0 };
    let weight = |light: &Light| {
        let factor = if light.emission == Emission::Directional { area } else { 1.0 };
        // The least number stands for what rounds to nothing, the greatest for what overflows.
        let least = if light.intensity == DVec3::ZERO { 0.0 } else { f64::MIN_POSITIVE };
        (light.luminance() * factor).clamp(least, f64::MAX)
    };
    lights.iter().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Reservoirs {
        Reservoirs {
            candidates: 8,
            temporal: true,
            history: 20,
            neighbours: 3,
            radius_px: 2.5,
            unbiased: true,
        }
    }

    #[test]
    fn settings_become_whole_numbers() {
        let plan = Plan::new(&settings()).unwrap();
        assert_eq!((plan.history, plan.radius, plan.radius_squared), (160, 2, 6));
        let without = Plan::new(&Reservoirs { temporal: false, ..settings() }).unwrap();
        assert_eq!(without.history, 0);
    }

    #[test]
    fn what_would_overflow_is_refused_by_name() {
        let most = Reservoirs { history: u32::MAX, neighbours: u32::MAX, ..settings() };
        assert!(Plan::new(&most).unwrap_err().to_string().contains("history"));
        for radius_px in [-1.0, f64::NAN, f64::INFINITY, 20_000.0] {
            let far = Reservoirs { radius_px, ..settings() };
            assert!(Plan::new(&far).unwrap_err().to_string().contains("radius"));
        }
    }

    #[test]
    fn every_light_that_gives_anything_weighs() {
        let light = |emission, intensity| Light {
            position: DVec3::ZERO,
            axis: DVec3::Z,
            intensity,
            emission,
        };
        let blue = DVec3::new(0.0, 0.0, 5e-324);
        let lights = [
            light(Emission::Omni, DVec3::ZERO),
            light(Emission::Omni, blue),
            light(Emission::Directional, blue),
            light(Emission::Directional, DVec3::splat(f64::MAX)),
        ];
        let weights = weights(&lights);
        assert_eq!(weights[0], 0.0);
        assert!(weights[1..].iter().all(|w| *w > 0.0 && w.is_finite()), "{weights:?}");
    }
}
