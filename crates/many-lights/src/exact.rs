//! Radiance by one light, exactly: what every sum, estimate and bound refers to.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 2.4.2, Eq. 2.1.
//! Deviations: the distance is clamped from below at [`World::clamp_m`], in the exact value, the
//! estimate and the bound alike; a light at the very point gives nothing.

use crate::{
    Light, Point, World,
    light::{Emission, angle},
};
use glam::DVec3;

/// Radiance (linear RGB) that leaves `point` diffusely because of `light`, nothing between them, f64:
/// `albedo / π · cos θ · falloff(φ) · intensity / max(distance², clamp²)`.
pub fn radiance(point: &Point, light: &Light, clamp_m: f64) -> DVec3 {
    let normal = point.normal.as_dvec3();
    let over_pi = point.albedo.as_dvec3() * std::f64::consts::FRAC_1_PI;
    if light.emission == Emission::Directional {
        return over_pi * light.intensity * normal.dot(-light.axis).max(0.0);
    }
    let to_light = light.position - point.position.as_dvec3();
    let squared = to_light.length_squared();
    if squared == 0.0 {
        return DVec3::ZERO;
    }
    let direction = to_light / squared.sqrt();
    let cosine = normal.dot(direction).max(0.0);
    if cosine == 0.0 {
        return DVec3::ZERO;
    }
    let falloff = match light.emission {
        Emission::Omni => 1.0,
        emission => emission.falloff(angle(light.axis, -direction)),
    };
    over_pi * light.intensity * (cosine * falloff / squared.max(clamp_m * clamp_m))
}

impl World {
    /// Radiance at a point from all lights, in their order, with shadow rays where there are
    /// occluders: the truth.
    pub fn truth(&self, point: &Point) -> DVec3 {
        let one = |light: &Light| {
            let radiance = radiance(point, light, self.clamp_m);
            if radiance == DVec3::ZERO || !self.sees(point, light) { DVec3::ZERO } else { radiance }
        };
        self.lights.iter().map(one).sum()
    }
}
