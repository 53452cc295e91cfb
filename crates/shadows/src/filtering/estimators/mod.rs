//! From the statistics of a window to a visibility, one file an algorithm.
//!
//! Every function takes the filtered statistics and the receiver's biased depth and gives a
//! visibility in 0..=1. Each is written once over [`Real`] and used in f64 by the reference and
//! in f32 by the CPU form; the shaders carry their own text.

pub mod chebyshev;
pub mod erf;
pub mod exponential;
pub mod exponential_variance;
pub mod gaussian;
pub mod layered;
pub mod moments;
pub mod power;
mod real;
pub mod step;

pub use real::Real;
