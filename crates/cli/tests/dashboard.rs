//! The dashboard in a pseudo-terminal: it walks, bends, leaves nothing behind.
#![cfg(unix)]

use std::{
    fs::File,
    io::{Read, Write},
    os::{
        fd::{AsRawFd, FromRawFd, OwnedFd},
        unix::process::CommandExt,
    },
    path::Path,
    process::{Child, Command, ExitStatus},
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

/// A loaded machine may take long.
const PATIENCE: Duration = Duration::from_secs(60);
const TITLES: [&str; 8] =
    ["Overview", "Front", "Technique", "Live", "Stress", "Claims", "Compare", "Runs"];
const LEFT_ALTERNATE_SCREEN: &str = "\x1b[?1049l";

/// The program on a terminal of its own.
struct Terminal {
    child: Child,
    master: File,
    /// Held, so that the terminal's modes can still be asked for once the program is gone.
    slave: OwnedFd,
    said: Arc<Mutex<Vec<u8>>>,
}

fn size(columns: u16, rows: u16) -> libc::winsize {
    libc::winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 }
}

impl Terminal {
    fn open(folder: &Path, fault: &str) -> Self {
        let (mut master, mut slave) = (0, 0);
        let eighty = size(80, 24);
        // SAFETY: the pointers are to locals; name and modes are not asked for.
        let opened = unsafe {
            libc::openpty(
                &mut master,
                &mut slave,
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                &eighty,
            )
        };
        assert_eq!(opened, 0, "a pseudo-terminal");
        // SAFETY: both were just opened and belong to nobody else. The master must not be
        // inherited: it would keep the terminal open.
        let (master, slave) = unsafe {
            libc::fcntl(master, libc::F_SETFD, libc::FD_CLOEXEC);
            (File::from_raw_fd(master), OwnedFd::from_raw_fd(slave))
        };
        let end = || slave.try_clone().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_dapple"));
        command
            .current_dir(folder)
            // A terminal that is not asked how it shows pictures: this one could not answer.
            .env("TERM", "linux")
            .env("DAPPLE_CACHE", "off")
            .env("DAPPLE_DASHBOARD_FAULT", fault)
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .env_remove("DAPPLE_REQUIRE_GPU")
            .stdin(end())
            .stdout(end())
            .stderr(end());
        // SAFETY: system calls only, between fork and exec.
        unsafe {
            command.pre_exec(|| {
                libc::setsid();
                libc::ioctl(0, libc::TIOCSCTTY as _, 0);
                Ok(())
            });
        }
        let child = command.spawn().unwrap();
        let said = Arc::new(Mutex::new(Vec::new()));
        let (mut from, into) = (master.try_clone().unwrap(), Arc::clone(&said));
        thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count) = from.read(&mut bytes) {
                into.lock().unwrap().extend(&bytes[..count]);
                if count == 0 {
                    break;
                }
            }
        });
        Self { child, master, slave, said }
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.said.lock().unwrap()).into_owned()
    }

    fn press(&mut self, keys: &str) -> usize {
        let before = self.said.lock().unwrap().len();
        self.master.write_all(keys.as_bytes()).unwrap();
        before
    }

    /// Waits until something is said behind position `from`.
    #[track_caller]
    fn wait_for(&self, from: usize, what: &str) {
        let start = Instant::now();
        loop {
            let bytes = self.said.lock().unwrap()[from..].to_vec();
            if String::from_utf8_lossy(&bytes).contains(what) {
                return;
            }
            assert!(start.elapsed() < PATIENCE, "no {what:?} in {:?}", self.text());
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn resize(&self, columns: u16, rows: u16) -> usize {
        let before = self.said.lock().unwrap().len();
        let new = size(columns, rows);
        // SAFETY: a terminal of ours and a local.
        let set = unsafe { libc::ioctl(self.master.as_raw_fd(), libc::TIOCSWINSZ as _, &new) };
        assert_eq!(set, 0);
        before
    }

    #[track_caller]
    fn ended(&mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                // What it said last may still be on its way.
                thread::sleep(Duration::from_millis(200));
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "it did not leave: {:?}", self.text());
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Whether lines are edited and echoed again, as before.
    fn is_cooked(&self) -> bool {
        // SAFETY: plain data, filled by the call.
        let mut modes: libc::termios = unsafe { std::mem::zeroed() };
        // SAFETY: an open terminal and a local.
        assert_eq!(unsafe { libc::tcgetattr(self.slave.as_raw_fd(), &mut modes) }, 0);
        let both = libc::ICANON | libc::ECHO;
        modes.c_lflag & both == both
    }

    #[track_caller]
    fn assert_given_back(&self) {
        let text = self.text();
        assert!(text.contains(LEFT_ALTERNATE_SCREEN), "{text:?}");
        assert!(text.contains("\x1b[?25h"), "the cursor is shown: {text:?}");
        assert!(self.is_cooked(), "raw mode is off");
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn it_walks_all_screens_bends_and_gives_the_terminal_back() {
    let at = tempfile::tempdir().unwrap();
    let mut terminal = Terminal::open(at.path(), "");
    terminal.wait_for(0, "[1Overview]");
    // The control for what is checked at the end.
    assert!(!terminal.is_cooked() && !terminal.text().contains(LEFT_ALTERNATE_SCREEN));
    for (i, title) in TITLES.iter().enumerate().skip(1) {
        let before = terminal.press(&(i + 1).to_string());
        terminal.wait_for(before, &format!("[{}{title}]", i + 1));
    }
    let before = terminal.resize(20, 5);
    terminal.wait_for(before, "q quit");
    for i in 0..TITLES.len() {
        terminal.press(&(i + 1).to_string());
    }
    let before = terminal.resize(80, 24);
    terminal.wait_for(before, "[8Runs]");
    terminal.press("q");
    assert_eq!(terminal.ended().code(), Some(0), "{:?}", terminal.text());
    terminal.assert_given_back();
}

#[test]
fn a_panic_gives_the_terminal_back_wherever_it_happens() {
    for fault in ["view", "thread"] {
        let at = tempfile::tempdir().unwrap();
        let mut terminal = Terminal::open(at.path(), fault);
        assert_eq!(terminal.ended().code(), Some(101), "{fault}: {:?}", terminal.text());
        terminal.assert_given_back();
        let text = terminal.text();
        let left = text.find(LEFT_ALTERNATE_SCREEN).unwrap();
        assert!(text[left..].contains("a deliberate panic"), "{fault}: {text:?}");
    }
}

/// Processes whose parent is `parent`, and theirs.
#[cfg(target_os = "linux")]
fn descendants(parent: u32) -> Vec<u32> {
    let mut all: Vec<(u32, u32)> = Vec::new();
    for entry in std::fs::read_dir("/proc").unwrap().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<u32>() else { continue };
        let stat = std::fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
        // Behind the name in brackets: state, parent.
        let Some((_, rest)) = stat.rsplit_once(") ") else { continue };
        let mut rest = rest.split(' ');
        let dead = rest.next() == Some("Z");
        if let Some(of) = rest.next().and_then(|p| p.parse().ok()).filter(|_| !dead) {
            all.push((pid, of));
        }
    }
    let mut found = vec![parent];
    let mut next = 0;
    while let Some(&of) = found.get(next) {
        found.extend(all.iter().filter(|p| p.1 == of).map(|p| p.0));
        next += 1;
    }
    found.split_off(1)
}

#[cfg(target_os = "linux")]
#[test]
fn no_job_outlives_a_dashboard_that_is_terminated_or_killed() {
    for signal in [libc::SIGTERM, libc::SIGHUP, libc::SIGKILL] {
        let at = tempfile::tempdir().unwrap();
        let mut terminal = Terminal::open(at.path(), "");
        let before = terminal.press("8");
        terminal.wait_for(before, "[8Runs]");
        // The catalogue must be there: the form lists its sweeps.
        let before = terminal.press("n");
        terminal.wait_for(before, "sweep");
        thread::sleep(Duration::from_secs(1));
        terminal.press("\x1b");
        thread::sleep(Duration::from_millis(300));
        terminal.press("n");
        let before = terminal.press("\r");
        terminal.wait_for(before, "running");
        let start = Instant::now();
        let family = loop {
            let family = descendants(terminal.child.id());
            // The job and the process that it measures in.
            if family.len() >= 2 {
                break family;
            }
            assert!(start.elapsed() < PATIENCE, "no job in {:?}", terminal.text());
            thread::sleep(Duration::from_millis(20));
        };
        // SAFETY: a signal to a child of ours that was not waited for.
        unsafe { libc::kill(terminal.child.id() as i32, signal) };
        terminal.ended();
        let start = Instant::now();
        let lives = |pid: &u32| {
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            !stat.is_empty() && !stat.contains(") Z ")
        };
        while family.iter().any(lives) {
            assert!(start.elapsed() < PATIENCE, "signal {signal}: {family:?} live on");
            thread::sleep(Duration::from_millis(50));
        }
        if signal != libc::SIGKILL {
            terminal.assert_given_back();
        }
    }
}
