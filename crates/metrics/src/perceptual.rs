//! Errors as seen: FLIP and SSIM, on 8-bit sRGB images.
//!
//! Based on: P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom,
//! M. D. Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020 (through the
//! authors' code, LDR, 67 pixels a degree); Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli,
//! "Image Quality Assessment: From Error Visibility to Structural Similarity", 2004.
//!
//! Deviations: SSIM is that of the crate `image-compare`: windows of 8x8 that do not overlap,
//! instead of a sliding 11x11 Gaussian, and variances that are sums over the window instead of
//! means, so that the constant C2 weighs up to 64 times less. Its figures rank results but do not
//! compare with those of other programs.
//!
//! Grey values (visibility) are displayed as they are: 0..=1 becomes the sRGB code
//! `round(255 v)`, clamped, without a transfer function. Differences below half a code vanish;
//! the errors in [`mod@crate::image`] see them.
//!
//! Errors: [`MetricError::Size`], [`MetricError::Empty`], [`MetricError::TooLarge`], and
//! [`MetricError::NotFinite`] for grey values.

use image_compare::Algorithm;

use crate::error::MetricError;
use crate::sum::Sum;

/// Most pixels: the bindings index bytes with 32 bits.
const LIMIT: u64 = (i32::MAX / 3) as u64;

/// FLIP for each pixel, row-major, in 0..=1; 0 is no visible difference. Inputs are RGB8, row-major,
/// 3 bytes a pixel.
///
/// # Errors
/// See the module.
pub fn flip_map(
    width: u32,
    height: u32,
    result: &[u8],
    truth: &[u8],
) -> Result<Vec<f32>, MetricError> {
    size(width, height, 3, result.len())?;
    size(width, height, 3, truth.len())?;
    let image = |data| nv_flip::FlipImageRgb8::with_data(width, height, data);
    let map = nv_flip::flip(image(truth), image(result), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    Ok(map.to_vec())
}

/// Mean of [`flip_map`].
///
/// # Errors
/// See the module.
pub fn flip_mean(width: u32, height: u32, result: &[u8], truth: &[u8]) -> Result<f64, MetricError> {
    Ok(mean(&flip_map(width, height, result, truth)?))
}

/// [`flip_map`] of grey images in 0..=1, one value a pixel.
///
/// # Errors
/// See the module.
pub fn flip_gray_map<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    width: u32,
    height: u32,
    result: &[A],
    truth: &[B],
) -> Result<Vec<f32>, MetricError> {
    size(width, height, 1, result.len())?;
    size(width, height, 1, truth.len())?;
    flip_map(width, height, &gray_to_rgb8(result)?, &gray_to_rgb8(truth)?)
}

/// Mean of [`flip_gray_map`].
///
/// # Errors
/// See the module.
pub fn flip_gray_mean<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    width: u32,
    height: u32,
    result: &[A],
    truth: &[B],
) -> Result<f64, MetricError> {
    Ok(mean(&flip_gray_map(width, height, result, truth)?))
}

/// Structural similarity of two grey images in 0..=1: 1 is equal, 0 unrelated, negative inverted.
///
/// # Errors
/// See the module.
pub fn ssim<A: Copy + Into<f64>, B: Copy + Into<f64>>(
    width: u32,
    height: u32,
    a: &[A],
    b: &[B],
) -> Result<f64, MetricError> {
    size(width, height, 1, a.len())?;
    size(width, height, 1, b.len())?;
    similarity(width, height, codes(a)?, codes(b)?)
}

/// [`ssim`] of two RGB8 images: the least of the three channels.
///
/// # Errors
/// See the module.
pub fn ssim_rgb(width: u32, height: u32, a: &[u8], b: &[u8]) -> Result<f64, MetricError> {
    size(width, height, 3, a.len())?;
    size(width, height, 3, b.len())?;
    let channel = |data: &[u8], c: usize| data.iter().skip(c).step_by(3).copied().collect();
    let mut least = f64::INFINITY;
    for c in 0..3 {
        least = least.min(similarity(width, height, channel(a, c), channel(b, c))?);
    }
    Ok(least)
}

/// Grey values in 0..=1 (clamped) as RGB8.
///
/// # Errors
/// [`MetricError::NotFinite`].
pub fn gray_to_rgb8<A: Copy + Into<f64>>(values: &[A]) -> Result<Vec<u8>, MetricError> {
    Ok(codes(values)?.into_iter().flat_map(|code| [code; 3]).collect())
}

