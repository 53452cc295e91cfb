//! Knobs: what can be turned, declared once. The declaration feeds the sweep files' checks, the
//! command line, tables and documentation.

mod steps;

use crate::SuiteError;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Knob settings by name; values are integers, floats or strings.
pub type Knobs = BTreeMap<String, Value>;

/// How error answers to a knob as its value grows. Checked by measurement, used by searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accuracy {
    /// Error falls (or stays) as the value grows.
    Monotone,
    /// Error has one minimum.
    Unimodal,
    /// Nothing is promised.
    None,
}

/// The values a knob takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Integers, both ends included.
    Int {
        /// Least.
        min: i64,
        /// Greatest.
        max: i64,
        /// Default.
        default: i64,
    },
    /// Floats, both ends included.
    Float {
        /// Least.
        min: f64,
        /// Greatest.
        max: f64,
        /// Default.
        default: f64,
    },
    /// One of a few words; the first is the default.
    Choice(&'static [&'static str]),
}

/// One knob.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knob {
    /// Name in sweeps, flags and records.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Values and default.
    pub range: Range,
    /// Whether steps are even in the logarithm.
    pub logarithmic: bool,
    /// How accuracy answers.
    pub accuracy: Accuracy,
    /// Ends of the part of the range that normal work steps through; `None`: all of it. What is
    /// allowed reaches further, for extremes.
    pub useful: Option<[f64; 2]>,
    /// One line.
    pub help: &'static str,
}

impl Knob {
    /// An integer knob.
    pub const fn int(
        name: &'static str,
        [min, default, max]: [i64; 3],
        help: &'static str,
    ) -> Self {
        let range = Range::Int { min, max, default };
        Self::of(name, range, help)
    }

    /// A float knob.
    pub const fn float(
        name: &'static str,
        [min, default, max]: [f64; 3],
        help: &'static str,
    ) -> Self {
        let range = Range::Float { min, max, default };
        Self::of(name, range, help)
    }

    /// A choice; the first word is the default.
    pub const fn choice(
        name: &'static str,
        words: &'static [&'static str],
        help: &'static str,
    ) -> Self {
        let range = Range::Choice(words);
        Self::of(name, range, help)
    }

    const fn of(name: &'static str, range: Range, help: &'static str) -> Self {
        let (logarithmic, accuracy, useful) = (false, Accuracy::None, None);
        Self { name, unit: "", range, logarithmic, accuracy, useful, help }
    }

    /// The same knob with a unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same knob, stepped in the logarithm.
    #[must_use]
    pub const fn log(self) -> Self {
        Self { logarithmic: true, ..self }
    }

    /// The same knob with a declared answer of accuracy.
    #[must_use]
    pub const fn accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// The same knob, stepped from `least` to `greatest` only. Both lie in the range; the default
    /// need not lie between them (a 0 that stands for a format's own value, say).
    #[must_use]
    pub const fn useful(self, least: f64, greatest: f64) -> Self {
        Self { useful: Some([least, greatest]), ..self }
    }

    /// The default as a record's value.
    pub fn default_value(&self) -> Value {
        match self.range {
            Range::Int { default, .. } => default.into(),
            Range::Float { default, .. } => default.into(),
            Range::Choice(words) => words.first().copied().unwrap_or_default().into(),
        }
    }

    /// What is allowed, for tables and errors.
    pub fn limit(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match self.range {
            Range::Int { min, max, .. } => format!("an integer in {min}..={max}{unit}"),
            Range::Float { min, max, .. } => format!("a number in {min}..={max}{unit}"),
            Range::Choice(words) => format!("one of {}", words.join(", ")),
        }
    }

    /// Accepts `value` in the knob's own type, or says what is allowed.
    ///
    /// # Errors
    /// [`SuiteError::Value`] for a wrong type, a value out of range, or one not finite.
    pub fn check(&self, what: &'static str, value: &Value) -> Result<Value, SuiteError> {
        let fits = match self.range {
            Range::Int { min, max, .. } => {
                value.as_i64().filter(|v| (min..=max).contains(v)).map(Value::from)
            }
            Range::Float { min, max, .. } => {
                value.as_f64().filter(|v| (min..=max).contains(v)).map(Value::from)
            }
            Range::Choice(words) => value.as_str().filter(|v| words.contains(v)).map(Value::from),
        };
        fits.ok_or_else(|| SuiteError::Value {
            what,
            name: self.name.into(),
            value: value.to_string(),
            limit: format!("must be {}", self.limit()),
        })
    }

    /// Reads a value typed on a command line.
    ///
    /// # Errors
    /// As [`Knob::check`].
    pub fn parse(&self, what: &'static str, text: &str) -> Result<Value, SuiteError> {
        let value = match self.range {
            Range::Int { .. } => text.parse::<i64>().map(Value::from).ok(),
            Range::Float { .. } => text.parse::<f64>().map(Value::from).ok(),
            Range::Choice(_) => None,
        };
        self.check(what, &value.unwrap_or_else(|| text.into()))
    }
}

