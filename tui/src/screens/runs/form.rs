//! The form that starts a job: which verb, then its fields. What is typed is judged by the program
//! itself; its answer stands in the job's log.

use crate::screens::World;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// Characters that a field takes.
const MOST: usize = 200;
/// Chooses every problem.
const ALL: &str = "all";

/// How a field's value becomes arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum As {
    /// The value itself.
    Word,
    /// `--name=value`.
    Flag(&'static str),
    /// `--name=value` for each word.
    Flags(&'static str),
}

/// What a field takes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Value {
    /// One of some words.
    Choice(Vec<String>, usize),
    /// A text, empty for the program's default.
    Text(String),
}

/// One line of the form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// What may stand there.
    pub hint: &'static str,
    value: Value,
    becomes: As,
}

impl Field {
    /// What stands in it.
    pub fn text(&self) -> &str {
        match &self.value {
            Value::Choice(words, at) => words.get(*at).map_or("", String::as_str),
            Value::Text(text) => text,
        }
    }

    /// Whether the arrow keys change it.
    pub fn is_choice(&self) -> bool {
        matches!(self.value, Value::Choice(..))
    }
}

/// A verb with its fields.
struct Verb {
    name: &'static str,
    help: &'static str,
    /// Arguments that always stand there.
    fixed: &'static [&'static str],
    fields: fn(&World) -> Vec<Field>,
}

const VERBS: [Verb; 7] = [
    Verb {
        name: "sweep",
        help: "a built-in sweep: times and errors",
        fixed: &["measure", "--feed"],
        fields: |world| {
            let sweeps = world.catalogue.as_ref().map(|c| c.sweeps.clone()).unwrap_or_default();
            let names = sweeps.into_iter().map(|s| s.0).collect();
            vec![
                choice("sweep", names, As::Flag("sweep")),
                text("repeats", "timed repeats; the sweep's own if empty", As::Flag("repeats")),
            ]
        },
    },
    Verb {
        name: "measure",
        help: "one problem on a scene of yours",
        fixed: &["measure", "--feed"],
        fields: |world| {
            vec![
                choice("problem", problems(world, false), As::Word),
                text(
                    "scene",
                    "generator, file, or data:PATH; several with spaces",
                    As::Flags("scene"),
                ),
                text("view", "camera name; the first if empty", As::Flag("view")),
                text(
                    "technique",
                    "TECHNIQUE or TECHNIQUE/VARIANT; all if empty",
                    As::Flags("technique"),
                ),
                text("form", "cpu or gpu; both if empty", As::Flags("form")),
                text("knob", "NAME=VALUE[,VALUE...]", As::Flags("knob")),
                text("param", "case parameter, NAME=VALUE", As::Flags("param")),
                text("repeats", "timed repeats", As::Flag("repeats")),
            ]
        },
    },
    Verb {
        name: "verify",
        help: "correctness gates with their controls",
        fixed: &["verify", "--feed"],
        fields: |world| {
            vec![
                choice("problem", problems(world, true), As::Word),
                text("technique", "only this technique's gates", As::Flag("technique")),
                text("cases", "random cases a property", As::Flag("cases")),
            ]
        },
    },
    Verb {
        name: "claims",
        help: "what the sources say, judged",
        fixed: &["claims", "--feed"],
        fields: |world| {
            vec![
                choice("problem", problems(world, true), As::Word),
                text("id", "only the claim of this id", As::Flag("id")),
            ]
        },
    },
    Verb {
        name: "stress",
        help: "where techniques break",
        fixed: &["stress", "--feed"],
        fields: |world| {
            vec![
                choice("problem", problems(world, true), As::Word),
                text("axis", "several with spaces; all if empty", As::Flags("axis")),
                text("technique", "several with spaces; all if empty", As::Flags("technique")),
                text("form", "cpu or gpu", As::Flags("form")),
            ]
        },
    },
    Verb {
        name: "advise",
        help: "the cheapest that is good enough for a scene",
        fixed: &["advise"],
        fields: |world| {
            vec![
                choice("problem", problems(world, false), As::Word),
                text("scene", "generator, file, or data:PATH", As::Flags("scene")),
                text(
                    "error",
                    "greatest error; or give a budget; the knee if neither",
                    As::Flag("error"),
                ),
                text("budget-ms", "milliseconds a frame may take", As::Flag("budget-ms")),
                text("metric", "the problem's axis metric if empty", As::Flag("metric")),
                text("time", "to spend, e.g. 60s or 5m", As::Flag("time")),
            ]
        },
    },
    Verb {
        name: "report",
        help: "everything on one HTML page",
        fixed: &["report"],
        fields: |world| {
            vec![
                choice("problem", problems(world, true), As::Word),
                text("output", "the page; report.html if empty", As::Flag("output")),
            ]
        },
    },
];

