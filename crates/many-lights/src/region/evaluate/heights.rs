//! Heights below which lights are hidden, for lists of a whole face.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1: the horizon is
//! as seen from a cell's top, so lower points are lit by what is hidden from them; the thesis proposes
//! to keep a height for each cluster.
//! Deviations: the thesis leaves the way open. Here the lower part of the face, up to each of a few
//! heights, is tested against all its own horizons, the greatest part first, by what is not hidden from
//! a greater one. Fusion in the order of insertion is not monotone, but that costs nothing here: each
//! height is proved by itself.

use super::{Evaluator, Question, Sight, Sink, white};
use crate::Emission;
use crate::region::{Direction, Steps, ViewCell};

/// The most heights of a face.
pub const MOST_HEIGHTS: u32 = 64;

/// The greatest f32 that is not above `value`.
fn down(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) > value { rounded.next_down() } else { rounded }
}

impl Evaluator {
    /// Lowers each of `below` to the greatest height (local y, metres) up to which no point of the
    /// cell's face towards `direction` sees any light of the node in the same place of `nodes`: plus
    /// infinity if none of the whole face does, minus infinity if no such height is found. `heights` of
    /// the face are tried, at even distances, and the whole; at most [`MOST_HEIGHTS`].
    ///
    /// `nodes` are any of the tree's, none inside another. Fill `below` with plus infinity first, and
    /// call this for each direction that a surface faces: its points at y <= `below` need not look at
    /// the node. Nothing is left out for being weak here, only for giving nothing at all. Without a
    /// face towards the direction nothing changes.
    pub fn heights(
        &mut self,
        cell: &ViewCell,
        direction: Direction,
        heights: u32,
        nodes: &[u32],
        below: &mut [f32],
    ) {
        let Some(face) = cell.face(direction) else { return };
        let heights = heights.min(MOST_HEIGHTS);
        self.face(cell.turn, direction);
        let sight = Sight { turn: cell.turn, direction };
        let (whole, white) = (face.cuboid(direction), white(&face.region));
        let mut question = Question { sight, face: whole, white, threshold: 0.0 };
        // What is done here is no part of the evaluation's own counts.
        std::mem::swap(&mut self.steps, &mut self.height_steps);
        let mut open = std::mem::take(&mut self.open);
        let mut seen = std::mem::take(&mut self.seen);
        open.clear();
        open.extend(0..nodes.len().min(below.len()) as u32);
        for height in (1..=heights + 1).rev() {
            let top = if height > heights {
                f32::INFINITY
            } else {
                let share = f64::from(height) / f64::from(heights + 1);
                down(whole.h[0] + share * (whole.h[1] - whole.h[0]))
            };
            question.face.h[1] = f64::from(top).min(whole.h[1]);
            if open.is_empty() || question.face.h[1] < whole.h[0] {
                break;
            }
            self.steps.evaluations += 1;
            seen.clear();
            seen.resize(nodes.len(), false);
            self.queues.waiting.clear();
            for &place in &open {
                let node = nodes[place as usize];
                if self.tree.nodes[node as usize].kind == Emission::Directional.code() {
                    seen[place as usize] = true;
                } else {
                    self.queues.waiting.push(sight.start(&self.tree, node, place));
                }
            }
            self.evaluate(&question, &mut Sink::Seen(&mut seen));
            open.retain(|&place| {
                let seen = seen[place as usize];
                if !seen {
                    let below = &mut below[place as usize];
                    *below = below.min(top);
                }
                seen
            });
        }
        for &place in &open {
            below[place as usize] = f32::NEG_INFINITY;
        }
        (self.open, self.seen) = (open, seen);
        std::mem::swap(&mut self.steps, &mut self.height_steps);
    }

    /// Work of [`Self::heights`] since it was made ready.
    pub fn height_steps(&self) -> &Steps {
        &self.height_steps
    }
}

#[cfg(test)]
mod tests {
    use super::down;

    #[test]
    fn heights_are_never_rounded_up() {
        for value in [0.1, -0.1, 1.0, 16_777_217.0, -16_777_217.0, 1e300, -1e300] {
            assert!(f64::from(down(value)) <= value, "{value}");
        }
        assert_eq!(down(1.5), 1.5);
    }
}
