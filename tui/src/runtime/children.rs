//! Child processes: started, heard, written to and ended without ever waiting for one.

use super::lines;
use crate::msg::{JobId, Msg};
use dapple_records::FeedLine;
use std::{
    collections::{BTreeMap, VecDeque},
    io::{BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, ExitStatus, Stdio},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc::SyncSender},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

/// From the interrupt to the kill: what is at work may be written down.
pub const GRACE: Duration = Duration::from_secs(3);
/// Between two looks at a child.
const LOOK: Duration = Duration::from_millis(20);
/// How long a child's last words are waited for once it is gone.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// Lines kept for a child that does not read; the oldest go, as the newest request counts.
const UNREAD: usize = 64;

/// All children that live.
pub struct Children {
    program: PathBuf,
    sender: SyncSender<Msg>,
    running: BTreeMap<JobId, Arc<Running>>,
}

/// One child, shared by the threads that serve it.
struct Running {
    child: Mutex<Child>,
    input: Input,
    /// When it was asked to end.
    asked: Mutex<Option<Instant>>,
}

/// Lines on their way to a child.
#[derive(Default)]
struct Input {
    lines: Mutex<(VecDeque<String>, bool)>,
    changed: Condvar,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Children {
    /// None yet.
    pub fn new(program: &Path, sender: SyncSender<Msg>) -> Self {
        Self { program: program.into(), sender, running: BTreeMap::new() }
    }

    /// Starts one. What it says comes as messages; if it cannot be started, that message is
    /// returned.
    pub fn start(&mut self, job: JobId, arguments: &[String], input: bool) -> Option<Msg> {
        self.running.retain(|_, running| running.lives());
        let mut command = Command::new(&self.program);
        command
            .args(arguments)
            .stdin(if input { Stdio::piped() } else { Stdio::null() })
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        apart(&mut command);
        let mut child = match command.spawn() {
            Ok(child) => child,
            Err(error) => {
                let how = format!("could not be started: {error}");
                return Some(Msg::Ended { job, code: None, how });
            }
        };
        let stdin = child.stdin.take();
        let mut readers = Vec::new();
        if let Some(stdout) = child.stdout.take() {
            readers.push(self.read(stdout, move |text| heard(job, text)));
        }
        if let Some(stderr) = child.stderr.take() {
            readers.push(self.read(stderr, move |text| Msg::Grumbled { job, text }));
        }
        let running = Arc::new(Running {
            child: Mutex::new(child),
            input: Input::default(),
            asked: Mutex::new(None),
        });
        if let Some(stdin) = stdin {
            let running = Arc::clone(&running);
            thread::spawn(move || running.input.carry(stdin));
        }
        let (of, sender) = (Arc::clone(&running), self.sender.clone());
        thread::spawn(move || {
            let ended = of.watch(job, &readers);
            of.input.close();
            let _ = sender.send(ended);
        });
        self.running.insert(job, running);
        None
    }

    fn read(
        &self,
        source: impl Read + Send + 'static,
        message: impl Fn(String) -> Msg + Send + 'static,
    ) -> JoinHandle<()> {
        let sender = self.sender.clone();
        thread::spawn(move || {
            // The channel is bounded: a child that talks faster than is drawn has to wait.
            lines::each(BufReader::new(source), |line| sender.send(message(line)).is_ok());
        })
    }

    /// Hands a line to a child's writer; a child that is gone tells so on its own.
    pub fn write(&self, job: JobId, line: String) {
        if let Some(running) = self.running.get(&job) {
            running.input.push(line);
        }
    }

    /// Asks a child to end: its input is closed and it is interrupted. Asked again, or once the
    /// time of grace is over, it is killed.
    pub fn stop(&self, job: JobId) {
        if let Some(running) = self.running.get(&job) {
            running.stop();
        }
    }

    /// Ends all and waits until they are gone, at most a little longer than the time of grace.
    pub fn stop_all(&mut self) {
        self.running.values().for_each(|running| running.stop());
        let start = Instant::now();
        while self.running.values().any(|running| running.lives()) {
            if start.elapsed() > GRACE {
                self.running.values().for_each(|running| running.kill());
            }
            if start.elapsed() > GRACE + LAST_WORDS {
                break;
            }
            thread::sleep(LOOK);
        }
        self.running.clear();
    }
}

impl Drop for Children {
    /// A panic of the interface must not leave them behind either.
    fn drop(&mut self) {
        self.running.values().for_each(|running| running.kill());
    }
}

impl Running {
    fn lives(&self) -> bool {
        matches!(lock(&self.child).try_wait(), Ok(None))
    }

