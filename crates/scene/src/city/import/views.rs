//! Views and paths of a real city, by rule.

use crate::city::City;

/// Adds cameras and paths.
pub fn add(city: &mut City) {
    let _ = city;
}
