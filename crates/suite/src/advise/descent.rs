//! The search within one candidate, written as if every answer were known.
//!
//! A step that needs an unknown answer returns the points it needs; once they are measured the same
//! search runs again from its beginning, over what is known by then, and comes further. So the
//! candidates advance side by side and are measured in one batch.

use super::{
    goal::{Goal, Score},
    space::{Candidate, Dial, Point},
};
use crate::knob::Accuracy;
use std::collections::BTreeMap;

/// Points that must be measured before the search can go on.
pub(super) type Need = Vec<Point>;

/// Share of a range to step over: the golden section.
const GOLDEN: f64 = 0.381_966;

/// A neighbour may become good enough by tuning if its error is within this factor of what is wanted.
const TUNABLE: f64 = 1.6;

/// Errors closer than this share lie on a plateau.
const FLAT: f64 = 0.02;

/// A knob costs time where a step multiplies it by this.
const DEARER: f64 = 1.5;

/// Turns over all knobs before a search is content.
const MOST_TURNS: usize = 4;

/// What is known of a candidate; `None` for what failed.
pub(super) type Known = BTreeMap<Point, Option<Score>>;

/// A candidate, what is known of it, and what is wanted.
pub(super) struct Descent<'a> {
    pub candidate: &'a Candidate,
    pub known: &'a Known,
    pub goal: Goal,
    /// Least time at which anybody meets the goal so far.
    pub lead_ns: Option<f64>,
}

