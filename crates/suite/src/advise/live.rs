//! The oracle that measures: settings side by side in child processes, recorded like a run.

use super::{Answer, Measured, Oracle};
use crate::{
    SuiteError,
    case::Case,
    plan::{Group, Plan},
    problem::Setting,
    run::{self, Options, Progress},
};
use dapple_records::{Row, Status};
use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    thread,
    time::{Duration, Instant},
};

/// Settings measured side by side: a batch is one process where it fits, since each prepares the
/// case anew.
const GROUP: usize = 24;

/// Settings of the first group.
const FIRST: usize = 4;

/// Part of the time left that one group may be expected to take.
const PARTS: f64 = 4.0;

/// Timed repeats while searching, and for those that the answer will name.
const REPEATS: u32 = 3;
const MORE_REPEATS: u32 = 9;

/// Measures what it is asked, until its time is over.
pub struct Live<'a> {
    case: Case,
    options: Options,
    stop: Arc<AtomicBool>,
    end: Instant,
    tell: &'a mut dyn FnMut(Progress<'_>),
    /// The cheapest setting of the first group and its time then. It runs along in every later group,
    /// and times are told by their ratio to it: between groups the machine may have drifted.
    anchor: Option<(Setting, f64)>,
    /// Every row measured, failures too; the last of a setting counts.
    pub rows: Vec<Row>,
    /// Record files written.
    pub files: Vec<PathBuf>,
    /// Time spent until the first setting of each process was begun: preparing the case.
    pub preparing: Duration,
    /// Longest time a setting has taken, on average over its group.
    slowest: Duration,
}

impl<'a> Live<'a> {
    /// Measures on `case` until `end`. `stop`, once set by someone else, ends it too.
    pub fn new(
        case: Case,
        options: Options,
        stop: Arc<AtomicBool>,
        end: Instant,
        tell: &'a mut dyn FnMut(Progress<'_>),
    ) -> Self {
        let (rows, files) = (Vec::new(), Vec::new());
        let (preparing, slowest) = (Duration::ZERO, Duration::ZERO);
        Self { case, options, stop, end, tell, rows, files, preparing, slowest, anchor: None }
    }

    fn measure(&mut self, settings: &[Setting], repeats: u32) -> Result<Vec<Answer>, SuiteError> {
        let mut answers = Vec::new();
        while answers.len() < settings.len() {
            let left = self.end.saturating_duration_since(Instant::now());
            // A group that the end cuts short leaves nothing: none may take more than a part of what
            // is left, and the first, of unknown pace, is small.
            let fits = match self.slowest {
                Duration::ZERO => FIRST,
                each => (left.as_secs_f64() / PARTS / each.as_secs_f64()).max(1.0) as usize,
            };
            if left.is_zero() || self.stop.load(Ordering::Relaxed) {
                break;
            }
            let rest = &settings[answers.len()..];
            let group = &rest[..rest.len().min(GROUP).min(fits)];
            let rows = self.group(group, repeats, left)?;
            let done = !rows.is_empty();
            let anchor_ns = self.anchor.as_ref().map(|(_, ns)| *ns);
            answers.extend(group.iter().map(|setting| answer(setting, &rows, anchor_ns)));
            if self.anchor.is_none() {
                self.anchor = cheapest(group, &answers);
            }
            self.rows.extend(rows);
            if !done {
                break;
            }
        }
        answers.resize(settings.len(), Answer::Unasked);
        Ok(answers)
    }

    /// One group as a run of its own. Its rows, or none if the time was over before.
    fn group(
        &mut self,
        settings: &[Setting],
        repeats: u32,
        left: Duration,
    ) -> Result<Vec<Row>, SuiteError> {
        let group = Group {
            index: 0,
            case: self.case.clone(),
            settings: self.anchor.iter().map(|(a, _)| a).chain(settings).cloned().collect(),
            repeated_baseline: self.anchor.is_some(),
            skipped: 0,
        };
        let plan = Plan {
            name: "advise".into(),
            repeats,
            // A hang ends with the time there is.
            limit_s: left.as_secs() + 1,
            groups: vec![group],
            notes: Vec::new(),
            shard: String::new(),
        };
        let (begun, mut first, mut rows, mut file) = (Instant::now(), None, Vec::new(), None);
        // Ends the run when the time is over; the channel's end ends the watch.
        let (finished, over) = mpsc::channel::<()>();
        let stop = Arc::new(AtomicBool::new(false));
        let (flag, outer) = (Arc::clone(&stop), Arc::clone(&self.stop));
        let watch = thread::spawn(move || {
            let end = begun + left;
            while over.recv_timeout(Duration::from_millis(50))
                == Err(mpsc::RecvTimeoutError::Timeout)
            {
                if Instant::now() >= end || outer.load(Ordering::Relaxed) {
                    flag.store(true, Ordering::Relaxed);
                }
            }
        });
        let tell = &mut *self.tell;
        let ended = run::run(&plan, &self.options, &stop, &mut |progress| {
            match &progress {
                Progress::Started { path, .. } => file = Some(path.to_path_buf()),
                Progress::Stage { setting, .. } if !setting.is_empty() => {
                    first.get_or_insert_with(|| begun.elapsed());
                }
                Progress::Row(row) => rows.push((*row).clone()),
                _ => {}
            }
            tell(progress);
        });
        drop(finished);
        let _ = watch.join();
        self.files.extend(file);
        let preparing = first.unwrap_or_else(|| begun.elapsed());
        self.preparing += preparing;
        if !rows.is_empty() {
            let each = (begun.elapsed() - preparing) / rows.len() as u32;
            self.slowest = self.slowest.max(each);
        }
        match ended {
            Err(SuiteError::Interrupted { .. }) => Ok(rows),
            Err(error) => Err(error),
            // The case itself is at fault: no other setting would fare better.
            Ok(finished) => match finished.failed_groups.into_iter().next() {
                Some((reason, _)) => Err(SuiteError::Usage(reason)),
                None => Ok(rows),
            },
        }
    }
}

