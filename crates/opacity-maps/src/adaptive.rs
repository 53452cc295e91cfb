//! Adaptive volumetric shadow map: N nodes of transmittance, each fragment inserted as it comes.
//!
//! Based on: Marco Salvi, Kiril Vidimče, Andrew Lauritzen, Aaron Lefohn, "Adaptive volumetric
//! shadow maps", Computer Graphics Forum 29(4) (EGSR), 2010, §4.1 (insertion: a segment multiplies
//! all nodes behind it) and §4.2 (compression: remove the node whose removal changes the area
//! under the curve least).
//!
//! A fragment is infinitely thin, so that the curve is a staircase: node i holds a depth d_i and
//! the transmittance T_i behind it, up to and including d_(i+1). Removing node i lets T_(i-1) go
//! on to d_(i+1), an area of (T_(i-1) - T_i)(d_(i+1) - d_i): the fragment moves back to the next
//! node. The last node is never removed. So T is 1 up to and including the first fragment's depth
//! and e^-Σω behind the last, is monotone, and is never darker than the truth: every removal
//! brightens, and removals add up. With as many nodes as there are different depths it is exact.
//!
//! Deviations: nodes are kept by insertion into one array with room for N + 1 (the authors' locks
//! on the graphics device are not needed); areas and products are worked out in f64 and rounded
//! when a texel is done, so that rounding never decides which node goes (a form in f32 may differ
//! where two areas nearly agree). Which nodes stay depends on the order of drawing
//! ([`Order::Sorted`](crate::Order::Sorted) sorts first).

use crate::{Adaptive, Fragment, Order, code::TexelCode, gather};

/// Most nodes of a texel.
const MOST_NODES: usize = 64;

/// Depth of a node that is not in use: no receiver lies behind it.
const UNUSED: f32 = f32::MAX;

/// N pairs of depth and transmittance, by depth.
pub struct Code(pub Adaptive);

/// A node while it is built.
#[derive(Clone, Copy, Default)]
struct Node {
    depth: f64,
    /// Behind it.
    t: f64,
}

/// Nodes by depth; room for one more than is kept.
struct Nodes {
    nodes: [Node; MOST_NODES + 1],
    len: usize,
}

impl Nodes {
    fn insert(&mut self, depth: f64, omega: f64) {
        let through = (-omega).exp();
        // From behind: what is drawn in order comes last.
        let mut at = self.len;
        while at > 0 && self.nodes[at - 1].depth > depth {
            self.nodes[at] = self.nodes[at - 1];
            self.nodes[at].t *= through;
            at -= 1;
        }
        let before = if at == 0 { 1.0 } else { self.nodes[at - 1].t };
        self.nodes[at] = Node { depth, t: before * through };
        self.len += 1;
    }

    fn remove_least(&mut self) {
        let mut least = (0, f64::INFINITY);
        let mut before = 1.0;
        for (i, pair) in self.nodes[..self.len].windows(2).enumerate() {
            let area = (before - pair[0].t) * (pair[1].depth - pair[0].depth);
            if area < least.1 {
                least = (i, area);
            }
            before = pair[0].t;
        }
        self.nodes.copy_within(least.0 + 1..self.len, least.0);
        self.len -= 1;
    }
}

impl TexelCode for Code {
    fn words(&self) -> usize {
        2 * self.0.nodes as usize
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let most = (self.0.nodes as usize).min(MOST_NODES);
        let mut nodes = Nodes { nodes: [Node::default(); MOST_NODES + 1], len: 0 };
        let mut insert = |f: Fragment| {
            nodes.insert(f64::from(f.depth), f64::from(f.omega));
            if nodes.len > most {
                nodes.remove_least();
            }
        };
        match self.0.order {
            Order::Drawn => gather::everything(fragments, opaque).for_each(insert),
            Order::Sorted => {
                gather::sorted(fragments, opaque, scratch);
                scratch.iter().for_each(|f| insert(*f));
            }
        }
        for (i, node) in words.chunks_exact_mut(2).enumerate() {
            let used = nodes.nodes[..nodes.len].get(i);
            node.copy_from_slice(&used.map_or([UNUSED, 0.0], |n| [n.depth as f32, n.t as f32]));
        }
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        // Nodes are few: from the front, as a shader would.
        words.chunks_exact(2).take_while(|node| node[0] < depth).last().map_or(1.0, |node| node[1])
    }

    fn bytes_per_texel(&self) -> u64 {
        8 * u64::from(self.0.nodes)
    }

    fn geometry_passes(&self) -> u64 {
        1
    }
}

/// The same staircase in f64: after each fragment the whole list is made anew, sorted, and the
/// node of least area left out. The processor's form differs by the rounding of its last store.
pub fn reference(
    settings: &Adaptive,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    depth: f32,
) -> f64 {
    let mut all: Vec<Fragment> = gather::everything(fragments, opaque).collect();
    if settings.order == Order::Sorted {
        all.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.omega.total_cmp(&b.omega)));
    }
    // (depth, transmittance behind it)
    let mut curve: Vec<(f64, f64)> = Vec::new();
    for f in all {
        let (d, through) = (f64::from(f.depth), (-f64::from(f.omega)).exp());
        let before = curve.iter().rfind(|node| node.0 <= d).map_or(1.0, |node| node.1);
        let (mut front, behind): (Vec<_>, Vec<_>) = curve.iter().partition(|node| node.0 <= d);
        front.push((d, before * through));
        front.extend(behind.into_iter().map(|(d, t)| (d, t * through)));
        curve = front;
        if curve.len() > settings.nodes as usize {
            let area = |i: usize| {
                let before = if i == 0 { 1.0 } else { curve[i - 1].1 };
                (before - curve[i].1) * (curve[i + 1].0 - curve[i].0)
            };
            let least = (0..curve.len() - 1).min_by(|&a, &b| area(a).total_cmp(&area(b)));
            curve.remove(least.unwrap_or(0));
        }
    }
    curve.iter().rfind(|node| node.0 < f64::from(depth)).map_or(1.0, |node| node.1)
}
