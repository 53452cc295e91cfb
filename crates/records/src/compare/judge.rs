//! Whether two figures differ beyond threshold and noise.
//!
//! Based on: Christophe Croux, Peter J. Rousseeuw, "Time-efficient algorithms for two highly robust
//! estimators of scale", Computational Statistics 1, 1992, section 3: factors that make the MAD of
//! a few normal samples unbiased.

use std::collections::BTreeSet;

use super::{Change, CounterChange, ErrorChange, Options, Pair, TimeChange, Verdict};
use crate::row::{Row, Status};

/// Repeats that each side needs for a verdict on its time: two say nothing about their spread.
pub const LEAST_REPEATS: usize = 3;

/// Errors that differ by no more than this are the same, whatever their ratio: the last bits of
/// 32-bit arithmetic on values up to 1, which drivers round differently.
pub const ERROR_FLOOR: f64 = 1e-6;

/// Scaled MADs on either side of a change that noise alone explains.
const BAND_MADS: f64 = 3.0;

/// The MAD of a normal distribution times this is its standard deviation.
const MAD_TO_DEVIATION: f64 = 1.4826;

type Side<'a> = (Option<usize>, Option<&'a Row>);

/// Judges one pair; at least one side is there.
pub(super) fn judge((a, old): Side<'_>, (b, new): Side<'_>, options: &Options) -> Pair {
    let mut pair = Pair {
        old: a,
        new: b,
        time: None,
        errors: Vec::new(),
        counters: Vec::new(),
        changes: Vec::new(),
    };
    let (Some(old), Some(new)) = (old, new) else {
        pair.changes.push(match new.map(|row| &row.status) {
            None => Change::Gone,
            Some(Status::Failed { .. }) => Change::Failed,
            Some(_) => Change::New,
        });
        return pair;
    };
    match (&old.status, &new.status) {
        (Status::Ok, Status::Ok) => compare_results(&mut pair, old, new, options),
        (Status::Ok | Status::NotRun { .. }, Status::Failed { .. }) => {
            pair.changes.push(Change::Failed);
        }
        (Status::Ok | Status::Failed { .. }, Status::NotRun { .. }) => {
            pair.changes.push(Change::NotRun);
        }
        (Status::Failed { .. }, Status::Ok) => pair.changes.push(Change::Fixed),
        (Status::NotRun { .. }, Status::Ok) => pair.changes.push(Change::New),
        (Status::Failed { .. }, Status::Failed { .. })
        | (Status::NotRun { .. }, Status::NotRun { .. }) => {}
    }
    pair
}

fn compare_results(pair: &mut Pair, old: &Row, new: &Row, options: &Options) {
    pair.time = time(old, new, options);
    pair.errors = errors(old, new, options.threshold);
    pair.counters = counters(old, new, options.any_machine);
    let time = pair.time.as_ref().map(|t| t.verdict);
    let any = |verdicts: &[Verdict]| pair.errors.iter().any(|e| verdicts.contains(&e.verdict));
    for (change, happened) in [
        (Change::Slower, time == Some(Verdict::Worse)),
        (Change::Worse, any(&[Verdict::Worse, Verdict::Vanished])),
        (Change::Counters, !pair.counters.is_empty()),
        (Change::Better, any(&[Verdict::Better])),
        (Change::Faster, time == Some(Verdict::Better)),
    ] {
        if happened {
            pair.changes.push(change);
        }
    }
}

fn time(old: &Row, new: &Row, options: &Options) -> Option<TimeChange> {
    let (old_ns, new_ns) = (old.median_ns()?, new.median_ns()?);
    // Logarithms make up and down alike: a swap of the sides changes the sign and nothing else.
    let (log, band) = (new_ns.ln() - old_ns.ln(), band(old).hypot(band(new)));
    let because = if options.any_machine {
        "different machines may be joined"
    } else if old.clock != new.clock {
        "different clocks"
    } else if old.samples_ns.len().min(new.samples_ns.len()) < LEAST_REPEATS {
        "fewer than 3 repeats"
    } else if !log.is_finite() {
        "a median of 0 ns"
    } else {
        ""
    };
    let verdict = match log {
        _ if !because.is_empty() => Verdict::NotJudged,
        log if log.abs() <= options.threshold.ln_1p().max(band) => Verdict::Same,
        log if log > 0.0 => Verdict::Worse,
        _ => Verdict::Better,
    };
    let ratio = if log.is_finite() { new_ns / old_ns } else { f64::NAN };
    Some(TimeChange { old_ns, new_ns, ratio, band: band.exp_m1(), verdict, because })
}

/// [`BAND_MADS`] scaled MADs over the median; 0 where there is no time.
fn band(row: &Row) -> f64 {
    match (row.mad_ns(), row.median_ns()) {
        (Some(mad), Some(median)) if median > 0.0 => {
            let unbiased = MAD_TO_DEVIATION * small_sample_factor(row.samples_ns.len());
            BAND_MADS * unbiased * mad / median
        }
        _ => 0.0,
    }
}

/// What the MAD of `count` normal samples must be multiplied by on average.
fn small_sample_factor(count: usize) -> f64 {
    const FACTORS: [f64; 10] = [1.0, 1.0, 1.196, 1.495, 1.363, 1.206, 1.200, 1.140, 1.129, 1.107];
    FACTORS.get(count).copied().unwrap_or(count as f64 / (count as f64 - 0.8))
}

fn errors(old: &Row, new: &Row, threshold: f64) -> Vec<ErrorChange> {
    let names: BTreeSet<&String> = old.errors.keys().chain(new.errors.keys()).collect();
    names
        .into_iter()
        .map(|metric| {
            let (old, new) = (old.errors.get(metric).copied(), new.errors.get(metric).copied());
            let verdict = match (old, new) {
                (Some(old), Some(new)) => error(old, new, threshold),
                (Some(_), None) => Verdict::Vanished,
                (None, _) => Verdict::Appeared,
            };
            ErrorChange { metric: metric.clone(), old, new, verdict }
        })
        .collect()
}

/// The lesser error is the measure of the change, so that a swap of the sides swaps the verdict.
fn error(old: f64, new: f64, threshold: f64) -> Verdict {
    match (old.is_finite(), new.is_finite()) {
        (true, true) => {
            let same = (new - old).abs() <= threshold * old.abs().min(new.abs()) + ERROR_FLOOR;
            match same {
                true => Verdict::Same,
                false if new > old => Verdict::Worse,
                false => Verdict::Better,
            }
        }
        // What is not finite reads as NaN: worse than any number.
        (true, false) => Verdict::Worse,
        (false, true) => Verdict::Better,
        (false, false) => Verdict::Same,
    }
}

fn counters(old: &Row, new: &Row, any_machine: bool) -> Vec<CounterChange> {
    let names: BTreeSet<&String> = old.counters.keys().chain(new.counters.keys()).collect();
    let mut changes: Vec<CounterChange> = names
        .into_iter()
        .map(|name| CounterChange {
            name: name.clone(),
            old: old.counters.get(name).copied(),
            new: new.counters.get(name).copied(),
        })
        .collect();
    // Other threads and drivers need other buffers.
    if !any_machine {
        let (old, new) = (Some(old.memory_bytes), Some(new.memory_bytes));
        changes.push(CounterChange { name: "memory_bytes".into(), old, new });
    }
    changes.retain(|change| change.old != change.new);
    changes
}
