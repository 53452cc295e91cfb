//! Rays against what is known without them: closed meshes, brute force, formulas.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod brute_force;
mod filtered;
mod input;
mod light;
mod maps;
mod shapes;
mod watertight;
