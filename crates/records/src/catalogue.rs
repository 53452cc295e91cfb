//! What a program can measure, as one JSON value: a dashboard draws its forms and tables from it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::front::Constraint;

/// Everything that is declared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Catalogue {
    /// Problems.
    pub problems: Vec<ProblemInfo>,
    /// Built-in sweeps: name and what to look for in them.
    pub sweeps: Vec<(String, String)>,
    /// Generated scenes: name and description.
    pub scenes: Vec<(String, String)>,
    /// This machine, as in records.
    pub machine: String,
    /// Processor's name.
    pub cpu: String,
    /// Graphics adapter, or why there is none.
    pub adapter: String,
    /// `hardware`, `software` or `none`.
    pub device: String,
}

/// A problem.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProblemInfo {
    /// Name on the command line.
    pub id: String,
    /// Full name.
    pub title: String,
    /// The question it answers.
    pub question: String,
    /// What the truth is.
    pub truth: String,
    /// Error metrics: name, unit, help.
    pub metrics: Vec<(String, String, String)>,
    /// The metric that fronts are drawn in.
    pub axis: String,
    /// Hard constraints: metric and greatest value.
    pub constraints: Vec<(String, f64)>,
    /// Three errors of the axis metric, tight to loose, at which the best technique is named.
    pub levels: Vec<f64>,
    /// Case parameters.
    pub parameters: Vec<KnobInfo>,
    /// Scene of the default case.
    pub default_scene: String,
    /// Whether results can be shown as pictures.
    pub pictures: bool,
    /// Techniques; the first is the baseline.
    pub techniques: Vec<TechniqueInfo>,
    /// Extremes: id, unit, help.
    pub extremes: Vec<(String, String, String)>,
    /// Gates there are, by technique.
    pub gates: BTreeMap<String, usize>,
    /// Claims there are: id and statement.
    pub claims: Vec<(String, String)>,
}

impl ProblemInfo {
    /// The hard constraints, as fronts take them.
    pub fn front_constraints(&self) -> Vec<Constraint> {
        let constraint =
            |(name, at_most): &(String, f64)| Constraint { name: name.clone(), at_most: *at_most };
        self.constraints.iter().map(constraint).collect()
    }
}

/// A technique.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TechniqueInfo {
    /// Name in records.
    pub id: String,
    /// Full name.
    pub title: String,
    /// Author, title, year of the source.
    pub source: String,
    /// Forms there are.
    pub forms: Vec<String>,
    /// Variants: id and help; the first is the default.
    pub variants: Vec<(String, String)>,
    /// Knobs.
    pub knobs: Vec<KnobInfo>,
}

/// A knob or parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KnobInfo {
    /// Name.
    pub name: String,
    /// Unit, empty for a pure number.
    pub unit: String,
    /// One line.
    pub help: String,
    /// What is allowed, in words.
    pub limit: String,
    /// Default.
    pub default: Value,
    /// Values one can step through, in order, the default among them.
    pub steps: Vec<Value>,
    /// `monotone`, `unimodal` or `none`.
    pub accuracy: String,
}
