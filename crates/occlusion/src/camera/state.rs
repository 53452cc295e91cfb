//! What a technique remembers between frames, and what a frame gives.

use super::queue::{Entry, FrontToBack};
use super::{Bounds, Crossing, Objects, Query, Renderer, Tree, Work};
use crate::OcclusionError;
use std::collections::VecDeque;

/// What one frame drew and what that took. Reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Objects drawn, in that order, each once.
    pub drawn: Vec<u32>,
    /// Counters.
    pub work: Work,
}

/// What is remembered of a node. Frames count from 1; 0 is never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// The latest frame that took it from the queue, within the frustum.
    pub visited: u32,
    /// The latest frame in which it counted as visible. Never later than its parent's.
    pub visible: u32,
    /// Visits in a row that found it hidden.
    pub hidden: u32,
    /// Up to this frame a leaf in sight is not asked.
    pub next_query: u32,
}

/// Everything a technique remembers, and its room to work in: nothing is allocated in a frame once
/// the room is large enough.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// One a node.
    pub(super) nodes: Vec<Memory>,
    /// Pixels that each node may cover, one a node; an upper estimate (see
    /// [`Coverage`](super::Coverage)).
    pub(super) coverage: Vec<u32>,
    /// What of the frustum's border each node that this frame found in sight crosses, one a node.
    pub(super) crossing: Vec<Crossing>,
    /// Frames begun.
    pub(super) frame: u32,
    /// Batches asked and not yet collected.
    pub(super) batches: VecDeque<Batch>,
    /// Their queries, oldest first.
    pub(super) asked: VecDeque<Asked>,
    /// The nodes of those queries.
    pub(super) members: VecDeque<u32>,
    /// Room to work in.
    pub(super) room: Room,
}

/// A batch on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    /// The frame that asked.
    pub frame: u32,
    /// Its number of queries.
    pub queries: u32,
    /// Whether the frame that asked waits for it.
    pub awaited: bool,
}

/// A query on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// Number of nodes.
    pub nodes: u32,
    /// Whether its one node is a leaf that was drawn already.
    pub drawn: bool,
}

/// Lists that live for a part of a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Room {
    pub queue: FrontToBack,
    /// Nodes met and not yet looked into, where order does not matter.
    pub open: Vec<u32>,
    /// Leaves to be sorted.
    pub leaves: Vec<Entry>,
    /// Objects decided on and not yet handed to the renderer.
    pub run: Vec<u32>,
    pub boxes: Vec<Bounds>,
    pub queries: Vec<Query>,
    pub counts: Vec<u32>,
    /// Nodes of the answer at hand.
    pub answered: Vec<u32>,
    /// Nodes that were hidden and wait to be asked, numbered.
    pub hidden: Vec<(u32, u32)>,
    /// Leaves that were drawn and wait to be asked with them.
    pub drawn: Vec<u32>,
    /// Leaves that were drawn and are asked when there is nothing else to do.
    pub visible: VecDeque<u32>,
    /// Nodes of groups that have to be asked one by one.
    pub again: Vec<u32>,
    /// Inner nodes traversed in this frame, parents first.
    pub inner: Vec<u32>,
    /// Nodes met in this frame that the frustum does not hold.
    pub outside: Vec<u32>,
    /// Nodes that stand for a node in its query, and their level below it.
    pub tight: Vec<(u32, u32)>,
}

impl Frame {
    /// Counts objects handed to the renderer.
    pub fn drew(&mut self, objects: &Objects, list: &[u32]) {
        self.drawn.extend_from_slice(list);
        self.work.draws += list.len() as u64;
        self.work.triangles +=
            list.iter().map(|&o| u64::from(objects.triangle_count(o))).sum::<u64>();
    }

    /// Empty, with the room it had.
    pub fn clear(&mut self) {
        self.drawn.clear();
        self.work = Work::default();
    }
}

impl State {
    /// Nothing seen yet of the nodes of `tree`.
    pub fn new(tree: &Tree) -> Self {
        let nodes = tree.nodes.len();
        Self {
            nodes: vec![Memory::default(); nodes],
            coverage: vec![0; nodes],
            crossing: vec![Crossing::UNKNOWN; nodes],
            ..Self::default()
        }
    }

    /// Forgets everything. Answers still on their way are waited for and thrown away, so
    /// `renderer` must be the one that was asked.
    ///
    /// # Errors
    /// The renderer's.
    pub fn reset(&mut self, renderer: &mut dyn Renderer) -> Result<(), OcclusionError> {
        let mut result = Ok(());
        while self.batches.pop_front().is_some() && result.is_ok() {
            self.room.counts.clear();
            result = renderer.collect(&mut self.room.counts);
        }
        self.batches.clear();
        self.asked.clear();
        self.members.clear();
        self.forget();
        result
    }

    /// Forgets what was seen, but not what is on its way.
    pub(super) fn forget(&mut self) {
        self.nodes.fill(Memory::default());
        self.coverage.fill(0);
        self.frame = 0;
    }

    /// What is remembered of each node.
    pub fn nodes(&self) -> &[Memory] {
        &self.nodes
    }

    /// Pixels that each node may cover.
    pub fn coverage(&self) -> &[u32] {
        &self.coverage
    }

    /// Where a caller that counts pixels itself stores what each node covers.
    pub fn coverage_mut(&mut self) -> &mut [u32] {
        &mut self.coverage
    }

    /// Frames begun since nothing was known.
    pub fn frames(&self) -> u32 {
        self.frame
    }

    /// Batches asked and not yet collected.
    pub fn under_way(&self) -> usize {
        self.batches.len()
    }

    /// Bytes that grow with the tree.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.nodes[..])
            + size_of_val(&self.coverage[..])
            + size_of_val(&self.crossing[..])) as u64
    }
}
