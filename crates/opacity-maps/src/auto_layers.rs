//! Choosing the number of layers K by what a frame may cost.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, section 7: raise K in a fly-through for as long as the frame rate stays
//! above 30.
//!
//! Deviations: the printed rule ends at the first K that is too slow and leaves it there, and one
//! slow frame ends it early ([`raised_while_fast`] keeps it as it is). [`Controller`] judges the
//! median of several frames, goes back to what met the budget, and goes up again only where the
//! time it has seen or expects there leaves a margin, so that noise does not move it to and fro.

use crate::OpacityError;

/// A time that a number of layers takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed {
    /// K.
    pub layers: u32,
    /// Milliseconds a frame.
    pub ms: f64,
}

/// The largest K that was measured within the budget, `None` where none was. Never falls as the
/// budget grows. A time that is not a number meets no budget.
pub fn largest_within(budget_ms: f64, measured: &[Timed]) -> Option<u32> {
    measured.iter().filter(|t| t.ms <= budget_ms).map(|t| t.layers).max()
}

/// Time as a line over K: a frame's constant part and what a layer adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Milliseconds at no layer.
    pub base_ms: f64,
    /// Milliseconds a layer, >= 0.
    pub layer_ms: f64,
}

impl Line {
    /// Least squares through two or more different K; `None` of fewer. A line that falls is taken
    /// as level at the mean.
    pub fn through(measured: &[Timed]) -> Option<Self> {
        let n = measured.len() as f64;
        let mean_k = measured.iter().map(|t| f64::from(t.layers)).sum::<f64>() / n;
        let mean_ms = measured.iter().map(|t| t.ms).sum::<f64>() / n;
        let about = |t: &Timed| f64::from(t.layers) - mean_k;
        let spread: f64 = measured.iter().map(|t| about(t) * about(t)).sum();
        if measured.len() < 2 || spread <= 0.0 {
            return None;
        }
        let rise: f64 = measured.iter().map(|t| about(t) * (t.ms - mean_ms)).sum();
        let layer_ms = (rise / spread).max(0.0);
        Some(Self { base_ms: mean_ms - layer_ms * mean_k, layer_ms })
    }

    /// Milliseconds of `layers`.
    pub fn ms(self, layers: u32) -> f64 {
        self.base_ms + self.layer_ms * f64::from(layers)
    }

    /// The largest of 1..=`most` within the budget, `None` where one layer is too much.
    pub fn largest_within(self, budget_ms: f64, most: u32) -> Option<u32> {
        (1..=most).rev().find(|&k| self.ms(k) <= budget_ms)
    }
}

/// The rule as published: from `first` on, K is raised by `step` while the frame just drawn was
/// faster than `fps`; where it ends, it stays. At most `most`.
pub fn raised_while_fast(
    fps: f64,
    first: u32,
    step: u32,
    most: u32,
    mut frame_ms: impl FnMut(u32) -> f64,
) -> u32 {
    let mut layers = first.min(most);
    while layers < most && 1000.0 / frame_ms(layers) > fps {
        layers = layers.saturating_add(step.max(1)).min(most);
    }
    layers
}

/// Frames whose median is one observation.
pub const WINDOW: usize = 9;

/// A median below this part of the first one after coming down to a choice means a lighter view,
/// not noise: what was seen above it no longer holds.
const LIGHTER: f64 = 0.8;

/// How a [`Controller`] behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Milliseconds a frame may take, > 0.
    pub budget_ms: f64,
    /// Part of the budget, 0..=0.5, that must be left over where K is raised.
    pub margin: f64,
}

/// Chooses K frame by frame among given ones.
#[derive(Clone, Debug)]
pub struct Controller {
    rule: Rule,
    /// K from few to many.
    choices: Vec<u32>,
    at: usize,
    /// Last time seen at each choice.
    seen: Vec<Option<f64>>,
    /// First time at each choice since it was last come down to.
    first: Vec<Option<f64>>,
    window: [f64; WINDOW],
    filled: usize,
}

impl Controller {
    /// Starts at the fewest layers of `choices`, which must rise.
    ///
    /// # Errors
    /// A rule out of range; choices that are none, do not rise, or leave 1..=256.
    pub fn new(rule: Rule, choices: &[u32]) -> Result<Self, OpacityError> {
        let Rule { budget_ms, margin } = rule;
        if !(budget_ms.is_finite() && budget_ms > 0.0) {
            return Err(OpacityError::setting("budget", budget_ms, "milliseconds above 0"));
        }
        if !(0.0..=0.5).contains(&margin) {
            return Err(OpacityError::setting("margin", margin, "0..=0.5"));
        }
        let rising = choices.windows(2).all(|w| w[0] < w[1]);
        let range = choices.iter().all(|k| (1..=256).contains(k));
        if choices.is_empty() || !rising || !range {
            let given = format!("{choices:?}");
            return Err(OpacityError::setting("choices of layers", given, "rising, 1..=256"));
        }
        let choices = choices.to_vec();
        let (seen, first) = (vec![None; choices.len()], vec![None; choices.len()]);
        Ok(Self { rule, choices, at: 0, seen, first, window: [0.0; WINDOW], filled: 0 })
    }

    /// K to draw the next frame with.
    pub fn layers(&self) -> u32 {
        self.choices[self.at]
    }

    /// Takes the time of a frame drawn with [`Controller::layers`]. Times that are not numbers are
    /// dropped.
    pub fn observe(&mut self, ms: f64) {
        if !ms.is_finite() {
            return;
        }
        self.window[self.filled] = ms;
        self.filled += 1;
        if self.filled < WINDOW {
            return;
        }
        self.filled = 0;
        self.window.sort_by(f64::total_cmp);
        let median = self.window[WINDOW / 2];
        self.seen[self.at] = Some(median);
        match self.first[self.at] {
            Some(first) if median >= LIGHTER * first => {}
            Some(_) => {
                self.seen[self.at + 1..].fill(None);
                self.first[self.at] = Some(median);
            }
            None => self.first[self.at] = Some(median),
        }
        if median > self.rule.budget_ms {
            if self.at > 0 {
                self.at -= 1;
                self.first[self.at] = None;
            }
        } else if self.at + 1 < self.choices.len()
            && self.expected_above() <= self.rule.budget_ms * (1.0 - self.rule.margin)
        {
            self.at += 1;
        }
    }

    /// Forgets the times of other numbers of layers: the scene or the view has changed.
    pub fn forget(&mut self) {
        self.seen.fill(None);
        self.first.fill(None);
        self.filled = 0;
    }

    /// Milliseconds to expect of the next choice: as last seen there, or on the line through this
    /// choice and the one below; where neither is known, no more than here.
    fn expected_above(&self) -> f64 {
        let at = |i: usize| self.seen[i].map(|ms| Timed { layers: self.choices[i], ms });
        let Some(here) = at(self.at) else { return f64::INFINITY };
        let below = self.at.checked_sub(1).and_then(at);
        match (at(self.at + 1), below) {
            (Some(above), _) => above.ms,
            (None, Some(below)) => Line::through(&[below, here])
                .map_or(here.ms, |line| line.ms(self.choices[self.at + 1])),
            (None, None) => here.ms,
        }
    }
}
