//! The three kinds of line.

use crate::claim::ClaimLine;
use crate::error::RecordError;
use crate::fields::{Fields, Object};
use crate::gate::GateLine;
use crate::row::Row;
use crate::stress::StressLine;

/// One parsed line of a record file.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// `"kind": "run"`: the first line of a file.
    Header(Box<RunHeader>),
    /// `"kind": "row"`.
    Row(Box<Row>),
    /// `"kind": "end"`: the last line of a complete run.
    End(RunEnd),
    /// `"kind": "gate"`.
    Gate(Box<GateLine>),
    /// `"kind": "claim"`.
    Claim(Box<ClaimLine>),
    /// `"kind": "stress"`.
    Stress(Box<StressLine>),
}

/// What was run, where and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunHeader {
    /// The run's id, unique (see [`crate::new_run_id`]).
    pub run: String,
    /// Name of the sweep; part of the file's name.
    pub sweep: String,
    /// Hash of everything that decides which rows the sweep has; a run is resumed only under the
    /// same hash.
    pub sweep_hash: String,
    /// The command line, for people.
    pub command: String,
    /// Shard as `i/n`; empty if the sweep is whole.
    pub shard: String,
    /// When the run began, RFC 3339 UTC.
    pub time: String,
    /// The program's version.
    pub version: String,
    /// Source revision of the program.
    pub revision: String,
    /// Whether the source had uncommitted changes.
    pub dirty: bool,
    /// Which machine (see [`Row::machine`]).
    pub machine: String,
    /// Operating system and architecture.
    pub os: String,
    /// Processor's name.
    pub cpu: String,
    /// Logical processors.
    pub threads: u32,
    /// Main memory.
    pub memory_bytes: u64,
}

impl RunHeader {
    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        let mut out = Object::new("run");
        for (key, text) in [
            ("run", &self.run),
            ("sweep", &self.sweep),
            ("sweep_hash", &self.sweep_hash),
            ("command", &self.command),
            ("shard", &self.shard),
            ("time", &self.time),
            ("version", &self.version),
            ("revision", &self.revision),
        ] {
            out.put(key, text.as_str());
        }
        out.put("dirty", self.dirty);
        for (key, text) in [("machine", &self.machine), ("os", &self.os), ("cpu", &self.cpu)] {
            out.put(key, text.as_str());
        }
        out.put("threads", self.threads);
        out.put("memory_bytes", self.memory_bytes);
        out.to_line()
    }
}

/// Says that a run is complete.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunEnd {
    /// The run's id.
    pub run: String,
    /// When it ended, RFC 3339 UTC.
    pub time: String,
    /// Distinct rows in the file.
    pub rows: u64,
}

impl RunEnd {
    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        let mut out = Object::new("end");
        out.put("run", self.run.as_str());
        out.put("time", self.time.as_str());
        out.put("rows", self.rows);
        out.to_line()
    }
}

impl Line {
    /// Parses one line (its line feed is optional).
    ///
    /// # Errors
    /// Not a JSON object, not one of ours, a later schema, a missing key, a wrong type.
    pub fn parse(bytes: &[u8]) -> Result<Self, RecordError> {
        let mut f = Fields::parse(bytes)?;
        // Kind and schema first: a later schema owes us nothing else.
        let kind = f.required("kind")?;
        let schema = f.count("schema")?;
        if schema == 0 {
            return Err(RecordError::Missing("schema".to_owned()));
        }
        if schema > u64::from(crate::SCHEMA) {
            return Err(RecordError::LaterSchema { found: schema, latest: crate::SCHEMA });
        }
        match kind.as_str() {
            "run" => Ok(Self::Header(Box::new(RunHeader {
                run: f.required("run")?,
                sweep: f.required("sweep")?,
                sweep_hash: f.required("sweep_hash")?,
                command: f.text("command")?,
                shard: f.text("shard")?,
                time: f.text("time")?,
                version: f.text("version")?,
                revision: f.text("revision")?,
                dirty: f.flag("dirty")?,
                machine: f.text("machine")?,
                os: f.text("os")?,
                cpu: f.text("cpu")?,
                threads: f.count32("threads")?,
                memory_bytes: f.count("memory_bytes")?,
            }))),
            "row" => Ok(Self::Row(Box::new(Row::from_fields(&mut f)?))),
            "end" => Ok(Self::End(RunEnd {
                run: f.required("run")?,
                time: f.text("time")?,
                rows: f.count("rows")?,
            })),
            "gate" => Ok(Self::Gate(Box::new(GateLine::from_fields(&mut f)?))),
            "claim" => Ok(Self::Claim(Box::new(ClaimLine::from_fields(&mut f)?))),
            "stress" => Ok(Self::Stress(Box::new(StressLine::from_fields(&mut f)?))),
            _ => Err(RecordError::Kind(kind)),
        }
    }

    /// One JSON line, without its line feed.
    pub fn to_line(&self) -> String {
        match self {
            Self::Header(line) => line.to_line(),
            Self::Row(line) => line.to_line(),
            Self::End(line) => line.to_line(),
            Self::Gate(line) => line.to_line(),
            Self::Claim(line) => line.to_line(),
            Self::Stress(line) => line.to_line(),
        }
    }
}
