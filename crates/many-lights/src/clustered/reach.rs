//! How far lights are allowed to reach.
//!
//! The fade is that of engines: (1 - (d / r)⁴)², B. Karis, "Real shading in Unreal Engine 4", 2013;
//! it multiplies what the light gives, and leaves the clamp of the distance as it is.

use crate::{Light, light::Emission};

/// Where a white surface that faces the light gives `cutoff` in the brightest channel, metres: 0
/// without intensity, infinite for directional lights.
pub fn reach_m(light: &Light, cutoff: f64) -> f64 {
    let brightest = light.intensity.max_element();
    if brightest == 0.0 {
        0.0
    } else if light.emission == Emission::Directional {
        f64::INFINITY
    } else {
        (brightest / cutoff * std::f64::consts::FRAC_1_PI).sqrt()
    }
}

/// Share that is left at a distance, of squares: 1 at the light, 0 from its reach on.
pub fn window(squared: f64, reach_squared: f64) -> f64 {
    let ratio = squared / reach_squared;
    let left = (1.0 - ratio * ratio).max(0.0);
    left * left
}

/// A light's reach as f32 forms know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Squared, m².
    pub squared: f32,
}

impl Reach {
    /// Of a light.
    pub fn of(light: &Light, cutoff: f64) -> Self {
        Self { squared: reach_m(light, cutoff).powi(2) as f32 }
    }

    /// Share that is left at a squared distance: with the fade, or cut off hard.
    #[inline(always)]
    pub fn share(self, squared: f32, faded: bool) -> f32 {
        if squared > self.squared {
            return 0.0;
        }
        let ratio = squared / self.squared;
        let left = (1.0 - ratio * ratio).max(0.0);
        if faded { left * left } else { 1.0 }
    }
}