fn codes<A: Copy + Into<f64>>(values: &[A]) -> Result<Vec<u8>, MetricError> {
    let code = |(index, &value): (usize, &A)| {
        let value: f64 = value.into();
        if !value.is_finite() {
            return Err(MetricError::NotFinite { index });
        }
        Ok((value.clamp(0.0, 1.0) * 255.0).round() as u8)
    };
    values.iter().enumerate().map(code).collect()
}

fn similarity(width: u32, height: u32, a: Vec<u8>, b: Vec<u8>) -> Result<f64, MetricError> {
    let len = a.len();
    let wrong = || MetricError::Size { width, height, channels: 1, len };
    let a = image::GrayImage::from_raw(width, height, a).ok_or_else(wrong)?;
    let b = image::GrayImage::from_raw(width, height, b).ok_or_else(wrong)?;
    let compared = image_compare::gray_similarity_structure(&Algorithm::MSSIMSimple, &a, &b);
    compared.map(|similarity| similarity.score).map_err(|_| wrong())
}

fn size(width: u32, height: u32, channels: u32, len: usize) -> Result<(), MetricError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > LIMIT {
        return Err(MetricError::TooLarge { width, height, limit: LIMIT });
    }
    if pixels * u64::from(channels) != len as u64 {
        return Err(MetricError::Size { width, height, channels, len });
    }
    if pixels == 0 { Err(MetricError::Empty) } else { Ok(()) }
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|&v| f64::from(v)).collect::<Sum>().total() / map.len() as f64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_config::config;

    /// Smooth blobs with an edge: something to see.
    fn picture(width: u32, height: u32) -> Vec<f64> {
        let value = |i: u32| {
            let (x, y) = (f64::from(i % width), f64::from(i / width));
            let blob = 0.5 + 0.4 * (x * 0.7).sin() * (y * 0.4).cos();
            if x > f64::from(width) / 2.0 { blob } else { 1.0 - blob * 0.5 }
        };
        (0..width * height).map(value).collect()
    }

    #[test]
    fn equal_images_are_equal() {
        let a = picture(24, 17);
        assert_eq!(flip_gray_mean(24, 17, &a, &a), Ok(0.0));
        assert_eq!(ssim(24, 17, &a, &a), Ok(1.0));
    }

    #[test]
    fn flip_of_white_against_black_is_the_published_figure() {
        // No edges, so only the colour term counts: HyAB(black, white) = 100; the greatest
        // distance (Hunt-adjusted green to blue) is 203.3. With the exponent 0.7: 25.12 of 41.25;
        // remapped above the knee (0.4 of the greatest, at 0.95):
        // 0.95 + 0.05 (25.12 - 16.50) / (41.25 - 16.50) = 0.967.
        let (white, black) = ([255; 3 * 20 * 20], [0; 3 * 20 * 20]);
        let map = flip_map(20, 20, &white, &black).unwrap();
        assert_eq!(map.len(), 400);
        for v in map {
            assert!((v - 0.967).abs() < 2e-3, "{v}");
        }
    }

    #[test]
    fn flip_points_at_the_place() {
        let (width, height) = (64, 48);
        let truth = vec![0.8_f32; 64 * 48];
        let mut result = truth.clone();
        result[10 * 64 + 50] = 0.0;
        let map = flip_gray_map(width, height, &result, &truth).unwrap();
        let (worst, _) = map.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        let (x, y) = (worst as i64 % 64, worst as i64 / 64);
        assert!((x - 50).abs() <= 1 && (y - 10).abs() <= 1, "({x}, {y})");
        assert_eq!(map[40 * 64 + 5], 0.0, "far away nothing is seen");
    }

    #[test]
    fn ssim_of_constant_images_follows_the_formula() {
        // No variance: (2 m n + C1) / (m^2 + n^2 + C1) with C1 = 2.55^2, m = 51, n = 204.
        let expected =
            (2.0 * 51.0 * 204.0 + 6.5025) / (51.0_f64.powi(2) + 204.0_f64.powi(2) + 6.5025);
        let found = ssim(16, 16, &[0.2_f64; 256], &[0.8_f64; 256]).unwrap();
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn ssim_of_one_window_follows_the_formula_with_summed_variances() {
        // Stripes 0 and 255 against their inverse in one 8x8 window: means 127.5, sums of squared
        // deviations 64 * 127.5^2, covariance its negative; C1 = 6.5025, C2 = 58.5225.
        let a: Vec<f64> = (0..64).map(|i| f64::from(i % 2)).collect();
        let b: Vec<f64> = a.iter().map(|v| 1.0 - v).collect();
        let v = 64.0 * 127.5 * 127.5;
        let expected = (58.5225 - 2.0 * v) / (58.5225 + 2.0 * v);
        let found = ssim(8, 8, &a, &b).unwrap();
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn worse_images_score_worse() {
        let truth = picture(40, 32);
        let noisy = |amount: f64| -> Vec<f64> {
            truth
                .iter()
                .enumerate()
                .map(|(i, v)| (v + if i % 3 == 0 { amount } else { -amount }).clamp(0.0, 1.0))
                .collect()
        };
        let (little, much) = (noisy(0.02), noisy(0.2));
        let flip = |a: &[f64]| flip_gray_mean(40, 32, a, &truth).unwrap();
        let similar = |a: &[f64]| ssim(40, 32, a, &truth).unwrap();
        assert!(0.0 < flip(&little) && flip(&little) < flip(&much) && flip(&much) <= 1.0);
        assert!(1.0 > similar(&little) && similar(&little) > similar(&much));
    }

    #[test]
    fn colour_images() {
        let a = gray_to_rgb8(&picture(16, 16)).unwrap();
        assert_eq!(ssim_rgb(16, 16, &a, &a), Ok(1.0));
        let mut b = a.clone();
        b.iter_mut().skip(1).step_by(3).for_each(|green| *green = 255 - *green);
        assert!(ssim_rgb(16, 16, &a, &b).unwrap() < 0.9, "one channel differs");
    }

    #[test]
    fn codes_are_rounded_and_clamped() {
        let codes = gray_to_rgb8(&[-1.0_f32, 0.0, 0.5, 1.0, 7.0]).unwrap();
        assert_eq!(codes, [[0; 3], [0; 3], [128; 3], [255; 3], [255; 3]].concat());
    }

    #[test]
    fn bad_input_is_refused() {
        let wrong = Err(MetricError::Size { width: 2, height: 2, channels: 1, len: 3 });
        assert_eq!(ssim(2, 2, &[0.0_f32; 4], &[0.0_f32; 3]), wrong);
        assert!(matches!(flip_mean(2, 2, &[0; 12], &[0; 11]), Err(MetricError::Size { .. })));
        assert_eq!(flip_mean(0, 5, &[], &[]), Err(MetricError::Empty));
        assert_eq!(ssim::<f32, f32>(0, 0, &[], &[]), Err(MetricError::Empty));
        let holed = [0.0, f32::NAN, 0.0, 0.0];
        let none = Err(MetricError::NotFinite { index: 1 });
        assert_eq!(ssim(2, 2, &holed, &[0.0_f32; 4]), none);
        assert_eq!(flip_gray_mean(2, 2, &[0.0_f32; 4], &holed), none);
        assert!(matches!(
            flip_mean(u32::MAX, u32::MAX, &[], &[]),
            Err(MetricError::TooLarge { .. })
        ));
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn any_size_works_and_stays_in_range(
            width in 1..24_u32,
            height in 1..24_u32,
            seed in any::<u64>(),
        ) {
            let noise = |salt: u64| -> Vec<f64> {
                (0..u64::from(width * height))
                    .map(|i| {
                        let mixed = (i + 1).wrapping_mul(seed | 1).wrapping_add(salt);
                        f64::from((mixed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as u32 % 256)
                            / 255.0
                    })
                    .collect()
            };
            let (a, b) = (noise(1), noise(99));
            let map = flip_gray_map(width, height, &a, &b)?;
            prop_assert_eq!(map.len(), (width * height) as usize);
            prop_assert!(map.iter().all(|v| (0.0..=1.0).contains(v)));
            let similar = ssim(width, height, &a, &b)?;
            prop_assert!((-1.0 - 1e-12..=1.0 + 1e-12).contains(&similar));
            prop_assert_eq!(flip_gray_mean(width, height, &a, &a)?, 0.0);
        }
    }
}
