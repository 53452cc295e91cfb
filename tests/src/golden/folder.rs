//! The folder of references: nothing may be missing from it, and nothing may be left in it.

use super::Picture;
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// `fixtures/goldens/`.
pub fn goldens_folder() -> PathBuf {
    Path::new(ROOT).join("fixtures/goldens")
}

/// `target/golden-failures/`.
pub fn failures_folder() -> PathBuf {
    Path::new(ROOT).join("target/golden-failures")
}

/// The reference `name` of a folder.
///
/// # Errors
/// That it is missing, or what is wrong with it.
pub fn reference(folder: &Path, name: &str) -> Result<Picture, String> {
    let path = folder.join(format!("{name}.snap.png"));
    let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Picture::from_png(&bytes)
}

/// What is wrong with a folder that should hold exactly the goldens of these names: `missing: FILE`
/// and `stale: FILE`, in order. Files that insta has set aside for review are passed over: the test
/// that set them aside has failed.
///
/// # Panics
/// For a name that is there twice.
pub fn audit<'a>(folder: &Path, names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut expected = BTreeSet::new();
    for name in names {
        for ending in ["snap", "snap.png"] {
            assert!(expected.insert(format!("{name}.{ending}")), "two goldens are named {name}");
        }
    }
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let found: BTreeSet<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| !name.contains(".snap.new"))
        .collect();
    let missing = expected.difference(&found).map(|name| format!("missing: {name}"));
    let stale = found.difference(&expected).map(|name| format!("stale: {name}"));
    missing.chain(stale).collect()
}
