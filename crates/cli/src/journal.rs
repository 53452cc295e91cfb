//! Where verdicts go beside the terminal: a run in the records, and a dashboard that listens.

use crate::{feed, output::note};
use dapple_gpu::Gpu;
use dapple_records::{Feed, Line, RecordError, Writer};
use dapple_suite::environment;
use std::path::Path;

/// A run that is written down as it goes. Records are kept for later; the verdicts themselves and
/// the exit code do not depend on them, so a folder that refuses is said and passed over.
pub struct Journal {
    /// Id of the run; every line carries it.
    pub run: String,
    writer: Option<Writer>,
    path: String,
    feed: bool,
    done: usize,
}

impl Journal {
    /// Begins a run of that name.
    pub fn begin(records: &Path, name: &str, key: &str, command: &str, feed: bool) -> Self {
        let header = environment::run_header(name, key, command);
        let writer = kept(Writer::create(records, &header));
        let path = writer.as_ref().map(|w| w.path().display().to_string()).unwrap_or_default();
        Self { run: header.run, writer, path, feed, done: 0 }
    }

    /// Says how many results there will be.
    pub fn planned(&self, total: usize) -> std::io::Result<()> {
        self.tell(&Feed::Started { path: self.path.clone(), total, resumed: 0 })
    }

    /// Says what is at work now.
    pub fn stage(&self, what: &str, setting: &str) -> std::io::Result<()> {
        let (what, setting) = (what.into(), setting.into());
        self.tell(&Feed::Stage { what, setting, stage: String::new() })
    }

    /// Keeps a result.
    pub fn put(&mut self, line: &Line) -> std::io::Result<()> {
        if let Some(writer) = &mut self.writer
            && kept(writer.append_line(line)).is_none()
        {
            self.writer = None;
        }
        self.done += 1;
        if self.feed {
            feed::tell_line(line)?;
        }
        self.tell(&Feed::Progress { done: self.done })
    }

    /// Ends the run: all of it was done.
    pub fn end(&mut self) {
        if let Some(mut writer) = self.writer.take()
            && kept(writer.end()).is_some()
        {
            note!("records: {}", self.path);
        }
    }

    fn tell(&self, event: &Feed) -> std::io::Result<()> {
        if self.feed { feed::tell(event) } else { Ok(()) }
    }
}

fn kept<T>(result: Result<T, RecordError>) -> Option<T> {
    result.map_err(|error| note!("not recorded: {error}")).ok()
}

/// The adapter's name as records have it.
pub fn adapter_name(gpu: Option<&Gpu>) -> String {
    gpu.map_or("none".into(), |gpu| gpu.facts.name.clone())
}
