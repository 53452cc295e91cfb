//! What all forms check before they are timed, and how a map's own error is told apart.

use super::{case::TranslucentCase, errors, settings};
use crate::{
    SuiteError, memory,
    problem::{Checked, Setting},
};
use dapple_opacity_maps::{
    Code, Format, Fragments, Model, Receiver, Settings, Taps,
    exact::Exact,
    reference::Reference,
    taps::{self, MOST, Tap},
};
use rayon::prelude::*;
use std::rc::Rc;

/// Most receivers held against the reference.
pub const MOST_CHECKED: usize = 4096;

/// Steps along a light ray in which banding is looked for.
const STEPS: usize = 128;

/// Rays that banding is looked for on.
const RAYS: usize = 2048;

/// What a setting's map is made of and judged by.
pub struct Grid {
    /// Side of the map, texels.
    pub resolution: u32,
    /// Whether the map is cropped to what casts and receives.
    pub crop: bool,
    /// Thickness model.
    pub model: Model,
    /// Fragments by that model.
    pub fragments: Rc<Fragments>,
    /// The same, sorted.
    pub own: Rc<Exact>,
    /// Sorted fragments by the truth's law.
    pub law: Rc<Exact>,
    /// Receivers in the map's coordinates.
    pub receivers: Rc<Vec<Receiver>>,
}

impl Grid {
    /// Finds the map's fragments if no other setting has.
    ///
    /// # Errors
    /// More fragments than memory allows.
    pub fn of(
        case: &TranslucentCase<'_>,
        crop: bool,
        resolution: u32,
        model: Model,
    ) -> Result<Self, SuiteError> {
        Ok(Self {
            resolution,
            crop,
            model,
            fragments: case.fragments(crop, resolution, model)?,
            own: case.exact(crop, resolution, model)?,
            law: case.exact(crop, resolution, case.law())?,
            receivers: case.receivers(crop),
        })
    }

    /// The map that a setting asks for, and what it stores.
    ///
    /// # Errors
    /// Settings that are refused, or more fragments than memory allows.
    pub fn asked(
        case: &TranslucentCase<'_>,
        setting: &Setting,
    ) -> Result<(Self, Settings), SuiteError> {
        let (resolution, crop) = (settings::resolution(setting)?, settings::crop(setting)?);
        let grid = Self::of(case, crop, resolution, settings::model(setting)?)?;
        let settings = settings::settings(setting, || Ok(grid.own.deepest_span()))?;
        Ok((grid, settings))
    }
}

/// Every transmittance must be a share.
pub fn check_range(result: &[f32], checked: &mut Checked) {
    let outside = result.iter().filter(|v| !(0.0..=1.0).contains(*v)).count();
    if outside > 0 {
        checked.violations.push(format!("{outside} transmittances are not within 0..=1"));
    }
}

/// All errors of a result: against truth, against the deep shadow map of the same texels, and the
/// latter's own.
///
/// # Errors
/// A value that is not finite.
pub fn measure(
    case: &TranslucentCase<'_>,
    grid: &Grid,
    settings: &Settings,
    result: &[f32],
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    check_range(result, checked);
    checked.errors = errors::against_truth(case, result)?;
    let own = deep(grid, &grid.own, settings);
    let law = deep(grid, &grid.law, settings);
    let plain = Settings { taps: Taps::One, ..settings.clone() };
    let one_tap = deep(grid, &grid.law, &plain);
    for (name, a, b) in [
        ("layering_rmse", result, own.as_slice()),
        ("model_rmse", own.as_slice(), law.as_slice()),
        ("map_rmse", one_tap.as_slice(), case.truth()),
    ] {
        checked.errors.insert(name.into(), dapple_metrics::rmse(a, b, Some(case.mask()))?);
    }
    Ok(())
}

