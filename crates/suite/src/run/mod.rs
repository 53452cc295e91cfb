//! The runner: one child process a group, every finished row on disk at once.
//!
//! A crash, a hang or a lost device becomes a row for the setting that was at work; the group
//! runs again without it. A run that was killed resumes where it stopped.

pub mod child;
pub(crate) mod process;
pub mod protocol;
pub(crate) mod records;

use crate::{SuiteError, plan::Plan};
use dapple_records::{Row, Status, Writer};
use process::{Begun, Ended, Limit, run_child};
use protocol::{Event, Fault, Job};
use std::{
    collections::BTreeSet,
    io::{Read, Write},
    path::{Path, PathBuf},
    sync::atomic::AtomicBool,
    time::Duration,
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
    /// Part of the work as `i/n`, for the record; empty for all of it.
    pub shard: String,
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
    let key = records::resume_key(&plan.hash(), options);
    let (writer, read) = records::open(&plan.name, &key, options)?;
    let done: BTreeSet<String> = read.rows.into_iter().map(|row| row.group).collect();
    tell(Progress::Started { path: writer.path(), total: plan.rows(), resumed: done.len() });
    plan.notes.iter().for_each(|text| tell(Progress::Note(text)));
    let (failed_groups, noted) = (Vec::new(), BTreeSet::new());
    let mut state = State { writer, done, noted, failed_groups, tell };
    for group in &plan.groups {
        let mut job = Job {
            run: state.writer.run().into(),
            group: group.clone(),
            todo: Vec::new(),
            banned: Vec::new(),
            repeats: plan.repeats,
            adapter: options.adapter.clone(),
            fault: options.fault.clone(),
        };
        (state.tell)(Progress::Group(&group.title()));
        loop {
            job.todo = state.left(&job);
            if job.todo.is_empty() {
                break;
            }
            state.turn(&mut job, plan, options, stop)?;
        }
    }
    state.writer.end()?;
    let path = state.writer.path().to_path_buf();
    let run = state.writer.run().into();
    Ok(Finished { path, run, failed_groups: state.failed_groups })
}

/// What is done, and where it goes.
struct State<'a> {
    writer: Writer,
    /// Keys of the rows on disk.
    done: BTreeSet<String>,
    noted: BTreeSet<String>,
    failed_groups: Vec<(String, u8)>,
    tell: &'a mut dyn FnMut(Progress<'_>),
}

impl State<'_> {
    /// Settings of the job's group that have no row yet.
    fn left(&self, job: &Job) -> Vec<usize> {
        let first = usize::from(job.group.repeated_baseline);
        let all = first..job.group.settings.len();
        all.filter(|setting| !self.done.contains(&job.group.key(*setting))).collect()
    }

    fn keep(&mut self, row: &Row) -> Result<(), SuiteError> {
        self.writer.append(row)?;
        self.done.insert(row.group.clone());
        (self.tell)(Progress::Row(row));
        Ok(())
    }

    /// One process for what is left of a group. At least one setting has its row afterwards.
    fn turn(
        &mut self,
        job: &mut Job,
        plan: &Plan,
        options: &Options,
        stop: &AtomicBool,
    ) -> Result<(), SuiteError> {
        let settings = job.group.settings.len();
        let limit = Limit::Whole(Duration::from_secs(plan.limit_s));
        let ended =
            run_child(&process::line(job)?, settings, options, limit, stop, &mut |event| {
                self.hear(job, event)
            })?;
        let mut failed = self.left(job);
        let (stage, reason) = match ended {
            Ended::Stopped => {
                let (path, done) = (self.writer.path().to_path_buf(), self.done.len());
                return Err(SuiteError::Interrupted { done, total: plan.rows(), path });
            }
            Ended::Done => ("run".into(), "the process ended without this row".into()),
            // The case itself is at fault: every setting of it gets the reason.
            Ended::Failed { reason, code } => {
                self.failed_groups.push((format!("{}: {reason}", job.group.title()), code));
                ("prepare".into(), reason)
            }
            // The others run again without the culprit, which may have its row already. A ban
            // that did not hold fails them all: every turn ends a setting.
            Ended::Died { begun: Some(Begun { setting: culprit, stage, .. }), reason }
                if culprit < settings && !job.banned.contains(&culprit) =>
            {
                job.banned.push(culprit);
                failed.retain(|setting| *setting == culprit);
                (stage, reason)
            }
            Ended::Died { begun, reason } => {
                (begun.map_or_else(|| "start".into(), |begun| begun.stage), reason)
            }
        };
        failed
            .into_iter()
            .try_for_each(|setting| self.keep(&failure(job, setting, &stage, &reason)))
    }

    fn hear(&mut self, job: &Job, event: Event) -> Result<(), SuiteError> {
        match event {
            Event::Row(row) => self.keep(&row)?,
            // Every form of a case makes the same notes.
            Event::Note(text) => {
                if self.noted.insert(text.clone()) {
                    (self.tell)(Progress::Note(&text));
                }
            }
            Event::Begin { setting, stage, .. } => {
                let setting = job.group.settings.get(setting).map(ToString::to_string);
                let setting = setting.as_deref().unwrap_or_default();
                (self.tell)(Progress::Stage { setting, stage: &stage });
            }
            Event::Stress(_) | Event::Failed { .. } | Event::Done => {}
        }
        Ok(())
    }
}

