//! Cascades over a case: slices of the camera's view, their maps by rays, receivers by view depth.

use super::{case::TranslucentCase, settings};
use crate::{
    SuiteError,
    knob::{Get, choice},
    problem::Setting,
};
use dapple_opacity_maps::Receiver;
use dapple_scene::Camera;
use dapple_shadows::{
    cascades::{self, Cascade, CascadeReceiver, CasterBox, Fit, Settings, Taps},
    filtering::DepthMap,
};
use dapple_trace::Ray;
use glam::DVec3;
use rayon::prelude::*;

/// What a setting asks of cascades.
pub struct Wishes {
    /// Side of each map, texels.
    pub side: u32,
    /// The slices with their regions.
    pub cascades: Vec<Cascade>,
    /// Taps and biases.
    pub settings: Settings,
}

/// Fits cascades to the camera's view of everything placed.
///
/// # Errors
/// Knobs out of range.
pub fn wishes(case: &TranslucentCase<'_>, setting: &Setting) -> Result<Wishes, SuiteError> {
    let side = settings::resolution(setting)?;
    let taps = [("3x3", Taps::Box3), ("1", Taps::One), ("4x4", Taps::Box4)];
    let taps = choice(&setting.knobs, "taps", &taps)?;
    let bias = setting.knobs.float("bias")? as f32;
    let settings = Settings { bias, ..Settings::new(taps) };
    let count = settings::whole(&setting.knobs, "splits", 1, 8)? as usize;
    let [near, far] = depths(case);
    let splits = cascades::splits(near, far, count, setting.knobs.float("split_lambda")?)?;
    let slices: Vec<[[f64; 2]; 8]> =
        splits.windows(2).map(|range| slice(case, range[0], range[1])).collect();
    let how = Fit { side, margin_texels: taps.reach() };
    let cascades = cascades::fit(&splits, &slices, &CasterBox::WHOLE, how)?;
    Ok(Wishes { side, cascades, settings })
}

/// View depths of everything placed: where the camera's planes lie.
fn depths(case: &TranslucentCase<'_>) -> [f64; 2] {
    let along = |p: DVec3| view_depth(case.camera(), p);
    let corners = case.casters().bounds().corners().map(along);
    let far = corners.into_iter().fold(0.0, f64::max) * 1.001;
    let near = corners.into_iter().fold(f64::INFINITY, f64::min) * 0.999;
    // A camera among the things it sees still has a near plane in front of it.
    [near.max(1e-3 * far), far.max(f64::MIN_POSITIVE)]
}

/// Distance from the camera along its axis.
pub fn view_depth(camera: &Camera, p: DVec3) -> f64 {
    let forward = (camera.target - camera.position).normalize_or_zero();
    (p - camera.position).dot(forward)
}

/// The corners of the camera's frustum between two view depths, in base map coordinates.
fn slice(case: &TranslucentCase<'_>, near: f64, far: f64) -> [[f64; 2]; 8] {
    let camera = case.camera();
    let forward = (camera.target - camera.position).normalize_or_zero();
    let [width, height] = case.size().map(f64::from);
    std::array::from_fn(|i| {
        let (x, y) = ((i & 1) as f64, (i >> 1 & 1) as f64);
        let depth = if i < 4 { near } else { far };
        let (origin, direction) = camera.ray(x, y, width / height);
        let at = origin + direction * (depth / direction.dot(forward));
        let at = case.view(false).project(at);
        [at.x, at.y]
    })
}

/// Receivers as cascades take them.
pub fn receivers(case: &TranslucentCase<'_>) -> Vec<CascadeReceiver> {
    let one = |(r, depth): (&Receiver, &f32)| {
        let mut receiver = CascadeReceiver::at(r.u, r.v, r.depth, *depth);
        if r.flags & Receiver::VALID == 0 {
            receiver.flags = 0;
        }
        receiver.with_slope(r.slope_u, r.slope_v)
    };
    case.receivers(false).iter().zip(case.view_depths()).map(one).collect()
}

/// The nearest depth of anything through each texel of a cascade's map, by rays.
pub fn depth_map(case: &TranslucentCase<'_>, cascade: &Cascade, side: u32) -> DepthMap {
    let (view, tracer) = (case.view(false), case.tracer());
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let texel = |x: u32, y: u32| {
        let [u, v] = cascade.base([centre(x), centre(y)]);
        let (origin, direction) = view.ray(u, v);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: 1.0 };
        tracer.closest(&ray).map_or(1.0, |hit| hit.t as f32)
    };
    let depths = if cascade.is_empty() {
        vec![1.0; side as usize * side as usize]
    } else {
        (0..side).into_par_iter().flat_map_iter(|y| (0..side).map(move |x| texel(x, y))).collect()
    };
    DepthMap { width: side, height: side, depths }
}
