//! What was read of each file, so that only what was appended is read again.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::read::scan::Ending;

/// Bytes at the beginning, and before the end of what was read, that must not have changed.
const GUARD: usize = 512;

/// One file of the index.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub path: PathBuf,
    /// Bytes read.
    pub length: u64,
    /// Lines read.
    pub lines: usize,
    pub ending: Ending,
    stamp: Stamp,
    guard: [u8; 32],
}

/// What tells one file from another of the same name.
#[derive(Clone, Debug, Default, PartialEq)]
struct Stamp {
    changed: Option<SystemTime>,
    node: (u64, u64),
}

/// How a file stands to what was read of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum News {
    None,
    Appended,
    /// Shorter, another file, or written over.
    Other,
}

impl Known {
    /// A file about to be read: no further than it reaches now.
    pub(crate) fn open(path: &Path) -> io::Result<(Self, File)> {
        let mut file = File::open(path)?;
        let about = file.metadata()?;
        let length = about.len();
        let guard = guard(&mut file, length)?;
        let (path, stamp) = (path.to_path_buf(), Stamp::of(&about));
        let known = Self { path, length, lines: 0, ending: Ending::Whole, stamp, guard };
        Ok((known, file))
    }

    pub(crate) fn news(&self) -> io::Result<News> {
        let about = std::fs::metadata(&self.path)?;
        let stamp = Stamp::of(&about);
        if about.len() < self.length || stamp.node != self.stamp.node {
            return Ok(News::Other);
        }
        if about.len() == self.length {
            return Ok(if stamp == self.stamp { News::None } else { News::Other });
        }
        let same = guard(&mut File::open(&self.path)?, self.length)? == self.guard;
        Ok(if same { News::Appended } else { News::Other })
    }

    /// Where to read on, and the number of that line; none where only a full read is right.
    pub(crate) fn resume(&self) -> Option<(u64, usize)> {
        match self.ending {
            Ending::Whole => Some((self.length, self.lines + 1)),
            Ending::Torn { offset, line, .. } => Some((offset, line)),
            Ending::Open => None,
        }
    }
}

impl Stamp {
    fn of(about: &Metadata) -> Self {
        #[cfg(unix)]
        let node = {
            use std::os::unix::fs::MetadataExt;
            (about.dev(), about.ino())
        };
        #[cfg(not(unix))]
        let node = (0, 0);
        Self { changed: about.modified().ok(), node }
    }
}

/// A hash of the first and last bytes of the first `length`. Leaves the file at its beginning.
fn guard(file: &mut File, length: u64) -> io::Result<[u8; 32]> {
    let mut hash = blake3::Hasher::new();
    for start in [0, length.saturating_sub(GUARD as u64)] {
        file.seek(SeekFrom::Start(start))?;
        let mut bytes = Vec::with_capacity(GUARD);
        file.by_ref().take((length - start).min(GUARD as u64)).read_to_end(&mut bytes)?;
        hash.update(&bytes);
    }
    file.seek(SeekFrom::Start(0))?;
    Ok(*hash.finalize().as_bytes())
}
