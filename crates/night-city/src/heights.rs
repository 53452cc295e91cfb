//! Heights below which the nodes of precuts are hidden.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (future work).
//! Deviations: those of [`Evaluator::heights`]; found together with a precut, and kept with it.

use crate::Town;
use dapple_many_lights::region::{
    Direction, FacadeCluster, Precuts, Steps, ViewCell, evaluate::Evaluator,
};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// What finds them, one a thread.
pub(crate) struct Heights {
    /// Tried for each face.
    heights: u32,
    evaluators: Vec<Mutex<Evaluator>>,
}

impl Heights {
    /// Made ready for the threads of the current pool.
    pub(crate) fn new(town: &Town, settings: &FacadeCluster, heights: u32) -> Self {
        let make = |_| {
            let (tree, occluders) = (Arc::clone(&town.lights), Arc::clone(&town.occluders));
            Mutex::new(Evaluator::new(tree, occluders, town.world(false).clamp_m, *settings))
        };
        let threads = rayon::current_num_threads().max(1);
        Self { heights, evaluators: (0..threads).map(make).collect() }
    }

    /// One for each node of the precut of each question, local y in metres: no point of the face at it
    /// or below sees anything of the node.
    pub(crate) fn all(
        &self,
        questions: &[(&ViewCell, Direction)],
        precuts: &[Vec<u32>],
        hidden_below: &mut Vec<Vec<f32>>,
    ) {
        hidden_below.resize_with(questions.len(), Vec::new);
        let each = questions.par_iter().zip(precuts).zip(hidden_below).with_max_len(1);
        each.for_each(|(((cell, direction), nodes), below)| {
            below.clear();
            below.resize(nodes.len(), f32::INFINITY);
            let thread = rayon::current_thread_index().unwrap_or(0) % self.evaluators.len();
            // It is overwritten before it is read: a panic elsewhere leaves nothing to distrust.
            let mut own = self.evaluators[thread].lock().unwrap_or_else(PoisonError::into_inner);
            own.heights(cell, *direction, self.heights, nodes, below);
        });
    }

    /// Work since they were made ready.
    pub(crate) fn steps(&self) -> Steps {
        self.each(|own| *own.height_steps()).fold(Steps::default(), |mut sum, own| {
            sum += own;
            sum
        })
    }

    /// Bytes of what finds them.
    pub(crate) fn bytes(&self) -> u64 {
        self.each(Evaluator::bytes).sum()
    }

    fn each<T>(&self, of: impl Fn(&Evaluator) -> T) -> impl Iterator<Item = T> {
        self.evaluators
            .iter()
            .map(move |own| of(&own.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}
