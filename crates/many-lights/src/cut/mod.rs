//! Cuts through light trees: which clusters stand for all lights at a pixel.

pub mod band;
mod cpu;
mod given;
mod lightcuts;
mod reference;
mod rule;
mod starts;
pub mod tile;
mod walk;

pub use cpu::Cpu;
pub use given::{Given, Method};
pub use lightcuts::{Found, Member, Open, cut};
pub use reference::Reference;
pub use rule::{Look, Receiver, Rule};
pub use starts::Starts;
pub use walk::{children, recursion, walk};
