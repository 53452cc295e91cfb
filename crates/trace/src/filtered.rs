//! The shadow signal that shadow-map filters approximate, and receivers as a shadow map sees them.

use crate::sampling::{seed_of, stratified};
use crate::surface::Surface;
use crate::tracer::{Hit, Ray, Tracer};
use dapple_scene::LightView;
use glam::DVec3;
use rayon::prelude::*;

/// How much closer to the light than the receiver's plane an occluder must be to count, in
/// normalised linear depth. Far below any depth bias, far above what f32 vertices leave of the
/// flatness of a tessellated plane seen at a grazing angle.
pub const PLANE_EPSILON: f64 = 1e-5;

/// How far from the tangent plane, in widths of the window along the slope, the receiver's own
/// surface (what its triangle is connected to by shared corners) is looked for. Half a width lets it turn by 45 degrees from the middle of the window to
/// its border; what strays further is another surface, and the plane stands in for it.
pub const SURFACE_REACH: f64 = 0.5;

/// A receiver's tangent plane in map coordinates and linear depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneInMap {
    /// Map coordinate of the point, 0..=1 inside the map.
    pub u: f64,
    /// Map coordinate of the point, downwards.
    pub v: f64,
    /// Linear depth of the point, 0..=1 between near and far.
    pub z: f64,
    /// Change of depth along the plane per unit of u: exact for parallel light, the derivative at
    /// the point for a perspective one.
    pub dz_du: f64,
    /// The same per unit of v.
    pub dz_dv: f64,
    /// Cosine between the normal and the direction to the light, in (0, 1].
    pub n_dot_l: f64,
}

/// The receiver as the map sees it, or `None` where it faces away from the light (n·l <= 0), lies
/// behind a perspective light, or is not finite.
pub fn receiver(view: &LightView, surface: &Surface) -> Option<PlaneInMap> {
    plane_in_map(view, surface.position, surface.normal)
}

/// [`receiver`] of a point and its unit normal.
pub(crate) fn plane_in_map(view: &LightView, position: DVec3, n: DVec3) -> Option<PlaneInMap> {
    let from_light = position - view.origin;
    let distance = from_light.dot(view.forward);
    let travel = if view.perspective { from_light.try_normalize()? } else { view.forward };
    let n_dot_l = -n.dot(travel);
    let visible = n_dot_l > 0.0 && (!view.perspective || distance > 0.0);
    if !visible {
        return None;
    }
    let side = 2.0 * view.half_extent;
    // Distance D along `forward` of the plane over the map. Parallel: n·(side (right du +
    // down dv) + forward dD) = 0. Perspective: D = k / (n·q) with q the ray's direction of unit
    // depth, so dD = -D (n·dq) / (n·q).
    let (depth, n_dot_q) = if view.perspective {
        (distance, n.dot(from_light) / distance)
    } else {
        (1.0, n.dot(view.forward))
    };
    let slope = -depth * side / n_dot_q / (view.far_m - view.near_m);
    let at = view.project(position);
    let plane = PlaneInMap {
        u: at.x,
        v: at.y,
        z: at.z,
        dz_du: slope * n.dot(view.right),
        dz_dv: slope * n.dot(view.down),
        n_dot_l,
    };
    (at.is_finite() && plane.dz_du.is_finite() && plane.dz_dv.is_finite()).then_some(plane)
}

