use super::*;
use crate::{
    app::App,
    screens::Focus,
    store::Store,
    testing::{drawn, has_colour, sizes, styled, text_of},
};
use dapple_records::{
    Catalogue, Index,
    catalogue::{ProblemInfo, TechniqueInfo},
};
use std::{path::Path, sync::Arc};

/// The known front: on the imaginary graphics card gaussian-cdf, vsm, msm and layered-gaussian are
/// on it; two more adapters and another problem are there too.
fn world() -> World {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/records");
    let mut world = App::new(false, 0).world;
    world.store = Arc::new(Store::of(Index::open(&folder).unwrap()));
    assert!(world.store.latest.len() >= 15);
    world.problem = "shadow-filtering".into();
    let technique = |id: &str| TechniqueInfo { id: id.into(), ..Default::default() };
    let info = ProblemInfo {
        id: world.problem.clone(),
        metrics: vec![("rmse".into(), String::new(), String::new())],
        axis: "rmse".into(),
        techniques: ["vsm", "hard", "pcf"].map(technique).to_vec(),
        ..Default::default()
    };
    let machine = "aaaaaaaa".to_string();
    world.catalogue =
        Some(Arc::new(Catalogue { problems: vec![info], machine, ..Default::default() }));
    world
}

fn entered(world: &mut World) -> (State, Vec<Effect>) {
    let mut state = State::default();
    let effects = state.enter(world);
    (state, effects)
}

fn names(state: &State, world: &World) -> Vec<String> {
    let index = &world.store.index;
    let of = |&at: &usize| {
        let point = &state.model.points[at];
        let mark = if point.on_front { "*" } else { "" };
        format!("{}{mark}", index.setting(&index.entries[point.index]).technique)
    };
    state.listed.iter().map(of).collect()
}

fn request(effects: &[Effect]) -> (u64, usize) {
    let [Effect::ReadRows { request, entries }] = effects else { panic!("{effects:?}") };
    (*request, entries[0])
}

fn row_at(world: &World, at: usize) -> Row {
    world.store.index.row(&world.store.index.entries[at]).unwrap()
}

#[test]
fn the_known_front_is_found_and_what_is_left_out_is_counted() {
    let mut world = world();
    let (state, _) = entered(&mut world);
    // Equal points stand in the order of the file.
    let expect = ["gaussian-cdf*", "vsm*", "hard", "msm*", "layered-gaussian*", "pcf"];
    assert_eq!(names(&state, &world), expect);
    let left_out: Vec<_> = state.model.left_out.iter().map(|(w, n)| (w.as_str(), *n)).collect();
    assert_eq!(left_out, [("failed", 1), ("no rmse", 1)]);
}

#[test]
fn the_marks_are_those_of_fronts_over_whole_rows() {
    let mut world = world();
    let rows: Vec<Row> =
        (0..world.store.index.entries.len()).map(|at| row_at(&world, at)).collect();
    let refs: Vec<&Row> = rows.iter().collect();
    let mut seen = 0;
    for clock in ["gpu", "wall"] {
        for metric in ["rmse", "leak"] {
            for front in dapple_records::front(&refs, metric, clock).fronts {
                if front.points.is_empty() || front.key.problem != world.problem {
                    continue;
                }
                let choice = Choice {
                    case: Some(Case::of(&front.key)),
                    place: Some(Place::of(&front.key)),
                    metric: Some(metric.into()),
                    gpu_clock: Some(clock == "gpu"),
                };
                let model = Model::of(&world, &choice);
                assert_eq!(model.points, front.points, "{metric} {clock}");
                seen += 1;
            }
        }
    }
    assert!(seen >= 4, "{seen} fronts");
    world.problem = "no-such-problem".into();
    assert!(Model::of(&world, &Choice::default()).points.is_empty());
}

#[test]
fn adapters_and_metrics_go_round_and_never_share_a_plot() {
    let mut world = world();
    let (mut state, _) = entered(&mut world);
    let first = state.model.places[0].clone();
    assert_eq!((first.adapter.as_str(), first.device.as_str()), ("Imaginary GPU", "hardware"));
    let mut adapters = Vec::new();
    for _ in 0..3 {
        adapters.push(state.model.places[state.model.place].adapter.clone());
        let keys: std::collections::BTreeSet<u32> =
            state.model.points.iter().map(|p| world.store.index.entries[p.index].key).collect();
        assert_eq!(keys.len(), 1, "one machine, adapter, case and truth");
        state.update(Action::Adapter, &mut world);
    }
    assert_eq!(adapters, ["Imaginary GPU", "cpu", "Imaginary rasteriser"]);
    assert_eq!(state.model.place, 0, "after the last comes the first");
    assert_eq!(state.model.metric, "rmse");
    state.update(Action::Metric, &mut world);
    assert_eq!(state.model.metric, "leak");
    assert_eq!(names(&state, &world), ["vsm*", "msm*"]);
    state.update(Action::Metric, &mut world);
    assert_eq!(state.model.metric, "rmse");
}

