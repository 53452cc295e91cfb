use super::*;
use crate::{
    jobs::State as JobState,
    keys::{Binding, TABLE},
    store::Store,
    testing::{self, has_colour, key, sizes, styled, text_of},
};
use dapple_records::Feed;
use insta::assert_snapshot;
use ratatui::crossterm::event::KeyCode;

fn press(app: &mut App, code: KeyCode) -> Vec<Effect> {
    app.update(Msg::Key(key(code)))
}

fn control_c(app: &mut App) -> Vec<Effect> {
    app.update(Msg::Key(KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)))
}

fn shown(app: &App, width: u16, height: u16) -> Buffer {
    testing::drawn(width, height, |area, buf| app.view(area, buf))
}

fn with_job() -> (App, JobId) {
    let mut app = testing::app(false);
    let effects = app.world.jobs.add("measure --sweep quick".into(), vec!["measure".into()], 0);
    let [Effect::Start { job, .. }] = effects[..] else { panic!("{effects:?}") };
    app.world.jobs.list[0].began_ms = testing::NOW - 60_000;
    (app, job)
}

#[test]
fn messages_lead_to_states_and_effects() {
    let mut app = App::new(false, 0);
    let effects = app.start();
    let [Effect::Reload, Effect::Start { job, arguments, input: false }] = &effects[..] else {
        panic!("{effects:?}")
    };
    assert_eq!(arguments, &["catalogue"]);
    // The catalogue fails, is shown, and is asked for again by the key that reads again.
    let failed = Msg::Ended { job: *job, code: Some(3), how: "exit code 3".into() };
    app.update(Msg::Grumbled { job: *job, text: "no such file".into() });
    assert_eq!(app.update(failed), [Effect::Reload]);
    assert_eq!(app.world.catalogue_trouble.as_deref(), Some("no such file"));
    let again = press(&mut app, KeyCode::Char('r'));
    assert!(matches!(&again[..], [Effect::Reload, Effect::Start { .. }]), "{again:?}");
    assert_eq!(app.world.catalogue_trouble, None);
    // While it is asked it is not asked twice.
    assert_eq!(press(&mut app, KeyCode::Char('r')), [Effect::Reload]);

    for (code, screen) in [
        (KeyCode::Char('3'), Screen::Technique),
        (KeyCode::Tab, Screen::Live),
        (KeyCode::BackTab, Screen::Technique),
        (KeyCode::Char('8'), Screen::Runs),
        (KeyCode::Tab, Screen::Overview),
        (KeyCode::BackTab, Screen::Runs),
    ] {
        press(&mut app, code);
        assert_eq!(app.screen, screen, "{code:?}");
    }
    assert_eq!(app.update(Msg::Resize), []);
    assert_eq!(app.update(Msg::Terminate), [Effect::Quit]);
    assert_eq!(press(&mut app, KeyCode::Char('q')), [Effect::Quit]);
    assert_eq!(control_c(&mut app), [Effect::Quit]);
}

#[test]
fn leaving_with_a_job_asks_first_and_any_other_key_stays() {
    for leave in [press as fn(&mut App, KeyCode) -> Vec<Effect>, |app, _| control_c(app)] {
        let (mut app, _) = with_job();
        assert_eq!(leave(&mut app, KeyCode::Char('q')), []);
        assert!(text_of(&shown(&app, 80, 24)).join(" ").contains("1 job not done"));
        // Also a key that means something else is only an answer.
        assert_eq!(press(&mut app, KeyCode::Char('8')), []);
        assert_eq!(app.screen, Screen::Overview);
        assert!(app.world.jobs.active());
        assert_eq!(leave(&mut app, KeyCode::Char('q')), []);
        assert_eq!(leave(&mut app, KeyCode::Char('q')), [Effect::Quit]);
    }
    // The system does not ask.
    let (mut app, _) = with_job();
    assert_eq!(app.update(Msg::Terminate), [Effect::Quit]);
}

#[test]
fn keys_are_text_in_a_form_except_the_one_that_always_leaves() {
    let mut app = testing::app(false);
    press(&mut app, KeyCode::Char('8'));
    // The newest run is complete, so a form opens.
    press(&mut app, KeyCode::Char('n'));
    assert_eq!(press(&mut app, KeyCode::Char('q')), []);
    assert_eq!(press(&mut app, KeyCode::Char('1')), []);
    assert_eq!(app.screen, Screen::Runs);
    assert_eq!(control_c(&mut app), [Effect::Quit]);
    press(&mut app, KeyCode::Esc);
    press(&mut app, KeyCode::Char('1'));
    assert_eq!(app.screen, Screen::Overview);
}

