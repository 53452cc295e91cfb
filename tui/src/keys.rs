//! The one key table: it drives dispatch, the footer and the help.

use crate::screens::Screen;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// What a key means to a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Leave the dashboard.
    Quit,
    /// Show or hide the keys.
    Help,
    /// Leave a detail, a form or the help.
    Close,
    /// Another screen.
    Go(Screen),
    /// The next screen.
    NextScreen,
    /// The one before.
    PreviousScreen,
    /// Up a row; a knob.
    Up,
    /// Down a row; a knob.
    Down,
    /// Left; a lower value.
    Left,
    /// Right; a higher value.
    Right,
    /// Up a page.
    PageUp,
    /// Down a page.
    PageDown,
    /// The first row.
    First,
    /// The last row.
    Last,
    /// Show what is selected.
    Open,
    /// The next problem.
    Problem,
    /// The next technique.
    Technique,
    /// The next case (scene, view, size).
    Scene,
    /// The next adapter.
    Adapter,
    /// The next error metric.
    Metric,
    /// The other clock.
    Clock,
    /// All settings or those on the front.
    All,
    /// Truth in place of the result.
    Flip,
    /// Turn the camera left.
    OrbitLeft,
    /// Turn the camera right.
    OrbitRight,
    /// Raise the camera.
    OrbitUp,
    /// Lower the camera.
    OrbitDown,
    /// Bring the camera nearer.
    Nearer,
    /// Take it farther away.
    Farther,
    /// The error map in place of the result.
    ErrorMap,
    /// The next form.
    Form,
    /// The next verdict to show only.
    Verdict,
    /// Everything at its default again.
    Reset,
    /// Start something: a form on the Runs screen.
    New,
    /// Cancel the selected job.
    Cancel,
    /// Show a job's log.
    Log,
    /// The next older run on the left.
    OldRun,
    /// The next older run on the right.
    NewRun,
    /// Read the records again.
    Reload,
}

/// One line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Key.
    pub key: KeyCode,
    /// As written in footer and help.
    pub name: &'static str,
    /// What it does.
    pub action: Action,
    /// Where; everywhere if empty.
    pub screens: &'static [Screen],
    /// One or two words for the footer; empty to show it in the help only.
    pub label: &'static str,
    /// For the help.
    pub help: &'static str,
}

const fn bind(
    key: KeyCode,
    name: &'static str,
    action: Action,
    screens: &'static [Screen],
    label: &'static str,
    help: &'static str,
) -> Binding {
    Binding { key, name, action, screens, label, help }
}

const EVERY: &[Screen] = &[];
use Screen::{Claims, Compare, Front, Live, Overview, Runs, Stress, Technique};

