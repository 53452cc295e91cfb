//! Many cells at once, over all threads.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (several threads
//! are left to future work).

use super::{Direction, Precuts, Steps, ViewCell};
use crate::{LightsError, pool::Pool};
use rayon::prelude::*;

/// A technique of from-region visibility made ready once a thread. What comes out does not depend on
/// how many there are.
pub struct Many(Pool<Box<dyn Precuts>>);

impl Many {
    /// Calls `make` once for each thread of the current pool; [`Self::all`] has to be called there too.
    ///
    /// # Errors
    /// What `make` fails with.
    pub fn new(
        make: impl FnMut() -> Result<Box<dyn Precuts>, LightsError>,
    ) -> Result<Self, LightsError> {
        Pool::try_new(make).map(Self)
    }

    /// The precut of each question, in the same place of `precuts`, whose lists are used again.
    pub fn all(&mut self, questions: &[(&ViewCell, Direction)], precuts: &mut Vec<Vec<u32>>) {
        precuts.resize_with(questions.len(), Vec::new);
        // One evaluation costs from microseconds to milliseconds: each may go to another thread.
        let each = questions.par_iter().zip(precuts.par_iter_mut()).with_max_len(1);
        each.for_each(|((cell, direction), nodes)| self.0.own().precut(cell, *direction, nodes));
    }

    /// Work since it was made ready, over all threads.
    pub fn steps(&self) -> Steps {
        self.0.all().fold(Steps::default(), |mut sum, own| {
            sum += *own.steps();
            sum
        })
    }

    /// Bytes that all threads hold beside the tree.
    pub fn bytes(&self) -> u64 {
        self.0.all().map(|own| own.bytes()).sum()
    }

    /// Threads.
    pub fn threads(&self) -> usize {
        self.0.len()
    }
}
