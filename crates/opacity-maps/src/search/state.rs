//! The search's state machine: one λ a frame, eleven frames, then the best is adopted.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, algorithm 5.2.3.1.
//!
//! Deviations: steps are integers, since the thesis's sum of tenths is never equal to 1.1; the
//! running best is forgotten when a search restarts; a score carries the step that its maps were
//! rendered with, so that it may arrive frames later (a read-back that nobody waits for) and still
//! counts for its own λ; the adopted λ can be kept on screen while others are tried.

use super::criteria::is_better;
use crate::{Criterion, OpacityError};

/// Most steps of a search.
const MOST_STEPS: usize = 20;

/// The values of λ that are tried: 0, 1 / n, 2 / n, .. 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps(u32);

impl Steps {
    /// The thesis's eleven: 0, 0.1, .. 1.
    pub const THESIS: Self = Self(10);

    /// Steps of `lambda`, 0.05..=0.25, which must divide 1 to within a thousandth.
    ///
    /// # Errors
    /// Anything else, by name.
    pub fn of(lambda: f32) -> Result<Self, OpacityError> {
        let refused =
            || OpacityError::setting("lambda step", lambda, "0.05..=0.25, a whole part of 1");
        if !(0.0499..=0.2501).contains(&lambda) {
            return Err(refused());
        }
        let steps = (1.0 / lambda).round();
        if (steps * lambda - 1.0).abs() > 1e-3 { Err(refused()) } else { Ok(Self(steps as u32)) }
    }

    /// Number of values of λ, hence of scored frames.
    pub fn values(self) -> u32 {
        self.0 + 1
    }

    /// λ of a step, exactly 1 at the last and beyond.
    pub fn lambda(self, step: u32) -> f32 {
        step.min(self.0) as f32 / self.0 as f32
    }
}

/// What is drawn while a search is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// The λ on trial, as the thesis does: it flickers.
    Trial,
    /// The λ adopted last: a second set of maps.
    #[default]
    Adopted,
}

/// Maps to be rendered and scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Which search it belongs to; scores of an earlier one are dropped.
    cycle: u32,
    step: u32,
    /// To render with.
    pub lambda: f32,
}

impl Trial {
    pub(super) fn step(self) -> u32 {
        self.step
    }
}

/// One frame of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// What is to be scored, if anything.
    pub trial: Option<Trial>,
    /// λ to draw with.
    pub drawn: f32,
}

/// Where a search stands.
#[derive(Clone, Debug)]
pub struct Cycle {
    criterion: Criterion,
    steps: Steps,
    shown: Shown,
    cycle: u32,
    /// Step that the next frame tries; beyond the last none.
    next: u32,
    /// Steps whose score has come.
    scored: [bool; MOST_STEPS + 1],
    /// Best score so far and its step.
    best: Option<(f64, u32)>,
    adopted: u32,
}

impl Cycle {
    /// A search about to begin; λ = 0 is drawn until one is adopted.
    #[must_use]
    pub fn new(criterion: Criterion, steps: Steps, shown: Shown) -> Self {
        let scored = [false; MOST_STEPS + 1];
        Self { criterion, steps, shown, cycle: 0, next: 0, scored, best: None, adopted: 0 }
    }

    /// Starts anew: densities, models or the light's direction have changed.
    pub fn needs_recompute(&mut self) {
        self.cycle = self.cycle.wrapping_add(1);
        self.next = 0;
        self.scored = [false; MOST_STEPS + 1];
        self.best = None;
    }

    /// Begins a frame.
    pub fn frame(&mut self) -> Frame {
        if self.next >= self.steps.values() {
            return Frame { trial: None, drawn: self.adopted() };
        }
        let lambda = self.steps.lambda(self.next);
        let trial = Trial { cycle: self.cycle, step: self.next, lambda };
        self.next += 1;
        let drawn = if self.shown == Shown::Trial { lambda } else { self.adopted() };
        Frame { trial: Some(trial), drawn }
    }

    /// Takes the score of a trial, in this frame or later. The best λ is adopted with the last
    /// score to come; of equal scores the smallest λ wins. A score that comes twice, or after a
    /// restart, changes nothing. Returns λ where it was adopted just now.
    pub fn scored(&mut self, trial: Trial, score: f64) -> Option<f32> {
        let step = trial.step as usize;
        if trial.cycle != self.cycle || self.scored[step] || trial.step >= self.next {
            return None;
        }
        self.scored[step] = true;
        let better = match self.best {
            None => !score.is_nan(),
            Some((best, at)) => {
                is_better(self.criterion, score, best) || (score == best && trial.step < at)
            }
        };
        if better {
            self.best = Some((score, trial.step));
        }
        let values = self.steps.values() as usize;
        if self.scored[..values].iter().all(|&s| s) {
            // Where no score is a number, nothing is known to be better than evenly.
            self.adopted = self.best.map_or(0, |(_, step)| step);
            return Some(self.adopted());
        }
        None
    }

    /// Whether a score is still to come.
    pub fn is_searching(&self) -> bool {
        !self.scored[..self.steps.values() as usize].iter().all(|&s| s)
    }

    /// The λ adopted last.
    pub fn adopted(&self) -> f32 {
        self.steps.lambda(self.adopted)
    }

    /// Its step.
    pub(super) fn adopted_step(&self) -> u32 {
        self.adopted
    }

    /// The values that are tried.
    pub fn steps(&self) -> Steps {
        self.steps
    }
}

/// Algorithm 5.2.3.1 as printed, a deliberate fault: λ is a running sum of tenths compared with
/// 1.1, and the best score outlives a restart.
#[derive(Clone, Debug)]
pub struct PrintedLoop {
    criterion: Criterion,
    split_ratio: f64,
    best_split: f64,
    best_score: Option<f64>,
    recompute: bool,
}

impl PrintedLoop {
    /// Lines 1 to 5.
    #[must_use]
    pub fn new(criterion: Criterion) -> Self {
        Self { criterion, split_ratio: 0.0, best_split: 0.0, best_score: None, recompute: true }
    }

    /// Lines 7 to 19; returns the λ of this frame's maps.
    pub fn frame(&mut self, score: impl FnOnce(f64) -> f64) -> f64 {
        let rendered = self.split_ratio;
        if self.recompute {
            let score = score(rendered);
            if self.best_score.is_none_or(|best| is_better(self.criterion, score, best)) {
                (self.best_score, self.best_split) = (Some(score), rendered);
            }
            self.split_ratio += 0.1;
        }
        // As printed.
        #[allow(clippy::float_cmp)]
        if self.split_ratio == 1.1 {
            self.split_ratio = self.best_split;
            self.recompute = false;
        }
        rendered
    }

    /// Lines 21 to 23.
    pub fn needs_recompute(&mut self) {
        self.recompute = true;
        self.split_ratio = 0.0;
    }

    /// Whether line 17 has ever fired.
    pub fn has_ended(&self) -> bool {
        !self.recompute
    }

    /// λ of the best score so far.
    pub fn best(&self) -> f64 {
        self.best_split
    }
}
