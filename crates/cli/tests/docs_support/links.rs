//! Links between pages, and paths named in them.

use super::{pages::Page, root};
use std::path::Path;

/// First parts of paths that are meant to exist when they stand in `code`.
const FOLDERS: [&str; 8] =
    ["crates/", "docs/", "shaders/", "benches/", "tests/", "fixtures/", ".ci/", "target/"];

/// How many links and paths there are, and those that lead nowhere.
pub fn broken(page: &Page) -> (usize, Vec<String>) {
    let base = page.path.parent().unwrap_or(Path::new(""));
    let (mut count, mut broken) = (0, Vec::new());
    for target in targets(&page.text) {
        if target.contains("://") || target.starts_with('#') {
            continue;
        }
        count += 1;
        let file = target.split('#').next().unwrap_or_default();
        if !base.join(file).exists() {
            broken.push(format!("{}: link to {target}", page.name));
        }
    }
    for path in paths(&page.text) {
        count += 1;
        if !root().join(&path).exists() {
            broken.push(format!("{}: path {path}", page.name));
        }
    }
    (count, broken)
}

/// `target` of every `[text](target)`.
fn targets(text: &str) -> Vec<String> {
    let after = text.split("](").skip(1);
    after.filter_map(|rest| Some(rest.split_once(')')?.0.to_string())).collect()
}

/// Code spans that are paths below the root. Those with a placeholder in capitals or a pattern are
/// not, nor what a build makes.
fn paths(text: &str) -> Vec<String> {
    let spans = text.lines().flat_map(|line| line.split('`').skip(1).step_by(2));
    spans
        .map(|span| span.split("::").next().unwrap_or_default().trim_end_matches('/'))
        .filter(|span| FOLDERS.iter().any(|f| span.starts_with(f)) && !span.starts_with("target/"))
        .filter(|span| !span.contains([' ', '*', '{', '<']))
        .filter(|span| {
            !span
                .split(['/', '.'])
                .any(|part| part.len() > 2 && part.chars().all(|c| c.is_uppercase() || c == '_'))
        })
        .map(ToString::to_string)
        .collect()
}
