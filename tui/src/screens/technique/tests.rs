use super::*;
use crate::{
    app::App,
    msg::JobId,
    store::Store,
    testing::{drawn, has_colour, sizes, styled, text_of},
};
use dapple_records::{
    Catalogue, Feed, FeedLine, Index, Row, RunHeader, Show, catalogue::ProblemInfo,
};
use std::sync::Arc;

/// Technique `t` with sizes 64, 128 and 256 at one layer, and 64 at two; `u` never recorded.
fn world() -> World {
    let header = RunHeader { run: "1".into(), ..RunHeader::default() };
    let mut text = header.to_line() + "\n";
    let settings = [(64, 1, 1_000, 0.4), (256, 1, 16_000, 0.1), (128, 1, 4_000, 0.2)];
    for (size, layers, ns, error) in settings.into_iter().chain([(64, 2, 2_000, 0.3)]) {
        let row = Row {
            run: "1".into(),
            problem: "p".into(),
            technique: "t".into(),
            variant: "plain".into(),
            form: "cpu".into(),
            case: "c".into(),
            scene: "c".into(),
            device: "cpu".into(),
            truth: "exact".into(),
            clock: "wall".into(),
            time: "2026-01-01T00:00:00.000Z".into(),
            samples_ns: vec![vec![ns]],
            knobs: [("size".to_string(), size.into()), ("layers".to_string(), layers.into())]
                .into(),
            errors: [("rmse".to_string(), error), ("leak".to_string(), 0.5)].into(),
            ..Row::default()
        };
        text += &(row.identified().to_line() + "\n");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.jsonl"), text).unwrap();
    let mut world = App::new(false, 0).world;
    // Rows are read from disk: the folder must outlive the test.
    world.store = Arc::new(Store::of(Index::open(&folder.keep()).unwrap()));
    world.problem = "p".into();
    let knob = |name: &str, limit: &str, default: i32| KnobInfo {
        name: name.into(),
        help: format!("the number of {name}"),
        limit: limit.into(),
        default: default.into(),
        accuracy: "monotone".into(),
        ..KnobInfo::default()
    };
    let technique = |id: &str| TechniqueInfo {
        id: id.into(),
        title: format!("Technique {id}"),
        source: "An Author, A Title, 2010".into(),
        forms: vec!["reference".into(), "cpu".into()],
        variants: vec![("plain".into(), "as printed".into())],
        knobs: vec![knob("layers", "1 to 8", 1), knob("size", "1 to 4096", 64)],
    };
    let info = ProblemInfo {
        id: "p".into(),
        question: "How dark?".into(),
        truth: "counting".into(),
        metrics: vec![("rmse".into(), String::new(), "root mean square".into())],
        axis: "rmse".into(),
        pictures: true,
        techniques: vec![technique("t"), technique("u")],
        ..ProblemInfo::default()
    };
    world.catalogue = Some(Arc::new(Catalogue { problems: vec![info], ..Catalogue::default() }));
    world
}

/// Answers requests for rows as the reader would; the other effects are returned.
fn answer(state: &mut State, world: &mut World, effects: Vec<Effect>) -> Vec<Effect> {
    let mut others = Vec::new();
    for effect in effects {
        let Effect::ReadRows { request, entries } = effect else {
            others.push(effect);
            continue;
        };
        let index = &world.store.index;
        let rows = entries.iter().map(|&at| index.row(&index.entries[at]).unwrap()).collect();
        others.extend(state.hear(&Msg::Rows { request, rows: Ok(rows) }, world));
    }
    others
}

/// The screen entered, its rows read, its child started.
fn entered(world: &mut World) -> (State, JobId, u64) {
    let mut state = State::default();
    let effects = state.enter(world);
    let effects = answer(&mut state, world, effects);
    let (job, show) = started(&effects);
    (state, job, show.request)
}

fn started(effects: &[Effect]) -> (JobId, Show) {
    let [Effect::Start { job, arguments, input: true }, Effect::Write { job: to, line }] = effects
    else {
        panic!("{effects:?}")
    };
    assert_eq!((arguments[0].as_str(), job), ("live", to));
    (*job, serde_json::from_str(line).unwrap())
}

fn heard(job: JobId, event: Feed) -> Msg {
    Msg::Heard { job, line: Box::new(FeedLine::Event(event)) }
}

fn picture(request: u64) -> Feed {
    Feed::Picture { request, width: 2, height: 1, truth: "AP8=".into(), result: "//8=".into() }
}

fn text(state: &State, world: &World, width: u16, height: u16) -> String {
    text_of(&drawn(width, height, |area, buf| state.view(world, area, buf))).join("\n")
}

#[test]
fn curves_take_the_rows_that_differ_in_one_knob_only() {
    let mut world = world();
    let (state, ..) = entered(&mut world);
    let knobs = state.knobs(&world);
    let of = |name: &str| {
        let knob = knobs.iter().find(|k| k.name == name).unwrap();
        let [errors, times] = state.curves(knob, "rmse");
        assert_eq!(errors.len(), times.len());
        errors.into_iter().map(|s| (s.label, s.value, s.current)).collect::<Vec<_>>()
    };
    let expect = [("64", 0.4, true), ("128", 0.2, false), ("256", 0.1, false)];
    assert_eq!(of("size"), expect.map(|(label, v, c)| (label.to_string(), v, c)), "by size");
    assert_eq!(of("layers").len(), 2);
}

#[test]
fn settings_knobs_techniques_and_pictures_go_round() {
    let mut world = world();
    let (mut state, ..) = entered(&mut world);
    assert_eq!(state.settings.len(), 4);
    for _ in 0..4 {
        state.update(Action::Right, &mut world);
    }
    assert_eq!(state.setting, 0);
    state.update(Action::Left, &mut world);
    assert_eq!(state.setting, 3);
    state.update(Action::Up, &mut world);
    assert_eq!(state.knob, 1);
    state.update(Action::Down, &mut world);
    assert_eq!(state.knob, 0);
    assert_eq!(state.metric(&world), "rmse");
    state.update(Action::Metric, &mut world);
    assert_eq!(state.metric(&world), "leak");
    for _ in 0..3 {
        state.update(Action::Flip, &mut world);
    }
    assert_eq!(state.pictures.face, 0);
    state.update(Action::Technique, &mut world);
    assert_eq!(world.technique, "u");
    assert!(text(&state, &world, 80, 22).contains("dapple measure p --technique u"));
    state.update(Action::Technique, &mut world);
    assert_eq!(world.technique, "t");
}

#[test]
fn a_child_makes_the_pictures_and_is_stopped_once_they_are_there() {
    let mut world = world();
    let (mut state, job, number) = entered(&mut world);
    assert!(text(&state, &world, 80, 22).contains("rendering"));
    let stale = heard(job, picture(number + 7));
    assert_eq!(state.hear(&stale, &mut world), []);
    assert_eq!(state.hear(&heard(JobId(999), picture(number)), &mut world), []);
    assert!(state.pictures.shown.is_none());
    let ready = |truth: &str| Feed::Ready { case: "c".into(), truth: truth.into(), frames: 1 };
    state.hear(&heard(job, ready("exact")), &mut world);
    assert!(state.pictures.note.is_empty());
    state.hear(&heard(job, ready("another")), &mut world);
    assert!(state.pictures.note.contains("another"));
    let stopped = state.hear(&heard(job, picture(number)), &mut world);
    assert_eq!(stopped, [Effect::Stop(job)]);
    assert!(matches!(state.pictures.shown, Some(Ok(_))));
    let ended = Msg::Ended { job, code: None, how: "killed".into() };
    assert_eq!(state.hear(&ended, &mut world), []);
    assert!(matches!(state.pictures.shown, Some(Ok(_))), "its end takes nothing away");
    // Nothing new is wanted: nothing is started.
    state.leave(&mut world);
    let effects = state.enter(&mut world);
    assert_eq!(answer(&mut state, &mut world, effects), []);
}

#[test]
fn only_the_last_setting_is_rendered_when_keys_are_held_down() {
    let mut world = world();
    let (mut state, job, _) = entered(&mut world);
    for _ in 0..3 {
        let effects = state.update(Action::Right, &mut world);
        assert!(answer(&mut state, &mut world, effects).iter().all(|e| *e == Effect::Stop(job)));
    }
    let ended = Msg::Ended { job, code: None, how: "killed".into() };
    let (next, show) = started(&state.hear(&ended, &mut world));
    assert_ne!(next, job);
    assert_eq!(show.knobs, state.row().unwrap().knobs);
    assert_eq!(show.knobs["size"], 256);
}

#[test]
fn a_child_that_fails_is_told_and_one_left_behind_is_stopped() {
    let mut world = world();
    let (mut state, job, number) = entered(&mut world);
    let failed = Feed::Failed { request: number, reason: "no adapter here".into() };
    assert_eq!(state.hear(&heard(job, failed), &mut world), [Effect::Stop(job)]);
    assert!(text(&state, &world, 80, 22).contains("no adapter here"));
    let (mut state, job, _) = entered(&mut world);
    state.hear(&Msg::Grumbled { job, text: "out of memory".into() }, &mut world);
    state.hear(&Msg::Ended { job, code: Some(3), how: "exit 3".into() }, &mut world);
    assert!(text(&state, &world, 80, 22).contains("out of memory"));
    let (mut state, job, _) = entered(&mut world);
    assert_eq!(state.leave(&mut world), [Effect::Stop(job)]);
    let (_, job, _) = entered(&mut world);
    assert!(job.0 > 0);
}

#[test]
fn stale_rows_are_ignored() {
    let mut world = world();
    let mut state = State::default();
    let effects = state.enter(&mut world);
    let [Effect::ReadRows { request, .. }] = effects[..] else { panic!("{effects:?}") };
    state.hear(&Msg::Rows { request: request + 5, rows: Ok(vec![Row::default()]) }, &mut world);
    assert!(state.rows.is_empty() && state.asked.is_some());
    state.hear(&Msg::Rows { request, rows: Err("cut short".into()) }, &mut world);
    assert!(text(&state, &world, 80, 22).contains("cut short"));
}

#[test]
fn a_problem_without_pictures_starts_no_child() {
    let mut world = world();
    let mut catalogue = Catalogue::clone(world.catalogue.as_ref().unwrap());
    catalogue.problems[0].pictures = false;
    world.catalogue = Some(Arc::new(catalogue));
    let mut state = State::default();
    let effects = state.enter(&mut world);
    assert_eq!(answer(&mut state, &mut world, effects), []);
    assert!(!text(&state, &world, 80, 22).contains("pictures"));
}

#[test]
fn screens_at_two_sizes_and_any_other() {
    let mut world = world();
    for colour in [true, false] {
        world.theme.colour = colour;
        let (mut state, job, number) = entered(&mut world);
        state.hear(&heard(job, picture(number)), &mut world);
        state.update(Action::Down, &mut world);
        for (width, height) in [(80, 22), (120, 38)] {
            let buf = drawn(width, height, |area, buf| state.view(&world, area, buf));
            if colour {
                insta::assert_snapshot!(format!("technique_{width}x{height}"), styled(&buf));
            } else {
                assert!(!has_colour(&buf));
            }
        }
        for docs in [false, true] {
            state.docs = docs;
            for (width, height) in sizes() {
                drawn(width, height, |area, buf| state.view(&world, area, buf));
            }
        }
    }
    for (width, height) in sizes() {
        drawn(width, height, |area, buf| {
            State::default().view(&App::new(true, 0).world, area, buf)
        });
    }
}
