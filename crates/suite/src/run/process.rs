//! Child processes: started, followed by what they say, ended whatever happens.

use super::{Options, protocol::Event};
use crate::SuiteError;
use serde::de::DeserializeOwned;
use std::{
    io::{self, BufRead, BufReader, Read, Write},
    process::{Child, Command, Stdio},
    sync::{
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError, TryRecvError},
    },
    thread,
    time::{Duration, Instant},
};

/// What a start may take where only stages are limited: it opens a graphics device.
const START_LIMIT: Duration = Duration::from_secs(120);

/// How long a child may take.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Limit {
    /// From its start to its end.
    Whole(Duration),
    /// From the beginning of each stage to the next.
    Stage(Duration),
}

/// The stage that a child said it began last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Begun {
    /// Position of the setting; beyond them all while it works for all of them.
    pub setting: usize,
    /// The stage's name.
    pub stage: String,
    /// Where on an axis.
    pub value: Option<f64>,
}

/// How a child ended.
pub(crate) enum Ended {
    Done,
    Stopped,
    /// Nothing of the job can be done: it said so before it began a setting.
    Failed {
        reason: String,
        code: u8,
    },
    /// Something ended it at work, or before it began anything.
    Died {
        begun: Option<Begun>,
        reason: String,
    },
}

impl Limit {
    /// What to say once the limit is over.
    fn over(self, start: Instant, begun: Option<Instant>) -> Option<String> {
        match self {
            Self::Whole(limit) if start.elapsed() > limit => {
                let (all, this) = (limit.as_secs(), begun.unwrap_or(start).elapsed());
                let this = this.as_secs_f64();
                Some(format!("no end after {all} s, the last {this:.1} s of them in this"))
            }
            Self::Stage(limit) => {
                let limit = if begun.is_none() { limit.max(START_LIMIT) } else { limit };
                let over = begun.unwrap_or(start).elapsed() > limit;
                over.then(|| format!("no end after {} s", limit.as_secs()))
            }
            Self::Whole(_) => None,
        }
    }
}

/// Runs the program of `options` on a job, one line of JSON, and hands on what it says.
/// `settings` is the number of settings that the job has.
///
/// # Errors
/// A child that cannot be started, an event that cannot be read, or those of `seen`.
pub(crate) fn run_child(
    job: &str,
    settings: usize,
    options: &Options,
    limit: Limit,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(Event) -> Result<(), SuiteError>,
) -> Result<Ended, SuiteError> {
    let mut command = Command::new(&options.program);
    // A group of its own: an interrupt from the terminal ends the child through its runner alone,
    // and is never taken for a crash of what was at work.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command
        .args(&options.arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(SuiteError::io(format!("starting {}", options.program.display())))?;
    let ended = follow(&mut child, job, settings, limit, stop, seen);
    // Whatever happened, no child outlives its group.
    let _ = child.kill();
    let _ = child.wait();
    ended
}

fn follow(
    child: &mut Child,
    job: &str,
    settings: usize,
    limit: Limit,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(Event) -> Result<(), SuiteError>,
) -> Result<Ended, SuiteError> {
    // The input stays open, in `child`: its end tells the child that the runner is gone.
    let (Some(stdin), Some(stdout), Some(mut stderr)) =
        (child.stdin.as_mut(), child.stdout.take(), child.stderr.take())
    else {
        return Err(SuiteError::Internal("a child's pipes are missing".into()));
    };
    // A child that died before reading shows as the end of its output below.
    let _ = writeln!(stdin, "{job}");
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        // Bytes, not text: a driver may print anything on standard output.
        for line in BufReader::new(stdout).split(b'\n').map_while(Result::ok) {
            if sender.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                break;
            }
        }
    });
    let said = thread::spawn(move || {
        let mut text = Vec::new();
        let _ = stderr.read_to_end(&mut text);
        String::from_utf8_lossy(&text).trim().to_string()
    });
    let start = Instant::now();
    let (mut begun, mut since): (Option<Begun>, _) = (None, None);
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(Ended::Stopped);
        }
        // What was said in time counts, however late it is read.
        let heard = match receiver.try_recv() {
            Err(TryRecvError::Empty) => match limit.over(start, since) {
                Some(reason) => return Ok(Ended::Died { begun, reason }),
                None => receiver.recv_timeout(Duration::from_millis(100)),
            },
            heard => heard.map_err(|_| RecvTimeoutError::Disconnected),
        };
        let event = match heard {
            Ok(line) => Event::from_line(&line)?,
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                let status = child.wait().map_err(SuiteError::io("waiting for a child"))?;
                let words = last_words(&said.join().unwrap_or_default());
                let reason = format!("the process ended early ({status}) {words}");
                return Ok(Ended::Died { begun, reason: reason.trim().into() });
            }
        };
        match event {
            None => {}
            Some(Event::Done) => return Ok(Ended::Done),
            // At work on a setting, e.g. a device that it lost: the case is not to blame.
            Some(Event::Failed { reason, .. })
                if begun.as_ref().is_some_and(|b| b.setting < settings) =>
            {
                return Ok(Ended::Died { begun, reason });
            }
            Some(Event::Failed { reason, code }) => return Ok(Ended::Failed { reason, code }),
            Some(event) => {
                if let Event::Begin { setting, stage, value } = &event {
                    let (setting, stage) = (*setting, stage.clone());
                    begun = Some(Begun { setting, stage, value: *value });
                    since = Some(Instant::now());
                }
                seen(event)?;
            }
        }
    }
}

