//! Claims, gates, and everything that did not work.

use super::{Input, latest, nothing};
use crate::catalogue::ProblemInfo;
use crate::claim::ClaimLine;
use crate::gate::GateLine;
use crate::row::Status;
use crate::text::significant;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// Reasons listed at most.
const MOST_REASONS: usize = 100;

/// Verdicts of one problem's claims, the latest of each on each machine.
pub fn claims<'a>(problem: &ProblemInfo, claims: &[&'a ClaimLine]) -> Markup {
    let key = |c: &'a ClaimLine| (&*c.id, &*c.machine, &*c.adapter);
    let latest = latest(claims, key, |c| &c.time);
    let machines = latest.keys().map(|k| (k.1, k.2)).collect::<std::collections::BTreeSet<_>>();
    html! {
        h3 { "Claims" }
        @if latest.is_empty() {
            (nothing("verdicts", &format!("dapple claims {}", problem.id)))
        } @else {
            p { (count(latest.values().map(|c| &*c.verdict))) }
            div.scroll tabindex="0" { table {
                thead { tr {
                    th scope="col" { "claim" } th scope="col" { "verdict" } th scope="col" { "statement and figures" }
                    @if machines.len() > 1 { th scope="col" { "machine, adapter" } }
                } }
                tbody { @for claim in latest.values() { tr {
                    th.w scope="row" { (claim.id) }
                    td.w { (verdict(&claim.verdict)) }
                    td { (figures(claim)) }
                    @if machines.len() > 1 { td { (claim.machine) ", " (claim.adapter) } }
                } } }
            } }
        }
    }
}

fn figures(claim: &ClaimLine) -> Markup {
    html! {
        details {
            summary { (claim.statement) }
            p { strong { "Source: " } (claim.place) }
            p { strong { "Judged: " } (claim.method) }
            @if !claim.figures.is_empty() {
                table {
                    thead { tr { th scope="col" { "figure" } th.n scope="col" { "value" } th scope="col" { "unit" } } }
                    tbody { @for figure in &claim.figures { tr {
                        td { (figure.what) } td.n { (significant(figure.value)) } td { (figure.unit) }
                    } } }
                }
            }
            p { strong { "Because: " } (claim.because) }
        }
    }
}

/// The word is the verdict; colour only repeats it.
fn verdict(verdict: &str) -> Markup {
    let class = match verdict {
        "reproduced" | "passed" => "good",
        "refuted" | "error" | "failed" | "control-missed" | "nothing-checked" => "bad",
        _ => "dim",
    };
    html! { span class=(class) { (verdict) } }
}

fn count<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    words.for_each(|word| *counts.entry(word).or_default() += 1);
    let words: Vec<_> = counts.iter().map(|(word, n)| format!("{n} {word}")).collect();
    words.join(", ")
}

/// The gates of one problem: a sentence, and a table of those that did not pass.
pub fn gates<'a>(problem: &ProblemInfo, gates: &[&'a GateLine]) -> Markup {
    let key = |g: &'a GateLine| [&*g.technique, &g.gate, &g.machine, &g.adapter];
    let latest = latest(gates, key, |g| &g.time);
    let checked: u64 = latest.values().map(|g| g.checked).sum();
    let odd: Vec<_> = latest.values().filter(|g| g.outcome != "passed").collect();
    html! {
        h3 { "Gates" }
        @if latest.is_empty() {
            (nothing("gates", &format!("dapple verify {}", problem.id)))
        } @else {
            p { (count(latest.values().map(|g| &*g.outcome))) "; " (checked) " checks." }
            @if !odd.is_empty() {
                div.scroll tabindex="0" { table {
                    thead { tr {
                        th scope="col" { "technique" } th scope="col" { "gate" } th scope="col" { "outcome" }
                        th scope="col" { "what holds" } th scope="col" { "detail" }
                    } }
                    tbody { @for gate in odd.iter().take(MOST_REASONS) { tr {
                        td { (gate.technique) } td { (gate.gate) } td.w { (verdict(&gate.outcome)) }
                        td { (gate.statement) } td { (gate.detail) }
                    } } }
                } }
                @if odd.len() > MOST_REASONS { p.dim { (odd.len() - MOST_REASONS) " more." } }
            }
        }
    }
}

/// Rows without a result, lines not read, pictures not made.
pub fn failures(input: &Input<'_>) -> Markup {
    let read = input.read;
    let mut reasons: BTreeMap<(&str, &str), Vec<String>> = BTreeMap::new();
    for row in &read.rows {
        let (word, reason) = match &row.status {
            Status::Ok => continue,
            Status::Failed { reason, .. } => ("failed", reason),
            Status::NotRun { reason } => ("not run", reason),
        };
        let who = format!("{} {}/{} ({})", row.case, row.technique, row.variant, row.form);
        reasons.entry((word, reason)).or_default().push(who);
    }
    let known = |id: &str| input.problems.iter().any(|p| p.id == id);
    let foreign = read.rows.iter().filter(|r| !known(&r.problem)).count();
    let mut skipped: BTreeMap<&str, usize> = BTreeMap::new();
    read.skipped.iter().for_each(|s| *skipped.entry(&s.reason).or_default() += 1);
    let fine = reasons.is_empty() && skipped.is_empty() && foreign == 0 && input.notes.is_empty();
    html! {
        section id="failures" {
            h2 { "What failed, was not run or not read" }
            @if fine { p { "Nothing." } }
            @if foreign > 0 { p { (foreign) " rows belong to problems that this page leaves out." } }
            @for note in input.notes { p { (note) } }
            @if !reasons.is_empty() {
                div.scroll tabindex="0" { table {
                    thead { tr {
                        th scope="col" { "outcome" } th.n scope="col" { "rows" } th scope="col" { "reason" }
                        th scope="col" { "first" }
                    } }
                    tbody { @for ((word, reason), who) in reasons.iter().take(MOST_REASONS) { tr {
                        td.w { (word) } td.n { (who.len()) } td { (reason) } td { (who[0]) }
                    } } }
                } }
                @if reasons.len() > MOST_REASONS { p.dim { (reasons.len() - MOST_REASONS) " more reasons." } }
            }
            @if !skipped.is_empty() {
                p { (read.skipped.len()) " lines were not read:" }
                ul { @for (reason, n) in skipped.iter().take(MOST_REASONS) { li { (n) ": " (reason) } } }
            }
        }
    }
}
