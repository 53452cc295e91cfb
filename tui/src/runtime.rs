//! Threads, children and the terminal: everything that is not pure.

use crate::{
    Options, TuiError,
    app::App,
    msg::{Effect, JobId, Msg},
    store::Store,
};
use dapple_records::FeedLine;
use ratatui::crossterm::event::{self, Event};
use ratatui_image::picker::{Picker, cap_parser::QueryStdioOptions};
use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Write},
    process::{Child, ChildStdin, Command, Stdio},
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{self, Sender},
    },
    thread,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

/// Between two ticks; a tick also looks for new records every so often.
const TICK: Duration = Duration::from_millis(250);

/// How long a terminal may take to say what pictures it can show.
const ANSWER: Duration = Duration::from_millis(500);

/// Milliseconds since 1970.
pub fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_millis() as i64
}

/// Runs until the user quits.
///
/// # Errors
/// The terminal's.
pub fn run(options: &Options) -> Result<(), TuiError> {
    let (sender, receiver) = mpsc::channel();
    let mut terminal = ratatui::try_init()?;
    let mut hands = Hands { options: options.clone(), sender, children: BTreeMap::new() };
    let mut app = App::new(options.colour, now_ms());
    // Before the keyboard is read: the terminal's answer comes the same way.
    app.world.picker = picker(options.colour);
    hands.listen();
    let mut effects = app.start();
    let ended = loop {
        if effects.contains(&Effect::Quit) {
            break Ok(());
        }
        for effect in effects.drain(..) {
            hands.carry_out(effect, &app);
        }
        if let Err(error) = terminal.draw(|frame| app.view(frame.area(), frame.buffer_mut())) {
            break Err(error.into());
        }
        // All that has come in by now is taken in before the next picture.
        let Ok(first) = receiver.recv() else { break Ok(()) };
        effects = app.update(first);
        while let Ok(next) = receiver.try_recv() {
            effects.extend(app.update(next));
        }
    };
    hands.stop_all();
    ratatui::restore();
    ended
}

/// How this terminal shows pictures. It is asked, and given a moment to answer; terminals known
/// not to answer, and ones that pictures are drawn in characters for, are not asked.
fn picker(colour: bool) -> Picker {
    let mute = std::env::var("TERM").is_ok_and(|term| term == "dumb" || term == "linux");
    if !colour || mute {
        return Picker::halfblocks();
    }
    let options = QueryStdioOptions { timeout: ANSWER, ..QueryStdioOptions::default() };
    Picker::from_query_stdio_with_options(options).unwrap_or_else(|_| Picker::halfblocks())
}

struct Hands {
    options: Options,
    sender: Sender<Msg>,
    children: BTreeMap<JobId, Running>,
}

struct Running {
    child: Arc<Mutex<Child>>,
    input: Option<ChildStdin>,
}

impl Hands {
    fn listen(&self) {
        let sender = self.sender.clone();
        thread::spawn(move || {
            while let Ok(event) = event::read() {
                let msg = match event {
                    Event::Key(key) => Msg::Key(key),
                    Event::Resize(..) => Msg::Resize,
                    _ => continue,
                };
                if sender.send(msg).is_err() {
                    break;
                }
            }
        });
        let sender = self.sender.clone();
        thread::spawn(move || {
            while sender.send(Msg::Tick(now_ms())).is_ok() {
                thread::sleep(TICK);
            }
        });
    }

    fn carry_out(&mut self, effect: Effect, app: &App) {
        match effect {
            Effect::Quit => {}
            Effect::Reload => {
                let (sender, folder) = (self.sender.clone(), self.options.records.clone());
                thread::spawn(move || {
                    let _ = sender.send(Msg::Store(Box::new(Store::open(&folder))));
                });
            }
            Effect::ReadRows { request, entries } => {
                let (sender, store) = (self.sender.clone(), Arc::clone(&app.world.store));
                thread::spawn(move || {
                    let rows = entries
                        .iter()
                        .filter_map(|&i| store.index.entries.get(i))
                        .map(|e| store.index.row(e).map_err(|e| e.to_string()))
                        .collect();
                    let _ = sender.send(Msg::Rows { request, rows });
                });
            }
            Effect::Start { job, arguments, input } => self.spawn(job, &arguments, input),
            Effect::Write { job, line } => {
                // A child that is gone reports its end on its own.
                if let Some(input) = self.children.get_mut(&job).and_then(|r| r.input.as_mut()) {
                    let _ = writeln!(input, "{line}").and_then(|()| input.flush());
                }
            }
            Effect::Stop(job) => self.stop(job),
        }
    }

    fn spawn(&mut self, job: JobId, arguments: &[String], input: bool) {
        let started = Command::new(&self.options.program)
            .args(arguments)
            .stdin(if input { Stdio::piped() } else { Stdio::null() })
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = match started {
            Ok(child) => child,
            Err(error) => {
                let how = format!("could not be started: {error}");
                let _ = self.sender.send(Msg::Ended { job, code: None, how });
                return;
            }
        };
        let (stdin, stdout, stderr) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let child = Arc::new(Mutex::new(child));
        self.children.insert(job, Running { child: Arc::clone(&child), input: stdin });
        let sender = self.sender.clone();
        thread::spawn(move || {
            let said = stderr.map(|stderr| {
                let sender = sender.clone();
                thread::spawn(move || {
                    for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
                        let text = String::from_utf8_lossy(&line).trim_end().to_string();
                        if sender.send(Msg::Grumbled { job, text }).is_err() {
                            break;
                        }
                    }
                })
            });
            for line in stdout.into_iter().flat_map(|out| BufReader::new(out).split(b'\n')) {
                let Ok(line) = line else { break };
                let msg = match FeedLine::parse(&String::from_utf8_lossy(&line)) {
                    Ok(Some(line)) => Msg::Heard { job, line: Box::new(line) },
                    Ok(None) => continue,
                    Err(error) => Msg::Grumbled { job, text: error.to_string() },
                };
                if sender.send(msg).is_err() {
                    break;
                }
            }
            if let Some(said) = said {
                let _ = said.join();
            }
            // Its output is closed: the wait is short.
            let status = child.lock().unwrap_or_else(PoisonError::into_inner).wait();
            let (code, how) = match status {
                Ok(status) => (status.code(), status.to_string()),
                Err(error) => (None, error.to_string()),
            };
            let _ = sender.send(Msg::Ended { job, code, how });
        });
    }

    fn stop(&mut self, job: JobId) {
        let Some(running) = self.children.get_mut(&job) else { return };
        running.input = None;
        let _ = running.child.lock().unwrap_or_else(PoisonError::into_inner).kill();
    }

    fn stop_all(&mut self) {
        for job in self.children.keys().copied().collect::<Vec<_>>() {
            self.stop(job);
        }
    }
}
