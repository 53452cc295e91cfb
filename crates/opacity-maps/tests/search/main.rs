//! Choosing λ: criteria against brute force and algebra, the state machine, the split texture.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod criteria;
mod driver;
mod layers;
mod rays;
mod searches;
mod state;
mod tiles;
