//! Clustered shading: lights of finite reach, listed by cells of the view that hold points.
//!
//! Based on: O. Olsson, M. Billeter and U. Assarsson, "Clustered deferred and forward shading", 2012,
//! sections 3 and 4: tiles of the image times slices of depth that grow by a constant factor; only
//! cells that hold points are listed, by their points' own boxes (the paper's explicit bounds); lights
//! are found through a hierarchy of 32 in one.
//! Deviations: cells are bounded along the axes of the world rather than of the eye, which is as
//! tight, and tighter where walls follow them; normals are no part of a cell; of lights that shine
//! into a cone only those are listed whose cone may touch the box, as engines do; the hierarchy over
//! lights is made once, since they do not move, and is not part of a frame, while cells and lists are.
//! Parallel eyes have slices of equal depth.
//!
//! A light's reach is where a white surface that faces it gives the cutoff: `I / (π r²) = cutoff` of
//! its brightest channel, so `r = sqrt(I / (π · cutoff))`. Beyond it the light gives nothing, so an
//! image lacks less than the cutoff times the number of lights left out, whatever the albedo. Lights
//! without intensity are in no list, directional ones in all.

mod cells;
mod cpu;
mod grid;
mod hierarchy;
mod reach;
mod reference;

pub use cells::{Cell, cells};
pub use cpu::Cpu;
pub use grid::{Grid, MAX_CELLS};
pub use hierarchy::{FAN, Group, Hierarchy};
pub use reach::{Reach, reach_m, window};
pub use reference::{Lists, Reference, lists};
