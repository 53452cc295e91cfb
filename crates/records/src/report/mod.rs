//! One self-contained HTML page from records: no script, nothing loaded from elsewhere.
//!
//! The page is a pure function of [`Input`]. Time never stands without error, nor error without
//! time. What is long is cut at a stated length, and says so.

mod fronts;
mod header;
mod outcomes;
mod plot;
mod stress;

use crate::catalogue::ProblemInfo;
use crate::front::Key;
use crate::read::Read;
use crate::row::Row;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeMap;

const STYLE: &str = include_str!("style.css");

/// What goes into a page.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The records.
    pub read: &'a Read,
    /// Problems to report, in order; rows of others are counted and left out.
    pub problems: &'a [ProblemInfo],
    /// Pictures of results.
    pub triplets: &'a [Triplet],
    /// Sentences about pictures that could not be made.
    pub notes: &'a [String],
    /// When the page is made, RFC 3339.
    pub time: &'a str,
    /// The command that makes it again.
    pub command: &'a str,
}

/// Truth, result and error map of one setting on one case.
#[derive(Clone, Debug)]
pub struct Triplet {
    /// The front it belongs to.
    pub key: Key,
    /// Technique, variant, form.
    pub setting: String,
    /// Its figures: time and error.
    pub figures: String,
    /// PNG files: truth, result, error.
    pub png: [Vec<u8>; 3],
    /// Columns and rows.
    pub size: [u32; 2],
}

/// The page.
pub fn page(input: &Input<'_>) -> String {
    let known: Vec<(&ProblemInfo, Vec<&Row>)> = input
        .problems
        .iter()
        .map(|p| (p, input.read.rows.iter().filter(|r| r.problem == p.id).collect()))
        .collect();
    let body = html! {
        a.skip href="#content" { "Skip to the content" }
        header {
            h1 { "Dapple: what speed costs in accuracy" }
            p { "Made " time datetime=(input.time) { (input.time) } " by " code { (input.command) } "." }
        }
        nav aria-label="Contents" {
            ol {
                li { a href="#machines" { "Machines and runs" } }
                @for (problem, _) in &known {
                    li { a href={"#" (problem.id)} { (problem.title) } }
                }
                li { a href="#failures" { "What failed, was not run or not read" } }
                li { a href="#again" { "Commands" } }
            }
        }
        main id="content" {
            (header::machines(input.read))
            @for (problem, rows) in &known {
                (self::problem(input, problem, rows))
            }
            (outcomes::failures(input))
            (header::commands(input.read))
        }
    };
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Dapple report" }
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    }
    .into_string()
}

fn problem(input: &Input<'_>, problem: &ProblemInfo, rows: &[&Row]) -> Markup {
    let claims: Vec<_> = input.read.claims.iter().filter(|c| c.problem == problem.id).collect();
    let gates: Vec<_> = input.read.gates.iter().filter(|g| g.problem == problem.id).collect();
    let points: Vec<_> = input.read.stress.iter().filter(|s| s.problem == problem.id).collect();
    html! {
        section id=(problem.id) {
            h2 { (problem.title) }
            p { (problem.question) }
            p { strong { "Truth: " } (problem.truth) }
            (fronts::fronts(input, problem, rows))
            (stress::map(problem, &points))
            (outcomes::claims(problem, &claims))
            (outcomes::gates(problem, &gates))
        }
    }
}

/// Of items with one key the latest; of several at that time the last.
fn latest<'a, T, K: Ord>(
    items: &[&'a T],
    key: impl Fn(&'a T) -> K,
    time: impl Fn(&T) -> &str,
) -> BTreeMap<K, &'a T> {
    let mut latest: BTreeMap<K, &T> = BTreeMap::new();
    for &item in items {
        let kept = latest.entry(key(item)).or_insert(item);
        if time(item) >= time(kept) {
            *kept = item;
        }
    }
    latest
}

/// What a section without content says: the command that would fill it.
fn nothing(what: &str, command: &str) -> Markup {
    html! { p.nothing { "No " (what) " in these records: " code { (command) } " makes some." } }
}

#[cfg(test)]
mod tests;
