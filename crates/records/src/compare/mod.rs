//! Two sets of rows, paired row by row: what got faster, slower, better or worse beyond noise.
//!
//! Rows are the same work if their identity ([`Row::identity`]) and their machine and processor are
//! the same. Of rows of one identity the latest counts ([`crate::front::latest`]). A row that died
//! before its case was prepared knows neither adapter nor truth; it is paired by its setting and
//! its case's name.
//!
//! Repeats of two runs share no drift, so they are not paired one by one: a time's ratio is that of
//! the two medians over repeats, and it changed only if it left both the threshold and the band
//! that the spread of the repeats explains (see [`TimeChange`]).

mod join;
mod judge;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::row::Row;

pub use judge::{ERROR_FLOOR, LEAST_REPEATS};

/// What counts as a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative change up to which times and errors are the same, e.g. 0.05; finite, at least 0.
    pub threshold: f64,
    /// Also pair rows of different machines, processors, adapters, drivers and thread counts.
    /// Times are then shown and never judged, nor is memory compared.
    pub any_machine: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { threshold: 0.05, any_machine: false }
    }
}

/// What happened to a row, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// It fails now, and did not before (or is new and fails).
    Failed,
    /// It was there before and is there no more.
    Gone,
    /// Its time rose beyond threshold and noise.
    Slower,
    /// An error rose beyond the threshold, or is measured no more.
    Worse,
    /// A counter changed, came or went.
    Counters,
    /// It had a result before and is now left out, e.g. for want of an adapter.
    NotRun,
    /// It is there now and was not before, or was left out.
    New,
    /// It failed before and does no more.
    Fixed,
    /// An error fell beyond the threshold.
    Better,
    /// Its time fell beyond threshold and noise.
    Faster,
}

impl Change {
    /// All, worst first.
    pub const ALL: [Self; 10] = [
        Self::Failed,
        Self::Gone,
        Self::Slower,
        Self::Worse,
        Self::Counters,
        Self::NotRun,
        Self::New,
        Self::Fixed,
        Self::Better,
        Self::Faster,
    ];

    /// One or two words, for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Failed => "fails",
            Self::Gone => "gone",
            Self::Slower => "slower",
            Self::Worse => "worse",
            Self::Counters => "counters",
            Self::NotRun => "not run",
            Self::New => "new",
            Self::Fixed => "fixed",
            Self::Better => "better",
            Self::Faster => "faster",
        }
    }
}

/// How one figure changed; less is better for times and errors alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Not beyond threshold and noise.
    Same,
    /// Fell.
    Better,
    /// Rose.
    Worse,
    /// Only the new side has it.
    Appeared,
    /// Only the old side has it.
    Vanished,
    /// Shown, and no verdict possible.
    NotJudged,
}

/// Two times of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeChange {
    /// Median over repeats before.
    pub old_ns: f64,
    /// Median over repeats after.
    pub new_ns: f64,
    /// `new_ns / old_ns`; NaN if a median is 0.
    pub ratio: f64,
    /// Relative change that the spread of the repeats explains, at least 0: with `s` the scaled
    /// MAD over the median of each side, `exp(3 hypot(s_old, s_new)) - 1`. A ratio above
    /// `1 + band`, or below `1 / (1 + band)`, is outside.
    pub band: f64,
    /// [`Verdict::Same`], [`Verdict::Better`] (faster), [`Verdict::Worse`] (slower) or
    /// [`Verdict::NotJudged`].
    pub verdict: Verdict,
    /// Why there is no verdict; empty if there is one.
    pub because: &'static str,
}

/// One error metric of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorChange {
    /// Its name.
    pub metric: String,
    /// Before; `None` if not measured.
    pub old: Option<f64>,
    /// After; `None` if not measured.
    pub new: Option<f64>,
    /// How it changed; never [`Verdict::NotJudged`].
    pub verdict: Verdict,
}

/// One counter of one row, and it changed: those that did not are left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CounterChange {
    /// Its name; `memory_bytes` for the row's memory.
    pub name: String,
    /// Before; `None` if not counted.
    pub old: Option<u64>,
    /// After; `None` if not counted.
    pub new: Option<u64>,
}

