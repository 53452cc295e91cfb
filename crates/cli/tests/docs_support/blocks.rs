//! Generated blocks: finding, making again, comparing.

use super::{pictures, views};
use crate::common;
use std::path::Path;

const BEGIN: &str = "<!-- generated: ";
const END: &str = "<!-- end -->";

/// A generated block of a page.
pub struct Block {
    pub command: String,
    /// Between the marker lines.
    pub body: String,
    /// Markers included.
    pub whole: String,
}

impl Block {
    /// The block with another body.
    pub fn with(&self, body: &str) -> String {
        format!("{BEGIN}{} -->\n{body}\n{END}", self.command)
    }
}

/// Every block of a page.
pub fn find(text: &str) -> Result<Vec<Block>, String> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(BEGIN) {
        let from = &rest[at..];
        let (first, after) = from.split_once('\n').ok_or("a marker at the end of the page")?;
        let command = first.strip_prefix(BEGIN).and_then(|c| c.strip_suffix(" -->"));
        let command = command.ok_or_else(|| format!("`{first}` is not closed"))?.to_string();
        let length = after.find(END).ok_or_else(|| format!("`{command}` has no end"))?;
        if after[..length].contains(BEGIN) {
            return Err(format!("`{command}` has no end"));
        }
        let whole = &from[..first.len() + 1 + length + END.len()];
        found.push(Block { command, body: after[..length].trim().into(), whole: whole.into() });
        rest = &from[whole.len()..];
    }
    Ok(found)
}

/// What a command gave.
pub enum Made {
    Body(String),
    NotRun(String),
}

/// Runs a block's command in `folder`; links are those of a page of that name.
pub fn make(command: &str, folder: &Path, page: &str) -> Made {
    let (line, view) = command.split_once(" | ").map_or((command, None), |(l, v)| (l, Some(v)));
    let words: Vec<&str> = line.split_whitespace().collect();
    assert_eq!(words[0], "dapple", "`{command}` is not a command line of the program");
    let output = common::run(folder, &words[1..]);
    assert!(output.status.success(), "{line}: {}", common::said(&output));
    let printed = String::from_utf8(output.stdout.clone()).unwrap();
    let lines: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let printed = lines.join("\n").trim_end().to_string();
    if printed.is_empty() {
        return Made::NotRun(common::said(&output).lines().next().unwrap_or_default().into());
    }
    let body = match (view, pictures::folder(line)) {
        (Some(view), _) => views::markdown(view, &printed, folder),
        (None, Some(output)) => pictures::markdown(&output, &printed),
        (None, None) => format!("```text\n$ {line}\n{printed}\n```"),
    };
    // Written as seen from the root.
    Made::Body(if page.starts_with("docs/") { body.replace("](docs/", "](") } else { body })
}

/// The first line that differs, times left out; `None` if nothing does.
pub fn difference(kept: &str, made: &str) -> Option<String> {
    let (kept, made) = (normal(kept), normal(made));
    let missing = made.iter().find(|line| count(&made, line) > count(&kept, line));
    let extra = kept.iter().find(|line| count(&kept, line) > count(&made, line));
    match (missing, extra) {
        (None, None) => None,
        (missing, extra) => Some(format!("page: {extra:?}, program: {missing:?}")),
    }
}

fn count(lines: &[String], line: &str) -> usize {
    lines.iter().filter(|l| *l == line).count()
}

/// Lines without what time decides: durations with their spread and ratio, the device's name, the
/// mark of the front and who is dominated. Their order is that of times too, so lines are compared
/// as a multiset.
fn normal(text: &str) -> Vec<String> {
    text.lines().map(normal_line).filter(|line| !line.is_empty()).collect()
}

fn normal_line(line: &str) -> String {
    if line.trim_start().starts_with("time:") {
        return "time: ~".into();
    }
    if line.starts_with("dominated:") {
        return String::new();
    }
    let words: Vec<&str> = line.split_whitespace().filter(|word| *word != "*").collect();
    let number = |word: &&str| word.parse::<f64>().is_ok();
    let mut out: Vec<&str> = Vec::new();
    let mut i = 0;
    while i < words.len() {
        let unit = words.get(i + 1).is_some_and(|unit| ["ns", "µs", "ms", "s"].contains(unit));
        if number(&words[i]) && unit {
            i += 2;
            // The spread in per cent and the ratio to the baseline come next.
            if words.get(i).is_some_and(|word| word.ends_with('%')) {
                i += 1;
                i += usize::from(words.get(i).is_some_and(number));
            }
            out.push("~");
        } else {
            out.push(words[i]);
            i += 1;
        }
    }
    out.join(" ")
}
