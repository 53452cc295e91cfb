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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::row;

    fn reason(change: impl FnOnce(&mut Row)) -> String {
        let mut row = row(0);
        change(&mut row);
        row.row = row.identity();
        validate(&row).unwrap_err().to_string()
    }

    fn untimed(row: &mut Row) {
        row.samples_ns.clear();
        row.passes_ns.clear();
        row.ratio = None;
    }

    #[test]
    fn good_rows_pass() {
        validate(&row(0)).unwrap();
        for (form, status) in [
            ("reference", Status::Ok),
            ("cpu", Status::Failed { stage: "port".into(), reason: "off by one".into() }),
            ("gpu", Status::NotRun { reason: "no adapter".into() }),
        ] {
            let mut row = Row { form: form.into(), status, clock: "none".into(), ..row(0) };
            untimed(&mut row);
            validate(&row.identified()).unwrap();
        }
    }

    #[test]
    fn time_is_never_without_error_nor_error_without_time() {
        assert!(reason(|r| r.errors.clear()).contains("without an error"));
        assert!(reason(untimed).contains("without samples"));
        assert!(reason(|r| r.samples_ns.push(vec![])).contains("repeat 2 has no samples"));
        assert!(reason(|r| r.samples_ns = vec![vec![0, 0]]).contains("0 ns"));
        assert!(reason(|r| r.clock = "none".into()).contains("has times"));
        let failed = Status::Failed { stage: "port".into(), reason: "x".into() };
        assert!(reason(|r| r.status = failed).contains("has times"));
        assert!(reason(|r| r.form = "reference".into()).contains("never timed"));
    }

    #[test]
    fn each_rule_is_enforced_and_named() {
        type Field = fn(&mut Row) -> &mut String;
        let empty: [(&str, Field); 10] = [
            ("run", |r| &mut r.run),
            ("problem", |r| &mut r.problem),
            ("technique", |r| &mut r.technique),
            ("case", |r| &mut r.case),
            ("time", |r| &mut r.time),
            ("scene_hash", |r| &mut r.scene_hash),
            ("size", |r| &mut r.size),
            ("adapter", |r| &mut r.adapter),
            ("machine", |r| &mut r.machine),
            ("revision", |r| &mut r.revision),
        ];
        for (name, field) in empty {
            let reason = reason(|r| field(r).clear());
            assert!(reason.ends_with(&format!("{name} is empty")), "{reason}");
        }
        assert!(reason(|r| r.form = "gpgpu".into()).contains("form is \"gpgpu\""));
        assert!(reason(|r| r.device = String::new()).contains("device is"));
        assert!(reason(|r| r.clock = "sun".into()).contains("clock is"));
        assert!(reason(|r| r.ratio = Some(f64::NAN)).contains("ratio is NaN"));
        assert!(reason(|r| r.baseline.clear()).contains("without a baseline"));
        for bad in [f64::NAN, f64::INFINITY] {
            let error = reason(|r| {
                r.errors.insert("psnr".into(), bad);
            });
            assert!(error.contains("error.psnr is"), "{error}");
            let port = reason(|r| {
                r.port_errors.insert("x".into(), bad);
            });
            assert!(port.contains("port.x is"), "{port}");
        }
        let list = reason(|r| {
            r.knobs.insert("k".into(), vec![1].into());
        });
        assert!(list.contains("knob \"k\""), "{list}");
        assert!(
            reason(|r| {
                r.counters.insert(String::new(), 1);
            })
            .contains("no name")
        );
        let stale = Row { row: "0".into(), ..row(0) };
        assert!(validate(&stale).unwrap_err().to_string().contains("its identity"));
        let mut mute = row(0);
        untimed(&mut mute);
        mute.status = Status::NotRun { reason: String::new() };
        assert!(validate(&mute).unwrap_err().to_string().contains("reason is empty"));
    }
}