fn choice(name: &'static str, words: Vec<String>, becomes: As) -> Field {
    Field { name, hint: "Left, Right: another", value: Value::Choice(words, 0), becomes }
}

fn text(name: &'static str, hint: &'static str, becomes: As) -> Field {
    Field { name, hint, value: Value::Text(String::new()), becomes }
}

/// Problems, the current one first; before them the word for all, if that is a choice.
fn problems(world: &World, all: bool) -> Vec<String> {
    let mut ids = world.problems();
    if let Some(at) = ids.iter().position(|id| *id == world.problem) {
        ids.rotate_left(at);
    }
    all.then(|| ALL.to_string()).into_iter().chain(ids).collect()
}

/// The form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Form {
    verb: usize,
    /// The fields of the verb.
    pub fields: Vec<Field>,
    /// The field that keys go to; 0 is the verb itself.
    pub at: usize,
}

/// What a key did to the form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Done {
    /// It stays open.
    No,
    /// It is closed.
    Cancelled,
    /// A job is to be started with these arguments.
    Start(Vec<String>),
}

impl Form {
    /// An empty form.
    pub fn new(world: &World) -> Self {
        Self { verb: 0, fields: (VERBS[0].fields)(world), at: 0 }
    }

    /// The verb's name and what it does.
    pub fn verb(&self) -> (&'static str, &'static str) {
        (VERBS[self.verb].name, VERBS[self.verb].help)
    }

    /// Takes a key.
    pub fn key(&mut self, key: KeyEvent, world: &World) -> Done {
        let count = self.fields.len() + 1;
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Esc => return Done::Cancelled,
            KeyCode::Enter => return Done::Start(self.arguments()),
            KeyCode::Up | KeyCode::BackTab => self.at = (self.at + count - 1) % count,
            KeyCode::Down | KeyCode::Tab => self.at = (self.at + 1) % count,
            KeyCode::Left => self.turn(false, world),
            KeyCode::Right => self.turn(true, world),
            KeyCode::Backspace => {
                if let Some(text) = self.typed() {
                    text.pop();
                }
            }
            KeyCode::Char('u') if control => {
                if let Some(text) = self.typed() {
                    text.clear();
                }
            }
            KeyCode::Char(c) if !control && !c.is_control() => {
                if let Some(text) = self.typed().filter(|t| t.chars().count() < MOST) {
                    text.push(c);
                }
            }
            _ => {}
        }
        Done::No
    }

    fn typed(&mut self) -> Option<&mut String> {
        match &mut self.fields.get_mut(self.at.checked_sub(1)?)?.value {
            Value::Text(text) => Some(text),
            Value::Choice(..) => None,
        }
    }

    fn turn(&mut self, forward: bool, world: &World) {
        let step = |at: usize, count: usize| match (count, forward) {
            (0, _) => 0,
            (_, true) => (at + 1) % count,
            (_, false) => (at + count - 1) % count,
        };
        let Some(field) = self.at.checked_sub(1) else {
            self.verb = step(self.verb, VERBS.len());
            self.fields = (VERBS[self.verb].fields)(world);
            return;
        };
        if let Some(Field { value: Value::Choice(words, at), .. }) = self.fields.get_mut(field) {
            *at = step(*at, words.len());
        }
    }

    /// As the program takes them. A value cannot be taken for a flag: it stands behind a `=`, or
    /// is one of a list.
    fn arguments(&self) -> Vec<String> {
        let mut arguments: Vec<String> =
            VERBS[self.verb].fixed.iter().map(ToString::to_string).collect();
        for field in &self.fields {
            let value = field.text().trim();
            if value.is_empty() || field.becomes == As::Word && value == ALL {
                continue;
            }
            match field.becomes {
                As::Word => arguments.push(value.into()),
                As::Flag(flag) => arguments.push(format!("--{flag}={value}")),
                As::Flags(flag) => {
                    // Quotes keep a path with spaces together; half a quote is left as typed.
                    let words = shlex::split(value).unwrap_or_else(|| vec![value.into()]);
                    arguments.extend(words.iter().map(|word| format!("--{flag}={word}")));
                }
            }
        }
        arguments
    }
}

/// The arguments of a command that a run's header names, made to tell a dashboard; none if it is
/// not a command of ours.
pub fn again(command: &str) -> Option<Vec<String>> {
    let mut words = shlex::split(command)?;
    if words.len() < 2 || words.remove(0) != "dapple" {
        return None;
    }
    let tells = VERBS.iter().any(|v| v.fixed.contains(&"--feed") && v.fixed[0] == words[0]);
    if tells && !words.iter().any(|w| w == "--feed") {
        words.push("--feed".into());
    }
    Some(words)
}
