use super::{
    map::{Kind, Summary, bar, summary},
    *,
};
use crate::{
    app::App,
    msg::JobId,
    store::Store,
    testing::{catalogue, drawn, has_colour, sizes, styled, text_of},
};
use dapple_records::{Feed, FeedLine, Index};
use insta::assert_snapshot;
use ratatui::buffer::Buffer;
use std::sync::Arc;

fn point(axis: &str, value: f64, verdict: &str) -> StressLine {
    StressLine {
        machine: "aaaaaaaa".into(),
        adapter: "cpu".into(),
        device: "cpu".into(),
        problem: "shadow-filtering".into(),
        case: "spheres".into(),
        technique: "vsm".into(),
        variant: "plain".into(),
        form: "cpu".into(),
        axis: axis.into(),
        logarithmic: true,
        value,
        label: format!("{value}"),
        verdict: verdict.into(),
        metric: "rmse".into(),
        error: (verdict != "crashed").then_some(value / 10.0),
        limit: Some(0.1),
        reason: format!("{verdict} here"),
        command: format!(
            "dapple stress shadow-filtering --axis {axis} --technique vsm/plain --form cpu --at {value}"
        ),
        ..StressLine::default()
    }
}

fn points(axis: &str, verdicts: &[(f64, &str)]) -> Vec<StressLine> {
    verdicts.iter().map(|(value, verdict)| point(axis, *value, verdict)).collect()
}

fn told(points: &[StressLine]) -> Summary {
    summary(&points.iter().collect::<Vec<_>>())
}

fn world(colour: bool) -> World {
    let mut world = App::new(colour, 1_767_326_400_000).world;
    let mut catalogue = catalogue();
    let axis = |id: &str| (id.to_string(), String::new(), format!("pushes the {id}"));
    catalogue.problems[0].extremes = ["scale", "offset", "vertices"].map(axis).into();
    world.problem = catalogue.problems[0].id.clone();
    world.catalogue = Some(Arc::new(catalogue));
    let mut index = Index::default();
    let mut stress = points(
        "scale",
        &[(0.01, "broken"), (0.1, "safe"), (1.0, "safe"), (10.0, "safe"), (100.0, "broken")],
    );
    stress.extend(points("offset", &[(1.0, "safe"), (10.0, "crashed")]));
    for (word, value, verdict) in [("nan", 0.0, "refused"), ("infinite", 1.0, "broken")] {
        stress.push(StressLine {
            label: word.into(),
            must_refuse: true,
            ..point("vertices", value, verdict)
        });
    }
    let mut others = points("scale", &[(0.01, "safe"), (1.0, "safe"), (100.0, "safe")]);
    others.extend(points("offset", &[(1.0, "not-run")]));
    stress.extend(others.into_iter().map(|p| StressLine { technique: "esm".into(), ..p }));
    stress.push(StressLine {
        form: "gpu".into(),
        adapter: "llvmpipe".into(),
        device: "software".into(),
        ..point("scale", 1.0, "safe")
    });
    index.stress = stress;
    world.store = Arc::new(Store::of(index));
    world
}

#[test]
fn shares_are_of_the_axis_as_it_is_stepped() {
    let some = |kind, share| Summary { kind, share: Some(share) };
    let close = |points: &[(f64, &str)], expect: Summary| {
        let found = told(&points_of(points));
        assert_eq!(found.kind, expect.kind, "{points:?}");
        let gap = found.share.unwrap_or(-1.0) - expect.share.unwrap_or(-1.0);
        assert!(gap.abs() < 1e-12, "{points:?}: {found:?}");
    };
    // Two decades of four, in the logarithm.
    close(
        &[(0.01, "broken"), (0.1, "safe"), (10.0, "safe"), (100.0, "broken")],
        some(Kind::Part, 0.5),
    );
    close(&[(1.0, "safe"), (10.0, "safe")], some(Kind::Full, 1.0));
    close(&[(1.0, "broken"), (10.0, "refused")], some(Kind::None, 0.0));
    close(
        &[(1.0, "safe"), (10.0, "safe"), (100.0, "broken"), (1e3, "safe"), (1e4, "safe")],
        some(Kind::Holes, 0.5),
    );
    close(&[(1.0, "safe"), (10.0, "crashed")], some(Kind::Crashed, 0.0));
    close(&[(1.0, "not-run")], Summary { kind: Kind::NotRun, share: None });
    assert_eq!(told(&[]).kind, Kind::NotRun);
    // From 0 on a logarithm cannot be taken: even steps.
    close(&[(0.0, "safe"), (1.0, "safe"), (4.0, "broken")], some(Kind::Part, 0.25));
}

fn points_of(verdicts: &[(f64, &str)]) -> Vec<StressLine> {
    points("scale", verdicts)
}

#[test]
fn bad_input_that_was_accepted_is_a_fault_and_words_count_alike() {
    let word = |label: &str, value: f64, verdict: &str| StressLine {
        label: label.into(),
        must_refuse: true,
        ..point("vertices", value, verdict)
    };
    let half = [word("nan", 0.0, "refused"), word("inf ", 1.0, "crashed")];
    assert_eq!(told(&half), Summary { kind: Kind::Crashed, share: Some(0.5) });
    assert_eq!(told(&[word("nan", 0.0, "safe")]).kind, Kind::Crashed);
    assert_eq!(told(&[word("nan", 0.0, "refused")]).kind, Kind::Full);
}

