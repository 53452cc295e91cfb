//! Round leaves over a slanted floor, seen by a camera that looks along v.

use dapple_shadows::cascades::lookup::Region;
use dapple_shadows::cascades::{
    Cascade, CascadeReceiver, CasterBox, Fit, Settings, Taps, fit, splits,
};
use dapple_shadows::filtering::DepthMap;
use rand::RngExt;

use crate::gpu_support::rng;

pub const NEAR: f64 = 1.0;
pub const FAR: f64 = 100.0;

/// Slopes of the floor, depth per unit of u and v.
pub const SLOPE: [f64; 2] = [0.2, 0.1];

pub fn floor(u: f64, v: f64) -> f64 {
    0.6 + SLOPE[0] * u + SLOPE[1] * v
}

/// Depth of the leaves.
pub const LEAF: f64 = 0.4;
/// Leaves stand on a grid of this many to a unit, each a disc.
const LEAVES: f64 = 12.0;
const RADIUS: f64 = 0.3 / LEAVES;

/// Distance to the nearest leaf's rim, positive outside.
pub fn rim(u: f64, v: f64) -> f64 {
    let off = |x: f64| (x * LEAVES).floor() / LEAVES + 0.5 / LEAVES - x;
    off(u).hypot(off(v)) - RADIUS
}

pub fn nearest(u: f64, v: f64) -> f64 {
    if rim(u, v) <= 0.0 { LEAF } else { floor(u, v) }
}

/// The camera stands at v = 0 and sees a trapezoid that widens along v.
pub fn view_depth(v: f64) -> f64 {
    NEAR + (FAR - NEAR) * v
}

fn half_width(v: f64) -> f64 {
    0.02 + 0.48 * v
}

pub fn corners(near: f64, far: f64) -> [[f64; 2]; 8] {
    let v = |depth: f64| (depth - NEAR) / (FAR - NEAR);
    let mut all = [[0.0; 2]; 8];
    for (i, corner) in all.iter_mut().enumerate() {
        let v = v(if i < 4 { near } else { far });
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        *corner = [0.5 + side * half_width(v), v];
    }
    all
}

pub fn cascades(count: usize, lambda: f64, side: u32, margin_texels: u32) -> Vec<Cascade> {
    let splits = splits(NEAR, FAR, count, lambda).unwrap();
    let slices: Vec<_> = splits.windows(2).map(|pair| corners(pair[0], pair[1])).collect();
    fit(&splits, &slices, &CasterBox::WHOLE, Fit { side, margin_texels }).unwrap()
}

/// A function of base map coordinates at the texel centres of each cascade.
pub fn maps(cascades: &[Cascade], side: u32, depth: impl Fn(f64, f64) -> f64) -> Vec<DepthMap> {
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let map = |cascade: &Cascade| {
        let texels = (0..side).flat_map(|y| (0..side).map(move |x| [centre(x), centre(y)]));
        let depths = texels.map(|local| {
            let [u, v] = if cascade.is_empty() { local } else { cascade.base(local) };
            if cascade.is_empty() { 1.0 } else { depth(u, v) as f32 }
        });
        DepthMap { width: side, height: side, depths: depths.collect() }
    };
    cascades.iter().map(map).collect()
}

/// Receivers on the floor within the camera's view.
pub fn receivers(count: usize, seed: u64) -> Vec<CascadeReceiver> {
    let mut rng = rng(seed);
    let one = |_| {
        let v = rng.random_range(0.001..0.999f64);
        let u = 0.5 + half_width(v) * rng.random_range(-0.99..0.99);
        CascadeReceiver::at(u as f32, v as f32, floor(u, v) as f32, view_depth(v) as f32)
            .with_slope(SLOPE[0] as f32, SLOPE[1] as f32)
    };
    (0..count).map(one).collect()
}

/// Whether a receiver on the floor is lit, where it lies further than `texels` from a rim.
pub fn truth(r: &CascadeReceiver, cascades: &[Cascade], side: u32, texels: f64) -> Option<f64> {
    let regions: Vec<_> = cascades.iter().map(|c| Region::new(c, side)).collect();
    let cascade = dapple_shadows::cascades::lookup::select(&regions, r.view_depth);
    let texel = cascades[cascade].scale / f64::from(side);
    let rim = rim(f64::from(r.u), f64::from(r.v));
    (rim.abs() > texels * texel).then_some(if rim > 0.0 { 1.0 } else { 0.0 })
}

/// Every kind of taps with each way of biasing.
pub fn all_settings() -> Vec<Settings> {
    let mut all = Vec::new();
    for taps in Taps::ALL {
        all.push(Settings::new(taps));
        all.push(Settings { bias: 1e-3, slope_bias: 0.7, plane_bias: false, taps });
        all.push(Settings { bias: 0.0, slope_bias: 0.3, plane_bias: true, taps });
    }
    all
}
