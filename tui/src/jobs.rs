//! Jobs: child processes with their progress and the end of their logs.

use crate::msg::{Effect, JobId};
use dapple_records::{Feed, FeedLine};
use std::collections::VecDeque;

/// Lines of a log that are kept.
const LOG_LINES: usize = 200;
/// Characters of one of them.
const LOG_COLUMNS: usize = 2000;
/// Jobs that are kept; the oldest that ended goes.
const JOBS: usize = 100;

/// How a job stands.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Waits for the one before it: two at once would slow each other's clocks.
    Queued,
    /// At work.
    Running,
    /// Asked to stop.
    Stopping,
    /// Gone, with its exit code and in words.
    Ended {
        /// Exit code.
        code: Option<i32>,
        /// In words.
        how: String,
    },
}

/// One job.
#[derive(Clone, Debug)]
pub struct Job {
    /// Number.
    pub id: JobId,
    /// For people.
    pub title: String,
    /// Arguments of the program.
    pub arguments: Vec<String>,
    /// How it stands.
    pub state: State,
    /// Results planned, 0 if not known.
    pub total: usize,
    /// Results there were when it began.
    pub resumed: usize,
    /// Results so far.
    pub done: usize,
    /// What is at work now.
    pub now: String,
    /// When it began, milliseconds since 1970.
    pub began_ms: i64,
    /// When it ended.
    pub ended_ms: i64,
    /// Its record file, once it has told.
    pub path: String,
    /// The end of its log.
    pub log: VecDeque<String>,
}

/// All jobs, in order. Those that measure run one after another.
#[derive(Clone, Debug, Default)]
pub struct Jobs {
    /// The jobs.
    pub list: Vec<Job>,
    next: u64,
}

impl Jobs {
    /// A new number, for a job that is not in the list (catalogue, live).
    pub fn reserve(&mut self) -> JobId {
        self.next += 1;
        JobId(self.next)
    }

    /// Puts a job at the queue's end, and starts it if nothing runs.
    pub fn add(&mut self, title: String, arguments: Vec<String>, now_ms: i64) -> Vec<Effect> {
        let id = self.reserve();
        if self.list.len() >= JOBS
            && let Some(at) = self.list.iter().position(Job::is_over)
        {
            self.list.remove(at);
        }
        self.list.push(Job {
            id,
            title,
            arguments,
            state: State::Queued,
            total: 0,
            resumed: 0,
            done: 0,
            now: String::new(),
            began_ms: 0,
            ended_ms: 0,
            path: String::new(),
            log: VecDeque::new(),
        });
        self.start_next(now_ms)
    }

    /// Starts the first queued job unless one runs.
    pub fn start_next(&mut self, now_ms: i64) -> Vec<Effect> {
        if self.running().is_some() {
            return Vec::new();
        }
        let Some(job) = self.list.iter_mut().find(|j| j.state == State::Queued) else {
            return Vec::new();
        };
        job.state = State::Running;
        job.began_ms = now_ms;
        vec![Effect::Start { job: job.id, arguments: job.arguments.clone(), input: false }]
    }

    /// Whether one runs or waits.
    pub fn active(&self) -> bool {
        self.list.iter().any(|job| !job.is_over())
    }

    /// The one that runs.
    pub fn running(&self) -> Option<&Job> {
        self.list.iter().find(|j| matches!(j.state, State::Running | State::Stopping))
    }

    /// Forgets what waits: nothing is started any more.
    pub fn clear_queue(&mut self, now_ms: i64) {
        for job in self.list.iter_mut().filter(|job| job.state == State::Queued) {
            job.give_up(now_ms);
        }
    }

    /// The job of that number.
    pub fn get_mut(&mut self, id: JobId) -> Option<&mut Job> {
        self.list.iter_mut().find(|j| j.id == id)
    }

    /// Takes in what a job said. Returns whether it is one of the list.
    pub fn hear(&mut self, id: JobId, line: &FeedLine) -> bool {
        let Some(job) = self.get_mut(id) else { return false };
        match line {
            FeedLine::Event(Feed::Started { total, resumed, path }) => {
                (job.total, job.resumed, job.done) = (*total, *resumed, *resumed);
                job.path.clone_from(path);
                job.log(format!("records: {path}"));
            }
            FeedLine::Event(Feed::Stage { what, setting, stage }) => {
                job.now = format!("{what} {setting} {stage}").trim().to_string();
            }
            FeedLine::Event(Feed::Progress { done }) => job.done = *done,
            FeedLine::Event(Feed::Note { text }) => job.log(text.clone()),
            FeedLine::Event(Feed::Failed { reason, .. }) => job.log(reason.clone()),
            FeedLine::Event(_) | FeedLine::Record(_) => {}
        }
        true
    }

    /// Takes in a job's end, and starts the next.
    pub fn end(&mut self, id: JobId, code: Option<i32>, how: &str, now_ms: i64) -> Vec<Effect> {
        if let Some(job) = self.get_mut(id) {
            job.state = State::Ended { code, how: how.into() };
            job.ended_ms = now_ms;
            job.log(how.to_string());
        }
        self.start_next(now_ms)
    }

