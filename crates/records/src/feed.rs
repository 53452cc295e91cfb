//! What a running `dapple` tells a dashboard: JSON lines on its standard output, mixed with the
//! lines of records themselves (rows, gates, claims, stress points).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::catalogue::Catalogue;
use crate::error::RecordError;
use crate::line::Line;

/// One event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Feed {
    /// What there is.
    Catalogue(Box<Catalogue>),
    /// A job begins.
    Started {
        /// The record file.
        path: String,
        /// Results planned, 0 if not known.
        total: usize,
        /// Results found of an earlier, unfinished run.
        resumed: usize,
    },
    /// What is at work now.
    Stage {
        /// The group, gate, claim or axis.
        what: String,
        /// The setting, or empty.
        setting: String,
        /// `prepare`, `check`, `time`, or empty.
        stage: String,
    },
    /// Results on disk so far.
    Progress {
        /// How many.
        done: usize,
    },
    /// Something the user should know.
    Note {
        /// The sentence.
        text: String,
    },
    /// A case is ready to be shown live.
    Ready {
        /// The case's name and truth, for people.
        case: String,
        /// Truth and its parameters, in words.
        truth: String,
        /// Frames of the case's path.
        frames: usize,
    },
    /// A live technique was checked against truth.
    Checked {
        /// Number of the request it answers.
        request: u64,
        /// Method errors.
        errors: BTreeMap<String, f64>,
        /// Counters.
        counters: BTreeMap<String, u64>,
        /// Memory of the technique's own data.
        memory_bytes: u64,
        /// Broken invariants.
        violations: Vec<String>,
    },
    /// One live frame's time.
    Frame {
        /// Number of the request it belongs to.
        request: u64,
        /// The time.
        ns: u64,
        /// `gpu` or `wall`.
        clock: String,
    },
    /// Truth and result as pictures, rows top to bottom, one byte a pixel (0 dark, 255 lit).
    Picture {
        /// Number of the request it answers.
        request: u64,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Truth, base64.
        truth: String,
        /// Result, base64.
        result: String,
    },
    /// A request or job could not be carried out.
    Failed {
        /// Number of the request, 0 for the job itself.
        request: u64,
        /// Why, for people.
        reason: String,
    },
    /// The job ended by itself.
    Done {
        /// Its exit code.
        code: u8,
    },
}

/// What a live process is asked to show; one JSON line on its standard input. A later request
/// replaces an earlier one that was not yet begun.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Show {
    /// Number of the request, rising.
    pub request: u64,
    /// Problem id.
    pub problem: String,
    /// Scene as on the command line; empty for the default.
    pub scene: String,
    /// View; empty for the first, `orbit:AZIMUTH,ELEVATION,DISTANCE` for one turned from it.
    pub view: String,
    /// Seed.
    pub seed: u64,
    /// Case parameters that are not at their default.
    pub parameters: BTreeMap<String, Value>,
    /// Technique id.
    pub technique: String,
    /// Variant; empty for the default.
    pub variant: String,
    /// Form.
    pub form: String,
    /// Knobs that are not at their default.
    pub knobs: BTreeMap<String, Value>,
}

/// A line of a child's output.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedLine {
    /// An event.
    Event(Feed),
    /// A record line.
    Record(Line),
}

impl Feed {
    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        // Plain data with string keys: serialising it cannot fail.
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl FeedLine {
    /// Reads a line; `None` for one that is neither (a driver printing on standard output).
    ///
    /// # Errors
    /// A record line or event of ours that cannot be read.
    pub fn parse(line: &str) -> Result<Option<Self>, RecordError> {
        let Ok(value) = serde_json::from_str::<Value>(line) else { return Ok(None) };
        if value.get("kind").is_some() {
            return Line::parse(line.as_bytes()).map(|line| Some(Self::Record(line)));
        }
        if value.get("event").is_none() {
            return Ok(None);
        }
        let event = serde_json::from_value(value);
        event.map(|e| Some(Self::Event(e))).map_err(|e| RecordError::Json(e.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::row;

    #[test]
    fn events_and_rows_are_told_apart_and_noise_is_passed_over() {
        let event = Feed::Frame { request: 3, ns: 17, clock: "wall".into() };
        assert_eq!(
            FeedLine::parse(&event.to_line()).unwrap(),
            Some(FeedLine::Event(event.clone()))
        );
        assert_eq!(
            FeedLine::parse(&row(0).to_line()).unwrap(),
            Some(FeedLine::Record(Line::Row(Box::new(row(0)))))
        );
        let catalogue = Feed::Catalogue(Box::default());
        let read = FeedLine::parse(&catalogue.to_line()).unwrap();
        assert_eq!(read, Some(FeedLine::Event(catalogue)));
        for noise in ["", "warning", "{\"a\":1}", "[1]"] {
            assert_eq!(FeedLine::parse(noise).unwrap(), None);
        }
        assert!(FeedLine::parse("{\"event\":\"frame\"}").is_err());
    }
}
