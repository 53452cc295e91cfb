//! Rays against what is known without them: closed meshes, brute force, formulas.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod brute_force;
mod camera_layers;
mod clouds;
mod filtered;
mod input;
mod light;
mod light_fragments;
mod maps;
mod once;
mod opacity;
mod shapes;
mod translucent;
mod transmittance;
mod volume;
mod volume_fragments;
mod watertight;
