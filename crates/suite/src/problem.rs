//! What a problem and its techniques declare, and what the runner asks of them.

use crate::{
    SuiteError, case::Case, claims::Claim, knob::Knob, knob::Knobs, stress::Axis, verify::Gate,
};
use dapple_gpu::Gpu;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, fmt};

/// In which shape a technique is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Clear, scalar, the oracle of ports; never timed.
    Reference,
    /// Fast and parallel on the processor.
    Cpu,
    /// WGSL on a graphics adapter.
    Gpu,
}

/// All forms there are.
pub const FORMS: &[Form] = &[Form::Reference, Form::Cpu, Form::Gpu];

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reference => "reference",
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        })
    }
}

/// One way to be wrong, against the problem's truth. Smaller is better.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Name in records (`error.NAME`).
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// One line.
    pub help: &'static str,
}

/// A metric that is a pure number.
pub const fn metric(name: &'static str, help: &'static str) -> Metric {
    Metric { name, unit: "", help }
}

/// An error that must not exceed a limit for a result to enter a front.
#[derive(Clone, Copy, Debug)]
pub struct Constraint {
    /// Metric name.
    pub metric: &'static str,
    /// Greatest allowed value.
    pub limit: f64,
}

/// A named change of a technique; the first in a list is the default.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Name in sweeps and records.
    pub id: &'static str,
    /// One line.
    pub help: &'static str,
    /// Forms of the technique that it has not got.
    pub not_in: &'static [Form],
}

/// A variant that every form of its technique has.
pub const fn variant(id: &'static str, help: &'static str) -> Variant {
    Variant { id, help, not_in: &[] }
}

/// The variants of a technique that has one.
pub const ONLY: &[Variant] = &[variant("plain", "as published")];

/// One way to solve a problem.
#[derive(Clone, Copy, Debug)]
pub struct Technique {
    /// Name in sweeps and records.
    pub id: &'static str,
    /// Full name.
    pub title: &'static str,
    /// Key in `docs/references.bib`.
    pub source: &'static str,
    /// Forms there are.
    pub forms: &'static [Form],
    /// At least one.
    pub variants: &'static [Variant],
    /// What can be turned.
    pub knobs: &'static [Knob],
}

/// A technique in all forms.
pub const fn technique(
    id: &'static str,
    title: &'static str,
    source: &'static str,
    variants: &'static [Variant],
    knobs: &'static [Knob],
) -> Technique {
    technique_in(FORMS, id, title, source, variants, knobs)
}

/// A technique in some forms.
pub const fn technique_in(
    forms: &'static [Form],
    id: &'static str,
    title: &'static str,
    source: &'static str,
    variants: &'static [Variant],
    knobs: &'static [Knob],
) -> Technique {
    Technique { id, title, source, forms, variants, knobs }
}

impl Technique {
    /// Whether a variant has a form.
    pub fn has(&self, variant: &str, form: Form) -> bool {
        let lacks = self.variants.iter().any(|v| v.id == variant && v.not_in.contains(&form));
        self.forms.contains(&form) && !lacks
    }
}

/// What a problem declares.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Name on the command line.
    pub id: &'static str,
    /// Full name.
    pub title: &'static str,
    /// The question it answers, one sentence.
    pub question: &'static str,
    /// What the ground truth is, one sentence.
    pub truth: &'static str,
    /// Error metrics.
    pub metrics: &'static [Metric],
    /// The metric that fronts are drawn in.
    pub axis: &'static str,
    /// What a result must meet to enter a front.
    pub constraints: &'static [Constraint],
    /// Three errors of the axis metric, tight to loose, at which overviews name the best technique.
    pub levels: [f64; 3],
    /// Whether results can be shown as pictures.
    pub pictures: bool,
    /// Parameters of a case: what the truth depends on.
    pub parameters: &'static [Knob],
    /// Scene of the default case (a generator's name).
    pub default_scene: &'static str,
    /// Techniques; the first is the baseline that ratios refer to.
    pub techniques: &'static [Technique],
}

impl Spec {
    /// The hard constraints, as fronts take them.
    pub fn front_constraints(&self) -> Vec<dapple_records::front::Constraint> {
        let constraint = |c: &Constraint| dapple_records::front::Constraint {
            name: c.metric.into(),
            at_most: c.limit,
        };
        self.constraints.iter().map(constraint).collect()
    }