impl Oracle for Live<'_> {
    fn ask(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError> {
        self.measure(settings, REPEATS)
    }

    fn again(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError> {
        self.measure(settings, MORE_REPEATS)
    }
}

/// The setting of least time among a group's.
fn cheapest(group: &[Setting], answers: &[Answer]) -> Option<(Setting, f64)> {
    let timed = group.iter().zip(answers).filter_map(|(setting, answer)| match answer {
        Answer::Measured(measured) => Some((setting.clone(), measured.time_ns)),
        _ => None,
    });
    timed.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn answer(setting: &Setting, rows: &[Row], anchor_ns: Option<f64>) -> Answer {
    let of = |row: &&Row| {
        row.technique == setting.technique
            && row.variant == setting.variant
            && row.knobs == setting.knobs
    };
    let Some(row) = rows.iter().find(of) else { return Answer::Unasked };
    match &row.status {
        Status::Failed { stage, reason } => Answer::Failed(format!("{stage}: {reason}")),
        Status::NotRun { reason } => Answer::Failed(reason.clone()),
        Status::Ok => measured(row, anchor_ns),
    }
}

fn measured(row: &Row, anchor_ns: Option<f64>) -> Answer {
    let (Some(median_ns), Some(mad_ns)) = (row.median_ns(), row.mad_ns()) else {
        return Answer::Failed("it has no time".into());
    };
    let by_ratio = anchor_ns.zip(row.ratio).map(|(ns, ratio)| ns * ratio);
    let time_ns = by_ratio.filter(|ns| *ns > 0.0).unwrap_or(median_ns);
    let mad_ns = mad_ns * time_ns / median_ns.max(1.0);
    Answer::Measured(Measured { time_ns, mad_ns, errors: row.errors.clone() })
}

/// Reads a time to spend: a number with `s`, `m` or `h`, from 1 s to a week.
///
/// # Errors
/// [`SuiteError::Value`] for anything else.
pub fn parse_time(text: &str) -> Result<Duration, SuiteError> {
    const WEEK_S: f64 = 7.0 * 24.0 * 3600.0;
    let text_trimmed = text.trim();
    let unit = [('s', 1.0), ('m', 60.0), ('h', 3600.0)];
    unit.iter()
        .find_map(|(unit, seconds)| {
            let number: f64 = text_trimmed.strip_suffix(*unit)?.trim_end().parse().ok()?;
            Some(number * seconds).filter(|s| (1.0..=WEEK_S).contains(s))
        })
        .map(Duration::from_secs_f64)
        .ok_or_else(|| SuiteError::Value {
            what: "flag",
            name: "--time".into(),
            value: text.into(),
            limit: "must be a number with s, m or h, from 1s to 168h".into(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_by_their_ratio_to_what_ran_along() {
        // The machine runs at half its speed: 40 ns are twice the anchor's time all the same.
        let row = Row {
            samples_ns: vec![vec![39], vec![40], vec![41]],
            ratio: Some(2.0),
            ..Row::default()
        };
        let told = |anchor| match measured(&row, anchor) {
            Answer::Measured(m) => (m.time_ns, m.mad_ns),
            other => panic!("{other:?}"),
        };
        assert_eq!(told(Some(10.0)), (20.0, 0.5));
        assert_eq!(told(None), (40.0, 1.0));
        assert!(matches!(measured(&Row::default(), None), Answer::Failed(_)));
    }

    #[test]
    fn times_are_read_with_their_unit() {
        for (text, seconds) in [("60s", 60.0), ("5m", 300.0), ("1.5h", 5400.0), (" 2 m ", 120.0)] {
            assert_eq!(parse_time(text).unwrap().as_secs_f64(), seconds);
        }
        for text in ["", "60", "s", "-5s", "0s", "nans", "infs", "1e9h", "5 parsecs", "1d"] {
            let error = parse_time(text).unwrap_err();
            assert!(error.to_string().contains("from 1s to 168h"), "{text}: {error}");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
