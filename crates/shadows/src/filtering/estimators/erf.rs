//! Based on: Sergei Winitzki, "A handy approximation for the error function and its inverse",
//! 2008, eq. 2; Jesus Gumbau, "Techniques for improving the visualization of natural scenes",
//! 2011, section 7.2.1.
//!
//! Deviations: the sign, which the printed form lacks; `exp_m1` against cancellation near 0 and
//! the complement without subtraction from 1.

use std::f64::consts::PI;

use super::Real;

/// `8 (pi - 3) / (3 pi (4 - pi))`, about 0.140012: exact to first order at 0 and at infinity.
/// Largest absolute error 3.4e-4.
pub const A: f64 = 8.0 * (PI - 3.0) / (3.0 * PI * (4.0 - PI));

/// The choice with the smallest largest absolute error, 1.2e-4.
pub const A_MINIMAX: f64 = 0.147;

/// Beyond this both precisions have `erf = 1` exactly, and `x^2` cannot overflow below.
const SATURATED: f64 = 30.0;

/// `x^2 (4/pi + a x^2) / (1 + a x^2)` for x >= 0.
#[inline]
fn exponent<R: Real>(x: R, a: f64) -> R {
    let x = x.at_most(R::of(SATURATED));
    let square = x * x;
    let ax = R::of(a) * square;
    square * (R::of(4.0 / PI) + ax) / (R::of(1.0) + ax)
}

/// The error function approximated with the constant `a`; odd, monotone, within -1..=1.
#[inline]
pub fn erf_with<R: Real>(x: R, a: f64) -> R {
    let magnitude = (-(-exponent(x.abs(), a)).exp_m1()).sqrt();
    if x < R::of(0.0) { -magnitude } else { magnitude }
}

/// The error function approximated with [`A`].
#[inline]
pub fn erf<R: Real>(x: R) -> R {
    erf_with(x, A)
}

/// `1 - erf(x)` for x >= 0, with full relative precision of the approximation in the tail.
#[inline]
pub fn erfc_positive<R: Real>(x: R) -> R {
    // 1 - sqrt(1 - e) = e / (1 + sqrt(1 - e))
    (-exponent(x, A)).exp() / (R::of(1.0) + erf(x))
}

/// The formula as printed, without sign: even instead of odd. Kept as a deliberate fault.
#[inline]
pub fn erf_printed<R: Real>(x: R) -> R {
    erf(x.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_is_the_printed_one() {
        assert!((A - 0.140_012).abs() < 5e-7);
    }

    #[test]
    fn ends_and_zero() {
        assert_eq!(erf(0.0f64), 0.0);
        assert_eq!(erf(f32::INFINITY), 1.0);
        assert_eq!(erf(f32::NEG_INFINITY), -1.0);
        assert_eq!(erfc_positive(0.0f32), 1.0);
        assert_eq!(erfc_positive(f32::MAX), 0.0);
        // Slope at 0 is 2 / sqrt(pi).
        assert!((erf(1e-9f64) / 1e-9 - 2.0 / PI.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn complement_agrees_where_subtraction_is_safe() {
        for i in 0..200 {
            let x = f64::from(i) * 0.01;
            assert!((erfc_positive(x) - (1.0 - erf(x))).abs() < 1e-15);
        }
    }
}
