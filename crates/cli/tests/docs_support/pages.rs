//! The pages: README, ARCHITECTURE and everything in `docs/`.

use super::root;
use std::{fs, path::PathBuf};

/// A page.
pub struct Page {
    /// Path below the root, with forward slashes.
    pub name: String,
    pub path: PathBuf,
    pub text: String,
}

impl Page {
    pub fn of(name: &str, text: &str) -> Self {
        Self { name: name.into(), path: root().join(name), text: text.into() }
    }
}

/// Every page, in a fixed order.
pub fn all() -> Vec<Page> {
    let mut names = vec!["README.md".to_string(), "ARCHITECTURE.md".to_string()];
    let mut docs: Vec<String> = fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".md"))
        .map(|name| format!("docs/{name}"))
        .collect();
    docs.sort();
    names.extend(docs);
    assert!(names.len() >= 8, "only {names:?}");
    names
        .iter()
        .map(|name| Page::of(name, &fs::read_to_string(root().join(name)).unwrap()))
        .collect()
}

/// Whether a paragraph opens with the technique's name: "**`vsm`**".
pub fn has_paragraph(text: &str, technique: &str) -> bool {
    text.lines().any(|line| line.starts_with(&format!("**`{technique}`**")))
}
