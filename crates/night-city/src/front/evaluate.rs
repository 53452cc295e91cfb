//! Precuts of a frame: those that are kept, those that are found, and what to do without.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.2.3.
//! Deviations: a frame may be told to find a few only; other cells start at the lights of a cell above
//! them, which is around them too, or at all lights.

use super::{Front, Shown};
use crate::{
    cells::{Directions, each},
    coherence::{Kept, Key},
    lists::Precut,
};
use dapple_many_lights::region::{Direction, ViewCell};
use dapple_occlusion::camera::Cells;

/// A precut to be found.
struct Asked {
    /// Of the cell.
    index: usize,
    key: Key,
    /// As [`Kept::put`] takes them.
    objects: Vec<u32>,
}

impl Front<'_> {
    /// Finds every precut of the cells that is not kept, or no longer valid; at most `budget`: those
    /// first that are not kept at all, the cells that cover most before others. How many those were.
    pub(super) fn evaluate(&mut self, cells: &Cells, shown: &[Shown], budget: usize) -> u64 {
        let mut asked: Vec<Asked> = Vec::new();
        for (index, shown) in shown.iter().enumerate() {
            let mut objects = Vec::new();
            if !self.night.whole_boxes {
                objects.extend_from_slice(cells.objects_of(index));
                objects.sort_unstable();
            }
            for direction in each(shown.directions) {
                let key = Key { node: shown.node, direction };
                if self.kept.wants(key, &objects) {
                    asked.push(Asked { index, key, objects: objects.clone() });
                }
            }
        }
        if asked.len() > budget {
            let (kept, coverage) = (&self.kept, self.state.coverage());
            asked.sort_by_key(|asked| {
                let is_kept = kept.get(asked.key).is_some();
                (is_kept, u32::MAX - coverage[asked.key.node as usize], asked.key)
            });
            asked.truncate(budget);
        }
        let question = |asked: &Asked| (shown[asked.index].cell(), asked.key.direction);
        let questions: Vec<(&ViewCell, Direction)> = asked.iter().map(question).collect();
        self.many.all(&questions, &mut self.found);
        if let Some(heights) = &self.heights {
            heights.all(&questions, &self.found, &mut self.below);
        }
        for (place, (asked, nodes)) in asked.iter().zip(&self.found).enumerate() {
            let hidden_below = match self.heights {
                Some(_) => &self.below[place][..],
                None => &[],
            };
            self.kept.put(asked.key, &asked.objects, Precut { nodes, hidden_below });
        }
        asked.len() as u64
    }

    /// Lets cells whose precuts the budget left no room for start at those of the nearest cell above
    /// them that has all it takes, or else at the roots: more lights, none missing. How many cells.
    pub(super) fn fall_back(&mut self, cells: &Cells, shown: &mut [Shown]) -> u64 {
        let Self { town, whole, kept, .. } = self;
        let is_kept = |kept: &Kept, node: u32, directions: Directions| {
            each(directions).all(|direction| kept.get(Key { node, direction }).is_some())
        };
        let mut late = 0;
        for (index, shown) in shown.iter_mut().enumerate() {
            if is_kept(kept, shown.node, shown.directions) {
                continue;
            }
            late += 1;
            shown.late = true;
            let mut node = shown.node;
            while node != 0 && shown.late {
                node = town.tree.nodes[node as usize].parent;
                let any = |direction| kept.get(Key { node, direction }).is_some();
                // The cell of all is not made for nothing.
                if !Direction::ALL.into_iter().any(any) {
                    continue;
                }
                let above = whole.of(town, node);
                let directions = above.directions_of(cells.objects_of(index));
                if is_kept(kept, node, directions) {
                    each(directions).for_each(|direction| kept.touch(Key { node, direction }));
                    *shown = Shown { node, whole: above, shrunk: None, directions, late: false };
                }
            }
        }
        late
    }
}
