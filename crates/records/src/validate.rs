//! The rules that a row must keep before it is written.

use serde_json::Value;

use crate::error::RecordError;
use crate::row::{Row, Status};

/// Checks a row.
///
/// - `run`, `problem`, `technique`, `form` (`reference`, `cpu` or `gpu`), `case` and `time` are
///   not empty; `row` is the row's identity; names of knobs, errors, passes and counters are not
///   empty; knobs are scalars.
/// - An `Ok` row also names scene hash, size, adapter, device (`hardware`, `software` or `cpu`),
///   machine and revision, and has at least one error. Its clock is `gpu` or `wall` and it has
///   samples (no repeat is empty), or its clock is `none` and it has none. Errors and ratio are
///   finite: time is never shown without error, nor error without time.
/// - A reference form is never timed.
/// - A `Failed` row has stage and reason, a `NotRun` row a reason; neither has times.
///
/// # Errors
/// [`RecordError::Invalid`] with the first broken rule.
pub fn validate(row: &Row) -> Result<(), RecordError> {
    check(row).map_err(|reason| RecordError::Invalid {
        problem: row.problem.clone(),
        technique: row.technique.clone(),
        case: row.case.clone(),
        reason,
    })
}

fn check(row: &Row) -> Result<(), String> {
    for (name, text) in [
        ("run", &row.run),
        ("problem", &row.problem),
        ("technique", &row.technique),
        ("case", &row.case),
        ("time", &row.time),
    ] {
        not_empty(name, text)?;
    }
    one_of("form", &row.form, &["reference", "cpu", "gpu"])?;
    if row.row != row.identity() {
        return Err(format!("row is {:?}, its identity {:?}", row.row, row.identity()));
    }
    names("knob", row.knobs.keys())?;
    names("error", row.errors.keys())?;
    names("port", row.port_errors.keys())?;
    names("counter", row.counters.keys())?;
    names("pass", row.passes_ns.keys())?;
    for (name, value) in &row.knobs {
        if matches!(value, Value::Null | Value::Array(_) | Value::Object(_)) {
            return Err(format!("knob {name:?} is no number, text or flag: {value}"));
        }
    }
    match &row.status {
        Status::Ok => check_ok(row),
        Status::Failed { stage, reason } => {
            not_empty("stage", stage)?;
            not_empty("reason", reason)?;
            untimed(row, "a failed row")
        }
        Status::NotRun { reason } => {
            not_empty("reason", reason)?;
            untimed(row, "a row that was not run")
        }
    }
}

fn check_ok(row: &Row) -> Result<(), String> {
    for (name, text) in [
        ("scene_hash", &row.scene_hash),
        ("size", &row.size),
        ("adapter", &row.adapter),
        ("machine", &row.machine),
        ("revision", &row.revision),
    ] {
        not_empty(name, text)?;
    }
    one_of("device", &row.device, &["hardware", "software", "cpu"])?;
    if row.errors.is_empty() {
        return Err("status ok without an error: time is never shown without error".to_owned());
    }
    for (kind, values) in [("error", &row.errors), ("port", &row.port_errors)] {
        if let Some((name, value)) = values.iter().find(|(_, value)| !value.is_finite()) {
            return Err(format!("{kind}.{name} is {value}; leave out what is not finite"));
        }
    }
    one_of("clock", &row.clock, &["gpu", "wall", "none"])?;
    if row.clock == "none" {
        return untimed(row, "a row with clock none");
    }
    if row.form == "reference" {
        return Err("a reference form is never timed; its clock is none".to_owned());
    }
    if row.samples_ns.is_empty() {
        return Err("status ok without samples: error is never shown without time".to_owned());
    }
    if let Some(repeat) = row.samples_ns.iter().position(Vec::is_empty) {
        return Err(format!("repeat {repeat} has no samples"));
    }
    if row.samples_ns.iter().flatten().all(|&ns| ns == 0) {
        return Err("every sample is 0 ns: the clock does not run".to_owned());
    }
    match row.ratio {
        Some(ratio) if !ratio.is_finite() => Err(format!("ratio is {ratio}")),
        Some(_) if row.baseline.is_empty() => Err("a ratio without a baseline".to_owned()),
        _ => Ok(()),
    }
}

fn untimed(row: &Row, what: &str) -> Result<(), String> {
    if row.samples_ns.is_empty() && row.passes_ns.is_empty() && row.ratio.is_none() {
        Ok(())
    } else {
        Err(format!("{what} has times"))
    }
}

fn not_empty(name: &str, text: &str) -> Result<(), String> {
    if text.is_empty() { Err(format!("{name} is empty")) } else { Ok(()) }
}

fn one_of(name: &str, text: &str, allowed: &[&str]) -> Result<(), String> {
    if allowed.contains(&text) {
        Ok(())
    } else {
        Err(format!("{name} is {text:?}, not one of {}", allowed.join(", ")))
    }
}

fn names<'a>(kind: &str, mut names: impl Iterator<Item = &'a String>) -> Result<(), String> {
    if names.any(String::is_empty) { Err(format!("a {kind} has no name")) } else { Ok(()) }
}
