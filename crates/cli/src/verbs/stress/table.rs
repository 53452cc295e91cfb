//! Safe sets as tables, and the points behind them for programs.

use crate::{
    args::Format,
    output::{Table, put},
};
use anyhow::Result;
use dapple_records::{
    StressLine,
    safe_set::{Interval, breaks, safe_set},
};
use dapple_suite::{
    problems,
    stress::{
        Values, find_axis,
        run::{AxisPlan, StressPlan},
    },
};

/// Reasons are cut to this many characters; the points have them whole.
const SHORT: usize = 90;

/// One table an axis and case; or every point.
pub fn print(plan: &StressPlan, points: &[StressLine], format: Format) -> Result<()> {
    match format {
        Format::Table => plan.axes.iter().try_for_each(|axis| print_axis(axis, points)),
        Format::Jsonl => Ok(points.iter().try_for_each(|point| put!("{}", point.to_line()))?),
        Format::Csv => csv(points),
    }
}

fn print_axis(plan: &AxisPlan, points: &[StressLine]) -> Result<()> {
    let axis = find_axis(problems::find(&plan.case.problem)?, &plan.axis)?;
    let unit = if axis.unit.is_empty() { String::new() } else { format!(" {}", axis.unit) };
    let home = axis.values.label(axis.home);
    let (problem, case) = (&plan.case.problem, plan.case.name());
    put!("{problem} {}, from {home}{unit}, {case}", axis.id)?;
    put!("  {}", axis.help)?;
    let mut table = Table::new(&["technique", "form", "safe", "points", "what breaks"]);
    for setting in &plan.settings {
        let form = setting.form.to_string();
        let of: Vec<&StressLine> = points
            .iter()
            .filter(|p| p.problem == *problem && p.case == case && p.axis == plan.axis)
            .filter(|p| p.technique == setting.technique && p.variant == setting.variant)
            .filter(|p| p.form == form)
            .collect();
        let name = format!("{}/{}", setting.technique, setting.variant);
        table.row([
            name.into(),
            form.into(),
            safe(axis.values, &of).into(),
            of.len().into(),
            why(&of).into(),
        ]);
    }
    table.print(Format::Table)?;
    Ok(put!("")?)
}

/// The safe set in words. An end with a star is the axis's own.
fn safe(values: Values, points: &[&StressLine]) -> String {
    let seen = points.iter().filter(|p| p.verdict != "not-run").count();
    if seen == 0 {
        return "not run".into();
    }
    let set = safe_set(points);
    match (&set[..], values) {
        ([], _) => "nothing".into(),
        ([all], _) if all.open_below && all.open_above => "everywhere".into(),
        (_, Values::Words(_)) => {
            let mut safe: Vec<_> = points.iter().filter(|p| p.is_safe()).collect();
            safe.sort_by(|a, b| a.value.total_cmp(&b.value));
            safe.iter().map(|p| p.label.as_str()).collect::<Vec<_>>().join(", ")
        }
        (set, _) => set.iter().map(interval).collect::<Vec<_>>().join(", "),
    }
}

fn interval(interval: &Interval) -> String {
    let star = |own: bool| if own { "*" } else { "" };
    let Interval { labels: [from, to], open_below, open_above, .. } = interval;
    if from == to {
        return format!("{from}{}", star(*open_below || *open_above));
    }
    format!("{from}{} .. {to}{}", star(*open_below), star(*open_above))
}

fn why(points: &[&StressLine]) -> String {
    let ends = breaks(points).into_iter().map(|point| {
        let reason: String = match point.reason.char_indices().nth(SHORT) {
            Some((cut, _)) => format!("{}…", &point.reason[..cut]),
            None => point.reason.clone(),
        };
        let how =
            if point.verdict == "broken" { String::new() } else { point.verdict.clone() + ": " };
        format!("{}: {how}{reason}", point.label)
    });
    ends.collect::<Vec<_>>().join("; ")
}

fn csv(points: &[StressLine]) -> Result<()> {
    let mut table = Table::new(&[
        "problem",
        "case",
        "technique",
        "variant",
        "form",
        "adapter",
        "device",
        "axis",
        "unit",
        "value",
        "label",
        "refined",
        "verdict",
        "must_refuse",
        "metric",
        "error",
        "limit",
        "reason",
        "command",
    ]);
    for p in points {
        table.row([
            p.problem.as_str().into(),
            p.case.as_str().into(),
            p.technique.as_str().into(),
            p.variant.as_str().into(),
            p.form.as_str().into(),
            p.adapter.as_str().into(),
            p.device.as_str().into(),
            p.axis.as_str().into(),
            p.unit.as_str().into(),
            p.value.into(),
            p.label.as_str().into(),
            p.refined.into(),
            p.verdict.as_str().into(),
            p.must_refuse.into(),
            p.metric.as_str().into(),
            p.error.into(),
            p.limit.into(),
            p.reason.as_str().into(),
            p.command.as_str().into(),
        ]);
    }
    table.print(Format::Csv)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, &str)]) -> Vec<StressLine> {
        let point = |&(value, verdict): &(f64, &str)| StressLine {
            value,
            label: value.to_string(),
            verdict: verdict.into(),
            reason: "it broke".into(),
            ..StressLine::default()
        };
        values.iter().map(point).collect()
    }

    fn shown(values: &[(f64, &str)]) -> (String, String) {
        let points = points(values);
        let points: Vec<&StressLine> = points.iter().collect();
        let axis = Values::Linear { least: 1.0, greatest: 4.0, steps: 3 };
        (safe(axis, &points), why(&points))
    }

    #[test]
    fn sets_are_written_with_their_holes_and_own_ends() {
        let (s, b) = ("safe", "broken");
        let hole = shown(&[(1.0, s), (2.0, s), (3.0, b), (4.0, s)]);
        assert_eq!(hole, ("1* .. 2, 4*".into(), "3: it broke".into()));
        assert_eq!(shown(&[(1.0, s), (4.0, s)]), ("everywhere".into(), String::new()));
        let refused = shown(&[(1.0, "refused"), (2.0, b)]);
        assert_eq!(refused, ("nothing".into(), "1: refused: it broke".into()));
        assert_eq!(shown(&[(1.0, "not-run")]), ("not run".into(), String::new()));
    }

    #[test]
    fn words_are_listed_and_long_reasons_are_cut() {
        let mut points = points(&[(2.0, "safe"), (0.0, "safe"), (1.0, "crashed")]);
        points[2].reason = "é".repeat(200);
        let points: Vec<&StressLine> = points.iter().collect();
        assert_eq!(safe(Values::Words(&["a", "b", "c"]), &points), "0, 2");
        assert_eq!(why(&points).chars().count(), "1: crashed: ".len() + SHORT + 1);
    }
}