impl Descent<'_> {
    /// From `at`, each knob in turn: first those that tune, then those that buy accuracy.
    fn once(&self, at: &Point) -> Result<Point, Need> {
        let mut at = at.clone();
        self.get(&at)?;
        for (i, _) in self.dials(false) {
            at = self.line(&at, i, true)?;
        }
        for (i, _) in self.dials(true) {
            at = match self.goal {
                // Without a limit there is no rung to look for.
                Goal::Knee => self.line(&at, i, true)?,
                _ => self.ladder(&at, i)?,
            };
        }
        Ok(at)
    }

    /// From the defaults, twice: the first turn chose its map before anything was tuned for it.
    pub fn sketch(&self) -> Result<Point, Need> {
        self.once(&self.once(&self.candidate.defaults())?)
    }

    /// [`Descent::once`] and the diagonal steps, until nothing changes.
    pub fn settle(&self, at: &Point) -> Result<Point, Need> {
        let mut at = at.clone();
        for _ in 0..MOST_TURNS {
            let next = self.diagonal(&self.once(&at)?)?;
            if next == at {
                break;
            }
            at = next;
        }
        Ok(at)
    }

    /// The dials with more than one value, those that accuracy rises with or the others.
    fn dials(&self, monotone: bool) -> impl Iterator<Item = (usize, &Dial)> {
        self.candidate
            .dials
            .iter()
            .enumerate()
            .filter(move |(_, d)| d.values.len() > 1 && is_ladder(d) == monotone)
    }

    fn get(&self, point: &Point) -> Result<Option<Score>, Need> {
        self.known.get(point).copied().ok_or_else(|| vec![point.clone()])
    }

    /// All of them, or those that are missing.
    fn all(&self, points: &[Point]) -> Result<(), Need> {
        let missing: Need =
            points.iter().filter(|p| !self.known.contains_key(*p)).cloned().collect();
        if missing.is_empty() { Ok(()) } else { Err(missing) }
    }

    /// Whether `a` is nearer to the goal than `b`, both known.
    fn beats(&self, a: &Point, b: &Point) -> bool {
        match (self.known.get(a).copied().flatten(), self.known.get(b).copied().flatten()) {
            (Some(a), Some(b)) => a.beats(&b, self.goal),
            (a, b) => a.is_some() && b.is_none(),
        }
    }

    /// The best along one dial: golden section where the values have an order, all of them where
    /// they have none.
    fn line(&self, at: &Point, dial: usize, wide: bool) -> Result<Point, Need> {
        let knob = &self.candidate.dials[dial];
        let place = |i: usize| with(at, dial, i);
        if !knob.ordered {
            let all: Vec<Point> = (0..knob.values.len()).map(place).collect();
            self.all(&all)?;
            return Ok(self.best(at, &all));
        }
        let apart = knob.apart.then_some(knob.default);
        // Positions with an order between them.
        let order: Vec<usize> = (0..knob.values.len()).filter(|i| Some(*i) != apart).collect();
        let known: Vec<usize> =
            (0..order.len()).filter(|k| self.known.contains_key(&place(order[*k]))).collect();
        let Some(&first) = known.first() else {
            // Nothing yet but the value that stands apart.
            return Err(vec![place(order[order.len() / 2])]);
        };
        let best = known.iter().fold(first, |best, k| {
            if self.beats(&place(order[*k]), &place(order[best])) { *k } else { best }
        });
        let below = known.iter().rev().find(|k| **k < best).map_or(0, |k| k + 1);
        let above = known.iter().find(|k| **k > best).copied().unwrap_or(order.len());
        // Unknown positions on either side of the best, up to the next known one.
        let (left, mut right) = (best - below, above - best - 1);
        if left == 0 && right > 0 && self.is_enough(&place(order[best]), dial) {
            right = 0;
        }
        if left == 0 && right == 0 {
            let free = wide && !self.rises(&place(order[best]), dial);
            if let Some(end) = free.then(|| self.flat_end(&order, best, &place)).flatten() {
                return Err(vec![place(end)]);
            }
            let own = place(order[best]);
            let apart = apart.map(place);
            self.all(apart.as_slice())?;
            return Ok(match apart {
                Some(apart) if !self.beats(&own, &apart) => apart,
                _ => self.best(at, &[own]),
            });
        }
        let step = |gap: usize| match wide {
            true => ((GOLDEN * (gap + 1) as f64).round() as usize).clamp(1, gap),
            false => 1,
        };
        // The lower side first, where what costs time is cheap. Where time was seen to rise, the
        // dearer side is climbed a step at a time: a stride would pay for the dearest first.
        let next = match left {
            0 if self.rises(&place(order[best]), dial) => best + 1,
            0 => best + step(right),
            left => best - step(left),
        };
        Err(vec![place(order[next])])
    }

    /// The results at `at` and at the nearest known lower value of a dial.
    fn with_lower(&self, at: &Point, dial: usize) -> Option<(Score, Score)> {
        let known = |point: &Point| self.known.get(point).copied().flatten();
        let lower = (0..at[dial]).rev().find_map(|i| known(&with(at, dial, i)))?;
        Some((known(at)?, lower))
    }

    /// Whether time was seen to rise with a dial.
    fn rises(&self, at: &Point, dial: usize) -> bool {
        let seen = self.with_lower(at, dial);
        seen.is_some_and(|(own, lower)| own.time_ns > DEARER * lower.time_ns && !own.ties(&lower))
    }

    /// Whether dearer values of a dial need not be measured: the goal is met at less, here or by
    /// another, or the next one would break the budget by far.
    fn is_enough(&self, at: &Point, dial: usize) -> bool {
        let Some((own, lower)) = self.with_lower(at, dial) else { return false };
        let next_ns = own.time_ns * (own.time_ns / lower.time_ns).min(4.0);
        self.rises(at, dial)
            && match self.goal {
                Goal::Error { .. } => {
                    own.meets(self.goal) || self.lead_ns.is_some_and(|lead| own.time_ns > lead)
                }
                Goal::Budget { ns } => next_ns > 2.0 * ns,
                Goal::Knee => false,
            }
    }

    /// Where the best is no better than its neighbour on one side, the unknown end of that side: a
    /// plateau hides what lies beyond it.
    fn flat_end(
        &self,
        order: &[usize],
        best: usize,
        place: &dyn Fn(usize) -> Point,
    ) -> Option<usize> {
        let score = |k: usize| self.known.get(&place(*order.get(k)?)).copied().flatten();
        let own = score(best)?;
        let flat = |k: Option<usize>| {
            k.and_then(score).is_some_and(|s| (s.error - own.error).abs() <= FLAT * own.error)
        };
        let last = order.len().checked_sub(1)?;
        [(best.checked_sub(1), 0), (Some(best + 1), last)]
            .into_iter()
            .filter(|(neighbour, _)| flat(*neighbour))
            .map(|(_, end)| order[end])
            .find(|end| !self.known.contains_key(&place(*end)))
    }

    /// The nearest to the goal; `at`, where known, unless another is nearer.
    fn best(&self, at: &Point, points: &[Point]) -> Point {
        let start = if self.known.contains_key(at) { at } else { &points[0] };
        let best = points.iter().fold(start, |best, p| if self.beats(p, best) { p } else { best });
        best.clone()
    }

    /// Bisects a dial that accuracy rises with for the rung where the goal is just met.
    fn ladder(&self, at: &Point, dial: usize) -> Result<Point, Need> {
        let knob = &self.candidate.dials[dial];
        let place = |i: usize| with(at, dial, i);
        // More of it is wanted while the error is too large, or while there is time left.
        let more = |score: Option<Score>| match (self.goal, score) {
            (Goal::Budget { .. }, Some(score)) => score.meets(self.goal),
            (_, Some(score)) => !score.meets(self.goal),
            // What failed is left in the direction of less: too large a map fails, not too small.
            (_, None) => false,
        };
        let (mut low, mut high) = (0, knob.values.len());
        let mut next = at[dial];
        let mut tried = Vec::new();
        while low < high {
            tried.push(place(next));
            if more(self.get(&place(next))?) {
                low = next + 1;
            } else {
                high = next;
            }
            next = (low + high) / 2;
        }
        Ok(self.best(at, &tried))
    }

    /// A step along one dial that costs or saves time, with the others tuned anew: what is best for
    /// one map is not for the next. Cheaper where the error could still do, dearer where the time
    /// allows.
    fn diagonal(&self, at: &Point) -> Result<Point, Need> {
        let Some(own) = self.get(at)? else { return Ok(at.clone()) };
        let mut best = at.clone();
        for (dial, knob) in self.candidate.dials.iter().enumerate().filter(|(_, d)| d.ordered) {
            let neighbours = [at[dial].checked_sub(1), Some(at[dial] + 1)];
            for next in neighbours.into_iter().flatten().filter(|n| *n < knob.values.len()) {
                let next = with(at, dial, next);
                let Some(score) = self.get(&next)? else { continue };
                let promising = match self.goal {
                    Goal::Error { at_most } => {
                        (score.time_ns <= own.time_ns || !own.meets(self.goal))
                            && score.error <= TUNABLE * at_most.max(own.error)
                    }
                    Goal::Budget { .. } => {
                        score.meets(self.goal) && score.error <= TUNABLE * own.error
                    }
                    Goal::Knee => false,
                };
                if promising {
                    let tuned = self.tuned(&next, dial)?;
                    best = self.best(&best, &[tuned]);
                }
            }
        }
        Ok(best)
    }

    /// The best near `at` with one dial kept: the other ordered ones move to neighbours, towards
    /// less error.
    fn tuned(&self, at: &Point, kept: usize) -> Result<Point, Need> {
        let sharper = Self { goal: Goal::Error { at_most: 0.0 }, ..*self };
        let mut at = at.clone();
        for (i, _) in self.dials(false).filter(|(i, d)| *i != kept && d.ordered) {
            at = sharper.line(&at, i, false)?;
        }
        Ok(at)
    }
}

/// Whether a dial is bisected: accuracy rises with it, and its default lies in its order.
fn is_ladder(dial: &Dial) -> bool {
    dial.accuracy == Accuracy::Monotone && dial.ordered && !dial.apart
}

/// `point` with one dial at another value.
fn with(point: &Point, dial: usize, value: usize) -> Point {
    let mut point = point.clone();
    point[dial] = value;
    point
}
