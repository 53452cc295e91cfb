//! How much light reaches a receiver through what lies in its way, by rays against the geometry: a
//! truth without a map's resolution.

use crate::filtered::{PLANE_EPSILON, plane_in_map, plane_point, reach};
use crate::light_cells::LightRays;
use crate::opacity::Opacities;
use crate::sampling::{seed_of, stratified};
use crate::tracer::Tracer;
use dapple_scene::LightView;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// What lets less light through than this counts as dark, and is not followed further.
pub const LEAST_TRANSMITTANCE: f64 = 1e-9;

/// Units of optical thickness a whole one is counted in. Sums of integers do not depend on the order
/// in which the tree finds the surfaces; 2^-56 is below the rounding of a double near 1.
const THICKNESS_UNITS: f64 = (1_u64 << 56) as f64;

/// How the opacities of the surfaces in the way add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// Π(1 - α): what alpha blending does.
    #[default]
    Product,
    /// e^-Σα: each opacity is taken for an optical thickness.
    Exponential,
}

/// A square of a light's map over which transmittance is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Side in map coordinates; the map itself has side 1.
    pub width_uv: f64,
    /// Rays along each side, one at random in each cell; 0 counts as 1.
    pub grid: u32,
}

/// A point to be lit, at the end of its way from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPath {
    /// World space, metres.
    pub position: DVec3,
    /// The placed triangle it lies on, which never stands in its way.
    pub triangle: u32,
    /// Whether that triangle is opaque.
    pub opaque: bool,
}

/// Transmittance, 0..=1, between the map's near plane and a receiver.
///
/// Everything strictly in front of the receiver counts, by [`Tracer::epsilon_m`]; behind an opaque
/// surface it is 0, and so is what falls under [`LEAST_TRANSMITTANCE`]. Receivers in front of the
/// near plane, behind a perspective light, or not finite, are lit. Whether a surface faces the
/// light does not matter.
///
/// With a `footprint` it is the mean over light rays through the square around the receiver, which
/// is not cut at the map's border. A translucent receiver stands for the plane of its light depth.
/// An opaque one stands for its own surface, as in [`crate::filtered_visibility`]: on each ray the
/// hit nearest to its tangent plane among those on the surface it is connected to, else the plane
/// itself; and what lies in front by [`PLANE_EPSILON`] counts. Points of the square where a
/// perspective light's ray never reaches the plane are left out; without any other, 0.
pub fn transmittance(
    tracer: &Tracer,
    opacities: &Opacities,
    view: &LightView,
    law: Law,
    footprint: Option<Footprint>,
    path: &LightPath,
    seed: u64,
) -> f64 {
    let rays = LightRays::by_tree(tracer, view);
    Through { tracer, opacities, view, law, rays }.transmittance(footprint, path, seed)
}

/// [`transmittance`] of every receiver, in parallel, each with a seed of its own.
///
/// Rays of parallel light are found in another way than one by one, which takes a moment to prepare;
/// where a ray runs exactly through an edge, it may choose the other side. (The ray of a receiver on
/// a triangle seen edge-on does.)
pub fn transmittance_all(
    tracer: &Tracer,
    opacities: &Opacities,
    view: &LightView,
    law: Law,
    footprint: Option<Footprint>,
    paths: &[LightPath],
    seed: u64,
) -> Vec<f64> {
    let rays = LightRays::by_cells(tracer, view);
    let through = Through { tracer, opacities, view, law, rays };
    let one = |(i, path)| through.transmittance(footprint, path, seed_of(seed, i));
    paths.par_iter().enumerate().map(one).collect()
}

/// What a light's rays pass, and how it adds up.
struct Through<'a> {
    tracer: &'a Tracer,
    opacities: &'a Opacities,
    view: &'a LightView,
    law: Law,
    rays: LightRays<'a>,
}

impl Through<'_> {
    fn transmittance(&self, footprint: Option<Footprint>, path: &LightPath, seed: u64) -> f64 {
        let (tracer, view) = (self.tracer, self.view);
        let at = view.project(path.position);
        let epsilon = tracer.epsilon_m() / (view.far_m - view.near_m);
        let level = |u: f64, v: f64| self.along([u, v], at.z - epsilon, path.triangle);
        let Some(Footprint { width_uv, grid }) = footprint else {
            return level(at.x, at.y);
        };
        let window = stratified(grid.max(1), seed)
            .map(|(a, b)| (at.x + width_uv * (a - 0.5), at.y + width_uv * (b - 0.5)));
        let normal = tracer.normal(path.triangle).filter(|_| path.opaque);
        let plane = normal.and_then(|normal| {
            let away = normal.dot(view.ray(at.x, at.y).1) > 0.0;
            let normal = if away { -normal } else { normal };
            Some((normal, plane_in_map(view, path.position, normal)?))
        });
        let Some((normal, plane)) = plane else {
            let cells = f64::from(grid.max(1)) * f64::from(grid.max(1));
            return window.map(|(u, v)| level(u, v)).sum::<f64>() / cells;
        };
        let reach = reach(view, &plane, width_uv);
        let (mut sum, mut counted) = (0.0, 0_u64);
        for (u, v) in window {
            let Some((_, direction, z)) = plane_point(view, path.position, normal, u, v) else {
                continue;
            };
            let surface = self.own_surface([u, v], direction, z, reach, path.triangle);
            sum += self.along([u, v], surface.unwrap_or(z) - PLANE_EPSILON, path.triangle);
            counted += 1;
        }
        if counted == 0 { 0.0 } else { sum / counted as f64 }
    }

    /// What passes from the near plane to depth `z`, but for triangle `skip`.
    fn along(&self, at: [f64; 2], z: f64, skip: u32) -> f64 {
        let limit = (-LEAST_TRANSMITTANCE.ln() * THICKNESS_UNITS) as u64;
        let mut sum = 0_u64;
        self.rays.visit(at, [0.0, z], |hit| {
            if hit.triangle == skip {
                return ControlFlow::Continue(());
            }
            let alpha = f64::from(self.opacities.alpha(hit.triangle));
            if alpha >= 1.0 {
                sum = u64::MAX;
                return ControlFlow::Break(());
            }
            let thickness = match self.law {
                // An f32 below 1 has a logarithm of at most 17: no sum up to the limit overflows.
                Law::Product => -(-alpha).ln_1p(),
                Law::Exponential => alpha,
            };
            sum += (thickness * THICKNESS_UNITS).round() as u64;
            if sum > limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if sum > limit { 0.0 } else { (-(sum as f64 / THICKNESS_UNITS)).exp() }
    }

    /// The depth of the hit nearest to `z`, within `reach`, on the surface of opaque triangle `own`.
    fn own_surface(
        &self,
        at: [f64; 2],
        direction: DVec3,
        z: f64,
        reach: f64,
        own: u32,
    ) -> Option<f64> {
        let mut nearest: Option<f64> = None;
        self.rays.visit(at, [z - reach, z + reach], |hit| {
            // Of two as near the one in front, in whatever order they are found.
            let rank = |t: f64| ((t - z).abs(), t);
            // What is connected is of one mesh, hence of one material.
            if nearest.is_none_or(|n| rank(hit.t) < rank(n))
                && self.opacities.is_opaque(hit.triangle)
                && self.tracer.is_same_surface(hit.triangle, own, direction)
            {
                nearest = Some(hit.t);
            }
            ControlFlow::Continue(())
        });
        nearest
    }
}
