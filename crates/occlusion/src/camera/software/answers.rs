//! Batches that were answered when asked, handed out by the modelled clock.

use super::super::{Latency, Readiness};
use crate::OcclusionError;
use std::collections::VecDeque;

/// What has been asked and not collected, oldest first.
#[derive(Clone, Debug)]
pub struct Answers {
    latency: u32,
    clock: Latency,
    queries: VecDeque<usize>,
    counts: VecDeque<u32>,
}

impl Answers {
    /// # Errors
    /// [`Readiness::Polled`]: there is no device to poll.
    pub fn new(readiness: Readiness) -> Result<Self, OcclusionError> {
        let Readiness::Modelled(latency) = readiness else {
            return Err(OcclusionError::value(
                "readiness polled",
                "a software renderer has no device to ask; use the modelled clock",
            ));
        };
        Ok(Self {
            latency,
            clock: Latency::default(),
            queries: VecDeque::new(),
            counts: VecDeque::new(),
        })
    }

    pub fn drew(&mut self, objects: usize) {
        self.clock.drew(objects);
    }

    /// A batch over so many boxes, with its answers.
    pub fn asked(&mut self, boxes: usize, counts: &[u32]) {
        self.clock.asked(boxes);
        self.queries.push_back(counts.len());
        self.counts.extend(counts);
    }

    pub fn ready(&self) -> bool {
        self.clock.ready(self.latency)
    }

    /// # Errors
    /// No batch is left.
    pub fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let Some(queries) = self.queries.pop_front() else {
            return Err(OcclusionError::value("collect", "every batch asked has been collected"));
        };
        self.clock.collected(self.latency);
        counts.extend(self.counts.drain(..queries));
        Ok(())
    }
}
