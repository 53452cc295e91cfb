//! Dapple's suite: problems, sweeps, the runner, gates and claims.
//!
//! A [`problem::Problem`] says what is to be computed and by which techniques; the rest of the
//! crate measures, checks and judges whatever problems declare, and knows none of them by name.

pub mod advise;
pub mod case;
pub mod city;
pub mod claims;
pub mod environment;
pub mod error;
pub mod knob;
pub mod light_mesh;
pub mod memory;
pub mod night;
pub mod plan;
pub mod problem;
pub mod problems;
pub mod run;
pub mod scene;
pub mod shell;
pub mod stress;
pub mod sweep;
#[cfg(test)]
pub(crate) mod testing;
pub mod truth_cache;
pub mod verify;

pub use error::SuiteError;