/// The table. A screen's own lines come before the general ones.
pub const TABLE: &[Binding] = &[
    bind(KeyCode::Enter, "Enter", Action::Open, &[Overview], "front", "show the problem's front"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Front], "technique", "show the technique"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Technique], "live", "turn its knobs live"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Stress], "case", "show the case and its image"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Claims], "figures", "statement, source, figures"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Compare], "detail", "both rows side by side"),
    bind(KeyCode::Enter, "Enter", Action::Open, &[Runs], "log", "show the job's log"),
    bind(KeyCode::Char('p'), "p", Action::Problem, EVERY, "problem", "the next problem"),
    bind(
        KeyCode::Char('t'),
        "t",
        Action::Technique,
        &[Technique, Live],
        "technique",
        "the next technique",
    ),
    bind(
        KeyCode::Char('s'),
        "s",
        Action::Scene,
        &[Front, Technique, Live],
        "case",
        "the next case: scene, view, size",
    ),
    bind(KeyCode::Char('a'), "a", Action::Adapter, &[Front, Stress], "adapter", "the next adapter"),
    bind(
        KeyCode::Char('m'),
        "m",
        Action::Metric,
        &[Front, Technique, Live, Compare],
        "metric",
        "the next metric",
    ),
    bind(KeyCode::Char('c'), "c", Action::Clock, &[Front], "clock", "gpu or wall clock"),
    bind(
        KeyCode::Char('d'),
        "d",
        Action::All,
        &[Front, Compare],
        "all",
        "all rows, or only those that matter",
    ),
    bind(KeyCode::Char('f'), "f", Action::Flip, &[Live, Technique], "truth", "flip against truth"),
    bind(KeyCode::Char('h'), "h", Action::OrbitLeft, &[Live], "", "turn the camera left"),
    bind(KeyCode::Char('l'), "l", Action::OrbitRight, &[Live], "h/j/k/l orbit", "turn it right"),
    bind(KeyCode::Char('k'), "k", Action::OrbitUp, &[Live], "", "raise the camera"),
    bind(KeyCode::Char('j'), "j", Action::OrbitDown, &[Live], "", "lower the camera"),
    bind(KeyCode::Char('+'), "+", Action::Nearer, &[Live], "", "bring the camera nearer"),
    bind(KeyCode::Char('-'), "-", Action::Farther, &[Live], "", "take it farther away"),
    bind(KeyCode::Char('e'), "e", Action::ErrorMap, &[Live], "error", "flip against the error map"),
    bind(KeyCode::Char('g'), "g", Action::Form, &[Live, Stress], "form", "the next form"),
    bind(KeyCode::Char('v'), "v", Action::Verdict, &[Claims], "verdict", "one verdict, or all"),
    bind(
        KeyCode::Enter,
        "Enter",
        Action::Open,
        &[Live],
        "",
        "ask again; start a dead process anew",
    ),
    bind(KeyCode::Char('0'), "0", Action::Reset, &[Live], "reset", "everything at its default"),
    bind(KeyCode::Char('n'), "n", Action::New, &[Runs], "new", "start a sweep, claims, stress ..."),
    bind(KeyCode::Char('x'), "x", Action::Cancel, &[Runs], "cancel", "cancel the selected job"),
    bind(KeyCode::Char('o'), "o", Action::OldRun, &[Compare], "old", "another run on the left"),
    bind(KeyCode::Char('w'), "w", Action::NewRun, &[Compare], "new", "another run on the right"),
    bind(KeyCode::Up, "Up", Action::Up, EVERY, "", "up a row"),
    bind(KeyCode::Down, "Down", Action::Down, EVERY, "", "down a row"),
    bind(KeyCode::Left, "Left", Action::Left, EVERY, "", "left, or a lower value"),
    bind(KeyCode::Right, "Right", Action::Right, EVERY, "", "right, or a higher value"),
    bind(KeyCode::PageUp, "PgUp", Action::PageUp, EVERY, "", "up a page"),
    bind(KeyCode::PageDown, "PgDn", Action::PageDown, EVERY, "", "down a page"),
    bind(KeyCode::Home, "Home", Action::First, EVERY, "", "the first row"),
    bind(KeyCode::End, "End", Action::Last, EVERY, "", "the last row"),
    bind(KeyCode::Char('1'), "1", Action::Go(Overview), EVERY, "", "overview"),
    bind(KeyCode::Char('2'), "2", Action::Go(Front), EVERY, "", "front"),
    bind(KeyCode::Char('3'), "3", Action::Go(Technique), EVERY, "", "technique"),
    bind(KeyCode::Char('4'), "4", Action::Go(Live), EVERY, "", "live"),
    bind(KeyCode::Char('5'), "5", Action::Go(Stress), EVERY, "", "stress"),
    bind(KeyCode::Char('6'), "6", Action::Go(Claims), EVERY, "", "claims"),
    bind(KeyCode::Char('7'), "7", Action::Go(Compare), EVERY, "", "compare"),
    bind(KeyCode::Char('8'), "8", Action::Go(Runs), EVERY, "", "runs"),
    bind(KeyCode::Tab, "Tab", Action::NextScreen, EVERY, "screen", "the next screen"),
    bind(KeyCode::BackTab, "Shift-Tab", Action::PreviousScreen, EVERY, "", "the screen before"),
    bind(KeyCode::Char('r'), "r", Action::Reload, EVERY, "", "read the records again"),
    bind(KeyCode::Esc, "Esc", Action::Close, EVERY, "", "leave a detail, a form, the help"),
    bind(KeyCode::Char('?'), "?", Action::Help, EVERY, "help", "these keys"),
    bind(KeyCode::Char('q'), "q", Action::Quit, EVERY, "quit", "leave; running jobs are stopped"),
];

/// What a key means on a screen. Ctrl-C always quits.
pub fn lookup(key: KeyEvent, screen: Screen) -> Option<Action> {
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return (key.code == KeyCode::Char('c')).then_some(Action::Quit);
    }
    on(screen).find(|binding| binding.key == key.code).map(|binding| binding.action)
}

/// The lines that hold on a screen, its own first.
pub fn on(screen: Screen) -> impl Iterator<Item = &'static Binding> {
    TABLE.iter().filter(move |b| b.screens.is_empty() || b.screens.contains(&screen))
}
