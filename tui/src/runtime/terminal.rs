//! The terminal: taken, drawn on, and given back whatever happens.

use crate::msg::Msg;
use ratatui::{
    DefaultTerminal,
    buffer::Buffer,
    crossterm::{cursor::Show, execute},
    layout::Rect,
};
use std::{io, panic, process, sync::mpsc::SyncSender, thread, time::Duration};

/// Exit code of a panic, as the standard library has it.
const PANICKED: i32 = 101;
/// Exit code of a program that a signal ended.
const SIGNALLED: i32 = 143;
/// How long an orderly end may take before it is cut short: a terminal that takes no more output
/// blocks whoever draws.
const ORDERLY: Duration = Duration::from_secs(8);

/// The terminal in raw mode on its alternate screen, given back when dropped.
pub struct Screen(DefaultTerminal);

impl Screen {
    /// Takes the terminal.
    ///
    /// # Errors
    /// Those of the terminal.
    pub fn open() -> io::Result<Self> {
        let terminal = ratatui::try_init()?;
        let before = panic::take_hook();
        let main = thread::current().id();
        panic::set_hook(Box::new(move |info| {
            // Ratatui's hook: restores the terminal, then the message.
            before(info);
            let _ = execute!(io::stdout(), Show);
            // The main thread unwinds, which ends its children; a panic elsewhere would leave a
            // dashboard drawing on a terminal that was given back.
            if thread::current().id() != main {
                process::exit(PANICKED);
            }
        }));
        Ok(Self(terminal))
    }

    /// Draws a picture; only what changed is sent.
    ///
    /// # Errors
    /// Those of the terminal.
    pub fn draw(&mut self, view: impl FnOnce(Rect, &mut Buffer)) -> io::Result<()> {
        self.0.draw(|frame| view(frame.area(), frame.buffer_mut())).map(|_| ())
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.0.show_cursor();
        ratatui::restore();
    }
}

/// On SIGTERM, SIGHUP and SIGINT the dashboard leaves in order; if that takes too long, out of
/// order.
pub fn on_signals(sender: &SyncSender<Msg>) {
    let sender = sender.clone();
    let mut asked = false;
    // Where no handler can be set the signal ends the program, and the children with it.
    let _ = ctrlc::set_handler(move || {
        let _ = sender.try_send(Msg::Terminate);
        if asked {
            return;
        }
        asked = true;
        let sender = sender.clone();
        thread::spawn(move || {
            // A full channel is read within moments, if at all.
            let _ = sender.send(Msg::Terminate);
        });
        thread::spawn(|| {
            thread::sleep(ORDERLY);
            ratatui::restore();
            process::exit(SIGNALLED);
        });
    });
}
