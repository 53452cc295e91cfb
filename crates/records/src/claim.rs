//! One claim's verdict, as `dapple claims` leaves it.

use crate::error::RecordError;
use crate::fields::{Fields, Object, type_error};

/// One figure behind a verdict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClaimFigure {
    /// What was measured, with scene and setting.
    pub what: String,
    /// Its value; NaN where it was not finite.
    pub value: f64,
    /// Unit, empty for a pure number.
    pub unit: String,
}

/// `"kind": "claim"`. The figures are three lists of one length, so that the line stays flat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClaimLine {
    /// The run's id.
    pub run: String,
    /// When it was judged, RFC 3339 UTC.
    pub time: String,
    /// Which machine.
    pub machine: String,
    /// Graphics adapter at hand; `none` without one.
    pub adapter: String,
    /// Source revision of the program.
    pub revision: String,
    /// Problem id.
    pub problem: String,
    /// Claim id, e.g. `gumbau-H7.3`.
    pub id: String,
    /// The source's statement in our words.
    pub statement: String,
    /// Where it stands in the source.
    pub place: String,
    /// How it is judged.
    pub method: String,
    /// `reproduced`, `refuted`, `open`, `needs-hardware`, or `error` if the judge could not run.
    pub verdict: String,
    /// Why.
    pub because: String,
    /// The figures.
    pub figures: Vec<ClaimFigure>,
}

impl ClaimLine {
    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        let mut out = Object::new("claim");
        out.texts([
            ("run", &self.run),
            ("time", &self.time),
            ("machine", &self.machine),
            ("adapter", &self.adapter),
            ("revision", &self.revision),
            ("problem", &self.problem),
            ("id", &self.id),
            ("statement", &self.statement),
            ("place", &self.place),
            ("method", &self.method),
            ("verdict", &self.verdict),
            ("because", &self.because),
        ]);
        let of = |f: fn(&ClaimFigure) -> &String| -> Vec<String> {
            self.figures.iter().map(|figure| f(figure).clone()).collect()
        };
        out.put("figure_what", of(|f| &f.what));
        out.put("figure_value", self.figures.iter().map(|f| f.value).collect::<Vec<_>>());
        out.put("figure_unit", of(|f| &f.unit));
        out.to_line()
    }

    pub(crate) fn from_fields(f: &mut Fields) -> Result<Self, RecordError> {
        let (what, unit) = (f.texts("figure_what")?, f.texts("figure_unit")?);
        let values = f.list("figure_value")?;
        if what.len() != values.len() || unit.len() != values.len() {
            return Err(type_error("figure_value", "as long as figure_what and figure_unit"));
        }
        let figures = what.into_iter().zip(values).zip(unit);
        Ok(Self {
            run: f.required("run")?,
            time: f.text("time")?,
            machine: f.text("machine")?,
            adapter: f.text("adapter")?,
            revision: f.text("revision")?,
            problem: f.required("problem")?,
            id: f.required("id")?,
            statement: f.text("statement")?,
            place: f.text("place")?,
            method: f.text("method")?,
            verdict: f.required("verdict")?,
            because: f.text("because")?,
            figures: figures
                .map(|((what, value), unit)| ClaimFigure { what, value, unit })
                .collect(),
        })
    }
}
