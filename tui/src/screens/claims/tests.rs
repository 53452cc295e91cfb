use super::*;
use crate::{
    app::App,
    store::Store,
    testing::{catalogue, drawn, has_colour, sizes, styled, text_of},
};
use dapple_records::{ClaimFigure, Index};
use insta::assert_snapshot;
use ratatui::buffer::Buffer;
use std::sync::Arc;

fn line(id: &str, verdict: &str, time: &str) -> ClaimLine {
    ClaimLine {
        time: time.into(),
        machine: "aaaaaaaa".into(),
        adapter: "none".into(),
        revision: "abc".into(),
        problem: "shadow-filtering".into(),
        id: id.into(),
        statement: format!("What {id} says of the two, at some length so that it wraps."),
        place: "section 3".into(),
        method: "both at equal memory".into(),
        verdict: verdict.into(),
        because: "the first errs less".into(),
        figures: vec![
            ClaimFigure { what: "error of A".into(), value: 0.0125, unit: String::new() },
            ClaimFigure { what: "time of B".into(), value: f64::NAN, unit: "ms".into() },
        ],
        ..ClaimLine::default()
    }
}

fn world(colour: bool) -> World {
    let mut world = App::new(colour, 1_767_326_400_000).world;
    let mut catalogue = catalogue();
    let claim = |id: &str| (id.to_string(), format!("The declared {id}."));
    catalogue.problems[0].claims = ["c1", "c2", "c3", "c4"].map(claim).into();
    world.problem = catalogue.problems[0].id.clone();
    world.catalogue = Some(Arc::new(catalogue));
    let mut index = Index::default();
    index.claims = vec![
        line("c1", "refuted", "2026-01-01T04:00:00Z"),
        line("c1", "reproduced", "2026-01-02T03:00:00Z"),
        line("c2", "refuted", "2026-01-02T03:00:00Z"),
        line("c4", "open", "2026-01-02T03:59:00Z"),
        line("gone", "needs-hardware", "2025-01-02T03:00:00Z"),
        ClaimLine { problem: "offsets".into(), ..line("other", "error", "2026-01-02T03:00:00Z") },
    ];
    world.store = Arc::new(Store::of(index));
    world
}

fn seen(state: &State, world: &World, width: u16, height: u16) -> Buffer {
    drawn(width, height, |area, buf| state.view(world, area, buf))
}

fn ids(state: &State, world: &World) -> Vec<String> {
    state.shown(world).iter().map(|c| format!("{} {}", c.id, c.verdict())).collect()
}

#[test]
fn declared_and_recorded_claims_are_listed_once_with_their_latest_verdict() {
    assert_eq!(
        ids(&State::default(), &world(false)),
        ["c1 reproduced", "c2 refuted", "c3 not judged", "c4 open", "gone needs-hardware"]
    );
}

#[test]
fn the_filter_goes_through_the_verdicts_there_are_and_back_to_all() {
    let (mut state, mut world) = (State::default(), world(false));
    let mut seen = Vec::new();
    for _ in 0..6 {
        assert_eq!(state.update(Action::Verdict, &mut world), []);
        seen.push(ids(&state, &world).join(", "));
    }
    assert_eq!(
        seen[..5],
        ["c1 reproduced", "c2 refuted", "c4 open", "gone needs-hardware", "c3 not judged"]
    );
    assert_eq!(state.shown(&world).len(), 5);
}

#[test]
fn a_claim_opens_scrolls_and_closes_and_one_not_judged_says_its_command() {
    let (mut state, mut world) = (State::default(), world(false));
    state.update(Action::Open, &mut world);
    let said = text_of(&seen(&state, &world, 80, 22)).join("\n");
    for part in
        ["section 3", "equal memory", "errs less", "0.01250", "none ms", "elsewhere", "✗ refuted"]
    {
        assert!(said.contains(part), "{part} in\n{said}");
    }
    let first = text_of(&seen(&state, &world, 80, 5));
    for _ in 0..3 {
        state.update(Action::Down, &mut world);
    }
    assert_ne!(text_of(&seen(&state, &world, 80, 5)), first);
    state.update(Action::Last, &mut world);
    let end = text_of(&seen(&state, &world, 80, 5)).join("\n");
    assert!(end.contains("dapple claims shadow-filtering --id c1"), "{end}");
    state.update(Action::Close, &mut world);
    for _ in 0..2 {
        state.update(Action::Down, &mut world);
    }
    state.update(Action::Open, &mut world);
    let said = text_of(&seen(&state, &world, 80, 22)).join("\n");
    assert!(said.contains("· not judged"), "{said}");
    assert!(said.contains("dapple claims shadow-filtering --id c3"), "{said}");
}

#[test]
fn screens() {
    let (mut state, mut world) = (State::default(), world(true));
    assert_snapshot!("claims_80x22", styled(&seen(&state, &world, 80, 22)));
    state.update(Action::Open, &mut world);
    assert_snapshot!("claim_120x38", styled(&seen(&state, &world, 120, 38)));
}

#[test]
fn no_size_panics_and_without_colour_there_is_none() {
    let mut state = State::default();
    for open in [false, true] {
        let mut world = world(false);
        if open {
            state.update(Action::Open, &mut world);
        }
        for (width, height) in sizes() {
            assert!(!has_colour(&seen(&state, &world, width, height)));
        }
    }
    let bare = App::new(true, 0).world;
    seen(&State::default(), &bare, 80, 22);
}