/// Bindings that hold on one screen and share a key.
fn clashes(table: &'static [Binding], screen: Screen) -> Vec<&'static str> {
    let on: Vec<&Binding> =
        table.iter().filter(|b| b.screens.is_empty() || b.screens.contains(&screen)).collect();
    let twice = |b: &&&Binding| on.iter().filter(|other| other.key == b.key).count() > 1;
    on.iter().filter(twice).map(|b| b.name).collect()
}

#[test]
fn every_binding_is_reached_and_none_is_bound_twice() {
    for screen in Screen::ALL {
        assert_eq!(clashes(TABLE, screen), [""; 0], "{screen:?}");
        for binding in keys::on(screen) {
            assert_eq!(keys::lookup(key(binding.key), screen), Some(binding.action));
        }
    }
    for binding in TABLE {
        let everywhere = binding.screens.is_empty();
        assert!(everywhere || !binding.help.is_empty(), "{}", binding.name);
    }
    // The control: a key bound on one screen and everywhere is caught.
    const TWICE: &[Binding] =
        &[Binding { screens: &[Screen::Front], ..TABLE[0] }, Binding { screens: &[], ..TABLE[0] }];
    assert_eq!(clashes(TWICE, Screen::Front).len(), 2);
    assert!(clashes(TWICE, Screen::Runs).is_empty());
}

#[test]
fn footer_and_help_come_from_the_table() {
    let mut app = testing::app(false);
    for screen in Screen::ALL {
        app.go(screen);
        let footer = text_of(&shown(&app, 200, 24)).pop().unwrap();
        for binding in keys::on(screen).filter(|b| !b.label.is_empty()) {
            let words = format!("{} {}", binding.name, binding.label);
            assert!(footer.contains(&words), "{words} in {footer}");
        }
        press(&mut app, KeyCode::Char('?'));
        let help = text_of(&shown(&app, 80, 60)).join("\n");
        for binding in keys::on(screen) {
            assert!(help.contains(binding.help), "{} in\n{help}", binding.help);
        }
        // Where it does not fit it scrolls to its end, and no further.
        for _ in 0..100 {
            press(&mut app, KeyCode::Down);
        }
        let end = text_of(&shown(&app, 80, 12)).join("\n");
        assert!(end.contains("Ctrl-C"), "{end}");
        press(&mut app, KeyCode::Up);
        press(&mut app, KeyCode::Esc);
        assert!(!app.help);
    }
    // The way out is seen first of all.
    let narrow = text_of(&shown(&app, 20, 5)).pop().unwrap();
    assert!(narrow.contains("q quit"), "{narrow}");
}

#[test]
fn all_eight_screens_are_named_at_eighty_columns_and_the_current_one_always() {
    let mut app = testing::app(false);
    for screen in Screen::ALL {
        app.go(screen);
        let top = text_of(&shown(&app, 80, 24)).remove(0);
        for other in Screen::ALL {
            assert!(top.contains(other.title()), "{top}");
        }
        assert!(top.contains(&format!("{}]", screen.title())), "{top}");
        for width in 13..80 {
            let top = text_of(&shown(&app, width, 5)).remove(0);
            let name: String = screen.title().chars().take(4).collect();
            assert!(top.contains(&name), "{width}: {top}");
        }
    }
}

/// The dashboard in many states: with and without records, catalogue, jobs, boxes on top.
fn states(colour: bool) -> Vec<App> {
    let empty = App::new(colour, 0);
    let full = testing::app(colour);
    let mut busy = full.clone();
    busy.world.jobs.add("measure".into(), Vec::new(), 0);
    let job = busy.world.jobs.list[0].id;
    for event in [
        Feed::Started { path: "records/x".into(), total: 7, resumed: 1 },
        Feed::Progress { done: 3 },
        Feed::Note { text: "a note ".repeat(40) },
    ] {
        busy.update(Msg::Heard { job, line: Box::new(FeedLine::Event(event)) });
    }
    let mut asked = busy.clone();
    press(&mut asked, KeyCode::Char('q'));
    let mut help = full.clone();
    help.help = true;
    let mut form = full.clone();
    press(&mut form, KeyCode::Char('8'));
    press(&mut form, KeyCode::Char('n'));
    let mut detail = busy.clone();
    press(&mut detail, KeyCode::Char('8'));
    press(&mut detail, KeyCode::Enter);
    let mut broken = full.clone();
    broken.update(Msg::Store(Arc::new(Store {
        trouble: Some("reading records: permission denied".into()),
        ..Store::default()
    })));
    broken.world.catalogue = None;
    broken.world.catalogue_trouble = Some("exit code 3".into());
    let mut leaving = busy.clone();
    leaving.world.leaving = true;
    vec![empty, full, busy, asked, help, form, detail, broken, leaving]
}

#[test]
fn no_size_no_screen_and_no_state_panics() {
    let mut drawn = 0;
    for state in states(true) {
        for screen in Screen::ALL {
            let mut app = state.clone();
            let help = app.help;
            app.go(screen);
            app.help = help;
            for (width, height) in sizes() {
                shown(&app, width, height);
                drawn += 1;
            }
        }
    }
    assert!(drawn > 10_000, "{drawn}");
}

#[test]
fn twenty_by_five_still_shows_something_of_use() {
    let mut app = testing::app(false);
    for screen in Screen::ALL {
        app.go(screen);
        let lines = text_of(&shown(&app, 20, 5));
        assert!(lines.iter().filter(|l| !l.is_empty()).count() >= 3, "{screen:?}: {lines:?}");
    }
}

#[test]
fn without_colour_no_cell_has_any() {
    let on_any = |colour: bool| {
        let mut coloured = Vec::new();
        for (at, state) in states(colour).into_iter().enumerate() {
            for screen in Screen::ALL {
                let mut app = state.clone();
                app.go(screen);
                if has_colour(&shown(&app, 120, 40)) {
                    coloured.push((at, screen));
                }
            }
        }
        coloured
    };
    assert_eq!(on_any(false), []);
    // The control: with colour every state has some.
    assert!(on_any(true).len() >= states(true).len());
}

#[test]
fn what_a_real_measurement_told_is_taken_in() {
    let text = include_str!("../../../fixtures/feed/measure.jsonl");
    let (mut app, job) = with_job();
    let mut lines = 0;
    for line in text.lines() {
        let line = FeedLine::parse(line).unwrap().expect("a line of ours");
        app.update(Msg::Heard { job, line: Box::new(line) });
        lines += 1;
    }
    assert!(lines > 5);
    let told = &app.world.jobs.list[0];
    assert_eq!((told.done, told.total, told.resumed), (1, 1, 0));
    assert!(told.path.starts_with("records/"));
    app.update(Msg::Ended { job, code: Some(0), how: "done".into() });
    assert!(matches!(app.world.jobs.list[0].state, JobState::Ended { code: Some(0), .. }));
}

#[test]
fn trouble_is_said_above_the_screen() {
    let app = &states(false)[7];
    let lines = text_of(&shown(app, 120, 24));
    assert!(lines[1].starts_with("! "), "{}", lines[1]);
    assert!(lines[1].contains("permission denied") && lines[1].contains("exit code 3"));
    assert!(!text_of(&shown(&testing::app(false), 120, 24))[1].starts_with('!'));
}

#[test]
fn screens_at_two_sizes_with_styles() {
    let mut app = testing::app(true);
    for (name, width, height) in [("80x24", 80, 24), ("120x40", 120, 40), ("20x5", 20, 5)] {
        assert_snapshot!(format!("overview_{name}"), styled(&shown(&app, width, height)));
    }
    press(&mut app, KeyCode::Char('?'));
    assert_snapshot!("help_80x24", styled(&shown(&app, 80, 24)));
    press(&mut app, KeyCode::Char('?'));

    let job = {
        app.world.jobs.add("measure --sweep quick".into(), Vec::new(), testing::NOW - 90_000);
        app.world.jobs.add("verify".into(), Vec::new(), testing::NOW);
        app.world.jobs.list[0].id
    };
    for event in [
        Feed::Started {
            path: "records/20260102T035830Z-quick-c3.jsonl".into(),
            total: 40,
            resumed: 4,
        },
        Feed::Stage {
            what: "spheres gpu".into(),
            setting: "vsm/plain".into(),
            stage: "time".into(),
        },
        Feed::Note { text: "scene oak is not at hand".into() },
        Feed::Progress { done: 16 },
    ] {
        app.update(Msg::Heard { job, line: Box::new(FeedLine::Event(event)) });
    }
    app.go(Screen::Runs);
    for (name, width, height) in [("80x24", 80, 24), ("120x40", 120, 40), ("20x5", 20, 5)] {
        assert_snapshot!(format!("runs_{name}"), styled(&shown(&app, width, height)));
    }
    press(&mut app, KeyCode::Down);
    press(&mut app, KeyCode::Enter);
    assert_snapshot!("runs_log_80x24", styled(&shown(&app, 80, 24)));
    press(&mut app, KeyCode::Esc);
    press(&mut app, KeyCode::Up);
    press(&mut app, KeyCode::Char('n'));
    press(&mut app, KeyCode::Right);
    press(&mut app, KeyCode::Down);
    press(&mut app, KeyCode::Down);
    assert_snapshot!("runs_form_80x24", styled(&shown(&app, 80, 24)));
    press(&mut app, KeyCode::Esc);
    press(&mut app, KeyCode::Char('q'));
    assert_snapshot!("leave_80x24", styled(&shown(&app, 80, 24)));
}
