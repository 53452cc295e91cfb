//! Every algorithm says what it is based on, and every key it cites is in `docs/references.bib`.

use dapple_suite::problems;
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn keys(bibliography: &str) -> BTreeSet<String> {
    bibliography
        .lines()
        .filter_map(|line| {
            Some(line.strip_prefix('@')?.split_once('{')?.1.trim_end_matches(',').into())
        })
        .collect()
}

fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
}

#[test]
fn every_technique_cites_a_known_source() {
    let known = keys(&fs::read_to_string(Path::new(ROOT).join("docs/references.bib")).unwrap());
    assert!(known.len() >= 10);
    let mut checked = 0;
    for problem in problems::ALL {
        for technique in problem.spec().techniques {
            checked += 1;
            assert!(
                known.contains(technique.source),
                "{}: `{}` is not in docs/references.bib",
                technique.id,
                technique.source
            );
        }
    }
    assert!(checked >= 15, "only {checked} techniques were seen");
    assert!(!known.contains("nobody1900"));
}

#[test]
fn every_estimator_opens_with_its_source() {
    let mut found = Vec::new();
    files(&Path::new(ROOT).join("crates/shadows/src/filtering/estimators"), "rs", &mut found);
    let support = ["mod.rs", "real.rs"];
    found.retain(|path| !support.iter().any(|s| path.ends_with(s)));
    assert!(found.len() >= 7, "only {} estimators were seen", found.len());
    for path in found {
        let text = fs::read_to_string(&path).unwrap();
        assert!(opens_with_source(&text), "{} does not say what it is based on", path.display());
    }
    assert!(!opens_with_source("//! A filter.\n\npub fn f() {}"));
}

fn opens_with_source(text: &str) -> bool {
    text.lines().take_while(|line| line.starts_with("//!")).any(|line| line.contains("Based on:"))
}
