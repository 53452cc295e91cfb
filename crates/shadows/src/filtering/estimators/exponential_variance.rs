//! Based on: Andrew Lauritzen and Michael McCool, "Layered variance shadow maps", Graphics
//! Interface 2008, section 5 (exponential warps); Andrew Lauritzen, Marco Salvi, Aaron Lefohn,
//! "Sample distribution shadow maps", I3D 2011, appendix (both warps, the smaller bound).
//!
//! Deviations: one exponent for both warps, 10 by default where published code has 40 or 42 for
//! the positive and 5 or an eighth for the negative one; the minimum variance is scaled by the
//! squared derivative of the warp at the receiver; the moments are divided by the larger of mean and
//! receiver before they are squared, so that nothing overflows up to the format's limit.
//! Receivers beyond the far plane are dark and receivers before the near plane lit, so that the
//! warp is never evaluated outside 0..=1.

use super::{Real, chebyshev};

/// `exp(c (2 z - 1))`.
#[inline]
pub fn warp_positive<R: Real>(z: R, c: R) -> R {
    (c * (z + z - R::of(1.0))).exp()
}

/// `-exp(-c (2 z - 1))`; increases with `z` as the positive warp does.
#[inline]
pub fn warp_negative<R: Real>(z: R, c: R) -> R {
    -(-(c * (z + z - R::of(1.0)))).exp()
}

/// Chebyshev's bound over the positive warp, from its mean and mean square.
#[inline]
pub fn visibility2<R: Real>(mean: R, mean_square: R, z: R, c: R, min_variance: R) -> R {
    match outside(z) {
        Some(visibility) => visibility,
        None => warped_bound(mean, mean_square, warp_positive(z, c), c, min_variance),
    }
}

/// The smaller of the bounds over both warps; `moments` are mean and mean square of the positive
/// warp, then of the negative one.
#[inline]
pub fn visibility4<R: Real>(moments: [R; 4], z: R, c: R, min_variance: R) -> R {
    if let Some(visibility) = outside(z) {
        return visibility;
    }
    let [positive, positive_square, negative, negative_square] = moments;
    let front = warped_bound(positive, positive_square, warp_positive(z, c), c, min_variance);
    let back = warped_bound(negative, negative_square, warp_negative(z, c), c, min_variance);
    front.at_most(back)
}

#[inline]
fn outside<R: Real>(z: R) -> Option<R> {
    if z > R::of(1.0) {
        Some(R::of(0.0))
    } else if z < R::of(0.0) {
        Some(R::of(1.0))
    } else {
        None
    }
}

#[inline]
fn warped_bound<R: Real>(mean: R, mean_square: R, warped: R, c: R, min_variance: R) -> R {
    if warped <= mean {
        return R::of(1.0);
    }
    let scale = R::of(1.0) / warped.abs().at_least(mean.abs());
    let receiver = warped * scale;
    // d(warp)/dz = 2 c |warp|
    let slope = R::of(2.0) * c * receiver;
    let floor = min_variance * slope * slope;
    chebyshev::visibility(mean * scale, mean_square * scale * scale, receiver, floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of a window with share `p` at `near` and the rest at `far`.
    fn moments<R: Real>(p: f64, near: f64, far: f64, c: f64) -> [R; 4] {
        let mean = |f: &dyn Fn(f64) -> f64| R::of(p * f(near) + (1.0 - p) * f(far));
        [
            mean(&|z| warp_positive(z, c)),
            mean(&|z| warp_positive(z, c).powi(2)),
            mean(&|z| warp_negative(z, c)),
            mean(&|z| warp_negative(z, c).powi(2)),
        ]
    }

    #[test]
    fn two_depths_are_exact_at_the_farther_one() {
        for p in [0.1, 0.5, 0.9] {
            let m = moments::<f64>(p, 0.3, 0.6, 5.0);
            assert!((visibility2(m[0], m[1], 0.6, 5.0, 0.0) - (1.0 - p)).abs() < 1e-9);
            assert!((visibility4(m, 0.6, 5.0, 0.0) - (1.0 - p)).abs() < 1e-9);
        }
    }

    #[test]
    fn nothing_overflows_in_f32_at_the_limit() {
        let c = 44.0;
        for near in [0.0, 0.5, 0.999] {
            for far in [0.001, 0.5, 1.0] {
                let m = moments::<f32>(0.5, near, far, f64::from(c));
                assert!(m.iter().all(|m| m.is_finite()), "{m:?}");
                for i in -1..=101 {
                    let z = i as f32 / 100.0;
                    for min_variance in [0.0, 1e-5, 1.0] {
                        let v = visibility4(m, z, c, min_variance);
                        assert!((0.0..=1.0).contains(&v), "{near} {far} {z}: {v}");
                    }
                }
            }
        }
    }

    #[test]
    fn warps_increase_with_depth() {
        assert!(warp_positive(0.6, 5.0) > warp_positive(0.5f64, 5.0));
        assert!(warp_negative(0.6, 5.0) > warp_negative(0.5f64, 5.0));
    }
}
