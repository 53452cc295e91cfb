//! What both forms check before they are timed.

use super::{case::ShadowCase, tolerance};
use crate::{
    SuiteError,
    problem::{Checked, Picture},
};
use dapple_shadows::filtering::{
    Counters, DepthMap, Estimator, Format, Receiver, Settings,
    kernel::Kernel,
    reference::{self, Rounding},
};
use std::collections::BTreeMap;

/// Every visibility must be a share.
pub fn check_range(result: &[f32], checked: &mut Checked) {
    let outside = result.iter().filter(|v| !(0.0..=1.0).contains(*v)).count();
    if outside > 0 {
        checked.violations.push(format!("{outside} visibilities are not within 0..=1"));
    }
}

/// Holds a port against the reference on the chosen pixels: each within what the port's rounding
/// may do to it there.
///
/// # Errors
/// Those of the reference.
pub fn check_port(
    case: &ShadowCase<'_>,
    settings: &Settings,
    map: &DepthMap,
    result: &[f32],
    subset: &[usize],
    rounding: &Rounding,
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    let expected = reference::expected(map, &chosen(case, subset), settings, rounding)?;
    let got: Vec<f32> = subset.iter().map(|i| result[*i]).collect();
    let deviation = tolerance::Deviation::between(&got, &expected);
    checked.port_errors.insert("visibility_max".into(), deviation.max);
    checked.port_errors.insert("visibility_beyond".into(), deviation.share_beyond);
    checked.violations.extend(deviation.violation(settings));
    Ok(())
}

/// The error of the estimator alone: against the exact share of the same stored depths that are
/// not nearer than the receiver, with the same window, lookup and bias.
///
/// # Errors
/// Those of the reference.
pub fn estimator_error(
    case: &ShadowCase<'_>,
    settings: &Settings,
    map: &DepthMap,
    result: &[f32],
    subset: &[usize],
    checked: &mut Checked,
) -> Result<(), SuiteError> {
    let exact =
        Settings { estimator: Estimator::Pcf { taps: 0 }, format: Format::F32, ..*settings };
    let expected = reference::visibility(map, &chosen(case, subset), &exact)?;
    let got: Vec<f32> = subset.iter().map(|i| result[*i]).collect();
    let error = dapple_metrics::rmse(&got, &expected, None)?;
    checked.errors.insert("estimator_rmse".into(), error);
    Ok(())
}

fn chosen(case: &ShadowCase<'_>, subset: &[usize]) -> Vec<Receiver> {
    subset.iter().map(|i| case.receivers()[*i]).collect()
}

/// Hardware-independent work of a frame.
pub fn counters(
    case: &ShadowCase<'_>,
    settings: &Settings,
    work: &Counters,
) -> BTreeMap<String, u64> {
    let receivers = case.mask().iter().filter(|m| **m).count() as u64;
    let kernel =
        if settings.estimator == Estimator::Hard { 1 } else { Kernel::of(settings).support() };
    [
        ("texels_fetched", work.texels_fetched),
        ("prefilter_texels", work.prefilter_texels),
        ("shade_texels", work.shade_texels),
        ("bytes_read", work.bytes_read),
        ("bytes_written", work.bytes_written),
        ("kernel_texels", kernel as u64),
        ("receivers", receivers),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into()
}

/// Truth and result; pixels that take no part are the truth's in both.
pub fn picture(case: &ShadowCase<'_>, result: &[f32]) -> Picture {
    let [width, height] = case.size();
    let shown = result.iter().zip(case.truth()).zip(case.mask());
    let result = shown.map(|((v, truth), mask)| if *mask { *v } else { *truth }).collect();
    Picture { width, height, truth: case.truth().to_vec(), result }
}