/// The box-filtered shadow of a receiver, 0 = shadowed, 1 = lit.
///
/// Average over the square window of side `width_uv` (map coordinates) around the receiver of
/// whether the receiver's surface is lit there. The surface above a point of the window is the hit
/// along the point's light ray that lies nearest to the receiver's *tangent plane*, within
/// [`SURFACE_REACH`], among those on the receiver's side of the surface that its triangle is
/// connected to; where there is none (beyond a table's edge), it is the plane itself. It is lit if
/// nothing lies closer to the light by more than [`PLANE_EPSILON`]. So neither a slanted plane nor
/// a curved surface shadows itself, however wide the window, while a slat just above a floor
/// shadows the floor and a leaf its neighbour. One random point in each cell of a `grid` × `grid` (0 counts as 1) raster of
/// the window, from `seed`. The window is not cut at the map's border.
///
/// A receiver that [`receiver`] refuses (facing away) gives 0. Points of the window where a
/// perspective light's ray never reaches the plane are left out; if there is no other, the result
/// is 0.
pub fn filtered_visibility(
    tracer: &Tracer,
    view: &LightView,
    surface: &Surface,
    width_uv: f64,
    grid: u32,
    seed: u64,
) -> f64 {
    let Some(plane) = receiver(view, surface) else {
        return 0.0;
    };
    let reach = reach(view, &plane, width_uv);
    let mut hits = Vec::new();
    let (mut lit, mut counted) = (0_u64, 0_u64);
    for (a, b) in stratified(grid.max(1), seed) {
        let (u, v) = (plane.u + width_uv * (a - 0.5), plane.v + width_uv * (b - 0.5));
        let Some((origin, direction, z)) =
            plane_point(view, surface.position, surface.normal, u, v)
        else {
            continue;
        };
        let ray = Ray { origin, direction, t_min: 0.0, t_max: z + reach };
        counted += 1;
        lit += u64::from(is_lit(tracer, &ray, surface.triangle, z, reach, &mut hits));
    }
    if counted == 0 { 0.0 } else { lit as f64 / counted as f64 }
}

/// [`SURFACE_REACH`] in linear depth: half the window's extent along the receiver's plane.
pub(crate) fn reach(view: &LightView, plane: &PlaneInMap, width_uv: f64) -> f64 {
    // Map coordinates in units of linear depth, at the receiver's own depth.
    let distance = view.near_m + plane.z * (view.far_m - view.near_m);
    let side = 2.0 * view.half_extent * if view.perspective { distance } else { 1.0 };
    let side = side / (view.far_m - view.near_m);
    let slope = plane.dz_du.hypot(plane.dz_dv);
    SURFACE_REACH * width_uv * side.hypot(slope)
}

/// [`filtered_visibility`] of every receiver, in parallel, each with a seed of its own; 1 where
/// there is no receiver.
pub fn filtered_visibility_all(
    tracer: &Tracer,
    view: &LightView,
    receivers: &[Option<Surface>],
    width_uv: f64,
    grid: u32,
    seed: u64,
) -> Vec<f64> {
    let one = |(i, receiver): (usize, &Option<Surface>)| match receiver {
        Some(s) => filtered_visibility(tracer, view, s, width_uv, grid, seed_of(seed, i)),
        None => 1.0,
    };
    receivers.par_iter().enumerate().map(one).collect()
}

/// The light ray above map point (u, v), and the depth at which it meets the tangent plane.
pub(crate) fn plane_point(
    view: &LightView,
    position: DVec3,
    normal: DVec3,
    u: f64,
    v: f64,
) -> Option<(DVec3, DVec3, f64)> {
    let (origin, direction): (DVec3, DVec3) = view.ray(u, v);
    let closing = -normal.dot(direction);
    let z = normal.dot(origin - position) / closing;
    let reached = if view.perspective {
        // In front of the light, where the ray still falls onto the lit side.
        let light_z = -view.near_m / (view.far_m - view.near_m);
        closing > 0.0 && z > light_z
    } else {
        true
    };
    (reached && z.is_finite()).then_some((origin, direction, z))
}

/// Whether the surface of triangle `own` at about depth `z` of the ray is the first that light
/// meets.
fn is_lit(tracer: &Tracer, ray: &Ray, own: u32, z: f64, reach: f64, hits: &mut Vec<Hit>) -> bool {
    let Some(first) = tracer.closest(ray).map(|hit| hit.t) else { return true };
    if first >= z - PLANE_EPSILON {
        return true;
    }
    if first < z - reach {
        return false;
    }
    tracer.all(ray, hits);
    let surface = hits
        .iter()
        .filter(|hit| tracer.is_same_surface(hit.triangle, own, ray.direction))
        .map(|hit| hit.t)
        .min_by(|a, b| (a - z).abs().total_cmp(&(b - z).abs()));
    surface.is_some_and(|surface| first >= surface - PLANE_EPSILON)
}
