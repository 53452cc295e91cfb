//! What all techniques do: walking the tree, drawing, asking, and remembering answers.
//!
//! Limit: a node that is met costs its entry of the tree (44 bytes, siblings side by side), a byte of
//! what it crosses, an entry of the queue (16 bytes) and what is remembered of it (20 bytes), and few
//! operations: the planes that its parent crosses, and a distance. Seen on one core of a server
//! (2026, `camera_times` along the street of `city`, 256 x 144), with the queries made: CHC 93 ns a
//! node, CHC++ 86 ns, stop-and-wait 82 ns. With five planes and the guard band computed for every
//! node, the latter twice, and pairs in the queue, it was 249, 246 and 167 ns.

use super::{jitter, tight_bounds};
use crate::OcclusionError;
use crate::camera::coverage::sum_up;
use crate::camera::settings::{Coverage, Settings, TightBounds};
use crate::camera::state::{Asked, Batch, Frame, Memory, State};
use crate::camera::{Crossing, Objects, Query, Renderer, Tree, View};

/// A frame under way.
pub(super) struct Walk<'a> {
    pub settings: &'a Settings,
    pub objects: &'a Objects,
    pub tree: &'a Tree,
    pub view: &'a View,
    pub state: &'a mut State,
    pub renderer: &'a mut dyn Renderer,
    pub out: &'a mut Frame,
}

/// One query's answer; its nodes are in the state's `room.answered`.
pub(super) struct Answer {
    /// The frame that asked.
    pub frame: u32,
    /// Whether its one node is a leaf that was drawn already.
    pub drawn: bool,
    /// Samples that showed.
    pub pixels: u32,
    /// Whether they are more than the threshold.
    pub visible: bool,
}

