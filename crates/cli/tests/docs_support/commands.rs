//! Command lines of the program that pages show.

use crate::common;
use dapple_suite::problems;
use std::{collections::BTreeMap, path::Path};

/// Verbs with their help, as the program prints it.
pub struct Known {
    help: BTreeMap<String, String>,
}

impl Known {
    pub fn new() -> Self {
        let help = |words: &[&str]| {
            let output = common::run(Path::new("."), words);
            String::from_utf8(output.stdout).unwrap()
        };
        let mut known = BTreeMap::new();
        for verb in verbs(&help(&["--help"])) {
            let text = help(&[&verb, "--help"]);
            for inner in verbs(&text) {
                known.insert(format!("{verb} {inner}"), help(&[&verb, &inner, "--help"]));
            }
            known.insert(verb, text);
        }
        assert!(known.len() >= 9, "{:?}", known.keys());
        Self { help: known }
    }

    /// What is wrong with a command line, if anything. Words in capitals stand for anything.
    pub fn objection(&self, command: &str) -> Option<String> {
        let words: Vec<&str> = command.split_whitespace().skip(1).collect();
        let verb = words.first().filter(|word| !word.starts_with('-'))?;
        if placeholder(verb) {
            return None;
        }
        let Some(mut help) = self.help.get(*verb) else {
            // A hidden verb has help, though the list of verbs does not name it.
            let hidden = common::run(Path::new("."), &[verb, "--help"]).status.success();
            return (!hidden).then(|| format!("no verb {verb}"));
        };
        let inner = !verbs(help).is_empty();
        if inner {
            let name = words.get(1).copied().unwrap_or_default();
            match self.help.get(&format!("{verb} {name}")) {
                Some(text) => help = text,
                None => return Some(format!("no verb {verb} {name}")),
            }
        }
        let mut positional: Vec<&str> = Vec::new();
        let mut arguments = words[1 + usize::from(inner)..].iter();
        while let Some(word) = arguments.next() {
            if !word.starts_with('-') {
                positional.push(word);
                continue;
            }
            let flag = word.split('=').next().unwrap_or_default();
            let Some(line) = help.lines().find(|line| names(line, flag)) else {
                return Some(format!("no flag {flag}"));
            };
            if line.contains('<') {
                let value = arguments.next().copied().unwrap_or_default();
                let wrong = match flag {
                    "--scene" => scene(value),
                    "--technique" => technique(value),
                    _ => None,
                };
                if wrong.is_some() {
                    return wrong;
                }
            }
        }
        let about_problems = ["list", "measure", "front", "verify", "claims", "render"];
        if !about_problems.contains(verb) {
            return None;
        }
        let unknown = positional.first().filter(|p| !placeholder(p) && problems::find(p).is_err());
        if let Some(problem) = unknown {
            return Some(format!("no problem {problem}"));
        }
        positional.get(1).and_then(|t| technique(t))
    }
}

fn placeholder(word: &str) -> bool {
    word.chars().all(|c| c.is_uppercase() || !c.is_alphabetic())
}

fn technique(word: &str) -> Option<String> {
    let (id, variant) = word.split_once('/').unwrap_or((word, "*"));
    let known = problems::ALL.iter().flat_map(|p| p.spec().techniques).filter(|t| t.id == id);
    let fits = known.flat_map(|t| t.variants).any(|v| variant == "*" || v.id == variant);
    (!placeholder(id) && !fits).then(|| format!("no technique {word}"))
}

fn scene(word: &str) -> Option<String> {
    let file = word.contains(['.', ':', '/']) || placeholder(word);
    let known = dapple_scene::generate::NAMES.iter().any(|(name, _)| *name == word);
    (!file && !known && word != "crown").then(|| format!("no scene {word}"))
}

/// Whether a line of help is about that flag.
fn names(line: &str, flag: &str) -> bool {
    line.trim_start().starts_with('-') && line.split([' ', ',']).any(|word| word == flag)
}

/// Names below `Commands:` in a help text.
fn verbs(help: &str) -> Vec<String> {
    let after = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    after
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| Some(line.split_whitespace().next()?.to_string()))
        .filter(|name| name != "help")
        .collect()
}

/// Every command line of a page: lines of code blocks, and code spans.
pub fn of(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if fenced {
            found.extend(command(line.trim_start().trim_start_matches("$ ")));
        } else {
            found.extend(line.split('`').skip(1).step_by(2).filter_map(command));
        }
    }
    found
}

/// A command line without its comment; `cargo run --release --` stands for the program.
fn command(line: &str) -> Option<String> {
    let line = line.split("  ").next().unwrap_or_default().trim();
    let cargo = line.strip_prefix("cargo run").and_then(|rest| rest.split_once(" -- "));
    let line = cargo.map_or(line.to_string(), |(_, arguments)| format!("dapple {arguments}"));
    line.starts_with("dapple ").then_some(line)
}