#[test]
fn the_axis_is_drawn_where_points_are() {
    let all = points_of(&[
        (1.0, "broken"),
        (10.0, "safe"),
        (100.0, "safe"),
        (1e3, "broken"),
        (1e4, "safe"),
    ]);
    let all: Vec<_> = all.iter().collect();
    assert_eq!(bar(&all, 9), "x·███·x·▌");
    assert_eq!(bar(&all, 0), "");
    assert_eq!(bar(&[], 9), "");
    assert_eq!(bar(&all[..1], 9), "", "one point is no axis");
}

fn seen(state: &State, world: &World, width: u16, height: u16) -> Buffer {
    drawn(width, height, |area, buf| state.view(world, area, buf))
}

fn said(state: &State, world: &World) -> String {
    text_of(&seen(state, world, 80, 22)).join("\n")
}

#[test]
fn cells_are_walked_and_forms_and_places_go_round() {
    let (mut state, mut world) = (State::default(), world(false));
    assert!(said(&state, &world).contains("vsm/plain along scale"));
    assert!(said(&state, &world).contains("safe in ]0.1, 10["));
    for (action, expect) in [
        (Action::Left, "vsm/plain along scale"),
        (Action::Right, "vsm/plain along offset"),
        (Action::Down, "esm/plain along offset"),
        (Action::Down, "esm/plain along offset"),
        (Action::Right, "esm/plain along vertices"),
        (Action::Right, "esm/plain along vertices"),
        (Action::Up, "✗ infinite"),
        (Action::Form, "adapter llvmpipe (software)"),
        (Action::Adapter, "adapter llvmpipe (software)"),
        (Action::Form, "adapter cpu"),
    ] {
        assert_eq!(state.update(action, &mut world), []);
        let said = said(&state, &world);
        assert!(said.contains(expect), "{action:?} {expect} in\n{said}");
    }
}

#[test]
fn a_cell_opens_to_its_failures_and_a_failure_to_its_picture() {
    let (mut state, mut world) = (State::default(), world(false));
    state.update(Action::Open, &mut world);
    assert!(said(&state, &world).contains("2 points not safe"), "{}", said(&state, &world));
    state.update(Action::Down, &mut world);
    assert!(said(&state, &world).contains("rmse 10.00, limit 0.1000; broken here"));
    let effects = state.update(Action::Open, &mut world);
    let [Effect::Start { job, arguments, input: false }] = &effects[..] else {
        panic!("{effects:?}")
    };
    assert_eq!(
        arguments.join(" "),
        "stress shadow-filtering --axis scale --technique vsm/plain --form cpu --at 100 --feed"
    );
    assert!(said(&state, &world).contains("is being made"));
    let picture = Feed::Picture {
        request: 0,
        width: 1,
        height: 1,
        truth: "/w==".into(),
        result: "AA==".into(),
    };
    let hear = |state: &mut State, world: &mut World, job: JobId, event: Feed| {
        let line = Box::new(FeedLine::Event(event));
        state.hear(&Msg::Heard { job, line }, world);
    };
    hear(&mut state, &mut world, JobId(99), picture.clone());
    assert!(state.image.picture.is_none(), "another's child");
    hear(&mut state, &mut world, *job, picture);
    assert!(state.image.picture.is_some());
    // Another point: the child at work is stopped first.
    state.update(Action::Up, &mut world);
    let again = state.update(Action::Open, &mut world);
    let [Effect::Stop(stopped), Effect::Start { job: second, .. }] = &again[..] else {
        panic!("{again:?}")
    };
    assert_eq!(stopped, job);
    state.hear(&Msg::Grumbled { job: *second, text: "no disk".into() }, &mut world);
    let ended = Msg::Ended { job: *second, code: Some(3), how: "exit code 3".into() };
    state.hear(&ended, &mut world);
    let words = said(&state, &world);
    assert!(words.contains("! exit code 3") && words.contains("no disk"), "{words}");
    assert_eq!(state.update(Action::Close, &mut world), []);
    assert!(state.open.is_none() && state.image.picture.is_none());
}

#[test]
fn without_points_the_command_is_said() {
    let mut world = world(false);
    world.store = Arc::new(Store::of(Index::default()));
    let mut state = State::default();
    assert!(said(&state, &world).contains("`dapple stress shadow-filtering`"));
    for action in [Action::Open, Action::Form, Action::Adapter, Action::Right, Action::Down] {
        assert_eq!(state.update(action, &mut world), []);
    }
}

#[test]
fn screens() {
    let (mut state, mut world) = (State::default(), world(true));
    assert_snapshot!("stress_80x22", styled(&seen(&state, &world, 80, 22)));
    assert_snapshot!("stress_120x38", styled(&seen(&state, &world, 120, 38)));
    state.update(Action::Open, &mut world);
    assert_snapshot!("stress_points_80x22", styled(&seen(&state, &world, 80, 22)));
}

#[test]
fn no_size_panics_and_without_colour_there_is_none() {
    let (mut state, mut world) = (State::default(), world(false));
    for _ in 0..2 {
        for (width, height) in sizes() {
            assert!(!has_colour(&seen(&state, &world, width, height)));
        }
        state.update(Action::Open, &mut world);
    }
}
