//! Where the camera's view depth is cut.
//!
//! Based on: Zhang et al. 2006 (`zhang2006`), the practical split scheme:
//! `C_i = lambda n (f / n)^(i / m) + (1 - lambda) (n + (f - n) i / m)`.
//!
//! Deviation: the logarithmic part is written with `expm1` and `ln_1p`, which keeps its digits
//! where far comes close to near.

use super::{CascadeError, MAX_CASCADES};

/// View depths `C_0..=C_m` of `count` = m slices between `near` and `far`.
///
/// `C_0 = near` and `C_m = far` exactly, and the depths increase strictly. `lambda` 0 gives
/// [`uniform_split`] and 1 [`logarithmic_split`], to the bit.
///
/// # Errors
/// [`CascadeError::Count`]; [`CascadeError::Range`] unless 0 < near < far, finite;
/// [`CascadeError::Knob`] for a `lambda` outside 0..=1; [`CascadeError::Narrow`] where near and
/// far are so close that two depths would be the same number.
pub fn splits(near: f64, far: f64, count: usize, lambda: f64) -> Result<Vec<f64>, CascadeError> {
    if !(1..=MAX_CASCADES).contains(&count) {
        return Err(CascadeError::Count { count });
    }
    if !(near > 0.0 && near < far && (far / near).is_finite()) {
        return Err(CascadeError::Range { near, far });
    }
    if !(0.0..=1.0).contains(&lambda) {
        return Err(CascadeError::Knob { name: "lambda", value: lambda, limit: "within 0..=1" });
    }
    let inner = |i| {
        let logarithmic = logarithmic_split(near, far, i, count);
        let uniform = uniform_split(near, far, i, count);
        // Both ends as they are: a sum with 0 times the other need not be.
        if lambda == 0.0 {
            uniform
        } else if lambda == 1.0 {
            logarithmic
        } else {
            lambda * logarithmic + (1.0 - lambda) * uniform
        }
    };
    let mut depths = vec![near];
    depths.extend((1..count).map(inner));
    depths.push(far);
    if depths.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(CascadeError::Narrow { near, far, count });
    }
    Ok(depths)
}

/// The `i`-th of `count` + 1 depths at equal distances.
#[must_use]
pub fn uniform_split(near: f64, far: f64, i: usize, count: usize) -> f64 {
    near + (far - near) * (i as f64 / count as f64)
}

/// The `i`-th of `count` + 1 depths of equal ratios.
#[must_use]
pub fn logarithmic_split(near: f64, far: f64, i: usize, count: usize) -> f64 {
    let share = i as f64 / count as f64;
    near + near * (share * ((far - near) / near).ln_1p()).exp_m1()
}
