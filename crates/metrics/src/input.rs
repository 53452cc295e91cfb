//! Checked pairs of elements.

use crate::error::MetricError;

/// A pair that takes part, with its index.
pub(crate) struct Pair {
    pub(crate) index: usize,
    pub(crate) a: f64,
    pub(crate) b: f64,
}

/// All pairs that the mask selects. Elements that it leaves out may be anything.
pub(crate) fn pairs<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    a: &[A],
    b: &[B],
    mask: Option<&[bool]>,
) -> Result<Vec<Pair>, MetricError> {
    if a.len() != b.len() {
        return Err(MetricError::Length { left: a.len(), right: b.len() });
    }
    if let Some(mask) = mask
        && mask.len() != a.len()
    {
        return Err(MetricError::Length { left: a.len(), right: mask.len() });
    }
    let mut pairs = Vec::with_capacity(a.len());
    for (index, (&a, &b)) in a.iter().zip(b).enumerate() {
        if mask.is_some_and(|mask| !mask[index]) {
            continue;
        }
        let (a, b): (f64, f64) = (a.into(), b.into());
        // The difference of finite values may overflow.
        if !a.is_finite() || !b.is_finite() || !(a - b).is_finite() {
            return Err(MetricError::NotFinite { index });
        }
        pairs.push(Pair { index, a, b });
    }
    if pairs.is_empty() { Err(MetricError::Empty) } else { Ok(pairs) }
}

pub(crate) fn finite(values: &[f64]) -> Result<(), MetricError> {
    if values.is_empty() {
        return Err(MetricError::Empty);
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(MetricError::NotFinite { index }),
        None => Ok(()),
    }
}
