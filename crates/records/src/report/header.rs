//! What was measured where, and how to do it again.

use crate::line::RunHeader;
use crate::read::Read;
use crate::text;
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// Runs listed at most; the newest are kept.
const MOST_RUNS: usize = 100;

/// Machines, adapters and runs.
pub fn machines(read: &Read) -> Markup {
    let mut adapters: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for row in read.rows.iter().filter(|r| !["cpu", "none", "unknown"].contains(&&*r.device)) {
        let name = format!("{} ({}), driver {}", row.adapter, row.device, row.driver);
        adapters.entry(&row.machine).or_default().insert(name);
    }
    let mut machines: BTreeMap<&str, &RunHeader> = BTreeMap::new();
    for header in &read.headers {
        machines.insert(&header.machine, header);
    }
    let runs = newest(read);
    html! {
        section id="machines" {
            h2 { "Machines and runs" }
            @if machines.is_empty() { p.nothing { "No runs in these records." } }
            @for (id, header) in &machines {
                h3 { "Machine " (id) }
                ul {
                    li { (header.cpu) ", " (header.threads) " threads" }
                    @if header.memory_bytes > 0 { li { (text::bytes(header.memory_bytes)) " of memory" } }
                    li { (header.os) }
                    @for adapter in adapters.get(id).into_iter().flatten() { li { (adapter) } }
                    @if !adapters.contains_key(id) { li { "no rows by a graphics adapter" } }
                }
            }
            @if !runs.is_empty() {
                div.scroll tabindex="0" { table {
                    caption {
                        "Runs"
                        @if read.headers.len() > runs.len() {
                            ", the newest " (runs.len()) " of " (read.headers.len())
                        }
                    }
                    thead { tr {
                        th scope="col" { "began" } th scope="col" { "what" } th scope="col" { "machine" }
                        th scope="col" { "revision" } th scope="col" { "state" }
                    } }
                    tbody { @for run in runs { tr {
                        td.w { (run.time) }
                        td { (run.sweep) @if !run.shard.is_empty() { " (part " (run.shard) ")" } }
                        td { (run.machine) }
                        td { (run.revision) @if run.dirty { " with changes" } }
                        td { @if read.ended.contains(&run.run) { "complete" } @else { span.bad { "unfinished" } } }
                    } } }
                } }
            }
        }
    }
}

/// Every command line that left these records.
pub fn commands(read: &Read) -> Markup {
    let mut seen = BTreeSet::new();
    let commands: Vec<_> =
        newest(read).into_iter().map(|h| &h.command).filter(|c| seen.insert(*c)).collect();
    html! {
        section id="again" {
            h2 { "Commands" }
            p { "These left the records; given again, they measure again." }
            ul { @for command in commands { li { code { (command) } } } }
        }
    }
}

fn newest(read: &Read) -> Vec<&RunHeader> {
    let mut runs: Vec<_> = read.headers.iter().collect();
    runs.sort_by(|a, b| b.time.cmp(&a.time).then(a.run.cmp(&b.run)));
    runs.truncate(MOST_RUNS);
    runs
}
