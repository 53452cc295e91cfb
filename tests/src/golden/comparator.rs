//! The comparison as insta asks for it, and what it leaves behind for people.

use super::{Picture, Tolerance, compare, compare::Deviation};
use insta::{Comparator, Snapshot, internals::SnapshotContents};
use std::{fs, path::PathBuf};

/// Compares pictures within a tolerance and writes those that fail.
#[derive(Clone, Debug)]
pub struct Tolerant {
    /// What is compared, for messages and files of failures.
    pub name: String,
    /// What it must keep.
    pub tolerance: Tolerance,
    /// Where expected, difference and actual are written.
    pub failures: PathBuf,
}

impl Comparator for Tolerant {
    fn matches(&self, reference: &Snapshot, test: &Snapshot) -> bool {
        let actual = picture(test).expect("the test made a PNG");
        self.judge(picture(reference), &actual)
    }

    fn dyn_clone(&self) -> Box<dyn Comparator> {
        Box::new(self.clone())
    }
}

impl Tolerant {
    /// Whether `actual` is within the tolerance of `expected`, which may be unreadable. Says what
    /// differs, and writes pictures of it, where it is not.
    pub fn judge(&self, expected: Result<Picture, String>, actual: &Picture) -> bool {
        let deviation = match &expected {
            Ok(expected) => compare(expected, actual, self.tolerance),
            Err(why) => Deviation::Unreadable(why.clone()),
        };
        let within = deviation.is_within(self.tolerance);
        if within {
            self.forget();
        } else {
            eprintln!("{}: {deviation} (tolerance `{}`)", self.name, self.tolerance.name);
            self.write(expected.ok().as_ref(), actual);
        }
        within
    }

    fn path(&self, what: &str) -> PathBuf {
        self.failures.join(format!("{}-{what}.png", self.name))
    }

    /// Removes what an earlier failure left.
    fn forget(&self) {
        for what in ["expected", "diff", "actual"] {
            // Most often there is none.
            let _ = fs::remove_file(self.path(what));
        }
    }

    fn write(&self, expected: Option<&Picture>, actual: &Picture) {
        fs::create_dir_all(&self.failures).expect("a folder for failures");
        let save = |what: &str, picture: &Picture| {
            fs::write(self.path(what), picture.to_png()).expect("a picture of the failure");
        };
        save("actual", actual);
        let Some(expected) = expected else { return };
        save("expected", expected);
        if (expected.width, expected.height) == (actual.width, actual.height) {
            // Eightfold, so that a difference of a few codes is seen.
            let strength = |(a, b): (&u8, &u8)| a.abs_diff(*b).saturating_mul(8);
            let codes = expected.codes.iter().zip(&actual.codes).map(strength).collect();
            save("diff", &Picture { codes, ..actual.clone() });
        }
        eprintln!("{}: pictures in {}", self.name, self.failures.display());
    }
}

fn picture(snapshot: &Snapshot) -> Result<Picture, String> {
    match snapshot.contents() {
        SnapshotContents::Binary(Some(bytes)) => Picture::from_png(bytes),
        SnapshotContents::Binary(None) => Err("its PNG file is missing".into()),
        SnapshotContents::Text(_) => Err("it is a text".into()),
    }
}