/// What the uncompressed deep shadow map says at every receiver, with the setting's taps, bias and
/// opaque map (a weight counts as opaque).
pub fn deep(grid: &Grid, exact: &Exact, settings: &Settings) -> Vec<f32> {
    let fragments: &Fragments = &grid.fragments;
    let one = |receiver: &Receiver| {
        if !receiver.in_map() {
            return 1.0;
        }
        let mut found = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
        let (width, height) = (fragments.width, fragments.height);
        let n = taps::taps(settings.taps, receiver, width, height, &mut found);
        let depth = receiver.depth - settings.bias;
        let sum: f64 = found[..n]
            .iter()
            .map(|tap| {
                let plane = receiver.plane_depth(tap.du, tap.dv) - settings.bias;
                let lit = plane <= fragments.opaque[tap.texel];
                if lit { exact.transmittance(tap.texel, depth) } else { 0.0 }
            })
            .sum();
        (sum / n as f64) as f32
    };
    grid.receivers.par_iter().map(one).collect()
}

/// Root mean squared step of the layering error along light rays: `transmittance(texel, depth)`
/// against the deep shadow map, in [`STEPS`] steps over each ray's extent, on at most [`RAYS`] rays
/// that meet something.
pub fn banding(grid: &Grid, transmittance: impl Fn(usize, f32) -> f32 + Sync) -> Option<f64> {
    let (fragments, own): (&Fragments, &Exact) = (&grid.fragments, &grid.own);
    let texels = fragments.texels();
    let covered: Vec<usize> = (0..texels).filter(|t| own.ends(*t).is_some()).collect();
    let stride = covered.len().div_ceil(RAYS).max(1);
    let rays: Vec<usize> = covered.into_iter().step_by(stride).collect();
    let one = |texel: &usize| {
        let (near, far) = own.ends(*texel)?;
        // A little beyond both ends, where light must be whole and darkness complete.
        let reach = 0.05 * (far - near).max(1e-4);
        let at = |i: usize| near - reach + (far - near + 2.0 * reach) * i as f32 / STEPS as f32;
        let error = |i: usize| {
            let depth = at(i);
            f64::from(transmittance(*texel, depth)) - own.transmittance(*texel, depth)
        };
        let errors: Vec<f64> = (0..=STEPS).map(error).collect();
        dapple_metrics::bands::banding(&errors).ok().map(|step| step * step)
    };
    let sums: Vec<f64> = rays.par_iter().filter_map(one).collect();
    (!sums.is_empty()).then(|| (sums.iter().sum::<f64>() / sums.len() as f64).sqrt())
}

/// Share of (ray, layer) cells that no fragment falls into, over rays that meet one. `sums` gives a
/// texel's cumulative layers.
pub fn idle_layers<'a>(
    fragments: &Fragments,
    layers: usize,
    sums: impl Fn(usize) -> &'a [f32],
) -> Option<f64> {
    let (mut idle, mut cells) = (0_u64, 0_u64);
    for texel in (0..fragments.texels()).filter(|t| !fragments.texel(*t).is_empty()) {
        let mut before = 0.0;
        for &sum in &sums(texel)[..layers] {
            idle += u64::from(sum <= before);
            before = sum;
        }
        cells += layers as u64;
    }
    (cells > 0).then(|| idle as f64 / cells as f64)
}

/// The thickness model that the truth's law is.
pub fn law_model(law: &str) -> Model {
    if law == "exponential" { Model::ExpAlpha } else { Model::ExpTau }
}

