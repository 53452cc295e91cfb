//! How much of a light a point sees.

use crate::sampling::{seed_of, stratified};
use crate::surface::Surface;
use crate::tracer::{Ray, Tracer};
use dapple_scene::Light;
use glam::DVec3;
use rayon::prelude::*;

/// The visible share of a light, 0..=1, at a point with a unit normal.
///
/// Directional and spot lights give 0 or 1 (`samples` and `seed` do not matter); outside a spot's
/// cone it is dark. An area light gives the visible share of its *area*, without any cosine or
/// distance weighting, from one random point in each cell of an n × n grid on it,
/// n = ceil(sqrt(samples)). What lies behind the surface (n·l <= 0) is not visible. Rays keep
/// [`Tracer::epsilon_m`] away from both ends.
pub fn light_visibility(
    tracer: &Tracer,
    point: DVec3,
    normal: DVec3,
    light: &Light,
    samples: u32,
    seed: u64,
) -> f64 {
    visibility(tracer, point, normal, None, light, samples, seed)
}

/// [`light_visibility`] of a hit; the triangle the hit lies on cannot shadow it.
pub fn surface_light_visibility(
    tracer: &Tracer,
    surface: &Surface,
    light: &Light,
    samples: u32,
    seed: u64,
) -> f64 {
    let own = Some(surface.triangle);
    visibility(tracer, surface.position, surface.normal, own, light, samples, seed)
}

/// [`surface_light_visibility`] of every receiver, in parallel, each with a seed of its own; 1
/// where there is no receiver.
pub fn light_visibility_all(
    tracer: &Tracer,
    receivers: &[Option<Surface>],
    light: &Light,
    samples: u32,
    seed: u64,
) -> Vec<f64> {
    let one = |(i, receiver): (usize, &Option<Surface>)| match receiver {
        Some(s) => surface_light_visibility(tracer, s, light, samples, seed_of(seed, i)),
        None => 1.0,
    };
    receivers.par_iter().enumerate().map(one).collect()
}

fn visibility(
    tracer: &Tracer,
    point: DVec3,
    normal: DVec3,
    own: Option<u32>,
    light: &Light,
    samples: u32,
    seed: u64,
) -> f64 {
    let sees = |towards: DVec3, distance: f64| {
        sees_along(tracer, point, normal, own, towards, distance) as u32 as f64
    };
    match *light {
        Light::Directional { direction } => sees(-direction, f64::INFINITY),
        Light::Spot { position, direction, half_angle_rad } => {
            let to_point = point - position;
            let in_cone = to_point.normalize_or_zero().dot(direction.normalize_or_zero())
                >= half_angle_rad.cos();
            if in_cone { sees(-to_point, to_point.length()) } else { 0.0 }
        }
        Light::Area { centre, half_u, half_v } => {
            let n = f64::from(samples.max(1)).sqrt().ceil() as u32;
            let total: f64 = stratified(n, seed)
                .map(|(a, b)| {
                    let target = centre + half_u * (2.0 * a - 1.0) + half_v * (2.0 * b - 1.0);
                    sees(target - point, (target - point).length())
                })
                .sum();
            total / (f64::from(n) * f64::from(n))
        }
    }
}

fn sees_along(
    tracer: &Tracer,
    point: DVec3,
    normal: DVec3,
    own: Option<u32>,
    towards: DVec3,
    distance: f64,
) -> bool {
    let Some(direction) = towards.try_normalize() else {
        return false;
    };
    let facing = normal.dot(direction) > 0.0;
    if !(facing && point.is_finite()) {
        return false;
    }
    let epsilon = tracer.epsilon_m();
    let ray = Ray { origin: point, direction, t_min: epsilon, t_max: distance - epsilon };
    !tracer.any_except(&ray, own)
}
