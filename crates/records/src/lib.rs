//! Measurements as append-only JSON Lines.
//!
//! One file a run: a `run` line ([`RunHeader`]), one flat `row` line for each measurement or
//! failure ([`Row`]), or one line a gate ([`GateLine`]), claim ([`ClaimLine`]) or stress point
//! ([`StressLine`]), and an `end` line ([`RunEnd`]) once the run is complete. Lines are
//! self-contained, so files may be concatenated, and DuckDB, pandas and polars read them as they
//! are. Units stand in the key (`_ns`, `_bytes`); maps are flattened (`knob.layers`,
//! `error.rmse`, `pass.filter-x_ns`).
//!
//! Versions: every line has `"schema"`. Unknown keys are ignored (a later minor change); a line of
//! a later schema is skipped with that reason; missing optional keys take their empty value.

pub mod catalogue;
pub mod claim;
pub mod compare;
pub mod error;
pub mod export;
pub mod feed;
mod fields;
#[cfg(test)]
mod fixtures;
pub mod front;
pub mod gate;
pub mod index;
pub mod line;
pub mod merge;
pub mod picture;
pub mod read;
pub mod report;
pub mod row;
pub mod safe_set;
pub mod stream;
pub mod stress;
pub mod text;
pub mod time;
pub mod validate;
pub mod write;

pub use catalogue::Catalogue;
pub use claim::{ClaimFigure, ClaimLine};
pub use error::RecordError;
pub use feed::{Feed, FeedLine, Show};
pub use front::front;
pub use gate::GateLine;
pub use index::Index;
pub use line::{Line, RunEnd, RunHeader};
pub use read::{Read, Skipped, read_dir, read_file, read_from, unfinished};
pub use row::{Row, Status};
pub use serde_json::Value;
pub use stress::StressLine;
pub use time::now;
pub use validate::validate;
pub use write::{Writer, new_run_id};

/// The schema that this crate writes and the latest that it reads.
pub const SCHEMA: u32 = 1;