#[test]
fn the_table_can_show_the_front_alone_and_the_selection_stays() {
    let mut world = world();
    let (mut state, _) = entered(&mut world);
    state.update(Action::Last, &mut world);
    state.update(Action::All, &mut world);
    assert_eq!(names(&state, &world).len(), 4);
    state.update(Action::First, &mut world);
    state.update(Action::Down, &mut world);
    assert_eq!(world.technique, "vsm");
    state.update(Action::All, &mut world);
    assert_eq!(names(&state, &world).len(), 6);
    assert_eq!(state.point().unwrap().time_ns, 1e5, "still vsm");
    // Read again: positions may be others, the setting is the same.
    let store = Store::of(world.store.index.clone());
    state.hear(&Msg::Store(store.into()), &mut world);
    assert_eq!(state.point().unwrap().time_ns, 1e5);
}

#[test]
fn one_row_is_asked_for_at_a_time_and_stale_answers_are_ignored() {
    let mut world = world();
    let (mut state, effects) = entered(&mut world);
    let (asked, at) = request(&effects);
    assert_eq!(state.update(Action::Down, &mut world), [], "one at a time");
    let answer = |request, at| Msg::Rows { request, rows: Ok(vec![row_at(&world, at)]) };
    let (stale, first) = (answer(asked + 100, at), answer(asked, at));
    let mut now = world.clone();
    assert_eq!(state.hear(&stale, &mut now), []);
    assert!(state.rows.is_empty());
    // The answer counts for the row it is of; the one selected by now is asked for next.
    let (asked, at) = request(&state.hear(&first, &mut now));
    assert!(state.row().is_none());
    let second = Msg::Rows { request: asked, rows: Ok(vec![row_at(&world, at)]) };
    assert_eq!(state.hear(&second, &mut now), []);
    assert_eq!(state.row().unwrap().as_ref().unwrap().technique, "vsm");
    assert_eq!(state.update(Action::Up, &mut now), [], "remembered");
    // New records: what was read is of positions that are gone.
    let store = Msg::Store(Store::of(now.store.index.clone()).into());
    assert_eq!(state.hear(&store, &mut now).len(), 1);
    assert!(state.row().is_none());
    let trouble = Msg::Rows { request: now.request, rows: Err("the file is gone".into()) };
    assert_eq!(state.hear(&trouble, &mut now), []);
    let text = text_of(&drawn(120, 40, |area, buf| state.view(&now, area, buf))).join("\n");
    assert!(text.contains("the file is gone"), "{text}");
}

#[test]
fn a_hidden_screen_does_no_work_and_shows_the_new_records_when_entered() {
    let mut world = world();
    let (mut state, _) = entered(&mut world);
    state.leave(&mut world);
    world.store = Arc::default();
    assert_eq!(state.hear(&Msg::Store(Store::default().into()), &mut world), []);
    assert_eq!(state.model.points.len(), 6, "not made anew");
    state.enter(&mut world);
    assert!(state.model.points.is_empty() && world.focus.is_some());
    let text = text_of(&drawn(80, 22, |area, buf| state.view(&world, area, buf))).join("\n");
    assert!(text.contains("dapple measure shadow-filtering"), "{text}");
}

#[test]
fn a_selection_of_another_screen_is_found() {
    let mut world = world();
    let at = (0..world.store.index.entries.len())
        .find(|&at| row_at(&world, at).technique == "msm")
        .unwrap();
    world.focus = Focus::of(&world.store.index, at);
    let (state, _) = entered(&mut world);
    assert_eq!(state.point().unwrap().index, at);
}

fn read(state: &mut State, world: &mut World, effects: &[Effect]) {
    let (request, at) = request(effects);
    let rows = Ok(vec![row_at(world, at)]);
    state.hear(&Msg::Rows { request, rows }, world);
}

#[test]
fn screens_at_two_sizes() {
    let mut world = world();
    for colour in [true, false] {
        world.theme.colour = colour;
        world.focus = None;
        let (mut state, effects) = entered(&mut world);
        read(&mut state, &mut world, &effects);
        let effects = state.update(Action::Last, &mut world);
        read(&mut state, &mut world, &effects);
        for (width, height) in [(80, 22), (120, 38)] {
            let buf = drawn(width, height, |area, buf| state.view(&world, area, buf));
            if colour {
                insta::assert_snapshot!(format!("front_{width}x{height}"), styled(&buf));
            } else {
                assert!(!has_colour(&buf));
            }
        }
    }
}

#[test]
fn no_size_panics() {
    let mut world = world();
    let (mut state, effects) = entered(&mut world);
    for (width, height) in sizes() {
        drawn(width, height, |area, buf| state.view(&world, area, buf));
        drawn(width, height, |area, buf| State::default().view(&world, area, buf));
    }
    read(&mut state, &mut world, &effects);
    for (width, height) in sizes() {
        drawn(width, height, |area, buf| state.view(&world, area, buf));
    }
}
