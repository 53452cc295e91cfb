//! The runner: one child process a group, every finished row on disk at once.
//!
//! A crash, a hang or a lost device becomes a row for the setting that was at work; the group
//! runs again without it. A run that was killed resumes where it stopped.

pub mod child;
pub mod protocol;

use crate::{SuiteError, case::DATA_VARIABLE, environment::environment, plan::Plan};
use dapple_records::{Row, RunHeader, Status, Writer};
use protocol::{Event, Fault, Job};
use std::{
    collections::BTreeSet,
    fs::File,
    io::{self, BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError, TryRecvError},
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
    let (mut writer, run, mut done) = open_records(plan, options, &resume_key(plan, options))?;
    let total = plan.rows();
    tell(Progress::Started { path: writer.path(), total, resumed: done.len() });
    plan.notes.iter().for_each(|text| tell(Progress::Note(text)));
    let mut failed_groups = Vec::new();
    let mut noted = BTreeSet::new();
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
            let left = |done: &BTreeSet<String>| -> Vec<usize> {
                let all = first..group.settings.len();
                all.filter(|i| !done.contains(&Job::key(index, *i))).collect()
            };
            job.todo = left(&done);
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
                    // Every form of a case makes the same notes.
                    Event::Note(text) => {
                        if noted.insert(text.clone()) {
                            tell(Progress::Note(&text));
                        }
                    }
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
            let mut failed = left(&done);
            let (stage, reason) = match ended {
                Ended::Stopped => {
                    let path = writer.path().to_path_buf();
                    return Err(SuiteError::Interrupted { done: done.len(), total, path });
                }
                Ended::Done => ("run".into(), "the process ended without this row".into()),
                // The case itself is at fault: every setting of it gets the reason.
                Ended::Failed { reason, code } => {
                    failed_groups.push((format!("{}: {reason}", group.title()), code));
                    ("prepare".into(), reason)
                }
                // The others run again without the culprit, which may have its row already. A ban
                // that did not hold fails them all: every turn of this loop ends a setting.
                Ended::Died { setting: Some(culprit), stage, reason }
                    if !job.banned.contains(&culprit) =>
                {
                    job.banned.push(culprit);
                    failed.retain(|setting| *setting == culprit);
                    (stage, reason)
                }
                Ended::Died { stage, reason, .. } => (stage, reason),
            };
            for setting in failed {
                let row = failure(&job, setting, &stage, &reason);
                writer.append(&row)?;
                done.insert(row.group.clone());
                tell(Progress::Row(&row));
            }
        }
    }
    writer.end()?;
    Ok(Finished { path: writer.path().to_path_buf(), run, failed_groups })
}

/// A resumed run must be the same work on the same data by the same program on the same adapter
/// with the same threads. The program is known by its content: a revision would miss changes that
/// are not committed, and be moved by commits that change nothing in it.
fn resume_key(plan: &Plan, options: &Options) -> String {
    let mut hash = blake3::Hasher::new();
    // A program that cannot be read cannot be started either.
    let _ = File::open(&options.program).and_then(|mut file| io::copy(&mut file, &mut hash));
    let (data, threads) = (std::env::var_os(DATA_VARIABLE), environment().threads);
    let rest = format!("{} {:?} {threads} {data:?}", plan.hash(), options.adapter);
    hash.update(rest.as_bytes());
    hash.finalize().to_hex()[..16].to_string()
}

type Opened = (Writer, String, BTreeSet<String>);

