//! Axes as most problems declare them, and what they do to settings.

use super::{Axis, Criterion, Prepare, Values};
use crate::problem::{Form, Problem, Setting, Spec};
use serde_json::Value;

/// What the axes of a problem have in common where they do not say otherwise.
#[derive(Clone, Copy)]
pub struct Usual {
    /// Whose.
    pub problem: &'static dyn Problem,
    /// As [`Axis::parameters`].
    pub parameters: &'static [(&'static str, &'static str)],
    /// As [`Axis::criterion`].
    pub criterion: Criterion,
}

impl Usual {
    /// An axis that pushes nothing yet: the case and every setting stay as they are.
    pub fn axis(self, id: &'static str, help: &'static str, values: Values, home: f64) -> Axis {
        Axis {
            id,
            unit: "",
            help,
            values,
            home,
            parameters: self.parameters,
            forms: &[Form::Cpu, Form::Gpu],
            criterion: self.criterion,
            must_refuse: never,
            prepare: Box::new(move |case, _, gpu| self.problem.prepare(case, gpu)),
            setting: Box::new(|setting, _| Some(setting.clone())),
        }
    }

    /// An axis of one knob of that name. Words that a technique's own knob does not have mean
    /// nothing to it.
    pub fn of_knob(
        self,
        knob: &'static str,
        id: &'static str,
        help: &'static str,
        values: Values,
        home: f64,
    ) -> Axis {
        let spec = self.problem.spec();
        Axis {
            setting: Box::new(move |setting, value| match values {
                Values::Words(words) => with_word(spec, setting, knob, words.get(position(value))?),
                _ => with(setting, knob, number(values, value)),
            }),
            ..self.axis(id, help, values, home)
        }
    }

    /// An axis of one parameter of the case, a number or a word.
    pub fn of_parameter(
        self,
        parameter: &'static str,
        id: &'static str,
        help: &'static str,
        values: Values,
        home: f64,
    ) -> Axis {
        let prepare: Prepare = Box::new(move |case, value, gpu| {
            let mut case = case.clone();
            let value = match values {
                Values::Words(words) => words.get(position(value)).copied().into(),
                _ => number(values, value),
            };
            case.parameters.insert(parameter.into(), value);
            self.problem.prepare(&case, gpu)
        });
        Axis { prepare, ..self.axis(id, help, values, home) }
    }
}

/// A value of an axis of numbers as knobs have it.
fn number(values: Values, value: f64) -> Value {
    match values {
        Values::Whole { .. } => (value as u32).into(),
        _ => value.into(),
    }
}

/// Nothing is bad at any value.
pub fn never(_: f64) -> bool {
    false
}

/// The setting with another value of a knob, where the technique has it. The knob's own range is
/// passed over: that is what extremes are.
pub fn with(setting: &Setting, knob: &str, value: impl Into<Value>) -> Option<Setting> {
    let mut changed = setting.clone();
    *changed.knobs.get_mut(knob)? = value.into();
    Some(changed)
}

/// The setting with another word of a knob, where the technique's own knob has that word.
pub fn with_word(spec: &Spec, setting: &Setting, knob: &str, word: &str) -> Option<Setting> {
    let technique = spec.technique(&setting.technique).ok()?;
    let own = technique.knobs.iter().find(|own| own.name == knob)?;
    with(setting, knob, own.check("knob", &word.into()).ok()?)
}

/// Knobs and their values as typed, passing over their ranges.
pub type Changes = &'static [(&'static str, &'static str)];

/// The setting with all of the changes, where the technique has all of the knobs.
pub fn with_all(setting: &Setting, changes: Changes) -> Option<Setting> {
    let change = |setting: Setting, (knob, text): &(&str, &str)| with(&setting, knob, typed(text));
    changes.iter().try_fold(setting.clone(), change)
}

/// The value that a text is read as: a whole number, else a number, else a word.
pub fn typed(text: &str) -> Value {
    let number = || text.parse::<f64>().ok().map(Value::from);
    text.parse::<i64>().ok().map(Value::from).or_else(number).unwrap_or_else(|| text.into())
}

/// The words of a table, for [`Values::Words`]. `N` must be the table's length.
pub const fn words<T, const N: usize>(table: &[(&'static str, T)]) -> [&'static str; N] {
    assert!(table.len() == N, "another number of words");
    let mut words = [""; N];
    let mut i = 0;
    while i < N {
        words[i] = table[i].0;
        i += 1;
    }
    words
}

/// Position of a word on an axis of words.
pub fn position(value: f64) -> usize {
    // Negative and not a number become 0, which is home on every such axis.
    value as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_as_the_number_it_is_or_as_a_word() {
        assert_eq!(typed("-1"), Value::from(-1));
        assert_eq!(typed("4294967360"), Value::from((1_i64 << 32) + 64));
        assert_eq!(typed("2.0"), Value::from(2.0));
        assert_ne!(typed("2.0"), Value::from(2));
        assert_eq!(typed("1e39"), Value::from(1e39));
        assert_eq!(typed("oak"), Value::from("oak"));
    }

    #[test]
    fn changes_are_made_one_after_the_other_or_not_at_all() {
        let setting = Setting {
            technique: "t".into(),
            variant: "v".into(),
            form: Form::Cpu,
            knobs: [("a".to_string(), 1.into()), ("b".to_string(), "x".into())].into(),
        };
        let changed = with_all(&setting, &[("a", "7"), ("b", "y"), ("a", "8")]).unwrap();
        assert_eq!((&changed.knobs["a"], &changed.knobs["b"]), (&8.into(), &"y".into()));
        assert_eq!(with_all(&setting, &[]), Some(setting.clone()));
        assert_eq!(with_all(&setting, &[("a", "7"), ("c", "0")]), None);
    }

    #[test]
    fn words_are_those_of_the_table() {
        const TABLE: &[(&str, u8)] = &[("one", 1), ("two", 2)];
        const WORDS: [&str; TABLE.len()] = words(TABLE);
        assert_eq!(WORDS, ["one", "two"]);
        let more = std::panic::catch_unwind(|| words::<u8, 3>(TABLE));
        assert!(more.is_err());
    }
}