    /// Cancels a job, queued or running.
    pub fn cancel(&mut self, id: JobId, now_ms: i64) -> Vec<Effect> {
        let Some(job) = self.get_mut(id) else { return Vec::new() };
        match job.state {
            State::Queued => {
                job.give_up(now_ms);
                Vec::new()
            }
            State::Running | State::Stopping => {
                job.state = State::Stopping;
                vec![Effect::Stop(id)]
            }
            State::Ended { .. } => Vec::new(),
        }
    }
}

impl Job {
    /// Whether it ended.
    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Ended { .. })
    }

    fn give_up(&mut self, now_ms: i64) {
        self.state = State::Ended { code: None, how: "cancelled before it began".into() };
        self.ended_ms = now_ms;
    }

    /// Adds a line to the log; the oldest goes, and so does what makes a line endless.
    pub fn log(&mut self, text: String) {
        let text = match text.char_indices().nth(LOG_COLUMNS) {
            Some((end, _)) => format!("{}…", &text[..end]),
            None => text,
        };
        if self.log.len() == LOG_LINES {
            self.log.pop_front();
        }
        self.log.push_back(text);
    }

    /// Milliseconds left, from the pace since it began.
    pub fn left_ms(&self, now_ms: i64) -> Option<i64> {
        let fresh = self.done.checked_sub(self.resumed).filter(|n| *n > 0)?;
        let left = self.total.checked_sub(self.done)?;
        let spent = now_ms.saturating_sub(self.began_ms);
        (self.state == State::Running && self.total > 0)
            .then(|| (i128::from(spent) * left as i128 / fresh as i128) as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn started(effects: &[Effect]) -> Vec<JobId> {
        let of = |effect: &Effect| match effect {
            Effect::Start { job, .. } => *job,
            other => panic!("{other:?}"),
        };
        effects.iter().map(of).collect()
    }

    fn add(jobs: &mut Jobs, title: &str) -> Vec<JobId> {
        started(&jobs.add(title.into(), vec![title.into()], 1000))
    }

    #[test]
    fn jobs_run_one_after_another_and_a_cancelled_one_is_passed_over() {
        let mut jobs = Jobs::default();
        let first = add(&mut jobs, "a");
        assert_eq!(first.len(), 1);
        assert!(add(&mut jobs, "b").is_empty() && add(&mut jobs, "c").is_empty());
        let (b, c) = (jobs.list[1].id, jobs.list[2].id);
        assert!(jobs.cancel(b, 2000).is_empty());
        assert_eq!(jobs.cancel(first[0], 2000), [Effect::Stop(first[0])]);
        assert_eq!(jobs.list[0].state, State::Stopping);
        // Asked again: the signal is sent again, which kills.
        assert_eq!(jobs.cancel(first[0], 2000), [Effect::Stop(first[0])]);
        assert_eq!(started(&jobs.end(first[0], None, "cancelled", 3000)), [c]);
        assert!(jobs.active());
        assert!(jobs.end(c, Some(0), "done", 4000).is_empty());
        assert!(!jobs.active() && jobs.cancel(c, 5000).is_empty());
        // An end that comes twice, or of nobody, starts nothing.
        assert!(jobs.end(JobId(99), Some(0), "done", 4000).is_empty());
    }

    #[test]
    fn what_is_left_follows_from_the_pace_since_it_began() {
        let mut jobs = Jobs::default();
        let id = add(&mut jobs, "a")[0];
        let tell = |jobs: &mut Jobs, event| jobs.hear(id, &FeedLine::Event(event));
        assert!(tell(&mut jobs, Feed::Started { path: "p".into(), total: 30, resumed: 10 }));
        assert_eq!(jobs.list[0].left_ms(2000), None);
        tell(&mut jobs, Feed::Progress { done: 15 });
        // Five in nine seconds, fifteen to go: what was there before does not count.
        assert_eq!(jobs.list[0].left_ms(10_000), Some(27_000));
        tell(&mut jobs, Feed::Progress { done: 31 });
        assert_eq!(jobs.list[0].left_ms(10_000), None);
        tell(&mut jobs, Feed::Started { path: "p".into(), total: usize::MAX, resumed: 0 });
        tell(&mut jobs, Feed::Progress { done: 1 });
        assert!(jobs.list[0].left_ms(i64::MAX).is_some());
        assert!(!jobs.hear(JobId(99), &FeedLine::Event(Feed::Progress { done: 1 })));
    }

    #[test]
    fn logs_and_the_list_are_bounded() {
        let mut jobs = Jobs::default();
        for n in 0..JOBS + 50 {
            let id = jobs.add(n.to_string(), Vec::new(), 0);
            let id = started(&id)[0];
            jobs.end(id, Some(0), "done", 0);
        }
        assert_eq!(jobs.list.len(), JOBS);
        let job = &mut jobs.list[0];
        for n in 0..LOG_LINES * 2 {
            job.log(format!("{n}"));
        }
        job.log("ä".repeat(LOG_COLUMNS * 2));
        assert_eq!(job.log.len(), LOG_LINES);
        assert_eq!(job.log.back().unwrap().chars().count(), LOG_COLUMNS + 1);
    }
}
