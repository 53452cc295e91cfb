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

/// Lights that give a point nothing, told without a root or an angle: most of a city's windows shine
/// elsewhere. Margins are far above rounding, and above what axes may be longer than 1, so that leaving
/// these out changes no bit of a sum.
struct Dark {
    position: DVec3,
    normal: DVec3,
    /// Of the last spot: that of the next is the same as a rule.
    half_angle_rad: f64,
    /// Its cosine, less a margin.
    cosine: f64,
}

impl Dark {
    fn at(point: &Point) -> Self {
        let (position, normal) = (point.position.as_dvec3(), point.normal.as_dvec3());
        Self { position, normal, half_angle_rad: 0.0, cosine: 0.0 }
    }

    /// Whether it surely gives nothing: it lies behind the surface, or the point beyond its cone.
    #[inline]
    fn is(&mut self, light: &Light) -> bool {
        if light.emission == Emission::Directional {
            return false;
        }
        let to_light = light.position - self.position;
        let squared = to_light.length_squared();
        let ahead = self.normal.dot(to_light);
        if ahead < 0.0 && ahead * ahead > 1e-20 * squared {
            return true;
        }
        let Emission::Spot { half_angle_rad } = light.emission else { return false };
        if half_angle_rad != self.half_angle_rad {
            (self.half_angle_rad, self.cosine) = (half_angle_rad, half_angle_rad.cos() - 1e-5);
        }
        let along = -light.axis.dot(to_light);
        self.cosine > 0.0 && (along <= 0.0 || along * along < self.cosine * self.cosine * squared)
    }
}

impl World {
    /// Radiance at a point from all lights, in their order, with shadow rays where there are
    /// occluders: the truth.
    pub fn truth(&self, point: &Point) -> DVec3 {
        let mut dark = Dark::at(point);
        let one = |light: &Light| {
            if dark.is(light) {
                return DVec3::ZERO;
            }
            let radiance = radiance(point, light, self.clamp_m);
            if radiance == DVec3::ZERO || !self.sees(point, light) { DVec3::ZERO } else { radiance }
        };
        self.lights.iter().map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::{Cloud, Facade, WINDOW, cloud, facade};

    #[test]
    fn leaving_out_dark_lights_changes_no_bit() {
        let narrow = Emission::Spot { half_angle_rad: 0.02 };
        let wide = Emission::Spot { half_angle_rad: 3.0 };
        let emissions =
            vec![WINDOW, narrow, Emission::Omni, wide, Emission::Oriented, Emission::Directional];
        let mut made = cloud(&Cloud { lights: 3000, emissions, ..Cloud::default() }).world;
        // At the very points, and in their planes.
        let points: Vec<Point> = made.frames[0].points.iter().copied().step_by(7).collect();
        for (light, point) in made.lights.iter_mut().step_by(3).zip(&points) {
            light.position = point.position.as_dvec3();
        }
        let beside = |(light, point): (&mut Light, &Point)| {
            let across = point.normal.any_orthonormal_vector();
            light.position = (point.position + 2.0 * across).as_dvec3();
        };
        made.lights.iter_mut().skip(1).step_by(3).zip(&points).for_each(beside);
        let opposite = facade(&Facade { size: [20, 13], ..Facade::default() }).0.world;
        let (mut left_out, mut kept) = (0, 0);
        for world in [made, opposite] {
            for point in world.frames[0].points.iter().filter(|point| point.is_there()) {
                let one = |light: &Light| radiance(point, light, world.clamp_m);
                let all: DVec3 = world.lights.iter().map(one).sum();
                assert_eq!(world.truth(point), all);
                let mut dark = Dark::at(point);
                for light in &world.lights {
                    let is_dark = dark.is(light);
                    assert!(!is_dark || one(light) == DVec3::ZERO, "{light:?} at {point:?}");
                    left_out += usize::from(is_dark);
                    kept += usize::from(!is_dark);
                }
            }
        }
        assert!(left_out.min(kept) > 100_000, "{left_out} left out, {kept} not");
    }
}
