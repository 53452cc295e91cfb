//! Threads, children and the terminal: everything that is not pure.
//!
//! One channel feeds the loop, and it is bounded: whoever talks faster than is drawn has to wait,
//! and memory does not grow. The loop itself never waits on a child or a file. Drawing follows a
//! message, at most thirty times a second unless a key was pressed; an idle dashboard sleeps.

mod children;
mod lines;
mod loader;
mod terminal;

use crate::{
    Fault, Options, TuiError,
    app::App,
    msg::{Effect, Msg},
};
use children::Children;
use loader::Loader;
use ratatui::crossterm::event::{self, Event};
use ratatui_image::picker::{Picker, cap_parser::QueryStdioOptions};
use std::{
    io::Write,
    sync::{
        Arc,
        mpsc::{self, Receiver, RecvTimeoutError, SyncSender},
    },
    thread,
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};
use terminal::Screen;

/// Between two ticks while a job runs, and while none does.
const TICK_BUSY: Duration = Duration::from_millis(250);
const TICK_IDLE: Duration = Duration::from_secs(1);
/// Between two pictures, unless a key asks for one.
const FRAME: Duration = Duration::from_millis(33);
/// Messages that may wait. A key waits behind no more than these.
const WAITING: usize = 128;
/// How long a terminal may take to say how it shows pictures.
const ANSWER: Duration = Duration::from_millis(500);

/// Milliseconds since 1970.
pub fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

/// Runs until the user quits.
///
/// # Errors
/// The terminal's.
pub fn run(options: &Options) -> Result<(), TuiError> {
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    let mut screen = Screen::open()?;
    terminal::on_signals(&sender);
    let mut app = App::new(options.colour, now_ms());
    // Before the keyboard is read: the terminal's answer comes the same way.
    app.world.picker = picker(options.colour);
    listen(sender.clone());
    let mut hands = Hands {
        children: Children::new(&options.program, sender.clone()),
        loader: Loader::start(options.records.clone(), sender.clone()),
        rows: reader(sender),
    };
    if options.fault == Some(Fault::Thread) {
        thread::spawn(|| deliberate_panic("a thread"));
    }
    let mut view = |app: &App| {
        screen.draw(|area, buf| {
            app.view(area, buf);
            if options.fault == Some(Fault::View) {
                deliberate_panic("the view");
            }
        })
    };
    let ended = go(&mut app, &mut hands, &receiver, &mut view);
    // Children may need a moment to write their last row; that they do is seen.
    app.world.leaving = true;
    let _ = view(&app);
    hands.children.stop_all();
    drop(screen);
    ended
}

/// The loop.
fn go(
    app: &mut App,
    hands: &mut Hands,
    receiver: &Receiver<Msg>,
    view: &mut dyn FnMut(&App) -> std::io::Result<()>,
) -> Result<(), TuiError> {
    let mut effects = app.start();
    let mut drawn: Option<Instant> = None;
    let mut ticked = Instant::now();
    loop {
        // What an effect answers at once comes before what waits in the channel.
        while let Some(effect) = effects.pop() {
            if effect == Effect::Quit {
                return Ok(());
            }
            if let Some(answer) = hands.carry_out(effect, app) {
                effects.extend(app.update(answer).into_iter().rev());
            }
        }
        view(app)?;
        let last = *drawn.insert(Instant::now());
        let tick = if app.world.jobs.active() { TICK_BUSY } else { TICK_IDLE };
        // All that comes in until the next picture is due is taken in before it.
        let (mut taken, mut key) = (0, false);
        while taken < WAITING && !effects.contains(&Effect::Quit) {
            let left = match taken {
                0 => tick.saturating_sub(ticked.elapsed()),
                _ if key => Duration::ZERO,
                _ => FRAME.saturating_sub(last.elapsed()),
            };
            match receiver.recv_timeout(left) {
                Ok(msg) => {
                    key |= matches!(msg, Msg::Key(_) | Msg::Resize | Msg::Terminate);
                    effects.extend(app.update(msg));
                    taken += 1;
                }
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
        if ticked.elapsed() >= tick {
            ticked = Instant::now();
            effects.extend(app.update(Msg::Tick(now_ms())));
        }
        effects.reverse();
    }
}

/// How this terminal shows pictures. It is asked, and given a moment to answer; terminals known
/// not to answer, and ones that pictures are drawn in characters for, are not asked.
fn picker(colour: bool) -> Picker {
    let mute = std::env::var("TERM").is_ok_and(|term| term == "dumb" || term == "linux");
    if !colour || mute {
        return Picker::halfblocks();
    }
    let options = QueryStdioOptions { timeout: ANSWER, ..QueryStdioOptions::default() };
    let picker = Picker::from_query_stdio_with_options(options);
    let picker = picker.unwrap_or_else(|_| Picker::halfblocks());
    // Silence is not an error but a terminal without abilities.
    if picker.capabilities().is_empty() {
        // Whoever waits for the answer would take the first key for it. A question that also
        // terminals inside terminals answer themselves ends that wait.
        let mut out = std::io::stdout();
        let _ = out.write_all(b"\x1b[5n").and_then(|()| out.flush());
        thread::sleep(ANSWER / 5);
    }
    picker
}

/// The keyboard and the terminal's size.
fn listen(sender: SyncSender<Msg>) {
    thread::spawn(move || {
        loop {
            let msg = match event::read() {
                Ok(Event::Key(key)) => Msg::Key(key),
                Ok(Event::Resize(..)) => Msg::Resize,
                Ok(_) => continue,
                // No keyboard any more: nobody could ever leave.
                Err(_) => Msg::Terminate,
            };
            let over = matches!(msg, Msg::Terminate);
            if sender.send(msg).is_err() || over {
                break;
            }
        }
    });
}

/// A request for whole rows.
type Request = (u64, Arc<crate::store::Store>, Vec<usize>);

/// The thread that reads whole rows.
fn reader(sender: SyncSender<Msg>) -> mpsc::Sender<Request> {
    let (ask, asked) = mpsc::channel::<Request>();
    thread::spawn(move || {
        for (request, store, entries) in asked {
            let rows = entries
                .iter()
                .filter_map(|&i| store.index.entries.get(i))
                .map(|e| store.index.row(e).map_err(|e| e.to_string()))
                .collect();
            if sender.send(Msg::Rows { request, rows }).is_err() {
                break;
            }
        }
    });
    ask
}

struct Hands {
    children: Children,
    loader: Loader,
    rows: mpsc::Sender<Request>,
}

impl Hands {
    fn carry_out(&mut self, effect: Effect, app: &App) -> Option<Msg> {
        match effect {
            // The loop's own.
            Effect::Quit => {}
            Effect::Reload => self.loader.ask(),
            Effect::ReadRows { request, entries } => {
                let lost =
                    self.rows.send((request, Arc::clone(&app.world.store), entries)).is_err();
                let rows = Err("the reader is gone".into());
                return lost.then_some(Msg::Rows { request, rows });
            }
            Effect::Start { job, arguments, input } => {
                return self.children.start(job, &arguments, input);
            }
            Effect::Write { job, line } => self.children.write(job, line),
            Effect::Stop(job) => self.children.stop(job),
        }
        None
    }
}

#[expect(clippy::panic, reason = "asked for, to test that the terminal is restored")]
fn deliberate_panic(of: &str) {
    panic!("a deliberate panic of {of}");
}
