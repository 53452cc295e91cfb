//! Stress: a problem declares extremes; each technique is pushed along them until it breaks.
//!
//! A logarithmic grid finds the safe set (which may have holes), bisection refines its ends. What
//! breaks is decided by the axis's [`Criterion`], by an invariant or port gate, by a value that is
//! not finite, or by a crash; bad input must be refused.

use crate::{
    SuiteError,
    case::Case,
    problem::{Form, Prepared, Setting},
};
use dapple_gpu::Gpu;

/// The values an axis takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// Stepped in the logarithm; both ends are probed, and so is the home value. Ends are > 0.
    Log {
        /// Least.
        least: f64,
        /// Greatest.
        greatest: f64,
        /// Grid points a decade.
        per_decade: u32,
    },
    /// 0, then as `Log`. Nothing is probed between 0 and the least.
    FromZero {
        /// Least above 0.
        least: f64,
        /// Greatest.
        greatest: f64,
        /// Grid points a decade.
        per_decade: u32,
    },
    /// Whole numbers stepped in the logarithm; `least` may be 0, and then 1 comes next.
    Whole {
        /// Least.
        least: u32,
        /// Greatest.
        greatest: u32,
        /// Grid points a decade.
        per_decade: u32,
    },
    /// Even steps; both ends are probed, and so is the home value.
    Linear {
        /// Least.
        least: f64,
        /// Greatest.
        greatest: f64,
        /// Steps between them.
        steps: u32,
    },
    /// Kinds without an order, by position; never refined.
    Words(&'static [&'static str]),
}

/// When a result counts as safe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Metric of the problem.
    pub metric: &'static str,
    /// Safe up to `times` the error at the home value ...
    pub times: f64,
    /// ... plus this.
    pub plus: f64,
}

/// Makes the case ready at a value of the axis.
pub type Prepare = Box<
    dyn for<'g> Fn(&Case, f64, Option<&'g Gpu>) -> Result<Box<dyn Prepared + 'g>, SuiteError>
        + Send
        + Sync,
>;

/// One extreme of a problem.
pub struct Axis {
    /// Name on the command line and in records, e.g. `scale`.
    pub id: &'static str,
    /// Unit of the values, empty for a pure number.
    pub unit: &'static str,
    /// What is pushed, one sentence.
    pub help: &'static str,
    /// The values.
    pub values: Values,
    /// Where normal use lies: the criterion refers to the error here.
    pub home: f64,
    /// Parameters of the case, NAME and VALUE as typed, where the caller gives none: many points
    /// are probed, so each has to be cheaper than a measured case. Others keep their defaults.
    pub parameters: &'static [(&'static str, &'static str)],
    /// Forms to be pushed.
    pub forms: &'static [Form],
    /// When a result counts as safe.
    pub criterion: Criterion,
    /// Whether the input at this value is bad and must be refused.
    pub must_refuse: fn(f64) -> bool,
    /// The case at a value.
    pub prepare: Prepare,
    /// The setting at a value; `None` for a technique to which the axis means nothing.
    pub setting: fn(&Setting, f64) -> Option<Setting>,
}