    /// The technique of that name.
    ///
    /// # Errors
    /// [`SuiteError::Unknown`] with the names there are.
    pub fn technique(&self, id: &str) -> Result<&'static Technique, SuiteError> {
        self.techniques.iter().find(|t| t.id == id).ok_or_else(|| {
            SuiteError::unknown("technique", id, self.techniques.iter().map(|t| t.id))
        })
    }

    /// Holds every knob of a setting to its declared range, whoever set it.
    ///
    /// # Errors
    /// A technique that there is not, or a knob out of range.
    pub fn check(&self, setting: &Setting) -> Result<(), SuiteError> {
        for knob in self.technique(&setting.technique)?.knobs {
            if let Some(value) = setting.knobs.get(knob.name) {
                knob.check("knob", value)?;
            }
        }
        Ok(())
    }
}

/// A technique with its variant, form and all knobs set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Technique id.
    pub technique: String,
    /// Variant id.
    pub variant: String,
    /// Form.
    pub form: Form,
    /// Every knob the technique declares.
    pub knobs: Knobs,
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{} ({})", self.technique, self.variant, self.form)
    }
}

/// What a prepared case tells about itself, for records.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Scene name.
    pub scene: String,
    /// Scene hash.
    pub scene_hash: String,
    /// View or path.
    pub view: String,
    /// Size in words, e.g. `320x180`.
    pub size: String,
    /// Truth and its parameters, in words.
    pub truth: String,
    /// What was added or left out, each a sentence for the user.
    pub notes: Vec<String>,
}

/// What a check before timing found.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Method error by metric name.
    pub errors: BTreeMap<String, f64>,
    /// Largest deviation from the reference form, by quantity.
    pub port_errors: BTreeMap<String, f64>,
    /// Hardware-independent work of one frame (or the whole path).
    pub counters: BTreeMap<String, u64>,
    /// Peak memory of the technique's own buffers.
    pub memory_bytes: u64,
    /// Broken invariants and port gates: any makes the row a failure.
    pub violations: Vec<String>,
}

/// Time of one frame.
#[derive(Clone, Debug, Default)]
pub struct FrameTime {
    /// Wall clock.
    pub wall_ns: u64,
    /// Sum of the passes by the device's clock, where it is sound.
    pub gpu_ns: Option<u64>,
    /// Each pass by the device's clock.
    pub passes: Vec<(&'static str, u64)>,
}

/// Pictures of a result for people; values in 0..=1, rows top to bottom.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Ground truth.
    pub truth: Vec<f32>,
    /// The technique's result.
    pub result: Vec<f32>,
}

/// A problem: what is to be computed, and against which truth.
pub trait Problem: Sync {
    /// What it declares.
    fn spec(&self) -> &'static Spec;

    /// Makes a case ready: input and truth, shared by all techniques.
    ///
    /// # Errors
    /// Bad input, named.
    fn prepare<'g>(
        &self,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Box<dyn Prepared + 'g>, SuiteError>;

    /// What `verify` runs.
    fn gates(&self) -> Vec<Gate>;

    /// What `claims` judges.
    fn claims(&self) -> Vec<Claim>;

    /// The extremes that `stress` pushes its techniques to.
    fn stress(&self) -> Vec<Axis>;
}

/// A case with its input and truth.
pub trait Prepared {
    /// For records.
    fn facts(&self) -> Facts;

    /// A technique ready to run: everything is allocated here.
    ///
    /// # Errors
    /// Settings that do not fit the case, or a device that refuses them.
    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError>;
}

/// A technique under measurement. Frames run in order from a `reset`.
pub trait Subject {
    /// Frames of the case's path, at least 1.
    fn frames(&self) -> usize;

    /// Forgets every earlier frame.
    ///
    /// # Errors
    /// The device's.
    fn reset(&mut self) -> Result<(), SuiteError>;

    /// Runs one frame and returns its time. Allocates nothing of its own.
    ///
    /// # Errors
    /// The device's.
    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError>;

    /// Runs the path once, untimed, against truth and reference.
    ///
    /// # Errors
    /// The device's, or bad input.
    fn check(&mut self) -> Result<Checked, SuiteError>;

    /// The result of the last frame as a picture, where the output is one.
    ///
    /// # Errors
    /// The device's.
    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        Ok(None)
    }
}
