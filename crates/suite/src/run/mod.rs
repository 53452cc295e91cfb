//! The runner: one child process a group, every finished row on disk at once.
//!
//! A crash, a hang or a lost device becomes a row for the setting that was at work; the group
//! runs again without it. A run that was killed resumes where it stopped.

pub mod child;
pub mod protocol;

use crate::{SuiteError, environment::environment, plan::Plan};
use dapple_records::{Row, RunHeader, Status, Writer};
use protocol::{Event, Fault, Job};
use std::{
    collections::BTreeSet,
    io::{BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    thread,
    time::{Duration, Instant},
};

/// How a run is carried out.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where records go.
    pub records: PathBuf,
    /// Part of an adapter's name.
    pub adapter: Option<String>,
    /// The command line, for the record.
    pub command: String,
    /// The program to start for each group, with the arguments that make it read a [`Job`].
    pub program: PathBuf,
    /// See `program`.
    pub arguments: Vec<String>,
    /// Start anew even where an unfinished run of the same plan lies.
    pub fresh: bool,
    /// A deliberate fault, for tests.
    pub fault: Option<Fault>,
}

/// What a run tells while it goes on.
pub enum Progress<'a> {
    /// Where the records are, how many rows are planned, how many were there already.
    Started {
        /// The record file.
        path: &'a Path,
        /// Rows planned.
        total: usize,
        /// Rows found of an earlier, unfinished run.
        resumed: usize,
    },
    /// A group begins.
    Group(&'a str),
    /// A setting begins a stage.
    Stage {
        /// The setting.
        setting: &'a str,
        /// `check` or `time`.
        stage: &'a str,
    },
    /// Something the user should know.
    Note(&'a str),
    /// A row is on disk.
    Row(&'a Row),
}

/// What a finished run left.
#[derive(Debug)]
pub struct Finished {
    /// The record file.
    pub path: PathBuf,
    /// Id of the run.
    pub run: String,
    /// Cases that could not be prepared: reason and exit code.
    pub failed_groups: Vec<(String, u8)>,
}

/// Runs a plan. `stop` ends it early, after which the same command resumes.
///
/// # Errors
/// Records that cannot be written, a child that cannot be started, [`SuiteError::Interrupted`].
pub fn run(
    plan: &Plan,
    options: &Options,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Progress<'_>),
) -> Result<Finished, SuiteError> {
    let facts = environment();
    // A resumed run must be the same work by the same program on the same adapter.
    let key =
        format!("{}{:?}{}{}", plan.hash(), options.adapter, facts.revision, facts.shader_hash);
    let key = blake3::hash(key.as_bytes()).to_hex()[..16].to_string();
    let (mut writer, run, mut done) = open_records(plan, options, &key)?;
    let total = plan.rows();
    tell(Progress::Started { path: writer.path(), total, resumed: done.len() });
    let mut failed_groups = Vec::new();
    for (index, group) in plan.groups.iter().enumerate() {
        let mut job = Job {
            run: run.clone(),
            index,
            group: group.clone(),
            todo: Vec::new(),
            banned: Vec::new(),
            repeats: plan.repeats,
            adapter: options.adapter.clone(),
            fault: options.fault.clone(),
        };
        tell(Progress::Group(&group.title()));
        loop {
            let first = usize::from(group.repeated_baseline);
            job.todo = (first..group.settings.len())
                .filter(|i| !done.contains(&Job::key(index, *i)))
                .collect();
            if job.todo.is_empty() {
                break;
            }
            let limit = Duration::from_secs(plan.limit_s);
            let ended = run_child(&job, options, limit, stop, &mut |event| {
                match event {
                    Event::Row(row) => {
                        writer.append(&row)?;
                        done.insert(row.group.clone());
                        tell(Progress::Row(&row));
                    }
                    Event::Note(text) => tell(Progress::Note(&text)),
                    Event::Begin { setting, stage } => {
                        let setting = group.settings.get(setting).map(ToString::to_string);
                        tell(Progress::Stage {
                            setting: setting.as_deref().unwrap_or_default(),
                            stage: &stage,
                        });
                    }
                    Event::Failed { .. } | Event::Done => {}
                }
                Ok(())
            })?;
            match ended {
                Ended::Done => break,
                Ended::Stopped => {
                    let path = writer.path().to_path_buf();
                    return Err(SuiteError::Interrupted { done: done.len(), total, path });
                }
                // The case itself is at fault: every setting of it gets the reason.
                Ended::Failed { reason, code } => {
                    for setting in job.todo.clone() {
                        let row = failure(&job, setting, "prepare", &reason);
                        writer.append(&row)?;
                        done.insert(row.group.clone());
                        tell(Progress::Row(&row));
                    }
                    failed_groups.push((format!("{}: {reason}", group.title()), code));
                }
                Ended::Died { setting, stage, reason } => {
                    // Before any setting began, or again at a banned baseline: the first unfinished
                    // one takes the blame, so that every turn of this loop ends one setting.
                    let culprit = setting
                        .filter(|s| *s < group.settings.len() && !job.banned.contains(s))
                        .unwrap_or(job.todo[0]);
                    job.banned.push(culprit);
                    if job.todo.contains(&culprit) {
                        let row = failure(&job, culprit, &stage, &reason);
                        writer.append(&row)?;
                        done.insert(row.group.clone());
                        tell(Progress::Row(&row));
                    }
                }
            }
        }
    }
    writer.end()?;
    Ok(Finished { path: writer.path().to_path_buf(), run, failed_groups })
}

type Opened = (Writer, String, BTreeSet<String>);

fn open_records(plan: &Plan, options: &Options, key: &str) -> Result<Opened, SuiteError> {
    let facts = environment();
    if !options.fresh
        && let Some(path) = dapple_records::unfinished(&options.records, key, &facts.machine)
    {
        let read = dapple_records::read_file(&path)?;
        if let Some(header) = read.headers.first() {
            let done = read.rows.iter().map(|row| row.group.clone()).collect();
            return Ok((Writer::resume(&path)?, header.run.clone(), done));
        }
    }
    let header = RunHeader {
        run: dapple_records::new_run_id(),
        sweep: plan.name.clone(),
        sweep_hash: key.into(),
        command: options.command.clone(),
        machine: facts.machine.clone(),
        cpu: facts.cpu.clone(),
        threads: facts.threads,
        revision: facts.revision.clone(),
        dirty: facts.dirty,
        time: dapple_records::time::now(),
        version: env!("CARGO_PKG_VERSION").into(),
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        ..RunHeader::default()
    };
    let writer = Writer::create(&options.records, &header)?;
    Ok((writer, header.run, BTreeSet::new()))
}

fn failure(job: &Job, setting: usize, stage: &str, reason: &str) -> Row {
    let mut row = child::blank(&job.group, setting);
    row.run.clone_from(&job.run);
    row.group = Job::key(job.index, setting);
    row.adapter = "unknown".into();
    row.device = "unknown".into();
    row.time = dapple_records::time::now();
    row.status = Status::Failed { stage: stage.into(), reason: reason.into() };
    row.row = row.identity();
    row
}

/// How a child ended.
enum Ended {
    Done,
    Stopped,
    Failed { reason: String, code: u8 },
    Died { setting: Option<usize>, stage: String, reason: String },
}

fn run_child(
    job: &Job,
    options: &Options,
    limit: Duration,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(Event) -> Result<(), SuiteError>,
) -> Result<Ended, SuiteError> {
    let mut child = Command::new(&options.program)
        .args(&options.arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(SuiteError::io(format!("starting {}", options.program.display())))?;
    let ended = follow(&mut child, job, limit, stop, seen);
    // Whatever happened, no child outlives its group.
    let _ = child.kill();
    let _ = child.wait();
    ended
}

fn follow(
    child: &mut Child,
    job: &Job,
    limit: Duration,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(Event) -> Result<(), SuiteError>,
) -> Result<Ended, SuiteError> {
    let (Some(mut stdin), Some(stdout), Some(mut stderr)) =
        (child.stdin.take(), child.stdout.take(), child.stderr.take())
    else {
        return Err(SuiteError::Internal("a child's pipes are missing".into()));
    };
    let line = serde_json::to_string(job).map_err(|e| SuiteError::Internal(e.to_string()))?;
    // A child that died before reading shows as the end of its output below.
    let _ = writeln!(stdin, "{line}");
    drop(stdin);
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let said = thread::spawn(move || {
        let mut text = Vec::new();
        let _ = stderr.read_to_end(&mut text);
        String::from_utf8_lossy(&text).trim().to_string()
    });
    let deadline = Instant::now() + limit;
    let (mut setting, mut stage) = (None, String::from("start"));
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(Ended::Stopped);
        }
        match receiver.recv_timeout(Duration::from_millis(100)) {
            Ok(line) => match Event::from_line(&line)? {
                Some(Event::Done) => return Ok(Ended::Done),
                Some(Event::Failed { reason, code }) => {
                    return Ok(Ended::Failed { reason, code });
                }
                Some(event) => {
                    if let Event::Begin { setting: s, stage: g } = &event {
                        (setting, stage) = (Some(*s), g.clone());
                    }
                    seen(event)?;
                }
                None => {}
            },
            Err(RecvTimeoutError::Timeout) if Instant::now() < deadline => {}
            Err(RecvTimeoutError::Timeout) => {
                let reason = format!("no end after {} s", limit.as_secs());
                return Ok(Ended::Died { setting, stage, reason });
            }
            Err(RecvTimeoutError::Disconnected) => {
                // An interrupt reaches the whole process group: the child may die first.
                thread::sleep(Duration::from_millis(50));
                if stop.load(Ordering::Relaxed) {
                    return Ok(Ended::Stopped);
                }
                let status = child.wait().map_err(SuiteError::io("waiting for a child"))?;
                let said = said.join().unwrap_or_default();
                let last = said.lines().next_back().unwrap_or_default();
                let reason = format!("the process ended early ({status}) {last}");
                return Ok(Ended::Died { setting, stage, reason: reason.trim().into() });
            }
        }
    }
}

/// The child's side: reads a [`Job`] from `input`, writes events to `output` until the reader
/// goes away.
///
/// # Errors
/// [`SuiteError::Usage`] for a job that cannot be read.
pub fn serve(input: &mut dyn Read, output: &mut dyn Write) -> Result<(), SuiteError> {
    let mut text = String::new();
    input.read_to_string(&mut text).map_err(SuiteError::io("reading the job"))?;
    let job: Job =
        serde_json::from_str(&text).map_err(|e| SuiteError::Usage(format!("job: {e}")))?;
    child::run(&job, &mut |event| {
        let line = format!("{}\n", event.to_line());
        if output.write_all(line.as_bytes()).and_then(|()| output.flush()).is_err() {
            // The runner is gone: nobody would read what follows.
            std::process::exit(3);
        }
    });
    Ok(())
}