impl Walk<'_> {
    /// Starts the frame.
    pub fn begin(&mut self) -> Result<(), OcclusionError> {
        // Far from the end of the numbers, so that spans added to a frame's do not wrap.
        if self.state.frame > u32::MAX / 2 {
            self.state.forget();
            self.state.batches.iter_mut().for_each(|batch| batch.frame = 0);
        }
        self.state.frame += 1;
        let room = &mut self.state.room;
        room.queue.clear();
        room.run.clear();
        room.boxes.clear();
        room.queries.clear();
        room.hidden.clear();
        room.drawn.clear();
        room.visible.clear();
        room.again.clear();
        room.inner.clear();
        room.outside.clear();
        self.renderer.begin(self.view)
    }

    /// Ends the frame.
    pub fn end(&mut self) -> Result<(), OcclusionError> {
        self.flush()?;
        // Last, as an answer about an earlier frame may have come in between.
        while let Some(node) = self.state.room.outside.pop() {
            self.cover(node, 0);
        }
        if self.settings.coverage == Coverage::Summed {
            sum_up(self.tree, &self.state.room.inner, &mut self.state.coverage);
        }
        self.renderer.end()
    }

    /// The root, if the frustum holds it.
    pub fn root(&mut self) -> Option<u32> {
        (!self.tree.nodes.is_empty() && self.meet(0, Crossing::UNKNOWN)).then_some(0)
    }

    /// Puts the root into the queue.
    pub fn enter(&mut self) {
        if let Some(root) = self.root() {
            self.enqueue(root);
        }
    }

    fn enqueue(&mut self, node: u32) {
        let distance = self.view.distance(&self.tree.nodes[node as usize].bounds);
        self.state.room.queue.push(distance, node);
    }

    /// The nearest node of the queue.
    pub fn next(&mut self) -> Option<u32> {
        self.state.room.queue.pop()
    }

    /// Whether the frustum holds a node. `above` is what its parent crosses.
    fn meet(&mut self, node: u32, above: Crossing) -> bool {
        self.out.work.nodes += 1;
        let crossing = self.view.crossing(&self.tree.nodes[node as usize].bounds, above);
        match crossing {
            Some(crossing) => self.state.crossing[node as usize] = crossing,
            None => self.state.room.outside.push(node),
        }
        crossing.is_some()
    }

    /// Hands on those children of an inner node that the frustum holds.
    pub fn open(&mut self, node: u32, mut each: impl FnMut(&mut Self, u32)) {
        self.state.room.inner.push(node);
        let above = self.state.crossing[node as usize];
        for child in self.tree.nodes[node as usize].children.clone() {
            if self.meet(child, above) {
                each(self, child);
            }
        }
    }

    /// Whether `node` cannot be asked.
    pub fn touches(&mut self, node: u32) -> bool {
        let crossing = self.state.crossing[node as usize];
        if !crossing.may_touch() {
            return false;
        }
        let touches = self.view.touches(&self.tree.nodes[node as usize].bounds);
        if touches {
            self.cover(node, self.view.width.saturating_mul(self.view.height));
        } else {
            self.state.crossing[node as usize] = crossing.without_touch();
        }
        touches
    }

    /// What was remembered of `node` until now; from now on it is visited in this frame.
    pub fn visit(&mut self, node: u32) -> Memory {
        let frame = self.state.frame;
        let memory = &mut self.state.nodes[node as usize];
        if memory.visited + 1 != frame {
            memory.hidden = 0;
        }
        let before = *memory;
        memory.visited = frame;
        before
    }

    /// Whether the last frame did not visit a node.
    pub fn is_unknown(&self, before: Memory) -> bool {
        before.visited == 0 || before.visited + 1 != self.state.frame
    }

    /// Whether a node counted as visible in the last frame.
    pub fn was_visible(&self, before: Memory) -> bool {
        before.visible != 0 && before.visible + 1 == self.state.frame
    }

    /// Draws a leaf, puts those children of an inner node into the queue that the frustum holds.
    pub fn traverse(&mut self, node: u32) {
        if self.tree.is_leaf(node) {
            self.draw(self.tree.objects_of(node));
        } else {
            self.open(node, Self::enqueue);
        }
    }

    /// Draws objects; the renderer gets them before it is next asked anything.
    pub fn draw(&mut self, objects: &[u32]) {
        self.state.room.run.extend_from_slice(objects);
        self.out.drew(self.objects, objects);
    }

    fn flush(&mut self) -> Result<(), OcclusionError> {
        let run = &mut self.state.room.run;
        if !run.is_empty() {
            self.renderer.draw(run)?;
            run.clear();
        }
        Ok(())
    }

    /// `node` and all that hold it count as visible in `frame`.
    pub fn pull_up(&mut self, node: u32, frame: u32) {
        let mut at = node as usize;
        while self.state.nodes[at].visible < frame {
            self.state.nodes[at].visible = frame;
            at = self.tree.nodes[at].parent as usize;
        }
    }

    fn cover(&mut self, node: u32, pixels: u32) {
        if self.settings.coverage != Coverage::Exact {
            self.state.coverage[node as usize] = pixels;
        }
    }

    /// Makes one query of `nodes`. `drawn` says of a single leaf that it was drawn already.
    pub fn query(&mut self, nodes: &[u32], drawn: bool, tight: TightBounds) {
        let state = &mut *self.state;
        let room = &mut state.room;
        let start = room.boxes.len() as u32;
        for &node in nodes {
            tight_bounds::cut(self.tree, node, tight, &mut room.tight);
            let boxes = room.tight.iter().map(|&(n, _)| self.tree.nodes[n as usize].bounds);
            room.boxes.extend(boxes);
            state.members.push_back(node);
        }
        room.queries.push(Query { boxes: start..room.boxes.len() as u32 });
        state.asked.push_back(Asked { nodes: nodes.len() as u32, drawn });
    }

    /// Asks the queries made as one batch. `awaited` says that this frame needs the answers.
    pub fn ask(&mut self, awaited: bool) -> Result<(), OcclusionError> {
        self.flush()?;
        let state = &mut *self.state;
        let (boxes, queries) = (&mut state.room.boxes, &mut state.room.queries);
        if queries.is_empty() {
            return Ok(());
        }
        let batch = Batch { frame: state.frame, queries: queries.len() as u32, awaited };
        self.renderer.ask(boxes, queries)?;
        state.batches.push_back(batch);
        self.out.work.batches += 1;
        self.out.work.queries += queries.len() as u64;
        self.out.work.boxes += boxes.len() as u64;
        boxes.clear();
        queries.clear();
        Ok(())
    }

    /// Whether the oldest batch can be collected without waiting.
    pub fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.flush()?;
        self.renderer.ready()
    }

    /// Whether an answer is on its way that this frame waits for.
    pub fn awaits(&self) -> bool {
        self.state.batches.iter().any(|b| b.awaited)
    }

    /// Collects the oldest batch: [`answer`](Self::answer) then gives its answers one by one.
    pub fn collect(&mut self) -> Result<Batch, OcclusionError> {
        self.flush()?;
        let counts = &mut self.state.room.counts;
        counts.clear();
        self.renderer.collect(counts)?;
        let given = counts.len();
        // Answers are taken from the end.
        counts.reverse();
        let batch = self.state.batches.pop_front();
        match batch {
            Some(batch) if batch.queries as usize == given => Ok(batch),
            _ => {
                let asked = batch.map_or(0, |b| b.queries);
                let limit = format!("{given} answers to {asked} queries");
                Err(OcclusionError::value("renderer", limit))
            }
        }
    }

    /// The next answer of the batch last collected.
    pub fn answer(&mut self, batch: Batch) -> Option<Answer> {
        let state = &mut *self.state;
        let pixels = state.room.counts.pop()?;
        let asked = state.asked.pop_front()?;
        state.room.answered.clear();
        state.room.answered.extend(state.members.drain(..asked.nodes as usize));
        let visible = pixels > self.settings.threshold_px;
        if visible {
            self.out.work.wasted += 1;
        }
        Some(Answer { frame: batch.frame, drawn: asked.drawn, pixels, visible })
    }

    /// Remembers what an answer says of each of its nodes, save whether they count as visible. An
    /// answer that shows a group says nothing of any of them.
    pub fn remember(&mut self, answer: &Answer) {
        let nodes = std::mem::take(&mut self.state.room.answered);
        if !answer.visible || nodes.len() == 1 {
            for &node in &nodes {
                self.cover(node, answer.pixels);
                let memory = &mut self.state.nodes[node as usize];
                memory.hidden = if answer.visible { 0 } else { memory.hidden.saturating_add(1) };
            }
        }
        self.state.room.answered = nodes;
    }

    /// The frame from which a leaf that was shown in `frame` is asked again. `first` says that it
    /// was hidden before.
    pub fn next_query(&self, node: u32, frame: u32, first: bool) -> u32 {
        let most = self.settings.assumed_visible;
        let span = match first && self.settings.jitter {
            true => jitter::span(self.settings.seed, node, frame, most),
            false => most,
        };
        frame + 1 + span
    }
}
