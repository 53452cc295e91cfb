//! Lights drawn by chance.

mod random;
pub mod reservoirs;
pub mod statistics;

pub use random::{Random, hash};