fn failure(job: &Job, setting: usize, stage: &str, reason: &str) -> Row {
    let mut row = child::blank(&job.group, setting);
    row.run.clone_from(&job.run);
    row.group = job.group.key(setting);
    row.adapter = "unknown".into();
    row.device = "unknown".into();
    row.time = dapple_records::time::now();
    row.status = Status::Failed { stage: stage.into(), reason: reason.into() };
    row.row = row.identity();
    row
}

/// The child's side: reads a [`Job`], one line of `input`, and writes events to `output`. The
/// runner keeps `input` open for as long as it lives.
///
/// # Errors
/// [`SuiteError::Usage`] for a job that cannot be read.
pub fn serve(input: impl Read + Send + 'static, output: &mut dyn Write) -> Result<(), SuiteError> {
    process::serve(input, output, child::run)
}

#[cfg(test)]
mod tests {
    use super::{
        records::{open, resume_key},
        *,
    };
    use crate::{sweep::Sweep, testing::played_by};
    use std::time::Instant;

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
            run(&plan(limit_s), &played_by(script, folder.path()), &never, &mut |_| ()).unwrap();
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
        run(&plan(60), &played_by(&script, folder.path()), &never, &mut |progress| {
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
    fn only_the_same_work_by_the_same_program_is_resumed() {
        let folder = tempfile::tempdir().unwrap();
        let base = played_by("", folder.path());
        let key = resume_key(&plan(60).hash(), &base);
        assert_eq!(key, resume_key(&plan(60).hash(), &base));
        let repeats = Plan { repeats: 9, ..plan(60) };
        assert_ne!(key, resume_key(&repeats.hash(), &base));
        assert_ne!(
            key,
            resume_key(&plan(60).hash(), &Options { adapter: Some("x".into()), ..base.clone() })
        );
        let program = folder.path().join("program");
        let other = Options { program: program.clone(), ..base };
        std::fs::write(&program, "one build").unwrap();
        let one = resume_key(&plan(60).hash(), &other);
        std::fs::write(&program, "another build").unwrap();
        assert_ne!(one, resume_key(&plan(60).hash(), &other));
    }

    #[test]
    fn a_run_in_progress_is_not_joined_and_a_concatenated_file_resumes_its_last_run() {
        let folder = tempfile::tempdir().unwrap();
        let options = played_by("", folder.path());
        let (writer, _) = open("t", "key", &options).unwrap();
        let run = writer.run().to_string();
        let error = open("t", "key", &options).unwrap_err();
        assert!(error.to_string().contains("another process"), "{error}");
        assert_eq!(error.exit_code(), 3);
        let path = writer.path().to_path_buf();
        drop(writer);
        let mut text = std::fs::read_to_string(&path).unwrap();
        text = format!("{}{text}", text.replace(&run, "an-older-run"));
        std::fs::write(&path, text).unwrap();
        assert_eq!(open("t", "key", &options).unwrap().0.run(), run);
    }
}
