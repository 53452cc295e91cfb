//! Errors of a result against its truth, and summaries of samples.
//!
//! Inputs are plain slices of `f32`, `f64` or anything that widens to `f64` exactly. All sums are
//! Neumaier-compensated `f64`: their error does not grow with the number of pixels. Nothing is
//! clamped; a NaN or infinity that would take part is refused with its index.

pub mod bands;
pub mod depth;
pub mod edge;
pub mod error;
pub mod image;
mod input;
pub mod perceptual;
pub mod set;
pub mod stats;
mod sum;
#[cfg(test)]
mod test_config;

pub use error::MetricError;
pub use image::{bias, leak_energy, loss_energy, mae, max_abs, percentile_abs, psnr, rmse};
pub use perceptual::{
    flip_gray_map, flip_gray_mean, flip_map, flip_mean, gray_to_rgb8, ssim, ssim_rgb,
};