/// One row before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Position in the old rows; `None` for a new row.
    pub old: Option<usize>,
    /// Position in the new rows; `None` for a row that is gone.
    pub new: Option<usize>,
    /// Times, where both sides are timed.
    pub time: Option<TimeChange>,
    /// Every error metric of both sides, changed or not, by name; empty unless both are ok.
    pub errors: Vec<ErrorChange>,
    /// Counters that changed, by name; empty unless both sides are ok.
    pub counters: Vec<CounterChange>,
    /// What happened, worst first; empty if nothing did.
    pub changes: Vec<Change>,
}

/// The outcome.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Every row of both sides that counts and was not refused, worst first; the order depends on
    /// what the rows say, not on where they stand.
    pub pairs: Vec<Pair>,
    /// Rows that only [`Options::any_machine`] would pair, for people: one sentence for each two
    /// places, with how many.
    pub refused: Vec<String>,
    /// Old rows left out because a later one measured the same.
    pub superseded_old: usize,
    /// New rows left out because a later one measured the same.
    pub superseded_new: usize,
}

/// The times of a comparison in one figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSummary {
    /// Pairs with a ratio.
    pub count: usize,
    /// Geometric mean of the ratios: 1 is no change, 2 twice as slow.
    pub geometric_mean: f64,
    /// Geometric standard deviation of the ratios, at least 1: most lie within the mean times and
    /// over this factor.
    pub spread: f64,
}

impl Pair {
    /// Whether anything happened.
    pub fn is_changed(&self) -> bool {
        !self.changes.is_empty()
    }
}

impl Comparison {
    /// Pairs that have both sides.
    pub fn joined(&self) -> usize {
        self.pairs.iter().filter(|p| p.old.is_some() && p.new.is_some()).count()
    }

    /// How many pairs each change happened to; one pair may count in several.
    pub fn counts(&self) -> BTreeMap<Change, usize> {
        let mut counts = BTreeMap::new();
        for change in self.pairs.iter().flat_map(|p| &p.changes) {
            *counts.entry(*change).or_insert(0) += 1;
        }
        counts
    }

    /// The ratios of all pairs together; `None` without any. It weighs every row alike, however
    /// long it takes and whatever it errs: a summary of drift, not a rank.
    pub fn times(&self) -> Option<TimeSummary> {
        let ratios = self.pairs.iter().filter_map(|p| p.time.as_ref().map(|t| t.ratio.ln()));
        let logs: Vec<f64> = ratios.filter(|log| log.is_finite()).collect();
        let count = logs.len();
        if count == 0 {
            return None;
        }
        let mean = logs.iter().sum::<f64>() / count as f64;
        let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / count as f64;
        Some(TimeSummary { count, geometric_mean: mean.exp(), spread: variance.sqrt().exp() })
    }
}

/// Pairs the rows and judges each pair. Positions in the result are positions in these slices.
pub fn compare(old: &[Row], new: &[Row], options: &Options) -> Comparison {
    let joined = join::join(old, new, options.any_machine);
    let mut pairs: Vec<(Pair, String)> = joined
        .pairs
        .into_iter()
        .map(|(a, b)| {
            let (before, after) = (a.map(|i| &old[i]), b.map(|i| &new[i]));
            let pair = judge::judge((a, before), (b, after), options);
            // At least one side is there.
            let label = after.or(before).map(join::label).unwrap_or_default();
            (pair, label)
        })
        .collect();
    pairs.sort_by(|(a, a_label), (b, b_label)| {
        // No change sorts behind every change.
        let worst = |pair: &Pair| pair.changes.first().copied();
        let order = match (worst(a), worst(b)) {
            (Some(a), Some(b)) => a.cmp(&b),
            (a, b) => b.is_some().cmp(&a.is_some()),
        };
        let size = |pair: &Pair| pair.time.as_ref().map_or(0.0, |t| t.ratio.ln().abs());
        order.then_with(|| size(b).total_cmp(&size(a))).then_with(|| a_label.cmp(b_label))
    });
    Comparison {
        pairs: pairs.into_iter().map(|(pair, _)| pair).collect(),
        refused: joined.refused,
        superseded_old: joined.superseded_old,
        superseded_new: joined.superseded_new,
    }
}
