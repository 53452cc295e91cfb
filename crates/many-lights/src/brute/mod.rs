//! R0: every light at every pixel.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 2.4.2, Eq. 2.1,
//! summed over all lights.
//! Deviations: none.

mod cpu;
mod reference;

pub use cpu::Cpu;
pub use reference::Reference;
