//! What the runner and its child processes tell each other: one JSON line each.

use crate::plan::Group;
use dapple_gpu::AdapterChoice;
use dapple_records::{RecordError, Row};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a child is asked to do; one line on its standard input.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// Id of the run, for its rows.
    pub run: String,
    /// Position of the group in the plan.
    pub index: usize,
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
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fault {
    /// What happens.
    pub kind: FaultKind,
    /// At which technique.
    pub technique: String,
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

impl Job {
    /// The key of a setting's row within its run: stable as long as the plan is.
    pub fn key(index: usize, setting: usize) -> String {
        format!("{index:04}.{setting:03}")
    }

    /// The adapter to open.
    pub fn adapter(&self) -> AdapterChoice {
        self.adapter.clone().map_or(AdapterChoice::Auto, AdapterChoice::Named)
    }
}

/// What a child reports.
#[derive(Clone, Debug)]
pub enum Event {
    /// A setting is about to be made, checked or timed: if the child dies now, it is the culprit.
    Begin {
        /// Position in the group.
        setting: usize,
        /// `prepare`, `check` or `time`.
        stage: String,
    },
    /// Something the user should know about the case.
    Note(String),
    /// A finished row.
    Row(Box<Row>),
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
            Self::Begin { setting, stage } => {
                serde_json::json!({"event": "begin", "setting": setting, "stage": stage})
                    .to_string()
            }
            Self::Note(text) => serde_json::json!({"event": "note", "text": text}).to_string(),
            Self::Failed { reason, code } => {
                serde_json::json!({"event": "failed", "reason": reason, "code": code}).to_string()
            }
            Self::Done => serde_json::json!({"event": "done"}).to_string(),
            // A row's own line: what is piped here is what a record holds.
            Self::Row(row) => row.to_line(),
        }
    }

    /// Reads a line; `None` for lines that are no event (a driver printing on standard output).
    ///
    /// # Errors
    /// A row that cannot be read.
    pub fn from_line(line: &str) -> Result<Option<Self>, RecordError> {
        let Ok(Value::Object(map)) = serde_json::from_str(line) else { return Ok(None) };
        let text = |key: &str| map.get(key).and_then(Value::as_str).unwrap_or_default().to_string();
        let number = |key: &str| map.get(key).and_then(Value::as_u64).unwrap_or_default();
        if map.contains_key("kind") {
            return Row::from_line(line).map(|row| Some(Self::Row(Box::new(row))));
        }
        Ok(match text("event").as_str() {
            "begin" => {
                Some(Self::Begin { setting: number("setting") as usize, stage: text("stage") })
            }
            "note" => Some(Self::Note(text("text"))),
            "failed" => Some(Self::Failed { reason: text("reason"), code: number("code") as u8 }),
            "done" => Some(Self::Done),
            _ => None,
        })
    }
}