/// Hardware-independent work of a frame.
pub fn counters(
    grid: &Grid,
    settings: &Settings,
    maps: &dapple_opacity_maps::cpu::Maps,
) -> std::collections::BTreeMap<String, u64> {
    let valid = grid.receivers.iter().filter(|r| r.in_map()).count() as u64;
    let taps = match settings.taps {
        Taps::One => 1,
        Taps::Box3 => 9,
        Taps::Box4 | Taps::Stochastic16 => 16,
    };
    [
        ("fragments", grid.fragments.items.len() as u64),
        ("geometry_passes", maps.code().geometry_passes()),
        ("map_bytes", maps.map_bytes()),
        ("receivers", valid),
        ("texels_fetched", valid * taps),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into()
}

/// Share of receivers that may lie outside what rounding can do to them: those whose opaque
/// comparison or hash is a tie.
pub const TIES: f64 = 0.005;

/// What rounding may do to a transmittance beyond the reference's own interval, by what is stored.
/// Processor and device stay a decade below: sums of f32 differ by 1e-7 a layer, halves may be
/// rounded towards zero by a device (3e-3 seen), bytes by a step of 1/255 an addition, and the
/// matrix of six moments magnifies what f32 leaves (2e-3 seen). Each of the `most` fragments of a
/// texel may cost half a unit in the last place of an f32 sum, and T no more than Ω.
pub fn tolerance(settings: &Settings, most: usize) -> f64 {
    let format = match &settings.code {
        Code::Layered(layered) => layered.format,
        Code::Fourier(fourier) => fourier.format,
        Code::Moments(moments) => moments.format,
        _ => Format::F32,
    };
    let sums = most as f64 * 2f64.powi(-24);
    let stored = match (&settings.code, format) {
        (Code::Moments(m), Format::F32) => {
            if m.moments == 4 {
                1e-3
            } else {
                1e-2
            }
        }
        (Code::Moments(_), _) => 5e-2,
        (_, Format::F32 | Format::Fixed) => 1e-4,
        (_, _) => 2e-2,
    };
    stored + sums
}

/// Holds a seeded choice of receivers against the reference on the fragments that the port had.
///
/// # Errors
/// Settings or fragments that the reference refuses.
pub fn hold(
    case: &TranslucentCase<'_>,
    grid: &Grid,
    settings: &Settings,
    fragments: &Fragments,
    result: &[f32],
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    let reference = Reference::new(settings, fragments)?;
    let (subset, receivers) = (case.subset(MOST_CHECKED), &grid.receivers[..]);
    let allowed: Vec<(f64, f64)> =
        subset.par_iter().map(|i| reference.interval(&receivers[*i])).collect();
    let got: Vec<f32> = subset.iter().map(|i| result[*i]).collect();
    check_port(settings, fragments, &got, &allowed, checked);
    Ok(())
}

/// Holds a port against the intervals in which the reference allows transmittances to lie.
pub fn check_port(
    settings: &Settings,
    fragments: &Fragments,
    got: &[f32],
    allowed: &[(f64, f64)],
    checked: &mut Checked,
) {
    let most = fragments.starts.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(0) as usize;
    let beyond = |(value, (least, most)): (&f32, &(f64, f64))| {
        let value = f64::from(*value);
        let outside = (least - value).max(value - most).max(0.0);
        if value.is_nan() { f64::INFINITY } else { outside }
    };
    let outside: Vec<f64> = got.iter().zip(allowed).map(beyond).collect();
    let max = outside.iter().copied().fold(0.0, f64::max);
    let tolerance = tolerance(settings, most);
    let share =
        outside.iter().filter(|d| **d > tolerance).count() as f64 / outside.len().max(1) as f64;
    checked.port_errors.insert("transmittance_max".into(), max);
    checked.port_errors.insert("transmittance_beyond".into(), share);
    if share > TIES || !max.is_finite() {
        checked.violations.push(format!(
            "port: {:.2} % of receivers lie more than {tolerance} outside what rounding can do to \
             the reference (allowed: {} %; farthest {max:.5})",
            100.0 * share,
            100.0 * TIES
        ));
    }
}

/// Refuses maps that the machine's memory cannot hold: numbers of 4 bytes on the processor,
/// whatever the format.
///
/// # Errors
/// [`SuiteError::Value`] with the bytes and the limit.
pub fn check_host(resolution: u32, settings: &Settings) -> Result<(), SuiteError> {
    let words = dapple_opacity_maps::code::of(settings).words() as u64;
    let bytes = 4 * (words + 1) * u64::from(resolution).pow(2);
    memory::check_host(resolution, &format!("{words} numbers a texel"), bytes)
}
