//! Cuts through light trees: which clusters stand for all lights at a pixel.
//!
//! R4 and R3 look at one node at a time ([`Rule`]) on a [`walk`] without a stack; R1 and R2 split the
//! worst node of a whole [`cut`]. Selection never asks what is seen, except that R1's and R2's whole
//! estimate does: a shadow ray goes to each node that they evaluate, as to each node of other cuts.

pub mod band;
mod cpu;
mod given;
mod lightcuts;
mod moving;
mod reference;
mod rule;
mod starting;
mod starts;
pub mod tile;
mod walk;

pub use cpu::Cpu;
pub use given::{Given, Method};
pub use lightcuts::{Found, Member, Open, cut};
pub use reference::Reference;
pub use rule::{Look, Receiver, Rule};
pub use starting::{Starting, starting};
pub use starts::{StartList, Starts};
pub use walk::{children, recursion, walk};

pub(crate) use moving::Moving;
