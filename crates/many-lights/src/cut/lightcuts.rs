//! Lightcuts: the worst node is split until no node matters.
//!
//! Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 3.
//! Deviations: the worst node is compared by the largest linear channel of its bound with that of the
//! whole estimate, not by luminance; nodes may have more than two children, and a cut ends when those
//! of its worst node no longer fit. The scan for the worst node is the thesis's (Melino Conte,
//! "Real-time Rendering of Cities at Night", 2018, section 3.2): the same cut, found otherwise.

use super::walk::children;
use crate::{Lightcuts, Selection};
use glam::DVec3;
use std::{borrow::Borrow, cmp::Ordering, collections::BinaryHeap};

/// A node of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// The node.
    pub node: u32,
    /// What it stands for, nothing where its light is not seen; exact for a leaf.
    pub estimate: DVec3,
    /// Bound of what its lights can give, largest channel; 0 for a leaf, which has no error.
    pub bound: f64,
}

/// A member by its place in the order in which nodes are split: larger bounds first, of equal ones the
/// first node.
#[derive(Clone, Copy, Debug)]
struct Candidate(Member);

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let bounds = self.0.bound.total_cmp(&other.0.bound);
        bounds.then(other.0.node.cmp(&self.0.node))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// Clusters of a cut that may still be split. Kept from pixel to pixel for its memory.
#[derive(Clone, Debug)]
pub struct Open(Container);

#[derive(Clone, Debug)]
enum Container {
    Heap(BinaryHeap<Candidate>),
    Scan(Vec<Candidate>),
}

impl Open {
    /// Room for `most` clusters.
    pub fn new(selection: Selection, most: usize) -> Self {
        Self(match selection {
            Selection::Heap => Container::Heap(BinaryHeap::with_capacity(most)),
            Selection::Scan => Container::Scan(Vec::with_capacity(most)),
        })
    }

    /// Makes room for `most` clusters, where there is less.
    pub fn reserve(&mut self, most: usize) {
        self.clear();
        match &mut self.0 {
            Container::Heap(heap) => heap.reserve_exact(most),
            Container::Scan(list) => list.reserve_exact(most),
        }
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        let most = match &self.0 {
            Container::Heap(heap) => heap.capacity(),
            Container::Scan(list) => list.capacity(),
        };
        (most * size_of::<Candidate>()) as u64
    }

    /// The clusters, in no stated order.
    pub fn members(&self) -> impl Iterator<Item = &Member> {
        let all = match &self.0 {
            Container::Heap(heap) => heap.as_slice(),
            Container::Scan(list) => list.as_slice(),
        };
        all.iter().map(|candidate| &candidate.0)
    }

    fn len(&self) -> usize {
        match &self.0 {
            Container::Heap(heap) => heap.len(),
            Container::Scan(list) => list.len(),
        }
    }

    fn clear(&mut self) {
        match &mut self.0 {
            Container::Heap(heap) => heap.clear(),
            Container::Scan(list) => list.clear(),
        }
    }

    fn push(&mut self, member: Member) {
        match &mut self.0 {
            Container::Heap(heap) => heap.push(Candidate(member)),
            Container::Scan(list) => list.push(Candidate(member)),
        }
    }

    /// Takes the worst cluster out where `split` says so.
    fn take_worst(&mut self, split: impl FnOnce(&Member) -> bool) -> Option<Member> {
        match &mut self.0 {
            Container::Heap(heap) => {
                split(&heap.peek()?.0).then(|| heap.pop())?.map(|worst| worst.0)
            }
            Container::Scan(list) => {
                let (place, worst) = list.iter().enumerate().max_by_key(|(_, one)| **one)?;
                split(&worst.0).then(|| list.swap_remove(place).0)
            }
        }
    }
}

/// What a cut came out as.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Sum of the members' estimates.
    pub radiance: DVec3,
    /// Members that are single lights.
    pub leaves: usize,
    /// Members.
    pub nodes: usize,
    /// Whether it was ended by its greatest size.
    pub ended: bool,
}

/// Makes the cut below `starts` in a tree whose nodes have `size`. `evaluate` gives each node that
/// becomes a member, once. What remains open are the cut's clusters; its single lights pass by in
/// `leaf`. Starts are always members, even beyond the most.
///
/// The whole estimate is kept as a running sum in f64: where a representative that nearly touches the
/// point is split, 1e-16 of its estimate may remain.
pub fn cut(
    settings: &Lightcuts,
    starts: impl IntoIterator<Item: Borrow<u32>>,
    size: impl Fn(u32) -> u32,
    mut evaluate: impl FnMut(u32) -> Member,
    mut leaf: impl FnMut(&Member),
    open: &mut Open,
) -> Found {
    open.clear();
    let mut found = Found::default();
    let mut put = |node: u32, found: &mut Found, open: &mut Open| {
        let member = evaluate(node);
        if size(node) == 1 {
            leaf(&member);
            found.leaves += 1;
            found.radiance += member.estimate;
        } else {
            open.push(member);
        }
        member.estimate
    };
    let mut total = DVec3::ZERO;
    for start in starts {
        total += put(*start.borrow(), &mut found, open);
    }
    loop {
        let limit = settings.epsilon * total.max_element();
        let others = found.leaves + open.len().saturating_sub(1);
        let worst = open.take_worst(|worst| {
            let split = worst.bound > limit;
            let room = (settings.most as usize).saturating_sub(others);
            found.ended = split && children(worst.node, &size).take(room + 1).count() > room;
            split && !found.ended
        });
        let Some(worst) = worst else { break };
        total -= worst.estimate;
        for child in children(worst.node, &size) {
            total += put(child, &mut found, open);
        }
    }
    found.radiance += open.members().map(|member| member.estimate).sum::<DVec3>();
    found.nodes = found.leaves + open.len();
    found
}