/// The value that a knob's word stands for.
///
/// # Errors
/// A word that is none.
pub fn choice<T: Copy>(
    knobs: &Knobs,
    name: &'static str,
    words: &[(&'static str, T)],
) -> Result<T, SuiteError> {
    let word = knobs.word(name)?;
    let found = words.iter().find(|(w, _)| *w == word);
    found
        .map(|(_, value)| *value)
        .ok_or_else(|| SuiteError::unknown(name, word, words.iter().map(|(w, _)| *w)))
}

/// Fills defaults in and refuses names that `knobs` does not declare.
///
/// # Errors
/// [`SuiteError::Unknown`] or [`SuiteError::Value`].
pub fn complete(what: &'static str, knobs: &[Knob], given: &Knobs) -> Result<Knobs, SuiteError> {
    for name in given.keys() {
        if !knobs.iter().any(|k| k.name == name) {
            return Err(SuiteError::unknown(what, name, knobs.iter().map(|k| k.name)));
        }
    }
    knobs
        .iter()
        .map(|k| {
            let value = match given.get(k.name) {
                Some(value) => k.check(what, value)?,
                None => k.default_value(),
            };
            Ok((k.name.to_string(), value))
        })
        .collect()
}

/// Splits `name=value` and reads the value as the knob of that name.
///
/// # Errors
/// [`SuiteError::Usage`] without `=`, else as [`Knob::parse`].
pub fn parse_assignment(
    what: &'static str,
    knobs: &[Knob],
    text: &str,
) -> Result<(String, Value), SuiteError> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| SuiteError::Usage(format!("{what} `{text}`: expected NAME=VALUE")))?;
    // Techniques may give one name different ranges; each is checked again with its own.
    let mut error = None;
    for knob in knobs.iter().filter(|k| k.name == name) {
        match knob.parse(what, value) {
            Ok(value) => return Ok((name.to_string(), value)),
            Err(refused) => error = error.or(Some(refused)),
        }
    }
    let known: BTreeSet<_> = knobs.iter().map(|k| k.name).collect();
    Err(error.unwrap_or_else(|| SuiteError::unknown(what, name, known)))
}

/// Typed access to completed knobs. A knob that was not declared is the program's own fault.
pub trait Get {
    /// An integer.
    ///
    /// # Errors
    /// [`SuiteError::Internal`] if the name was not declared with this type.
    fn int(&self, name: &str) -> Result<i64, SuiteError>;
    /// A float (or an integer read as one).
    ///
    /// # Errors
    /// As [`Get::int`].
    fn float(&self, name: &str) -> Result<f64, SuiteError>;
    /// A word.
    ///
    /// # Errors
    /// As [`Get::int`].
    fn word(&self, name: &str) -> Result<&str, SuiteError>;
}

impl Get for Knobs {
    fn int(&self, name: &str) -> Result<i64, SuiteError> {
        self.get(name).and_then(Value::as_i64).ok_or_else(|| undeclared(name))
    }

    fn float(&self, name: &str) -> Result<f64, SuiteError> {
        self.get(name).and_then(Value::as_f64).ok_or_else(|| undeclared(name))
    }

    fn word(&self, name: &str) -> Result<&str, SuiteError> {
        self.get(name).and_then(Value::as_str).ok_or_else(|| undeclared(name))
    }
}

fn undeclared(name: &str) -> SuiteError {
    SuiteError::Internal(format!("knob `{name}` is read but not declared with that type"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOBS: &[Knob] = &[
        Knob::int("resolution", [1, 512, 8192], "map side"),
        Knob::float("bias", [0.0, 0.001, 1.0], "depth bias"),
        Knob::choice("format", &["f32", "f16"], "storage"),
    ];

    #[test]
    fn defaults_fill_what_is_not_given() {
        let given = Knobs::from([("bias".into(), 0.5.into())]);
        let all = complete("knob", KNOBS, &given).unwrap();
        assert_eq!(all.int("resolution").unwrap(), 512);
        assert_eq!(all.float("bias").unwrap(), 0.5);
        assert_eq!(all.word("format").unwrap(), "f32");
    }

    #[test]
    fn bad_values_name_the_knob_and_the_limit() {
        for (text, expect) in [
            ("resolution=0", "an integer in 1..=8192"),
            ("resolution=many", "an integer in 1..=8192"),
            ("bias=NaN", "a number in 0..=1"),
            ("bias=-1", "a number in 0..=1"),
            ("format=f8", "one of f32, f16"),
            ("colour=red", "there is: bias, format, resolution"),
            ("resolution", "expected NAME=VALUE"),
        ] {
            let error = parse_assignment("knob", KNOBS, text).unwrap_err();
            assert!(error.to_string().contains(expect), "{text}: {error}");
            assert_eq!(error.exit_code(), 2);
        }
    }

    #[test]
    fn a_value_that_one_knob_of_the_name_takes_is_read() {
        let knobs = [Knob::choice("f", &["a"], ""), Knob::choice("f", &["a", "b"], "")];
        assert_eq!(parse_assignment("knob", &knobs, "f=b").unwrap().1, "b");
        assert!(parse_assignment("knob", &knobs, "f=c").is_err());
    }

    #[test]
    fn both_ends_of_a_range_are_allowed() {
        assert_eq!(parse_assignment("knob", KNOBS, "resolution=1").unwrap().1, 1);
        assert_eq!(parse_assignment("knob", KNOBS, "resolution=8192").unwrap().1, 8192);
    }
}