/// What a dead process said of its death: its panic, else its last line.
fn last_words(stderr: &str) -> String {
    let mut lines = stderr.lines().filter(|l| !l.trim().is_empty() && !l.starts_with("note:"));
    match stderr.find("panicked at") {
        Some(at) => stderr[at..].lines().take(2).collect::<Vec<_>>().join(" "),
        None => lines.next_back().unwrap_or_default().into(),
    }
}

/// The child's side: reads a job, one line of `input`, and writes the events of `work` to `output`.
/// The runner keeps `input` open for as long as it lives.
///
/// # Errors
/// [`SuiteError::Usage`] for a job that cannot be read.
pub(crate) fn serve<Job: DeserializeOwned>(
    input: impl Read + Send + 'static,
    output: &mut dyn Write,
    work: impl FnOnce(&Job, &mut dyn FnMut(Event)),
) -> Result<(), SuiteError> {
    let mut input = BufReader::new(input);
    let mut text = String::new();
    input.read_line(&mut text).map_err(SuiteError::io("reading the job"))?;
    let job: Job =
        serde_json::from_str(&text).map_err(|e| SuiteError::Usage(format!("job: {e}")))?;
    thread::spawn(move || {
        let _ = io::copy(&mut input, &mut io::sink());
        // Even a killed runner closes its end. An orphan would disturb the run that resumes; and
        // nothing a driver does at an orderly exit may keep it.
        std::process::abort();
    });
    work(&job, &mut |event| {
        let line = format!("{}\n", event.to_line());
        if output.write_all(line.as_bytes()).and_then(|()| output.flush()).is_err() {
            // The runner is gone: nobody would read what follows.
            std::process::exit(3);
        }
    });
    Ok(())
}

/// A job as the one line that [`serve`] reads.
///
/// # Errors
/// [`SuiteError::Internal`] for a job that JSON cannot hold.
pub(crate) fn line(job: &impl serde::Serialize) -> Result<String, SuiteError> {
    serde_json::to_string(job).map_err(|e| SuiteError::Internal(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_words_are_the_panic_and_not_the_note_behind_it() {
        let panic = "warming up\nthread 'main' panicked at a.rs:1:2:\nindex out of bounds\n\
                     note: run with `RUST_BACKTRACE=1`";
        assert_eq!(last_words(panic), "panicked at a.rs:1:2: index out of bounds");
        assert_eq!(last_words("one\ntwo\n\nnote: three"), "two");
        assert_eq!(last_words(""), "");
    }

    #[test]
    fn a_start_is_not_held_to_the_limit_of_a_stage() {
        let second = Duration::from_secs(1);
        let now = Instant::now();
        let Some(past) = now.checked_sub(10 * second) else { return };
        assert_eq!(Limit::Stage(second).over(past, None), None);
        assert_eq!(Limit::Stage(second).over(past, Some(now)), None);
        assert_eq!(Limit::Stage(second).over(past, Some(past)), Some("no end after 1 s".into()));
        assert_eq!(Limit::Whole(60 * second).over(past, Some(past)), None);
        let said = Limit::Whole(second).over(past, Some(now)).unwrap();
        assert!(said.starts_with("no end after 1 s, the last 0.0 s"), "{said}");
    }
}
