//! A renderer that looks over the shoulder of whoever asks, and that may answer wrongly.

use crate::SuiteError;
use dapple_occlusion::{
    OcclusionError,
    camera::{Bounds, Image, Objects, Query, Readiness, Renderer, View, software::Reference},
};
use std::{collections::VecDeque, sync::Arc};

/// How answers are wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Samples pass behind what is drawn.
    Reversed,
    /// Answers tell none from some.
    Boolean,
    /// Of several boxes, the first alone is looked at.
    FirstBoxOnly,
}

/// The plain renderer; asks about each box by itself as well.
pub struct Asked {
    /// What draws.
    pub inner: Reference,
    /// The same, where nothing is ever drawn.
    empty: Reference,
    fault: Option<Fault>,
    /// Number of queries and of the boxes of each, by batch.
    pending: VecDeque<Vec<usize>>,
    /// Queries of several boxes that showed nothing.
    pub hidden_groups: u64,
    /// Of those, queries with a box that shows by itself.
    pub wrong_groups: u64,
}

impl Asked {
    /// Answers come after `latency` operations.
    ///
    /// # Errors
    /// Objects that are refused.
    pub fn new(
        objects: &Arc<Objects>,
        latency: u32,
        fault: Option<Fault>,
    ) -> Result<Self, SuiteError> {
        let renderer = || Reference::new(Arc::clone(objects), Readiness::Modelled(latency));
        Ok(Self {
            inner: renderer()?,
            empty: renderer()?,
            fault,
            pending: VecDeque::new(),
            hidden_groups: 0,
            wrong_groups: 0,
        })
    }

    /// What was drawn.
    pub fn image(&self) -> &Image {
        self.inner.image()
    }
}

impl Renderer for Asked {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        self.empty.begin(view)?;
        self.inner.begin(view)
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        self.inner.draw(objects)
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        let mut all = queries.to_vec();
        if self.fault == Some(Fault::FirstBoxOnly) {
            all.iter_mut().for_each(|query| query.boxes.end = query.boxes.start + 1);
        }
        if self.fault == Some(Fault::Reversed) {
            self.empty.ask(boxes, queries)?;
        }
        all.extend((0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }));
        self.pending.push_back(queries.iter().map(|query| query.boxes.len()).collect());
        self.inner.ask(boxes, &all)
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.inner.ready()
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let mut all = Vec::new();
        self.inner.collect(&mut all)?;
        let sizes = self.pending.pop_front().unwrap_or_default();
        let (answers, mut each) = all.split_at(sizes.len());
        for (answer, size) in answers.iter().zip(sizes) {
            let (members, rest) = each.split_at(size);
            each = rest;
            let hidden_group = size > 1 && *answer == 0;
            let shows = members.iter().any(|count| *count > 0);
            self.hidden_groups += u64::from(hidden_group);
            self.wrong_groups += u64::from(hidden_group && shows);
        }
        let mut samples = Vec::new();
        if self.fault == Some(Fault::Reversed) {
            self.empty.collect(&mut samples)?;
        }
        counts.extend(answers.iter().enumerate().map(|(i, &passed)| match self.fault {
            Some(Fault::Reversed) => samples[i] - passed,
            Some(Fault::Boolean) => passed.min(1),
            _ => passed,
        }));
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        self.inner.end()
    }
}
