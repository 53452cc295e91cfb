//! A renderer that writes down what it is asked, and one that only repeats the answers: what is left
//! of a frame's time is the walk.

use super::support::{LATENCY, Path};
use crate::SuiteError;
use dapple_occlusion::{
    OcclusionError,
    camera::{
        Bounds, Frame, Latency, Objects, Query, Readiness, Renderer, Settings, State, View,
        software::Fast, techniques,
    },
};
use std::{collections::BTreeSet, sync::Arc, time::Instant};

/// Draws, and keeps what was answered.
pub struct Recorder {
    renderer: Fast,
    objects: Arc<Objects>,
    /// Counts of each batch, in the order of collecting.
    pub answers: Vec<Vec<u32>>,
    /// Templates of what was drawn since the last batch.
    templates: BTreeSet<u32>,
    /// Draw calls of one a template between two batches.
    pub instanced_calls: u64,
}

impl Recorder {
    fn count_calls(&mut self) {
        self.instanced_calls += self.templates.len() as u64;
        self.templates.clear();
    }
}

impl Renderer for Recorder {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        self.renderer.begin(view)
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        let template = |o: &u32| self.objects.objects[*o as usize].template;
        self.templates.extend(objects.iter().map(template));
        self.renderer.draw(objects)
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        self.count_calls();
        self.renderer.ask(boxes, queries)
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.renderer.ready()
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        let before = counts.len();
        self.renderer.collect(counts)?;
        self.answers.push(counts[before..].to_vec());
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        self.count_calls();
        self.renderer.end()
    }
}

/// Draws nothing and gives recorded answers, by the same modelled clock.
struct Replay<'a> {
    answers: std::slice::Iter<'a, Vec<u32>>,
    latency: Latency,
    after: u32,
}

impl Renderer for Replay<'_> {
    fn begin(&mut self, _: &View) -> Result<(), OcclusionError> {
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        self.latency.drew(objects.len());
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], _: &[Query]) -> Result<(), OcclusionError> {
        self.latency.asked(boxes.len());
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        Ok(self.latency.ready(self.after))
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        self.latency.collected(self.after);
        // A batch too many is found by its number of answers.
        counts.extend_from_slice(self.answers.next().map_or(&[], |batch| batch));
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        Ok(())
    }
}

/// What was answered and drawn along a path.
pub struct Recorded {
    /// By batch.
    pub answers: Vec<Vec<u32>>,
    /// One a frame.
    pub frames: Vec<Frame>,
    /// Draw calls of one a template between two batches, one a frame.
    pub instanced_calls: Vec<u64>,
}

/// Runs a technique along a path and writes down what it is answered.
///
/// # Errors
/// Settings that are refused.
pub fn record(path: &Path, settings: &Settings) -> Result<Recorded, SuiteError> {
    let (objects, tree) = (&path.town.objects, &path.town.tree);
    let mut recorder = Recorder {
        renderer: Fast::new(Arc::clone(objects), LATENCY)?,
        objects: Arc::clone(objects),
        answers: Vec::new(),
        templates: BTreeSet::new(),
        instanced_calls: 0,
    };
    let mut state = State::new(tree);
    let (mut frames, mut calls) = (Vec::new(), Vec::new());
    for view in &path.views {
        let (mut out, before) = (Frame::default(), recorder.instanced_calls);
        techniques::frame(settings, objects, tree, view, &mut state, &mut recorder, &mut out)?;
        frames.push(out);
        calls.push(recorder.instanced_calls - before);
    }
    Ok(Recorded { answers: recorder.answers, frames, instanced_calls: calls })
}

/// Nanoseconds of walking the tree along a path, nothing drawn.
///
/// # Errors
/// Answers of another walk.
pub fn walk_ns(path: &Path, settings: &Settings, recorded: &Recorded) -> Result<f64, SuiteError> {
    let (objects, tree) = (&path.town.objects, &path.town.tree);
    let after = match LATENCY {
        Readiness::Modelled(after) => after,
        Readiness::Polled => 0,
    };
    let mut replay =
        Replay { answers: recorded.answers.iter(), latency: Latency::default(), after };
    let (mut state, mut out) = (State::new(tree), Frame::default());
    let mut ns = 0.0;
    for (view, before) in path.views.iter().zip(&recorded.frames) {
        let start = Instant::now();
        techniques::frame(settings, objects, tree, view, &mut state, &mut replay, &mut out)?;
        ns += start.elapsed().as_nanos() as f64;
        if out != *before {
            return Err(SuiteError::Internal("a repeated walk took another way".into()));
        }
    }
    Ok(ns)
}
