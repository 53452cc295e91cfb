use super::*;
use crate::testing;
use dapple_records::{GateLine, StressLine};

fn rows() -> Vec<Summary> {
    summary::summaries(&testing::app(false).world)
}

#[test]
fn the_cheapest_that_meets_a_level_is_named_on_each_machine_and_adapter() {
    let rows = rows();
    let row = &rows[0];
    assert_eq!(row.id, "shadow-filtering");
    let names = |best: &Best| -> Vec<Option<String>> {
        best.at.iter().map(|at| at.as_ref().map(|c| c.name.clone())).collect()
    };
    // Looked up by hand in the fixture: hardware first.
    assert_eq!(row.best[0].key.device, "hardware");
    let found = names(&row.best[0]);
    assert_eq!(found.len(), 3);
    for (at, best) in row.best[0].at.iter().enumerate() {
        let level = [0.005, 0.02, 0.05][at];
        if let Some(best) = best {
            assert!(best.error <= level, "{best:?}");
        }
    }
    // A looser level is never dearer.
    let times: Vec<f64> = row.best[0].at.iter().flatten().map(|c| c.time_ns).collect();
    assert!(!times.is_empty() && times.is_sorted_by(|a, b| a >= b), "{times:?}");
}

#[test]
fn gates_claims_and_stability_are_counted_by_hand() {
    let rows = rows();
    let row = &rows[0];
    assert_eq!((row.gates.passed, row.gates.failed, row.gates.not_run), (2, 1, 1));
    assert_eq!(row.gates.broken, ["vsm bound (failed)"]);
    let claims = &row.claims;
    assert_eq!((claims.reproduced, claims.refuted, claims.open, claims.errors), (1, 1, 2, 1));
    // One pair safe throughout, one broken at an end; a point that was not run is no pair.
    assert_eq!(row.stable, (1, 2));
    let other = &rows[1];
    assert_eq!(other.gates, summary::Gates::default());
    assert_eq!((other.claims.total(), other.stable), (0, (0, 0)));
}

#[test]
fn what_is_missing_is_said_with_its_command() {
    let app = testing::app(false);
    let info = &app.world.catalogue.as_ref().unwrap().problems;
    let rows = rows();
    let said = next(&rows[1], Some(&info[1])).join("\n");
    for verb in ["measure", "verify"] {
        assert!(said.contains(&format!("dapple {verb} offsets")), "{said}");
    }
    assert!(!said.contains("stress"), "no extremes are declared: {said}");
    assert!(next(&rows[0], Some(&info[0])).is_empty());
}

#[test]
fn statuses_of_gates_are_told_apart_without_colour() {
    let world = testing::app(false).world;
    let text = |passed, failed, not_run, time_ms| {
        let gates = summary::Gates { passed, failed, not_run, time_ms, broken: Vec::new() };
        gates_text(&Summary { gates, ..Summary::default() }, &world)
    };
    let all = [
        text(3, 0, 0, Some(0)),
        text(3, 1, 0, Some(0)),
        text(0, 0, 2, Some(0)),
        text(0, 0, 0, None),
    ];
    let different: std::collections::BTreeSet<_> = all.iter().collect();
    assert_eq!(different.len(), all.len(), "{all:?}");
    assert_eq!(all[3], "- never run");
}

fn gates_text(row: &Summary, world: &World) -> String {
    gates(row, world).text
}

#[test]
fn of_gates_the_last_machine_counts_and_of_points_the_whole_axis() {
    // Controls for the two rules above, on lines made here.
    let mut app = testing::app(false);
    let mut store = (*app.world.store).clone();
    store.index.gates.push(GateLine {
        problem: "shadow-filtering".into(),
        machine: "elsewhere".into(),
        outcome: "passed".into(),
        time: "2026-06-01T00:00:00.000Z".into(),
        ..GateLine::default()
    });
    for point in store.index.stress.iter_mut().filter(|p| !p.is_safe()) {
        point.verdict = "safe".into();
    }
    store.index.stress.push(StressLine {
        problem: "shadow-filtering".into(),
        axis: "new".into(),
        verdict: "crashed".into(),
        ..StressLine::default()
    });
    app.world.store = std::sync::Arc::new(store);
    let row = &summary::summaries(&app.world)[0];
    assert_eq!((row.gates.passed, row.gates.failed), (1, 0));
    assert_eq!(row.stable, (2 + 1, 4));
}
