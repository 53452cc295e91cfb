use super::*;
use crate::{
    app::App,
    msg::JobId,
    testing::{self, key},
};
use ratatui::crossterm::event::KeyCode;

fn world() -> World {
    testing::app(false).world
}

fn press(state: &mut State, world: &mut World, codes: &[KeyCode]) -> Vec<Effect> {
    codes.iter().flat_map(|code| state.key(key(*code), world)).collect()
}

fn typed(text: &str) -> Vec<KeyCode> {
    text.chars().map(KeyCode::Char).collect()
}

fn arguments(effects: &[Effect]) -> Vec<String> {
    match effects {
        [Effect::Start { arguments, input: false, .. }] => arguments.clone(),
        other => panic!("{other:?}"),
    }
}

/// The form of a verb, by its name.
fn form_of(verb: &str, world: &mut World) -> State {
    let mut state = State::default();
    state.cursor.set(0);
    state.form = Some(Form::new(world));
    for _ in 0..20 {
        if state.form.as_ref().is_some_and(|f| f.verb().0 == verb) {
            return state;
        }
        press(&mut state, world, &[KeyCode::Right]);
    }
    panic!("no verb {verb}");
}

#[test]
fn a_form_becomes_a_command() {
    let mut world = world();
    let mut state = form_of("sweep", &mut world);
    let effects = press(&mut state, &mut world, &[KeyCode::Enter]);
    assert_eq!(arguments(&effects), ["measure", "--feed", "--sweep=quick"]);
    assert!(!state.typing());
    let job = world.jobs.list[0].id;
    assert_eq!(selected_job(&state, &world), Some(job));
    world.jobs.end(job, Some(0), "done", 0);

    let mut state = form_of("measure", &mut world);
    let mut keys = vec![KeyCode::Down, KeyCode::Right, KeyCode::Tab];
    keys.extend(typed("q 'two words'"));
    keys.extend([KeyCode::Down, KeyCode::Down]);
    keys.extend(typed("--helpx"));
    keys.extend([KeyCode::Backspace, KeyCode::Enter]);
    let effects = press(&mut state, &mut world, &keys);
    assert_eq!(
        arguments(&effects),
        [
            "measure",
            "--feed",
            "offsets",
            "--scene=q",
            "--scene=two words",
            // What is typed is a value and cannot become a flag.
            "--technique=--help",
        ]
    );
    // A second job waits for the first.
    let mut state = form_of("verify", &mut world);
    assert!(press(&mut state, &mut world, &[KeyCode::Enter]).is_empty());
    let last = world.jobs.list.last().unwrap();
    assert_eq!(last.arguments, ["verify", "--feed"], "all problems are no argument");
}

#[test]
fn every_verb_of_the_form_has_fields_and_escape_starts_nothing() {
    let mut world = world();
    let mut seen = std::collections::BTreeSet::new();
    let mut state = form_of("sweep", &mut world);
    for _ in 0..7 {
        let form = state.form.as_ref().unwrap();
        assert!(!form.fields.is_empty());
        seen.insert(form.verb().0);
        press(&mut state, &mut world, &[KeyCode::Right]);
    }
    assert_eq!(seen.len(), 7);
    assert!(press(&mut state, &mut world, &[KeyCode::Esc]).is_empty());
    assert!(!state.typing() && world.jobs.list.is_empty());
}

#[test]
fn an_unfinished_run_is_resumed_with_its_own_command() {
    assert_eq!(
        form::again("dapple measure --sweep 'my sweep.toml' --records records"),
        Some(
            ["measure", "--sweep", "my sweep.toml", "--records", "records", "--feed"]
                .map(String::from)
                .to_vec()
        )
    );
    // A verb that tells nothing is started as it was.
    let advise = form::again("dapple advise p --scene q").unwrap();
    assert!(!advise.contains(&"--feed".to_string()));
    for foreign in ["rm -rf /", "", "dapple", "dapple 'half"] {
        assert_eq!(form::again(foreign), None, "{foreign}");
    }

    let mut world = world();
    let mut state = State::default();
    // Rows: no jobs, then runs, the newest first; the fixture's first is unfinished.
    let unfinished = world.store.index.ended.iter().rev().position(|ended| !ended).unwrap();
    state.cursor.set(unfinished);
    let effects = state.update(Action::New, &mut world);
    assert_eq!(arguments(&effects), ["measure", "--sweep", "quick", "--feed"]);
    // On a complete one a form opens.
    let complete = world.store.index.ended.iter().rev().position(|ended| *ended).unwrap();
    state.cursor.set(complete + 1);
    assert!(state.update(Action::New, &mut world).is_empty());
    assert!(state.typing());
}

#[test]
fn a_job_is_cancelled_and_its_log_scrolls_within_bounds() {
    let mut world = world();
    let mut state = State::default();
    let id = match state.start(vec!["verify".into()], &mut world).as_slice() {
        [Effect::Start { job, .. }] => *job,
        other => panic!("{other:?}"),
    };
    assert_eq!(state.update(Action::Cancel, &mut world), [Effect::Stop(id)]);
    assert_eq!(world.jobs.list[0].state, JobState::Stopping);
    for n in 0..50 {
        world.jobs.get_mut(id).unwrap().log(format!("line {n}"));
    }
    state.update(Action::Open, &mut world);
    let picture = world.clone();
    let shown = |state: &State| {
        let buf = testing::drawn(60, 12, |area, buf| state.view(&picture, area, buf));
        testing::text_of(&buf).join("\n")
    };
    assert!(shown(&state).contains("line 49"));
    let mut scrolled = state.clone();
    scrolled.update(Action::First, &mut world);
    assert!(shown(&scrolled).contains("command") && !shown(&scrolled).contains("line 49"));
    for _ in 0..3 {
        scrolled.update(Action::Up, &mut world);
    }
    assert!(shown(&scrolled).contains("command"));
    state.update(Action::Close, &mut world);
    assert!(!shown(&state).contains("line 49"));
}

#[test]
fn every_state_of_a_job_is_told_apart_without_colour() {
    let ended = |code, how: &str| JobState::Ended { code, how: how.into() };
    let states = [
        JobState::Queued,
        JobState::Running,
        JobState::Stopping,
        ended(Some(0), "done"),
        ended(Some(1), "done; a check failed"),
        ended(Some(2), "refused"),
        ended(None, "cancelled"),
        ended(None, "killed"),
    ];
    let mut world = world();
    world.jobs.add("a".into(), Vec::new(), 0);
    let mut seen = std::collections::BTreeSet::new();
    for one in &states {
        let job = &mut world.jobs.list[0];
        job.state = one.clone();
        seen.insert(state(job, Theme { colour: false }).text);
    }
    assert_eq!(seen.len(), states.len(), "{seen:?}");
}

#[test]
fn a_failed_job_shows_what_it_said() {
    let mut app: App = testing::app(false);
    app.world.jobs.add("measure nothing".into(), Vec::new(), 0);
    let id = app.world.jobs.list[0].id;
    app.update(Msg::Grumbled { job: id, text: "unknown problem `nothing`".into() });
    app.update(Msg::Ended { job: id, code: Some(2), how: "refused".into() });
    let cells = job_cells(&app.world.jobs.list[0], &app.world);
    assert_eq!(cells[0].text, "measure nothing: unknown problem `nothing`");
    // No such job: nothing happens.
    app.update(Msg::Ended { job: JobId(999), code: None, how: String::new() });
}
