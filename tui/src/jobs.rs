//! Jobs: child processes with their progress and the end of their logs.

use crate::msg::{Effect, JobId};
use dapple_records::{Feed, FeedLine};
use std::collections::VecDeque;

/// Lines of a log that are kept.
const LOG_LINES: usize = 200;

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
            log: VecDeque::new(),
        });
        self.start_next(now_ms)
    }

    /// Starts the first queued job unless one runs.
    pub fn start_next(&mut self, now_ms: i64) -> Vec<Effect> {
        if self.list.iter().any(|j| matches!(j.state, State::Running | State::Stopping)) {
            return Vec::new();
        }
        let Some(job) = self.list.iter_mut().find(|j| j.state == State::Queued) else {
            return Vec::new();
        };
        job.state = State::Running;
        job.began_ms = now_ms;
        vec![Effect::Start { job: job.id, arguments: job.arguments.clone(), input: false }]
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
                job.state = State::Ended { code: None, how: "cancelled before it began".into() };
                job.ended_ms = now_ms;
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
    /// Adds a line to the log; the oldest goes.
    pub fn log(&mut self, text: String) {
        if self.log.len() == LOG_LINES {
            self.log.pop_front();
        }
        self.log.push_back(text);
    }

    /// Milliseconds left, from the pace since it began.
    pub fn left_ms(&self, now_ms: i64) -> Option<i64> {
        let fresh = self.done.checked_sub(self.resumed).filter(|n| *n > 0)?;
        let left = self.total.checked_sub(self.done)?;
        let spent = now_ms - self.began_ms;
        (self.state == State::Running && self.total > 0)
            .then(|| spent.saturating_mul(left as i64) / fresh as i64)
    }
}
