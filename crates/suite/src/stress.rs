//! Stress: a problem declares extremes; each technique is pushed along them until it breaks.
//!
//! A logarithmic grid finds the safe set (which may have holes), bisection refines its ends. What
//! breaks is decided by the axis's [`Criterion`], by an invariant or port gate, by a value that is
//! not finite, or by a crash; bad input must be refused.

pub mod at;
pub(crate) mod bad;
pub mod child;
pub(crate) mod edit;
pub mod judge;
pub mod line;
pub(crate) mod motion;
pub(crate) mod night;
pub mod run;
pub mod search;
pub(crate) mod settings;
#[cfg(test)]
pub(crate) mod testing;
pub(crate) mod world;

use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Prepared, Problem, Setting, Spec},
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

/// The setting at a value of the axis; `None` for a technique to which the axis means nothing.
pub type Push = Box<dyn Fn(&Setting, f64) -> Option<Setting> + Send + Sync>;

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
    /// The setting at a value.
    pub setting: Push,
}

impl Values {
    /// A value for people; [`Values::parse`] reads it back bit for bit.
    pub fn label(self, value: f64) -> String {
        match self {
            Self::Words(words) => {
                let word = words.get(value as usize).filter(|_| value >= 0.0);
                word.map_or_else(|| value.to_string(), ToString::to_string)
            }
            // Rust writes the shortest text that reads back as the same number.
            _ if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
            _ => format!("{value:e}"),
        }
    }

    /// Reads a value typed on a command line.
    ///
    /// # Errors
    /// [`SuiteError::Unknown`] for a word that is none of them, [`SuiteError::Value`] for what is
    /// no number on the axis.
    pub fn parse(self, axis: &str, text: &str) -> Result<f64, SuiteError> {
        if let Self::Words(words) = self {
            let position = words.iter().position(|word| *word == text);
            let position = position.map(|position| position as f64);
            return position
                .ok_or_else(|| SuiteError::unknown("value", text, words.iter().copied()));
        }
        let (least, greatest) = search::ends(self).unwrap_or_default();
        let fits = |value: &f64| {
            let whole = !matches!(self, Self::Whole { .. }) || value.fract() == 0.0;
            (least..=greatest).contains(value) && whole
        };
        text.parse().ok().filter(fits).ok_or_else(|| SuiteError::Value {
            what: "axis",
            name: axis.into(),
            value: text.into(),
            limit: format!("must be {}", self.limit()),
        })
    }

    /// What there is, for people.
    pub fn limit(self) -> String {
        let (least, greatest) = search::ends(self).unwrap_or_default();
        let (least, greatest) = (self.label(least), self.label(greatest));
        match self {
            Self::Words(words) => format!("one of {}", words.join(", ")),
            Self::Whole { .. } => format!("an integer in {least}..={greatest}"),
            _ => format!("a number in {least}..={greatest}"),
        }
    }
}

impl Axis {
    /// Its grid with home among it, ascending.
    pub fn grid(&self) -> Vec<f64> {
        search::grid(self.values, self.home)
    }

    /// Parameters of the case: those given, else the axis's own, else the problem's.
    ///
    /// # Errors
    /// As [`knob::complete`].
    pub fn case_parameters(&self, spec: &Spec, given: &Knobs) -> Result<Knobs, SuiteError> {
        let mut parameters = Knobs::new();
        for (name, value) in self.parameters {
            let assignment = format!("{name}={value}");
            let (name, value) = knob::parse_assignment("parameter", spec.parameters, &assignment)?;
            parameters.insert(name, value);
        }
        parameters.extend(given.clone());
        knob::complete("parameter", spec.parameters, &parameters)
    }

    /// What is wrong with the declaration, if anything.
    pub fn fault(&self, spec: &Spec) -> Option<String> {
        let Criterion { metric, times, plus } = self.criterion;
        let home = search::at_home(self.values, self.home);
        if home != Some(self.home) {
            Some(format!("home {} is not {}", self.home, self.values.limit()))
        } else if (self.must_refuse)(self.home) {
            Some("home itself must be refused".into())
        } else if !spec.metrics.iter().any(|m| m.name == metric) {
            Some(format!("no metric `{metric}`"))
        } else if !(times >= 1.0 && times.is_finite() && plus >= 0.0 && plus.is_finite()) {
            Some(format!("an error of {times} times home's and {plus} is not safe at home"))
        } else if self.forms.is_empty() || self.forms.contains(&Form::Reference) {
            Some("its forms must be some of cpu and gpu".into())
        } else {
            self.case_parameters(spec, &Knobs::new()).err().map(|error| error.to_string())
        }
    }
}

/// The axis of that name.
///
/// # Errors
/// [`SuiteError::Unknown`] with the names there are.
pub fn find_axis(problem: &dyn Problem, id: &str) -> Result<Axis, SuiteError> {
    let mut axes = problem.stress();
    let Some(position) = axes.iter().position(|axis| axis.id == id) else {
        return Err(SuiteError::unknown("axis", id, axes.iter().map(|axis| axis.id)));
    };
    Ok(axes.swap_remove(position))
}

#[cfg(test)]
mod tests;
