//! Lights drawn by chance.

mod random;

pub use random::{Random, hash};
