//! The best partner of a cluster among all that are left.
//!
//! Based on: B. Walter et al., "Fast agglomerative clustering for rendering", 2008, section 3.2.
//! Deviations: the tree is made anew whenever half of its clusters are gone, and what is joined takes
//! the place of one of its parts in between. Boxes of nodes are not those of what lies below: of each
//! side the innermost is kept, which bounds the box of a join more closely.

use super::{
    cluster::{Cluster, Metric},
    median::halve,
};
use glam::DVec3;
use std::cmp::Ordering;

/// Clusters in a leaf of the search tree.
const LEAF: usize = 4;

const NONE: u32 = u32::MAX;

/// A pair, in the order in which pairs are joined: by cost, then by numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Partner {
    pub cost: f64,
    pub low: u32,
    pub high: u32,
}

impl Partner {
    fn of(cost: f64, a: u32, b: u32) -> Self {
        Self { cost, low: a.min(b), high: a.max(b) }
    }

    /// The one of the two that is not `id`.
    pub fn other(&self, id: u32) -> u32 {
        if self.low == id { self.high } else { self.low }
    }
}

impl Eq for Partner {}

impl Ord for Partner {
    fn cmp(&self, other: &Self) -> Ordering {
        let cost = self.cost.total_cmp(&other.cost);
        cost.then(self.low.cmp(&other.low)).then(self.high.cmp(&other.high))
    }
}

impl PartialOrd for Partner {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What is known of all clusters below a node of the search tree: the metric is at least that of this.
#[derive(Clone, Copy, Debug)]
struct Least {
    /// The greatest lower and the least upper corner.
    min: DVec3,
    max: DVec3,
    intensity: f64,
    id: u32,
}

const EMPTY: Least =
    Least { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY, intensity: f64::INFINITY, id: NONE };

impl Least {
    fn with(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
            intensity: self.intensity.min(other.intensity),
            id: self.id.min(other.id),
        }
    }

    /// At most the pair of `cluster` with any below. Every step rounds as the metric itself does, and
    /// rounding keeps the order: this holds to the last bit.
    fn bound(&self, cluster: &Cluster, turned: f64, id: u32) -> Partner {
        let diagonal = (cluster.max.max(self.max) - cluster.min.min(self.min)).length_squared();
        let cost = (cluster.intensity + self.intensity) * (diagonal + turned);
        Partner::of(cost, id, self.id)
    }
}

/// Clusters that are left, and a tree to search them.
pub(super) struct Partners<'a> {
    metric: &'a Metric,
    /// By number; the first ones are the lights.
    clusters: Vec<Cluster>,
    /// Place of each cluster in `slots`, `NONE` once it is joined.
    slot_of: Vec<u32>,
    /// The cluster at each place of the search tree's leaves, or `NONE`.
    slots: Vec<u32>,
    /// A complete binary tree: the children of node i are 2 i and 2 i + 1; the last half are leaves.
    nodes: Vec<Least>,
    alive: usize,
    stack: Vec<(Partner, u32)>,
}

impl<'a> Partners<'a> {
    pub fn new(metric: &'a Metric, clusters: Vec<Cluster>) -> Self {
        let ids: Vec<u32> = (0..clusters.len() as u32).collect();
        let mut all = Self {
            metric,
            slot_of: vec![NONE; clusters.len()],
            slots: Vec::new(),
            nodes: Vec::new(),
            alive: clusters.len(),
            stack: Vec::new(),
            clusters,
        };
        all.plant(ids);
        all
    }

    pub fn is_alive(&self, id: u32) -> bool {
        self.slot_of[id as usize] != NONE
    }

    /// Replaces two by what they are together, whose number it returns.
    pub fn join(&mut self, a: u32, b: u32) -> u32 {
        let id = self.clusters.len() as u32;
        let joined = self.clusters[a as usize].joined(&self.clusters[b as usize]);
        self.clusters.push(joined);
        let (kept, gone) = (self.slot_of[a as usize], self.slot_of[b as usize]);
        (self.slot_of[a as usize], self.slot_of[b as usize]) = (NONE, NONE);
        self.slot_of.push(kept);
        self.slots[kept as usize] = id;
        self.slots[gone as usize] = NONE;
        self.alive -= 1;
        if 2 * self.alive * LEAF <= self.slots.len() && self.alive > LEAF {
            let left = self.slots.iter().copied().filter(|&id| id != NONE).collect();
            self.plant(left);
        } else {
            self.renew(gone as usize / LEAF);
            self.renew(kept as usize / LEAF);
        }
        id
    }

