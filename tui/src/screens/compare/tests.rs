use super::*;
use crate::{
    app::App,
    store::Store,
    testing::{drawn, has_colour, sizes, styled, text_of},
};
use dapple_records::{Index, RunHeader};
use std::sync::Arc;

/// One setting in a run: technique, repeats, error, bytes counted.
type Setting<'a> = (&'a str, [u64; 5], f64, u64);

fn lines(run: &str, time: &str, machine: &str, settings: &[Setting<'_>]) -> String {
    let header = RunHeader {
        run: run.into(),
        sweep: "quick".into(),
        sweep_hash: "0".into(),
        time: time.into(),
        machine: machine.into(),
        revision: "abc".into(),
        ..RunHeader::default()
    };
    let mut text = header.to_line() + "\n";
    for (technique, ns, error, counted) in settings {
        let row = Row {
            run: run.into(),
            problem: "p".into(),
            technique: technique.to_string(),
            form: "cpu".into(),
            case: "c".into(),
            machine: machine.into(),
            device: "cpu".into(),
            time: time.into(),
            clock: "wall".into(),
            samples_ns: ns.iter().map(|ns| vec![*ns]).collect(),
            errors: [("rmse".to_string(), *error), ("leak".to_string(), 0.5)].into(),
            counters: [("texels".to_string(), *counted)].into(),
            ..Row::default()
        };
        text += &(row.identified().to_line() + "\n");
    }
    text
}

const STEADY: [u64; 5] = [1_000_000, 1_001_000, 1_002_000, 1_003_000, 1_004_000];
const TWICE: [u64; 5] = [2_000_000, 2_001_000, 2_002_000, 2_003_000, 2_004_000];

/// Three runs on one machine, one on another.
fn world() -> World {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let old = [("same", STEADY, 0.1, 7), ("slow", STEADY, 0.1, 7), ("wrong", STEADY, 0.1, 7)];
    let new = [("same", STEADY, 0.1, 7), ("slow", TWICE, 0.1, 7), ("wrong", STEADY, 0.2, 7)];
    write("a.jsonl", lines("1", "2026-01-01T00:00:00.000Z", "m", &old));
    write("b.jsonl", lines("2", "2026-01-02T00:00:00.000Z", "m", &new));
    write("c.jsonl", lines("3", "2026-01-03T00:00:00.000Z", "m", &old));
    write("d.jsonl", lines("4", "2026-01-01T12:00:00.000Z", "other", &old));
    let mut world = App::new(false, 1_767_484_800_000).world;
    // Rows are read from disk: the folder must outlive the test.
    let index = Index::open(&folder.keep()).unwrap();
    world.store = Arc::new(Store::of(index));
    world.problem = "p".into();
    world
}

/// Carries out what was asked for, as the reader would.
fn answer(state: &mut State, world: &mut World, effects: Vec<Effect>) {
    for effect in effects {
        let Effect::ReadRows { request, entries } = effect else { panic!("{effect:?}") };
        let index = &world.store.index;
        let rows = entries.iter().map(|&at| index.row(&index.entries[at]).unwrap()).collect();
        state.hear(&Msg::Rows { request, rows: Ok(rows) }, world);
    }
}

fn compared(world: &mut World) -> State {
    let mut state = State::default();
    let effects = state.enter(world);
    answer(&mut state, world, effects);
    state
}

fn ids(state: &State, world: &World) -> [String; 2] {
    state.runs.unwrap().map(|run| world.store.index.headers[run].run.clone())
}

fn shown(state: &State) -> Vec<(String, Vec<&'static str>)> {
    let outcome = state.outcome().unwrap();
    let of = |&at: &usize| {
        let changes = outcome.comparison.pairs[at].changes.iter().map(|c| c.name()).collect();
        (outcome.lines[at].setting.clone(), changes)
    };
    state.listed().iter().map(of).collect()
}

#[test]
fn the_newest_run_is_compared_with_the_one_before_it() {
    let mut world = world();
    let state = compared(&mut world);
    assert_eq!(ids(&state, &world), ["2", "3"]);
    assert_eq!(
        shown(&state),
        [("wrong".to_string(), vec!["better"]), ("slow".to_string(), vec!["faster"])]
    );
}

#[test]
fn other_runs_are_chosen_on_either_side_and_never_the_same_twice() {
    let mut world = world();
    let mut state = compared(&mut world);
    // On the right the next older that is not on the left.
    let effects = state.update(Action::NewRun, &mut world);
    assert!(!effects.is_empty() && state.asked.is_some());
    answer(&mut state, &mut world, effects);
    assert_eq!(ids(&state, &world), ["2", "4"]);
    let effects = state.update(Action::NewRun, &mut world);
    answer(&mut state, &mut world, effects);
    let effects = state.update(Action::NewRun, &mut world);
    answer(&mut state, &mut world, effects);
    assert_eq!(ids(&state, &world), ["2", "3"], "round");
    let effects = state.update(Action::OldRun, &mut world);
    answer(&mut state, &mut world, effects);
    let effects = state.update(Action::OldRun, &mut world);
    answer(&mut state, &mut world, effects);
    let [old, new] = ids(&state, &world);
    assert!(old != new && new == "3", "{old} {new}");
}

#[test]
fn slower_and_worse_stand_first_and_all_rows_can_be_shown() {
    let mut world = world();
    let mut state = State { chosen: ["1".into(), "2".into()], ..State::default() };
    let effects = state.enter(&mut world);
    answer(&mut state, &mut world, effects);
    let changed = [("slow".to_string(), vec!["slower"]), ("wrong".to_string(), vec!["worse"])];
    assert_eq!(shown(&state), changed);
    state.update(Action::All, &mut world);
    assert_eq!(shown(&state).len(), 3);
    assert_eq!(state.metrics(), ["leak", "rmse"]);
    state.update(Action::Metric, &mut world);
    let text = text_of(&drawn(100, 20, |area, buf| state.view(&world, area, buf))).join("\n");
    assert!(text.contains("x2.00 ▲") && text.contains("0.2000▲"), "{text}");
    assert!(text.contains("1 slower, 1 worse"), "{text}");
}

#[test]
fn machines_are_not_mixed_and_that_is_said() {
    let mut world = world();
    let mut state = State { chosen: ["4".into(), "3".into()], ..State::default() };
    let effects = state.enter(&mut world);
    answer(&mut state, &mut world, effects);
    let outcome = state.outcome().unwrap();
    assert_eq!(outcome.comparison.joined(), 0);
    let [refused] = &outcome.comparison.refused[..] else { panic!("{:?}", outcome.comparison) };
    let text = text_of(&drawn(80, 22, |area, buf| state.view(&world, area, buf))).join(" ");
    assert!(text.contains(refused.split(' ').next().unwrap()), "{text}");
}

#[test]
fn stale_rows_are_ignored_and_trouble_is_told() {
    let mut world = world();
    let mut state = State::default();
    let effects = state.enter(&mut world);
    let [Effect::ReadRows { request, .. }] = effects[..] else { panic!("{effects:?}") };
    state.hear(&Msg::Rows { request: request + 9, rows: Ok(Vec::new()) }, &mut world);
    assert!(state.outcome.is_none() && state.asked.is_some());
    state.hear(&Msg::Rows { request, rows: Err("gone".into()) }, &mut world);
    let text = text_of(&drawn(80, 22, |area, buf| state.view(&world, area, buf))).join("\n");
    assert!(text.contains("gone"), "{text}");
    // Fewer rows than were asked for must not be paired by position.
    let mut state = State::default();
    let effects = state.enter(&mut world);
    let [Effect::ReadRows { request, .. }] = effects[..] else { panic!("{effects:?}") };
    state.hear(&Msg::Rows { request, rows: Ok(Vec::new()) }, &mut world);
    assert!(state.outcome.as_ref().unwrap().is_err());
}

#[test]
fn both_rows_stand_side_by_side() {
    let mut world = world();
    let mut state = compared(&mut world);
    let effects = state.update(Action::Open, &mut world);
    answer(&mut state, &mut world, effects);
    let lines = state.detail_lines(&world);
    let error = lines.iter().find(|l| l.what == "rmse").unwrap();
    assert_eq!((&error.sides, error.differs), (&["0.2000".into(), "0.1000".into()], true));
    assert!(lines.iter().any(|l| l.what == "machine" && !l.differs));
    for _ in 0..100 {
        state.update(Action::Down, &mut world);
    }
    assert_eq!(state.detail.as_ref().unwrap().scroll, lines.len() - 1, "not beyond the end");
    state.update(Action::Close, &mut world);
    assert!(state.detail.is_none());
}

#[test]
fn one_run_is_not_enough() {
    let mut world = world();
    world.problem = "another".into();
    let state = compared(&mut world);
    let text = text_of(&drawn(80, 22, |area, buf| state.view(&world, area, buf))).join("\n");
    assert!(text.contains("dapple measure another"), "{text}");
}

#[test]
fn screens_at_two_sizes_and_any_other() {
    let mut world = world();
    for colour in [true, false] {
        world.theme.colour = colour;
        let mut state = State { chosen: ["1".into(), "2".into()], ..State::default() };
        let effects = state.enter(&mut world);
        answer(&mut state, &mut world, effects);
        for (width, height) in [(80, 22), (120, 38)] {
            let buf = drawn(width, height, |area, buf| state.view(&world, area, buf));
            if colour {
                insta::assert_snapshot!(format!("compare_{width}x{height}"), styled(&buf));
            } else {
                assert!(!has_colour(&buf));
            }
        }
        let effects = state.update(Action::Open, &mut world);
        answer(&mut state, &mut world, effects);
        let buf = drawn(80, 22, |area, buf| state.view(&world, area, buf));
        if colour {
            insta::assert_snapshot!("compare_detail_80x22", styled(&buf));
        } else {
            assert!(!has_colour(&buf));
        }
        for (width, height) in sizes() {
            drawn(width, height, |area, buf| state.view(&world, area, buf));
        }
    }
}
