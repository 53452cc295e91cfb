//! What there is to choose from: techniques with their variants, and the values of every knob.

use crate::{
    knob::{Accuracy, Knob, Knobs, Range},
    problem::{Form, Setting, Technique},
};
use serde_json::Value;

/// One knob with the values to try.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// Knob's name.
    pub name: String,
    /// Values, ascending where they have an order.
    pub values: Vec<Value>,
    /// Index of the default.
    pub default: usize,
    /// How accuracy answers.
    pub accuracy: Accuracy,
    /// Whether the values have an order.
    pub ordered: bool,
    /// Whether the default stands apart from that order (a 0 that means the format's own value).
    pub apart: bool,
}

/// A technique with a variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Technique id.
    pub technique: String,
    /// Variant id.
    pub variant: String,
    /// Form.
    pub form: Form,
    /// Its knobs.
    pub dials: Vec<Dial>,
}

/// Everything to choose from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Space {
    /// Techniques with variants.
    pub candidates: Vec<Candidate>,
}

/// A value for each dial, by index.
pub(super) type Point = Vec<usize>;

impl Dial {
    /// The knob with the values one steps it through.
    pub fn of(knob: &Knob) -> Self {
        let values = knob.steps();
        let default = knob.default_value();
        let apart = match (knob.useful, default.as_f64()) {
            (Some([least, greatest]), Some(default)) => !(least..=greatest).contains(&default),
            _ => false,
        };
        Self {
            name: knob.name.into(),
            default: values.iter().position(|v| *v == default).unwrap_or_default(),
            ordered: !matches!(knob.range, Range::Choice(_)),
            accuracy: knob.accuracy,
            values,
            apart,
        }
    }
}

impl Candidate {
    /// A technique with a variant, every knob stepped.
    pub fn of(technique: &Technique, variant: &str, form: Form) -> Self {
        Self {
            technique: technique.id.into(),
            variant: variant.into(),
            form,
            dials: technique.knobs.iter().map(Dial::of).collect(),
        }
    }

    /// `technique/variant`.
    pub fn name(&self) -> String {
        format!("{}/{}", self.technique, self.variant)
    }

    /// All defaults.
    pub(super) fn defaults(&self) -> Point {
        self.dials.iter().map(|d| d.default).collect()
    }

    /// The setting at a point.
    pub(super) fn setting(&self, point: &Point) -> Setting {
        let knobs: Knobs = self
            .dials
            .iter()
            .zip(point)
            .map(|(dial, at)| (dial.name.clone(), dial.values[*at].clone()))
            .collect();
        Setting {
            technique: self.technique.clone(),
            variant: self.variant.clone(),
            form: self.form,
            knobs,
        }
    }
}

impl Space {
    /// Settings there are.
    pub fn size(&self) -> u64 {
        let of = |c: &Candidate| {
            c.dials.iter().map(|d| d.values.len() as u64).fold(1, u64::saturating_mul)
        };
        self.candidates.iter().map(of).fold(0, u64::saturating_add)
    }
}
