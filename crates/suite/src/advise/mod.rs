//! Which technique and setting is the cheapest that is good enough, from as few measurements as
//! will do.
//!
//! [`advise`] is a search over an [`Oracle`]: it names settings, the oracle measures them (or looks
//! them up, in tests), and what was found decides what is named next. Monotone knobs are bisected,
//! the others narrowed by golden section, choices tried; techniques race at equal error and at equal
//! time, and those dominated by a margin are dropped on the way.

#[cfg(test)]
mod declared;
mod descent;
mod goal;
mod live;
mod race;
#[cfg(test)]
mod replay;
mod space;
#[cfg(test)]
mod synthetic;

pub use goal::{Goal, Request, dominates, knee};
pub use live::{Live, parse_time};
pub use race::advise;
pub use space::{Candidate, Dial, Space};

use crate::{SuiteError, problem::Setting};
use std::collections::BTreeMap;

/// What measuring a setting gave.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// It passed its check and was timed.
    Measured(Measured),
    /// It cannot be used, and why.
    Failed(String),
    /// It was not measured: the time to spend is over.
    Unasked,
}

/// Time and errors of a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Median time of a frame.
    pub time_ns: f64,
    /// Its spread: median absolute deviation over repeats.
    pub mad_ns: f64,
    /// Errors by metric.
    pub errors: BTreeMap<String, f64>,
}

/// Whoever can tell what settings cost and how wrong they are.
pub trait Oracle {
    /// Measures settings, one answer each, in order.
    ///
    /// # Errors
    /// What makes every further question useless: a case that cannot be prepared, records that
    /// cannot be written.
    fn ask(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError>;

    /// Measures settings again for a surer time, where that is worth anything; the answers replace
    /// the earlier ones.
    ///
    /// # Errors
    /// As [`Oracle::ask`].
    fn again(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError> {
        Ok(vec![Answer::Unasked; settings.len()])
    }
}

/// A setting with what was measured of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The setting.
    pub setting: Setting,
    /// Median time of a frame.
    pub time_ns: f64,
    /// Its spread.
    pub mad_ns: f64,
    /// The metric asked about.
    pub error: f64,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The choice; `None` where nothing that was measured passed its check.
    pub choice: Option<Found>,
    /// Whether the choice meets the goal; otherwise it is the nearest to it.
    pub met: bool,
    /// The best of another technique.
    pub runner_up: Option<Found>,
    /// The next cheaper setting on the front that was found.
    pub cheaper: Option<Found>,
    /// The next more accurate setting on the front that was found.
    pub better: Option<Found>,
    /// The front that was found, by time.
    pub front: Vec<Found>,
    /// Techniques with variant that are not the choice, and why.
    pub dropped: Vec<(String, String)>,
    /// Settings asked for.
    pub asked: usize,
    /// Settings there are to choose from.
    pub of: u64,
    /// Whether the time was over before the search was.
    pub cut_short: bool,
}
