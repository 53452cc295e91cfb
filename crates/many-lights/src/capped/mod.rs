//! A fixed most number of lights: for each 8 x 8 pixels the strongest, by the most that each can give
//! to any of them; the pixels' sums leave all others out.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 1.1 (at most 256
//! lights shade a pixel in DOOM, 2016).
//! Deviations: games cull lights by their reach and drop what exceeds the cap in some order; here no
//! light has a reach, and those that are kept are the strongest by a bound over the tile (Walter's
//! form), so the cap is at its best. Equally strong ones are taken by lowest index.

mod choose;
mod cpu;
mod groups;
mod lists;
mod reference;

pub use choose::{Choice, strongest};
pub use cpu::Cpu;
pub use groups::{FAN, Groups};
pub use lists::{Lists, Row};
pub use reference::{Reference, strongest_of_all};
