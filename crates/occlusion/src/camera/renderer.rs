//! What techniques ask of whatever draws.

use super::{Bounds, View};
use crate::OcclusionError;
use std::ops::Range;

/// One question: how many samples of these boxes (ranges of the batch's boxes) would pass the depth
/// test now. A sample passes where its depth is at least the one drawn (ties pass). Boxes are
/// rasterised grown by a guard band that covers the rounding of every form, with all six faces;
/// samples of overlapping faces or boxes count each time, so that a count is an upper estimate of
/// the pixels shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Query {
    /// Indices into the batch's boxes.
    pub boxes: Range<u32>,
}

/// Draws and answers. Commands take effect in the order they are given; an answer refers to what was
/// drawn before its batch was asked.
pub trait Renderer {
    /// Starts a frame: clears depth and ids. Batches of earlier frames may still be collected.
    ///
    /// # Errors
    /// The device's.
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError>;

    /// Draws objects with depth test and depth write, in that order.
    ///
    /// # Errors
    /// The device's.
    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError>;

    /// Asks one batch of queries over `boxes`. Returns at once.
    ///
    /// # Errors
    /// The device's.
    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError>;

    /// Whether the oldest batch that has not been collected can be without waiting. `true` where
    /// there is none.
    ///
    /// # Errors
    /// The device's.
    fn ready(&mut self) -> Result<bool, OcclusionError>;

    /// The counts of the oldest batch that has not been collected, one a query, appended to
    /// `counts`. Waits if need be.
    ///
    /// # Errors
    /// The device's, or no batch is left.
    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError>;

    /// Ends the frame: everything drawn is submitted.
    ///
    /// # Errors
    /// The device's.
    fn end(&mut self) -> Result<(), OcclusionError>;
}

/// Hardware-independent work of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Tree nodes taken from the queue.
    pub nodes: u64,
    /// Queries asked (a multiquery counts once).
    pub queries: u64,
    /// Boxes of those queries.
    pub boxes: u64,
    /// Batches of queries: changes of state between drawing and asking.
    pub batches: u64,
    /// Waits for an answer with nothing else to do.
    pub stalls: u64,
    /// Queries of previously invisible nodes that came back visible (a multiquery that has to be
    /// asked again counts), and of visible nodes that stayed so: they culled nothing.
    pub wasted: u64,
    /// Draw calls: runs of objects handed to [`Renderer::draw`] count one an object.
    pub draws: u64,
    /// Triangles of the objects drawn.
    pub triangles: u64,
    /// Texels of hierarchical depth written.
    pub pyramid_texels: u64,
    /// Compute dispatches that cull.
    pub dispatches: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.queries += other.queries;
        self.boxes += other.boxes;
        self.batches += other.batches;
        self.stalls += other.stalls;
        self.wasted += other.wasted;
        self.draws += other.draws;
        self.triangles += other.triangles;
        self.pyramid_texels += other.pyramid_texels;
        self.dispatches += other.dispatches;
    }
}

/// When an answer is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// After so many further objects drawn and boxes asked: the same counters on every machine.
    Modelled(u32),
    /// When the device says so.
    Polled,
}

/// The batches under way, by the modelled clock: objects drawn and boxes asked.
#[derive(Clone, Debug, Default)]
pub struct Latency {
    now: u64,
    asked: std::collections::VecDeque<u64>,
}

impl Latency {
    /// So many objects were drawn.
    pub fn drew(&mut self, objects: usize) {
        self.now += objects as u64;
    }

    /// A batch of so many boxes was asked.
    pub fn asked(&mut self, boxes: usize) {
        self.now += boxes as u64;
        self.asked.push_back(self.now);
    }

    /// Whether the oldest batch is at least `latency` operations old; `true` where there is none.
    pub fn ready(&self, latency: u32) -> bool {
        self.asked.front().is_none_or(|then| self.now - then >= u64::from(latency))
    }

    /// The oldest batch was collected; `false` where there was none. Who waits for an answer lets
    /// its time pass.
    pub fn collected(&mut self, latency: u32) -> bool {
        let oldest = self.asked.pop_front();
        if let Some(then) = oldest {
            self.now = self.now.max(then + u64::from(latency));
        }
        oldest.is_some()
    }
}

/// What a renderer drew, rows top to bottom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Object + 1 and triangle within it; [0, 0] where nothing was drawn.
    pub ids: Vec<[u32; 2]>,
    /// Reversed depth, 0 where nothing was drawn.
    pub depth: Vec<f32>,
}

impl Image {
    /// Of that size, with nothing drawn. Keeps the room it had.
    pub fn clear(&mut self, width: u32, height: u32) {
        let pixels = width as usize * height as usize;
        (self.width, self.height) = (width, height);
        self.ids.clear();
        self.ids.resize(pixels, [0, 0]);
        self.depth.clear();
        self.depth.resize(pixels, 0.0);
    }
}
