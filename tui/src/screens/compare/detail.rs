//! Both rows of a pair side by side.

use super::State;
use crate::{
    screens::World,
    widgets::format::{bytes, count, duration, significant},
};
use dapple_records::{Row, Status};
use std::collections::BTreeSet;

/// One line: what, old, new; and whether the sides differ.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub what: String,
    pub sides: [String; 2],
    pub differs: bool,
}

impl State {
    /// The lines of the detail that is open; none if none is.
    pub(super) fn detail_lines(&self, _world: &World) -> Vec<Line> {
        let Some(detail) = &self.detail else { return Vec::new() };
        let Some(Ok(rows)) = &detail.rows else { return Vec::new() };
        let mut rows = rows.iter();
        let sides = detail.sides.map(|there| if there { rows.next() } else { None });
        lines(sides)
    }
}

/// All that two rows say; a side that is not there is empty.
fn lines(rows: [Option<&Row>; 2]) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut tell = |what: &str, of: &dyn Fn(&Row) -> String| {
        let sides = rows.map(|row| row.map(of).unwrap_or_default());
        if sides.iter().any(|s| !s.is_empty()) {
            let differs = sides[0] != sides[1];
            lines.push(Line { what: what.into(), sides, differs });
        }
    };
    tell("outcome", &|r| match &r.status {
        Status::Ok => "ok".into(),
        Status::Failed { stage, reason } => format!("failed at {stage}: {reason}"),
        Status::NotRun { reason } => format!("not run: {reason}"),
    });
    tell("time", &|r| match (r.median_ns(), r.mad_ns()) {
        (Some(time), Some(spread)) => format!("{} ± {}", duration(time), duration(spread)),
        _ => String::new(),
    });
    tell("p99", &|r| r.p99_ns().map(duration).unwrap_or_default());
    tell("clock", &|r| format!("{}, {} repeats", r.clock, r.samples_ns.len()));
    for name in names(rows, |r| r.errors.keys().collect()) {
        tell(&name, &|r| r.errors.get(&name).map(|v| significant(*v)).unwrap_or_default());
    }
    for name in names(rows, |r| r.passes_ns.keys().collect()) {
        let of = |r: &Row| r.passes_ns.get(&name).map(|ns| duration(*ns as f64));
        tell(&format!("pass {name}"), &|r| of(r).unwrap_or_default());
    }
    for name in names(rows, |r| r.counters.keys().collect()) {
        let of = |r: &Row| r.counters.get(&name).map(|n| count(*n as usize));
        tell(&name, &|r| of(r).unwrap_or_default());
    }
    tell("memory", &|r| bytes(r.memory_bytes));
    for name in names(rows, |r| r.knobs.keys().collect()) {
        tell(&format!("knob {name}"), &|r| {
            let value = r.knobs.get(&name);
            value.map(|v| v.as_str().map_or(v.to_string(), str::to_string)).unwrap_or_default()
        });
    }
    tell("revision", &|r| format!("{}{}", r.revision, if r.dirty { " with changes" } else { "" }));
    tell("shaders", &|r| r.shader_hash.clone());
    tell("machine", &|r| r.machine.clone());
    tell("processor", &|r| format!("{}, {} threads", r.cpu, r.threads));
    tell("adapter", &|r| r.adapter.clone());
    tell("driver", &|r| r.driver.clone());
    tell("measured", &|r| r.time.clone());
    lines
}

fn names(rows: [Option<&Row>; 2], of: impl Fn(&Row) -> Vec<&String>) -> Vec<String> {
    let all: BTreeSet<String> =
        rows.into_iter().flatten().flat_map(|r| of(r).into_iter().cloned()).collect();
    all.into_iter().collect()
}
