//! What the runner and its child processes tell each other: one JSON line each.

use crate::{SuiteError, plan::Group};
use dapple_gpu::AdapterChoice;
use dapple_records::{Line, RecordError, Row, StressLine};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a child is asked to do; one line on its standard input.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// Id of the run, for its rows.
    pub run: String,
    /// The group.
    pub group: Group,
    /// Which settings still need a row, by position.
    pub todo: Vec<usize>,
    /// Settings that may not be started again, by position.
    pub banned: Vec<usize>,
    /// Timed repeats.
    pub repeats: u32,
    /// Part of an adapter's name, or none for the best one.
    pub adapter: Option<String>,
    /// A deliberate fault, for the runner's own tests.
    pub fault: Option<Fault>,
}

/// A deliberate fault at the check of one technique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// What happens.
    pub kind: FaultKind,
    /// At which technique.
    pub technique: String,
    /// At which value of an axis; at any if none.
    pub value: Option<f64>,
}

/// Ways to fail that a runner must survive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FaultKind {
    /// The process ends at once.
    Crash,
    /// The process never answers.
    Hang,
}

impl Fault {
    /// Reads `KIND:TECHNIQUE` or `KIND:TECHNIQUE@VALUE`, the kind being `crash` or `hang`.
    ///
    /// # Errors
    /// [`SuiteError::Usage`] with what is expected.
    pub fn parse(text: &str) -> Result<Self, SuiteError> {
        let expected = || {
            SuiteError::Usage(format!("fault `{text}`: expected crash:TECHNIQUE or hang:TECHNIQUE"))
        };
        let (kind, rest) = text.split_once(':').ok_or_else(expected)?;
        let kind = match kind {
            "crash" => FaultKind::Crash,
            "hang" => FaultKind::Hang,
            _ => return Err(expected()),
        };
        let (technique, value) = match rest.split_once('@') {
            Some((technique, value)) => (technique, Some(value.parse().map_err(|_| expected())?)),
            None => (rest, None),
        };
        Ok(Self { kind, technique: technique.into(), value })
    }

    /// Does what is asked for, if it is asked for here.
    pub(crate) fn commit(&self, technique: &str, value: Option<f64>) {
        if self.technique != technique || (self.value.is_some() && self.value != value) {
            return;
        }
        match self.kind {
            FaultKind::Crash => std::process::abort(),
            FaultKind::Hang => std::thread::sleep(std::time::Duration::from_secs(3600)),
        }
    }
}

/// The adapter of that name, or the best.
pub(crate) fn adapter_choice(name: Option<&String>) -> AdapterChoice {
    name.map_or(AdapterChoice::Auto, |name| AdapterChoice::Named(name.clone()))
}

/// What a child reports.
#[derive(Clone, Debug)]
pub enum Event {
    /// A setting is about to be made, checked or timed: if the child dies now, it is the culprit.
    Begin {
        /// Position in the job; beyond them all for what is done for all.
        setting: usize,
        /// `prepare`, `check` or `time`.
        stage: String,
        /// Where on an axis.
        value: Option<f64>,
    },
    /// Something the user should know about the case.
    Note(String),
    /// A finished row.
    Row(Box<Row>),
    /// A finished point of an axis.
    Stress(Box<StressLine>),
    /// The case itself cannot be measured: nothing of this group can.
    Failed {
        /// Why.
        reason: String,
        /// The exit code it stands for.
        code: u8,
    },
    /// The group is finished.
    Done,
}

impl Event {
    /// One line of JSON, without the line's end.
    pub fn to_line(&self) -> String {
        match self {
            Self::Begin { setting, stage, value } => serde_json::json!(
                {"event": "begin", "setting": setting, "stage": stage, "value": value}
            )
            .to_string(),
            Self::Note(text) => serde_json::json!({"event": "note", "text": text}).to_string(),
            Self::Failed { reason, code } => {
                serde_json::json!({"event": "failed", "reason": reason, "code": code}).to_string()
            }
            Self::Done => serde_json::json!({"event": "done"}).to_string(),
            // A row's own line: what is piped here is what a record holds.
            Self::Row(row) => row.to_line(),
            Self::Stress(point) => point.to_line(),
        }
    }

    /// Reads a line; `None` for lines that are no event (a driver printing on standard output).
    ///
    /// # Errors
    /// A record line that cannot be read, or of another kind.
    pub fn from_line(line: &str) -> Result<Option<Self>, RecordError> {
        let Ok(Value::Object(map)) = serde_json::from_str(line) else { return Ok(None) };
        let text = |key: &str| map.get(key).and_then(Value::as_str).unwrap_or_default().to_string();
        let number = |key: &str| map.get(key).and_then(Value::as_u64).unwrap_or_default();
        if map.contains_key("kind") {
            return match Line::parse(line.as_bytes())? {
                Line::Row(row) => Ok(Some(Self::Row(row))),
                Line::Stress(point) => Ok(Some(Self::Stress(point))),
                _ => Err(RecordError::Kind(text("kind"))),
            };
        }
        Ok(match text("event").as_str() {
            "begin" => Some(Self::Begin {
                setting: number("setting") as usize,
                stage: text("stage"),
                value: map.get("value").and_then(Value::as_f64),
            }),
            "note" => Some(Self::Note(text("text"))),
            "failed" => Some(Self::Failed { reason: text("reason"), code: number("code") as u8 }),
            "done" => Some(Self::Done),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_with_and_without_a_value() {
        let fault = Fault::parse("crash:vsm@1e3").unwrap();
        assert_eq!((fault.kind, fault.value), (FaultKind::Crash, Some(1e3)));
        let fault = Fault::parse("hang:cpu-thread").unwrap();
        assert_eq!((fault.kind, fault.technique.as_str()), (FaultKind::Hang, "cpu-thread"));
        assert_eq!(fault.value, None);
        for text in ["crash", "burn:vsm", "crash:vsm@high"] {
            assert!(Fault::parse(text).unwrap_err().to_string().contains("expected"), "{text}");
        }
        // Neither aborts.
        Fault::parse("crash:vsm@1e3").unwrap().commit("vsm", Some(1.0));
        Fault::parse("crash:vsm").unwrap().commit("msm", None);
    }

    #[test]
    fn a_point_passes_through_a_pipe_whole() {
        let point = StressLine {
            run: "r".into(),
            problem: "p".into(),
            case: "c".into(),
            technique: "t".into(),
            form: "cpu".into(),
            axis: "scale".into(),
            verdict: "safe".into(),
            value: 0.1 + 0.2,
            ..StressLine::default()
        };
        let line = Event::Stress(Box::new(point.clone())).to_line();
        let Some(Event::Stress(read)) = Event::from_line(&line).unwrap() else { panic!("{line}") };
        assert_eq!(*read, point);
        let begin = Event::Begin { setting: 3, stage: "check".into(), value: Some(0.1 + 0.2) };
        let Some(Event::Begin { value, .. }) = Event::from_line(&begin.to_line()).unwrap() else {
            panic!("{}", begin.to_line())
        };
        assert_eq!(value, Some(0.1 + 0.2));
    }
}
