//! The thread that owns the index of the records: it looks whether files changed, reads what is
//! new, and hands it on. There is one, so that never two readings are under way.

use crate::{msg::Msg, store::Store};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel},
    },
    thread,
    time::{Duration, Instant, SystemTime},
};

/// Between two looks at the folder; after a long reading the pause is as long as several of them.
const PAUSE: Duration = Duration::from_secs(1);
const READINGS_A_PAUSE: u32 = 4;

/// The way to ask for a reading.
pub struct Loader(SyncSender<()>);

impl Loader {
    /// Starts the thread.
    pub fn start(folder: PathBuf, sender: SyncSender<Msg>) -> Self {
        let (ask, asked) = sync_channel(1);
        thread::spawn(move || follow(&folder, &asked, &sender));
        Self(ask)
    }

    /// Reads the folder soon; one request waits at most.
    pub fn ask(&self) {
        match self.0.try_send(()) {
            Ok(()) | Err(TrySendError::Full(()) | TrySendError::Disconnected(())) => {}
        }
    }
}

fn follow(folder: &Path, asked: &Receiver<()>, sender: &SyncSender<Msg>) {
    // Before the reading: what changes meanwhile is met again.
    let mut seen = signature(folder);
    let mut store = Arc::new(Store::open(folder));
    if sender.send(Msg::Store(Arc::clone(&store))).is_err() {
        return;
    }
    give_back();
    let mut pause = PAUSE;
    loop {
        // Asked or not, a folder that did not change is not read again.
        if let Err(RecvTimeoutError::Disconnected) = asked.recv_timeout(pause) {
            return;
        }
        let now = signature(folder);
        if now == seen {
            continue;
        }
        let start = Instant::now();
        seen = now;
        // Screens keep theirs while the next is read: there are two only until they have it.
        Arc::make_mut(&mut store).refresh();
        if sender.send(Msg::Store(Arc::clone(&store))).is_err() {
            return;
        }
        give_back();
        pause = PAUSE.max(start.elapsed() * READINGS_A_PAUSE);
    }
}

/// Returns to the system what reading took and no longer needs: the allocator would keep it.
fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it may be called at any time, from any thread.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// What tells whether a folder changed, without reading its files: lengths and times.
type Signature = Result<BTreeMap<PathBuf, (u64, Option<SystemTime>)>, String>;

fn signature(folder: &Path) -> Signature {
    let entries = fs::read_dir(folder).map_err(|e| e.kind().to_string())?;
    let mut files = BTreeMap::new();
    for entry in entries.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|x| x == "jsonl")
            && let Ok(facts) = entry.metadata()
        {
            files.insert(path, (facts.len(), facts.modified().ok()));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_records::{RunHeader, Writer};
    use std::sync::mpsc::sync_channel;

    fn next(receiver: &Receiver<Msg>) -> Arc<Store> {
        match receiver.recv_timeout(Duration::from_secs(20)).unwrap() {
            Msg::Store(store) => store,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_written_deleted_and_brought_back_is_followed() {
        let at = tempfile::tempdir().unwrap();
        let folder = at.path().join("records");
        let (sender, receiver) = sync_channel(8);
        let loader = Loader::start(folder.clone(), sender);
        let first = next(&receiver);
        assert!(first.index.headers.is_empty() && first.trouble.is_none());

        let header = |run: &str| RunHeader {
            run: run.into(),
            sweep: "s".into(),
            sweep_hash: "h".into(),
            ..RunHeader::default()
        };
        drop(Writer::create(&folder, &header("a")).unwrap());
        assert_eq!(next(&receiver).index.headers.len(), 1);
        drop(Writer::create(&folder, &header("b")).unwrap());
        loader.ask();
        let mut now = next(&receiver);
        // The reading may have met the file before its first line.
        while now.index.headers.len() < 2 {
            now = next(&receiver);
        }
        fs::remove_dir_all(&folder).unwrap();
        while !now.index.headers.is_empty() {
            now = next(&receiver);
        }
        assert!(now.trouble.is_none(), "{:?}", now.trouble);
        // A file where the folder was: that is said, and what was read before is not lost.
        fs::write(&folder, "no folder").unwrap();
        assert!(next(&receiver).trouble.is_some());
    }
}