    fn stop(&self) {
        self.input.close();
        let asked = lock(&self.asked).replace(Instant::now());
        match asked {
            None => interrupt(&mut lock(&self.child)),
            Some(_) => self.kill(),
        }
    }

    fn kill(&self) {
        // One that is gone cannot be killed, which is as well.
        let _ = lock(&self.child).kill();
    }

    /// Waits for the end without holding the lock, and kills what stays beyond its time of grace.
    fn watch(&self, job: JobId, readers: &[JoinHandle<()>]) -> Msg {
        let status = loop {
            match lock(&self.child).try_wait() {
                Ok(Some(status)) => break Ok(status),
                Err(error) => break Err(error),
                Ok(None) => {}
            }
            if lock(&self.asked).is_some_and(|at| at.elapsed() > GRACE) {
                self.kill();
            }
            thread::sleep(LOOK);
        };
        // A grandchild may hold the pipes open; what was said comes before the end all the same.
        let gone = Instant::now();
        while readers.iter().any(|r| !r.is_finished()) && gone.elapsed() < LAST_WORDS {
            thread::sleep(LOOK / 4);
        }
        let asked = lock(&self.asked).is_some();
        let (code, how) = match status {
            Ok(status) => (status.code(), in_words(status, asked)),
            Err(error) => (None, error.to_string()),
        };
        Msg::Ended { job, code, how }
    }
}

impl Input {
    fn push(&self, line: String) {
        let mut lines = lock(&self.lines);
        if lines.0.len() == UNREAD {
            lines.0.pop_front();
        }
        lines.0.push_back(line);
        self.changed.notify_one();
    }

    fn close(&self) {
        lock(&self.lines).1 = true;
        self.changed.notify_one();
    }

    /// Writes line by line until the child or this end is gone.
    fn carry(&self, mut stdin: ChildStdin) {
        loop {
            let mut lines = lock(&self.lines);
            while lines.0.is_empty() && !lines.1 {
                lines = self.changed.wait(lines).unwrap_or_else(PoisonError::into_inner);
            }
            // Once closed, what is still unread is of no use to anyone.
            let Some(line) = lines.0.pop_front().filter(|_| !lines.1) else { return };
            drop(lines);
            if writeln!(stdin, "{line}").and_then(|()| stdin.flush()).is_err() {
                return;
            }
        }
    }
}

/// A line of a child's standard output. What is neither event nor record belongs into its log: a
/// table for people, or what a driver printed.
fn heard(job: JobId, text: String) -> Msg {
    match FeedLine::parse(&text) {
        Ok(Some(line)) => Msg::Heard { job, line: Box::new(line) },
        Ok(None) => Msg::Grumbled { job, text },
        Err(error) => Msg::Grumbled { job, text: error.to_string() },
    }
}

fn in_words(status: ExitStatus, asked: bool) -> String {
    match status.code() {
        Some(0) => "done".into(),
        Some(1) => "done; a check failed (exit code 1)".into(),
        Some(2) => "refused its arguments or input (exit code 2)".into(),
        Some(3) => "the environment refused (exit code 3)".into(),
        Some(code) => format!("exit code {code}"),
        None if asked => "cancelled".into(),
        None => format!("killed: {status}"),
    }
}

/// Sends an interrupt, upon which a runner finishes what it writes and ends.
#[cfg(unix)]
fn interrupt(child: &mut Child) {
    // Not reaped yet, as the lock on it is held: the number is still its own.
    if matches!(child.try_wait(), Ok(None))
        && let Ok(pid) = i32::try_from(child.id())
    {
        // SAFETY: a signal to a process of ours.
        unsafe { libc::kill(pid, libc::SIGINT) };
    }
}

#[cfg(not(unix))]
fn interrupt(child: &mut Child) {
    let _ = child.kill();
}

/// In a group of its own, so that an interrupt from the terminal reaches it through us alone; and
/// on Linux ended when this program is killed.
fn apart(command: &mut Command) {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    #[cfg(target_os = "linux")]
    // SAFETY: between fork and exec only this one system call is made.
    unsafe {
        std::os::unix::process::CommandExt::pre_exec(command, || {
            libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGINT);
            Ok(())
        });
    }
}
