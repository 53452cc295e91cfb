//! What is refused of a city, by name.

use thiserror::Error;

/// Why a city cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CityError {
    /// A knob of the generator beyond its range.
    #[error("city: `{name}` = {value} is not within {limit}")]
    Value {
        /// The knob.
        name: &'static str,
        /// As given.
        value: f64,
        /// What is allowed.
        limit: String,
    },
}