fn open_records(plan: &Plan, options: &Options, key: &str) -> Result<Opened, SuiteError> {
    let facts = environment();
    if !options.fresh
        && let Some(path) = dapple_records::unfinished(&options.records, key, &facts.machine)
    {
        let writer = Writer::resume(&path)?;
        // Read under the writer's lock: another process may have ended the run just now.
        let read = dapple_records::read_file(&path)?;
        let run = writer.run().to_string();
        if !read.ended.contains(&run) {
            let rows = read.rows.into_iter().filter(|row| row.run == run);
            let done = rows.map(|row| row.group).collect();
            return Ok((writer, run, done));
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
    /// The case cannot be measured.
    Failed {
        reason: String,
        code: u8,
    },
    /// Something ended it at work on a setting, or on the case (`None`).
    Died {
        setting: Option<usize>,
        stage: String,
        reason: String,
    },
}

fn run_child(
    job: &Job,
    options: &Options,
    limit: Duration,
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
    // The input stays open, in `child`: its end tells the child that the runner is gone.
    let (Some(stdin), Some(stdout), Some(mut stderr)) =
        (child.stdin.as_mut(), child.stdout.take(), child.stderr.take())
    else {
        return Err(SuiteError::Internal("a child's pipes are missing".into()));
    };
    let line = serde_json::to_string(job).map_err(|e| SuiteError::Internal(e.to_string()))?;
    // A child that died before reading shows as the end of its output below.
    let _ = writeln!(stdin, "{line}");
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
    let (mut setting, mut stage, mut begun) = (None, String::from("start"), start);
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(Ended::Stopped);
        }
        // What was said in time counts, however late it is read.
        let heard = match receiver.try_recv() {
            Err(TryRecvError::Empty) if start.elapsed() > limit => {
                let (all, this) = (limit.as_secs(), begun.elapsed().as_secs_f64());
                let reason = format!("no end after {all} s, the last {this:.1} s of them in this");
                return Ok(Ended::Died { setting, stage, reason });
            }
            Err(TryRecvError::Empty) => receiver.recv_timeout(Duration::from_millis(100)),
            heard => heard.map_err(|_| RecvTimeoutError::Disconnected),
        };
        let event = match heard {
            Ok(line) => Event::from_line(&line)?,
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                let status = child.wait().map_err(SuiteError::io("waiting for a child"))?;
                let words = last_words(&said.join().unwrap_or_default());
                let reason = format!("the process ended early ({status}) {words}");
                return Ok(Ended::Died { setting, stage, reason: reason.trim().into() });
            }
        };
        match event {
            None => {}
            Some(Event::Done) => return Ok(Ended::Done),
            // At work on a setting, e.g. a device that it lost: the case is not to blame.
            Some(Event::Failed { reason, .. }) if setting.is_some() => {
                return Ok(Ended::Died { setting, stage, reason });
            }
            Some(Event::Failed { reason, code }) => return Ok(Ended::Failed { reason, code }),
            Some(event) => {
                if let Event::Begin { setting: s, stage: g } = &event {
                    setting = Some(*s).filter(|s| *s < job.group.settings.len());
                    (stage, begun) = (g.clone(), Instant::now());
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

/// The child's side: reads a [`Job`], one line of `input`, and writes events to `output`. The
/// runner keeps `input` open for as long as it lives.
///
/// # Errors
/// [`SuiteError::Usage`] for a job that cannot be read.
pub fn serve(input: impl Read + Send + 'static, output: &mut dyn Write) -> Result<(), SuiteError> {
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
    child::run(&job, &mut |event| {
        let line = format!("{}\n", event.to_line());
        if output.write_all(line.as_bytes()).and_then(|()| output.flush()).is_err() {
            // The runner is gone: nobody would read what follows.
            std::process::exit(3);
        }
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Sweep;

    fn options(folder: &Path, script: &str) -> Options {
        Options {
            records: folder.into(),
            adapter: None,
            command: "test".into(),
            program: "/bin/sh".into(),
            arguments: vec!["-c".into(), script.into()],
            fresh: false,
            fault: None,
        }
    }

    fn plan(limit_s: u64) -> Plan {
        let text = format!(
            "about = 't'\nlimit_s = {limit_s}\n[[measure]]\nproblem = 'shadow-filtering'\n\
             forms = ['cpu']\n[[measure.technique]]\nid = 'hard'\n[[measure.technique]]\n\
             id = 'vsm'\n[[measure.technique]]\nid = 'pcf'"
        );
        Sweep::parse(Path::new("t"), &text).unwrap().plan("t").unwrap()
    }

    /// Runs a script in place of the measuring process: technique, stage and reason of each row.
    fn outcome(script: &str, limit_s: u64) -> Vec<(String, String, String)> {
        let folder = tempfile::tempdir().unwrap();
        let never = AtomicBool::new(false);
        let finished =
            run(&plan(limit_s), &options(folder.path(), script), &never, &mut |_| ()).unwrap();
        let rows = dapple_records::read_file(&finished.path).unwrap().rows;
        rows.into_iter()
            .map(|row| match row.status {
                Status::Failed { stage, reason } => (row.technique, stage, reason),
                other => panic!("{other:?}"),
            })
            .collect()
    }

    /// The problem's baseline, `vsm`, comes first: setting 1 is `hard`.
    const BEGIN_1: &str = r#"echo '{"event":"begin","setting":1,"stage":"check"}'"#;

    #[test]
    fn a_death_before_any_setting_fails_the_case_once() {
        // Each turn that blamed one setting would pay the whole limit again.
        for script in ["exit 7", r#"echo '{"event":"begin","setting":99,"stage":"prepare"}'"#] {
            let rows = outcome(script, 60);
            assert_eq!(rows.len(), 3, "{rows:?}");
            assert!(rows.iter().all(|r| r.2 == rows[0].2), "{rows:?}");
        }
    }

    #[test]
    fn the_culprit_gets_its_own_reason_and_a_ban_that_does_not_hold_ends_the_group() {
        let script = format!("read job; {BEGIN_1}; echo 'it broke' >&2; exit 3");
        let rows = outcome(&script, 60);
        assert_eq!(rows.len(), 3);
        assert_eq!((rows[0].0.as_str(), rows[0].1.as_str()), ("hard", "check"));
        assert!(rows[0].2.contains("it broke"), "{rows:?}");
    }

    #[test]
    fn a_failure_at_work_on_a_setting_is_that_settings() {
        // Stands for a lost device: the first turn fails at setting 1, the second ends without rows.
        let script = format!(
            r#"read job; case "$job" in *'"banned":[]'*) {BEGIN_1}
               echo '{{"event":"failed","reason":"device lost","code":3}}';;
               *) echo '{{"event":"done"}}';; esac"#
        );
        let rows = outcome(&script, 60);
        assert_eq!(rows.len(), 3, "{rows:?}");
        assert_eq!((rows[0].0.as_str(), rows[0].2.as_str()), ("hard", "device lost"));
        assert!(rows[1..].iter().all(|r| r.2.contains("without this row")), "{rows:?}");
    }

    #[test]
    fn a_process_that_never_stops_talking_meets_its_limit_too() {
        let script = format!("read job; {BEGIN_1}; while :; do echo '{{}}'; sleep 0.02; done");
        let begun = Instant::now();
        let rows = outcome(&script, 1);
        assert!(begun.elapsed() < Duration::from_secs(30));
        assert!(rows[0].0 == "hard" && rows[0].2.contains("no end after 1 s"), "{rows:?}");
    }

    #[test]
    fn a_note_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let script =
            format!(r#"read job; echo '{{"event":"note","text":"no ground"}}'; {BEGIN_1}; exit 4"#);
        let mut notes = 0;
        let never = AtomicBool::new(false);
        run(&plan(60), &options(folder.path(), &script), &never, &mut |progress| {
            notes += usize::from(matches!(progress, Progress::Note("no ground")));
        })
        .unwrap();
        assert_eq!(notes, 1);
    }

    #[test]
    fn output_that_is_no_text_is_passed_over() {
        let script = format!(r"read job; printf '\377\n'; {BEGIN_1}; exit 4");
        assert_eq!(outcome(&script, 60)[0].0, "hard");
    }

    #[test]
    fn the_last_words_are_the_panic_and_not_the_note_behind_it() {
        let panic = "warming up\nthread 'main' panicked at a.rs:1:2:\nindex out of bounds\n\
                     note: run with `RUST_BACKTRACE=1`";
        assert_eq!(last_words(panic), "panicked at a.rs:1:2: index out of bounds");
        assert_eq!(last_words("one\ntwo\n\nnote: three"), "two");
        assert_eq!(last_words(""), "");
    }

    #[test]
    fn only_the_same_work_by_the_same_program_is_resumed() {
        let folder = tempfile::tempdir().unwrap();
        let base = options(folder.path(), "");
        let key = resume_key(&plan(60), &base);
        assert_eq!(key, resume_key(&plan(60), &base));
        let repeats = Plan { repeats: 9, ..plan(60) };
        assert_ne!(key, resume_key(&repeats, &base));
        assert_ne!(
            key,
            resume_key(&plan(60), &Options { adapter: Some("x".into()), ..base.clone() })
        );
        let program = folder.path().join("program");
        let other = Options { program: program.clone(), ..base };
        std::fs::write(&program, "one build").unwrap();
        let one = resume_key(&plan(60), &other);
        std::fs::write(&program, "another build").unwrap();
        assert_ne!(one, resume_key(&plan(60), &other));
    }

    #[test]
    fn a_run_in_progress_is_not_joined_and_a_concatenated_file_resumes_its_last_run() {
        let folder = tempfile::tempdir().unwrap();
        let options = options(folder.path(), "");
        let (writer, run, _) = open_records(&plan(60), &options, "key").unwrap();
        let error = open_records(&plan(60), &options, "key").unwrap_err();
        assert!(error.to_string().contains("another process"), "{error}");
        assert_eq!(error.exit_code(), 3);
        let path = writer.path().to_path_buf();
        drop(writer);
        let mut text = std::fs::read_to_string(&path).unwrap();
        text = format!("{}{text}", text.replace(&run, "an-older-run"));
        std::fs::write(&path, text).unwrap();
        assert_eq!(open_records(&plan(60), &options, "key").unwrap().1, run);
    }
}