    /// The least pair that holds `id`.
    pub fn best(&mut self, id: u32) -> Option<Partner> {
        let cluster = self.clusters[id as usize];
        let turned = self.metric.turned(cluster.cosine());
        let mut best: Option<Partner> = None;
        let leaves = self.nodes.len() / 2;
        self.stack.clear();
        self.stack.push((self.nodes[1].bound(&cluster, turned, id), 1));
        while let Some((bound, node)) = self.stack.pop() {
            if best.is_some_and(|best| bound >= best) {
                continue;
            }
            let node = node as usize;
            if node >= leaves {
                let first = (node - leaves) * LEAF;
                for &other in &self.slots[first..first + LEAF] {
                    if other != NONE && other != id {
                        let cost = self.metric.cost(&cluster, &self.clusters[other as usize]);
                        let pair = Partner::of(cost, id, other);
                        best = Some(best.map_or(pair, |best| best.min(pair)));
                    }
                }
                continue;
            }
            let child = |child: usize| {
                let least = &self.nodes[child];
                (least.bound(&cluster, turned, id), child as u32)
            };
            let (near, far) = (child(2 * node), child(2 * node + 1));
            let (near, far) = if far.0 < near.0 { (far, near) } else { (near, far) };
            for (bound, next) in [far, near] {
                if self.nodes[next as usize].id != NONE {
                    self.stack.push((bound, next));
                }
            }
        }
        best
    }

    /// A search tree over `ids`, in halves.
    fn plant(&mut self, mut ids: Vec<u32>) {
        let leaves = ids.len().div_ceil(LEAF).max(1).next_power_of_two();
        self.slots.clear();
        self.slots.resize(leaves * LEAF, NONE);
        self.nodes.clear();
        self.nodes.resize(2 * leaves, EMPTY);
        let clusters = &self.clusters;
        place(&|id| clusters[id as usize].middle(), &mut ids, &mut self.slots);
        for (slot, &id) in (0..).zip(&self.slots) {
            if id != NONE {
                self.slot_of[id as usize] = slot;
            }
        }
        for leaf in 0..leaves {
            self.nodes[leaves + leaf] = self.leaf(leaf);
        }
        for node in (1..leaves).rev() {
            self.nodes[node] = self.nodes[2 * node].with(&self.nodes[2 * node + 1]);
        }
    }

    fn leaf(&self, leaf: usize) -> Least {
        let slots = &self.slots[leaf * LEAF..(leaf + 1) * LEAF];
        slots.iter().filter(|&&id| id != NONE).fold(EMPTY, |least, &id| {
            let Cluster { min, max, intensity, .. } = self.clusters[id as usize];
            least.with(&Least { min, max, intensity, id })
        })
    }

    /// Follows a change of a leaf up to the root.
    fn renew(&mut self, leaf: usize) {
        let mut node = self.nodes.len() / 2 + leaf;
        self.nodes[node] = self.leaf(leaf);
        while node > 1 {
            node /= 2;
            self.nodes[node] = self.nodes[2 * node].with(&self.nodes[2 * node + 1]);
        }
    }
}

/// Spreads `ids` over places, a power of two times [`LEAF`] of them.
fn place(at: &impl Fn(u32) -> DVec3, ids: &mut [u32], slots: &mut [u32]) {
    if slots.len() <= LEAF || ids.len() < 2 {
        slots[..ids.len()].copy_from_slice(ids);
        return;
    }
    let (left, right) = halve(at, ids);
    let (left_slots, right_slots) = slots.split_at_mut(slots.len() / 2);
    place(at, left, left_slots);
    place(at, right, right_slots);
}
