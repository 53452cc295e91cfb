use super::*;
use crate::{
    app::App,
    testing::{catalogue, drawn, has_colour, sizes, styled, text_of},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use dapple_records::catalogue::KnobInfo;
use insta::assert_snapshot;
use ratatui::{buffer::Buffer, layout::Rect};
use std::sync::Arc;

fn world(colour: bool) -> World {
    let mut world = App::new(colour, 1_000_000).world;
    let mut catalogue = catalogue();
    catalogue.problems[0].parameters = vec![KnobInfo {
        name: "width".into(),
        unit: "px".into(),
        help: "image columns".into(),
        limit: "an integer in 16..=7680 px".into(),
        default: 320.into(),
        steps: vec![160.into(), 320.into()],
        accuracy: "none".into(),
    }];
    world.problem = catalogue.problems[0].id.clone();
    world.catalogue = Some(Arc::new(catalogue));
    world
}

/// The child, and what it is asked.
fn asked(effects: &[Effect]) -> (JobId, Show) {
    match effects {
        [.., Effect::Write { job, line }] => (*job, serde_json::from_str(line).unwrap()),
        other => panic!("{other:?}"),
    }
}

fn entered() -> (State, World, JobId) {
    let (mut state, mut world) = (State::default(), world(false));
    let effects = state.enter(&mut world);
    assert!(
        matches!(&effects[0], Effect::Start { arguments, input: true, .. } if arguments == &["live"])
    );
    let job = asked(&effects).0;
    (state, world, job)
}

fn tell(state: &mut State, world: &mut World, job: JobId, event: Feed) {
    let line = Box::new(FeedLine::Event(event));
    assert_eq!(state.hear(&Msg::Heard { job, line }, world), []);
}

fn checked(request: u64, rmse: f64) -> Feed {
    Feed::Checked {
        request,
        errors: BTreeMap::from([("rmse".into(), rmse)]),
        counters: BTreeMap::from([("texels_fetched".into(), 12_345)]),
        memory_bytes: 1 << 20,
        violations: Vec::new(),
    }
}

fn picture(request: u64) -> Feed {
    let bytes = |lit: u32| {
        let pixel = |i: u32| if (i % 32 + i / 32).is_multiple_of(lit) { 255_u8 } else { 60 };
        STANDARD.encode((0..32 * 18).map(pixel).collect::<Vec<u8>>())
    };
    Feed::Picture { request, width: 32, height: 18, truth: bytes(4), result: bytes(3) }
}

fn select(state: &mut State, world: &mut World, wanted: &Row) {
    let rows = state.choice.rows(world.info().unwrap());
    state.cursor.set(rows.iter().position(|row| row == wanted).unwrap());
}

#[test]
fn keys_ask_for_what_they_turn_and_for_nothing_else() {
    let (mut state, mut world, child) = entered();
    select(&mut state, &mut world, &Row::Knob("resolution".into()));
    let (job, show) = asked(&state.update(Action::Right, &mut world));
    assert_eq!((job, &show.knobs["resolution"]), (child, &1024.into()));
    // Numbers stop at their ends; nothing changed, so nothing is asked.
    assert_eq!(state.update(Action::Right, &mut world), []);
    let (_, back) = asked(&state.update(Action::Left, &mut world));
    assert!(back.knobs.is_empty(), "a default is not sent");
    assert!(back.request > show.request);

    select(&mut state, &mut world, &Row::Parameter("width".into()));
    let (_, show) = asked(&state.update(Action::Left, &mut world));
    assert_eq!(show.parameters["width"], 160);

    for (action, view) in [
        (Action::OrbitRight, "orbit:10,0,1"),
        (Action::OrbitUp, "orbit:10,10,1"),
        (Action::Farther, "orbit:10,10,1.4"),
        (Action::OrbitLeft, "orbit:0,10,1.4"),
        (Action::OrbitLeft, "orbit:-10,10,1.4"),
        (Action::Nearer, "orbit:-10,10,1"),
        (Action::OrbitDown, "orbit:-10,0,1"),
        (Action::OrbitRight, ""),
    ] {
        assert_eq!(asked(&state.update(action, &mut world)).1.view, view);
    }
    let (_, show) = asked(&state.update(Action::Technique, &mut world));
    assert_eq!((show.technique.as_str(), world.technique.as_str()), ("vsm", "vsm"));
    assert_eq!(asked(&state.update(Action::Form, &mut world)).1.form, "gpu");
    let (_, show) = asked(&state.update(Action::Reset, &mut world));
    assert_eq!((show.technique.as_str(), show.form.as_str()), ("vsm", "gpu"));
    assert!(show.parameters.is_empty() && show.view.is_empty());
    for quiet in [Action::Up, Action::Down, Action::Flip, Action::ErrorMap, Action::Metric] {
        assert_eq!(state.update(quiet, &mut world), [], "{quiet:?}");
    }
}

#[test]
fn a_full_turn_and_the_poles_stay_in_what_a_view_may_say() {
    let (mut state, mut world, _) = entered();
    for _ in 0..40 {
        state.update(Action::OrbitRight, &mut world);
        state.update(Action::OrbitUp, &mut world);
        state.update(Action::Farther, &mut world);
    }
    assert_eq!(state.choice.view(), "orbit:40,90,4");
    assert_eq!(state.update(Action::OrbitUp, &mut world), []);
}

#[test]
fn only_the_newest_request_is_answered() {
    let (mut state, mut world, child) = entered();
    let first = state.asked.as_ref().unwrap().show.request;
    let (_, show) = asked(&state.update(Action::Technique, &mut world));
    tell(&mut state, &mut world, child, checked(first, 0.5));
    tell(&mut state, &mut world, child, picture(first));
    let stale = Feed::Frame { request: first, ns: 5, clock: "wall".into() };
    tell(&mut state, &mut world, child, stale);
    let late = Feed::Failed { request: first, reason: "late".into() };
    tell(&mut state, &mut world, child, late);
    assert!(state.answer.is_none() && state.picture.is_none() && state.trouble.is_none());
    assert_eq!(state.times.count(), 0);
    // Nor does another's child say anything here.
    tell(&mut state, &mut world, JobId(77), checked(show.request, 0.5));
    assert!(state.answer.is_none());

    tell(&mut state, &mut world, child, checked(show.request, 0.2));
    tell(&mut state, &mut world, child, picture(show.request));
    let frame = Feed::Frame { request: show.request, ns: 5_000_000, clock: "wall".into() };
    tell(&mut state, &mut world, child, frame);
    assert_eq!(state.answer.as_ref().unwrap().errors["rmse"], 0.2);
    assert!(state.picture.is_some() && state.times.count() == 1);
}

#[test]
fn a_change_is_told_against_the_setting_before() {
    let (mut state, mut world, child) = entered();
    let request = state.asked.as_ref().unwrap().show.request;
    tell(&mut state, &mut world, child, checked(request, 0.2));
    select(&mut state, &mut world, &Row::Knob("resolution".into()));
    let (_, show) = asked(&state.update(Action::Right, &mut world));
    tell(&mut state, &mut world, child, checked(show.request, 0.1));
    let said = text_of(&seen(&state, &world, 120, 40)).join("\n");
    assert!(said.contains("rmse 0.1000 ▼-50%"), "{said}");
    assert!(said.contains("change: resolution default → 1024"), "{said}");
    assert!(said.contains("--knob resolution=1024"), "{said}");
    // Asked again for the same, the change stays.
    let (_, again) = asked(&state.update(Action::Open, &mut world));
    tell(&mut state, &mut world, child, checked(again.request, 0.1));
    assert_eq!(state.before.as_ref().unwrap().errors["rmse"], 0.2);
}

#[test]
fn a_dead_child_is_shown_with_its_last_words_and_started_by_a_key() {
    let (mut state, mut world, child) = entered();
    let text = "dapple: device lost".to_string();
    state.hear(&Msg::Grumbled { job: child, text }, &mut world);
    let ended = Msg::Ended { job: child, code: None, how: "killed by signal 9".into() };
    assert_eq!(state.hear(&ended, &mut world), []);
    let said = text_of(&seen(&state, &world, 80, 24)).join("\n");
    assert!(said.contains("! the live process ended:") && said.contains("device lost"), "{said}");
    assert!(said.contains("Enter starts it again"), "{said}");
    // Not by itself: what dies at once would be started for ever.
    assert_eq!(state.hear(&Msg::Tick(2_000_000), &mut world), []);
    let effects = state.update(Action::Open, &mut world);
    let [Effect::Start { job, .. }, Effect::Write { .. }] = effects[..] else {
        panic!("{effects:?}")
    };
    assert_ne!(job, child);
    assert!(state.trouble.is_none());
}

#[test]
fn the_child_lives_while_the_screen_is_shown() {
    let (mut state, mut world, child) = entered();
    assert_eq!(state.leave(&mut world), [Effect::Stop(child)]);
    assert_eq!(state.hear(&Msg::Tick(2_000_000), &mut world), []);
    let ended = Msg::Ended { job: child, code: None, how: "killed".into() };
    state.hear(&ended, &mut world);
    assert!(state.trouble.is_none(), "it was asked to");
    assert_eq!(state.enter(&mut world).len(), 2);
    // Where the declarations come later, it starts then.
    let (mut state, mut bare) = (State::default(), App::new(false, 0).world);
    assert_eq!(state.enter(&mut bare), []);
    assert_eq!(state.hear(&Msg::Tick(1), &mut world).len(), 2);
}

#[test]
fn another_problem_is_shown_by_the_same_child_and_what_has_no_picture_has_no_camera() {
    let (mut state, mut world, child) = entered();
    world.problem = "offsets".into();
    world.technique.clear();
    let effects = state.enter(&mut world);
    assert_eq!(effects.len(), 1, "no second child: {effects:?}");
    let (job, show) = asked(&effects);
    assert_eq!((job, show.problem.as_str(), show.technique.as_str()), (child, "offsets", "scan"));
    assert_eq!(state.update(Action::OrbitLeft, &mut world), []);
    tell(
        &mut state,
        &mut world,
        child,
        Feed::Checked {
            request: show.request,
            errors: BTreeMap::from([("wrong".into(), 0.0)]),
            counters: BTreeMap::new(),
            memory_bytes: 5,
            violations: vec!["order is broken".into()],
        },
    );
    let said = text_of(&seen(&state, &world, 80, 24)).join("\n");
    assert!(said.contains("wrong 0") && said.contains("! broken: order is broken"), "{said}");
    assert!(!said.contains("picture"), "{said}");
}

fn seen(state: &State, world: &World, width: u16, height: u16) -> Buffer {
    drawn(width, height, |area: Rect, buf: &mut Buffer| state.view(world, area, buf))
}

fn answered(colour: bool) -> (State, World) {
    let (mut state, mut world, child) = entered();
    world.theme.colour = colour;
    let request = state.asked.as_ref().unwrap().show.request;
    tell(&mut state, &mut world, child, checked(request, 0.02));
    select(&mut state, &mut world, &Row::Knob("resolution".into()));
    let (_, show) = asked(&state.update(Action::Right, &mut world));
    tell(&mut state, &mut world, child, checked(show.request, 0.025));
    tell(&mut state, &mut world, child, picture(show.request));
    for i in 0..60 {
        let ns = 4_000_000 + 50_000 * (i % 7) * (i % 5);
        let clock = "wall".into();
        tell(&mut state, &mut world, child, Feed::Frame { request: show.request, ns, clock });
    }
    (state, world)
}

#[test]
fn screens() {
    let (state, world) = answered(false);
    assert_snapshot!("live_80x22", styled(&seen(&state, &world, 80, 22)));
    assert_snapshot!("live_120x38", styled(&seen(&state, &world, 120, 38)));
}

#[test]
fn no_size_panics_and_without_colour_there_is_none() {
    for colour in [false, true] {
        let (mut state, world) = answered(colour);
        for (width, height) in sizes().step_by(5) {
            let buf = seen(&state, &world, width, height);
            assert!(colour || !has_colour(&buf));
        }
        state.trouble = Some("a reason ".repeat(40));
        state.child = None;
        for (width, height) in [(0, 0), (1, 1), (20, 3), (80, 22)] {
            seen(&state, &world, width, height);
        }
    }
}
