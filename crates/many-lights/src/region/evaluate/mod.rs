//! The lights that may reach a face: clusters between planes, tested against the shadows on them.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.4 and 5.3.3
//! (the steps of Table 5.V).
//! Deviations: planes lie at occluders' far faces; an occluder that a plane cuts is projected by its
//! part before it; a cluster that a plane cuts is divided before its potential is tested, so that each
//! cluster that is strong enough goes to exactly one of steps 9 and 11; children of clusters that are
//! hidden in part are tested from step 7 on; nothing is projected while no shadow is there. Of shadows,
//! only what waiting clusters can touch goes on to the next plane; their projections there, of which the
//! table knows nothing, are not counted.
//!
//! What decides, for a face of depth `[w0, w1]` and planes `p0 = w1 < p1 < ... < infinity`:
//! - Lights without a place are put out at once. Nodes whose box ends before w0 are dropped.
//! - Between p and the next plane q, a cluster with `e1 > q` and `e0 <= q` is divided; with `e1 <= q` it
//!   has its last test, with `e0 > q` an early one; both by its projection on p.
//! - The shadows on q are those on p, moved, and those of all occluders with a part before q and
//!   behind both p and w1, by far face; of both, what the clusters that wait can touch.

mod clock;
mod cluster;
mod heights;
mod planes;

pub use clock::Parts;
pub use heights::MOST_HEIGHTS;

use super::{
    Cuboid, Direction, FacadeCluster, Fusion, Occluders, Precuts, Split, Steps, Turn, Turned,
    ViewCell,
    fusion::{Horizon, Verdict, around, asked_part, nothing_yet},
    horizon::{Projection, Supports, Umbra, umbra},
    potential::{is_too_weak, white},
};
use crate::{Emission, LightTree, bound::Region};
use clock::{Clock, Part};
use cluster::{Cluster, Sight, UNDIVIDED, UNPROJECTED};
use planes::{Order, Sweep};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Facade-cluster visibility made ready for one light tree. Takes nothing from the heap once every
/// turn was met and the lists have grown.
pub struct Evaluator {
    tree: Arc<LightTree>,
    occluders: Arc<Occluders>,
    clamp_m: f64,
    settings: FacadeCluster,
    /// By the bits of the turn's axis.
    turns: BTreeMap<[u64; 2], Facing>,
    sweep: Sweep,
    horizon: Horizon,
    shadows: Vec<Umbra>,
    queues: Queues,
    steps: Steps,
    clock: Clock,
    height_steps: Steps,
    /// Places of nodes whose height is not found yet.
    open: Vec<u32>,
    /// By place: whether any of the face's points may see the node.
    seen: Vec<bool>,
}

/// The occluders of a turn.
struct Facing {
    turned: Arc<Turned>,
    orders: [Option<Order>; 4],
}

/// Clusters between two planes.
#[derive(Default)]
struct Queues {
    /// Not looked at yet.
    waiting: Vec<Cluster>,
    /// For a last test.
    last: Vec<Cluster>,
    /// For an early test.
    early: Vec<Cluster>,
    /// What clusters' projections have in common, where that is kept.
    supports: Vec<Supports>,
}

/// What becomes of clusters that are left.
enum Sink<'a> {
    /// Their nodes are put out.
    Nodes(&'a mut Vec<u32>),
    /// By start node: whether anything of it is left.
    Seen(&'a mut [bool]),
}

/// What is asked of one evaluation.
struct Question {
    sight: Sight,
    /// The face in the direction's space.
    face: Cuboid,
    /// Its surfaces, white.
    white: Region,
    threshold: f64,
}

impl Evaluator {
    /// Ready for the lights of a tree behind occluders. `clamp_m` is [`crate::World::clamp_m`].
    pub fn new(
        tree: Arc<LightTree>,
        occluders: Arc<Occluders>,
        clamp_m: f64,
        settings: FacadeCluster,
    ) -> Self {
        Self {
            tree,
            occluders,
            clamp_m,
            settings,
            turns: BTreeMap::new(),
            sweep: Sweep::default(),
            horizon: Horizon::new(settings.fusion),
            shadows: Vec::new(),
            queues: Queues::default(),
            steps: Steps::default(),
            clock: Clock::default(),
            height_steps: Steps::default(),
            open: Vec::new(),
            seen: Vec::new(),
        }
    }

    /// Whether evaluations are timed part by part from here on. It costs a few clock reads a plane.
    pub fn time(&mut self, timed: bool) {
        self.clock.run(timed);
    }

    /// Times since it was made ready; 0 where none were asked for.
    pub fn parts(&self) -> &Parts {
        &self.clock.parts
    }

    /// Makes the occluders of a turn and a direction ready, where that was not done.
    fn face(&mut self, turn: Turn, direction: Direction) {
        let facing = self.turns.entry(key(turn)).or_insert_with(|| Facing {
            turned: self.occluders.turned(turn, self.settings.occluders),
            orders: [const { None }; 4],
        });
        let order = &mut facing.orders[direction.index()];
        if order.is_none() {
            *order = Some(Order::of(&facing.turned.solids, direction));
        }
    }

    /// Steps 5 to 14: every start node is `waiting`; what is left goes to `sink`.
    fn evaluate(&mut self, question: &Question, sink: &mut Sink<'_>) {
        let facing = self.turns.get(&key(question.sight.turn));
        let Some((facing, order)) = facing.and_then(|facing| {
            let order = facing.orders[question.sight.direction.index()].as_ref()?;
            Some((facing, order))
        }) else {
            return;
        };
        let Question { sight, face, .. } = question;
        let front = face.w[1];
        self.horizon.clear();
        self.sweep.start(order, front);
        self.queues.supports.clear();
        let mut plane = front;
        while !self.queues.waiting.is_empty() {
            self.steps.iterations += 1;
            let settings = &self.settings;
            let next = order.next(front, plane, settings.planes, settings.least_step_m);
            let mut tests = Tests {
                tree: &self.tree,
                horizon: &self.horizon,
                clamp_m: self.clamp_m,
                split: settings.split,
                fusion: settings.fusion,
                cached: settings.cached,
                steps: &mut self.steps,
                question,
                plane,
                next: next.unwrap_or(f64::INFINITY),
            };
            self.clock.book(Part::Sorting);
            while !self.queues.waiting.is_empty() {
                tests.sort_out(&mut self.queues, sink);
                self.clock.book(Part::Potential);
                tests.last(&mut self.queues, sink);
                self.clock.book(Part::Last);
            }
            let asked = tests.early(&mut self.queues);
            self.clock.book(Part::Early);
            let Some(next) = next.filter(|_| !self.queues.waiting.is_empty()) else { break };
            self.steps.reprojections += 1;
            if !self.horizon.is_empty() {
                self.steps.moved += self.horizon.reproject_asked(face, [plane, next], &asked);
            }
            self.clock.book(Part::Reprojection);
            self.steps.projections += 1;
            self.sweep.advance(order, plane, next);
            self.shadows.clear();
            for solid in self.sweep.active(order) {
                self.steps.projected += 1;
                let solid = &facing.turned.solids[solid as usize];
                let solid = sight.direction.cuboid(solid.min, solid.max);
                let shadow = umbra(face, &solid, next, self.settings.edge);
                self.shadows.extend(shadow.and_then(|shadow| asked_part(&shadow, &asked)));
            }
            self.horizon.add(&self.shadows);
            self.clock.book(Part::Projection);
            plane = next;
        }
        self.queues.waiting.clear();
    }
}

impl Sink<'_> {
    fn put(&mut self, cluster: &Cluster) {
        match self {
            Self::Nodes(nodes) => nodes.push(cluster.node),
            Self::Seen(seen) => seen[cluster.start as usize] = true,
        }
    }

    /// Whether it does not matter any more what becomes of a cluster.
    fn is_known(&self, cluster: &Cluster) -> bool {
        match self {
            Self::Nodes(_) => false,
            Self::Seen(seen) => seen[cluster.start as usize],
        }
    }
}

/// The tests between one plane and the next.
struct Tests<'a> {
    tree: &'a LightTree,
    horizon: &'a Horizon,
    clamp_m: f64,
    split: Split,
    fusion: Fusion,
    cached: bool,
    steps: &'a mut Steps,
    question: &'a Question,
    plane: f64,
    next: f64,
}

impl Tests<'_> {
    /// 6 to 8: each waiting cluster is dropped, divided, culled, or goes to one of the tests.
    fn sort_out(&mut self, queues: &mut Queues, sink: &Sink<'_>) {
        let Queues { waiting, last, early, .. } = queues;
        let Question { sight, face, white, threshold } = self.question;
        while let Some(mut cluster) = waiting.pop() {
            let [near, far] = cluster.cuboid.w;
            if far < face.w[0] || sink.is_known(&cluster) {
                continue;
            }
            let node = &self.tree.nodes[cluster.node as usize];
            // The box of a leaf is a point.
            if near <= self.next && far > self.next && !node.is_leaf() {
                self.steps.straddling += 1;
                sight.divide(self.tree, &cluster, cluster.levels, waiting);
                continue;
            }
            self.steps.potential += 1;
            if !cluster.strong {
                if is_too_weak(node, white, self.clamp_m, *threshold) {
                    self.steps.potential_culled += 1;
                    continue;
                }
                cluster.strong = true;
            }
            if near > self.next { early.push(cluster) } else { last.push(cluster) }
        }
    }

    /// 9 and 10: each cluster is hidden, put out, or divided.
    fn last(&mut self, queues: &mut Queues, sink: &mut Sink<'_>) {
        while let Some(mut cluster) = queues.last.pop() {
            self.steps.last += 1;
            let all = &mut queues.supports;
            let (verdict, _) = self.test(&mut cluster, all, |steps| &mut steps.last_projected);
            if verdict == Verdict::Hidden {
                self.steps.last_culled += 1;
                continue;
            }
            let levels = match (cluster.levels, self.split) {
                (UNDIVIDED, Split::All) => UNDIVIDED,
                (UNDIVIDED, Split::Levels(levels)) => levels.min(UNDIVIDED - 1),
                (levels, _) => levels,
            };
            let inner = self.tree.nodes[cluster.node as usize].size > 1;
            if verdict == Verdict::Partial && inner && levels > 0 {
                self.steps.last_divided += 1;
                let levels = if levels == UNDIVIDED { levels } else { levels - 1 };
                let sight = &self.question.sight;
                sight.divide(self.tree, &cluster, levels, &mut queues.waiting);
            } else {
                self.steps.last_output += 1;
                sink.put(&cluster);
            }
        }
    }

    /// 11 and 12: what is not hidden waits for the next plane. Around its projections there.
    fn early(&mut self, queues: &mut Queues) -> Projection {
        let mut asked = nothing_yet(self.fusion);
        while let Some(mut cluster) = queues.early.pop() {
            self.steps.early += 1;
            let all = &mut queues.supports;
            let (verdict, supports) =
                self.test(&mut cluster, all, |steps| &mut steps.early_projected);
            if verdict == Verdict::Hidden {
                self.steps.early_culled += 1;
                continue;
            }
            let supports =
                supports.unwrap_or_else(|| Supports::of(&self.question.face, &cluster.cuboid));
            asked = around(&asked, &supports.on(self.next));
            queues.waiting.push(cluster);
        }
        asked
    }

    /// The cluster against the shadows on the plane; `count` is of projections.
    fn test(
        &mut self,
        cluster: &mut Cluster,
        all: &mut Vec<Supports>,
        count: fn(&mut Steps) -> &mut u64,
    ) -> (Verdict, Option<Supports>) {
        // Clusters beside the cell, before the first plane, have no projection.
        if self.horizon.is_empty() {
            return (Verdict::Free, None);
        }
        let supports = match all.get(cluster.supports as usize) {
            Some(kept) => *kept,
            None => {
                *count(self.steps) += 1;
                let supports = Supports::of(&self.question.face, &cluster.cuboid);
                if self.cached && all.len() < UNPROJECTED as usize {
                    cluster.supports = all.len() as u32;
                    all.push(supports);
                }
                supports
            }
        };
        let verdict = self.horizon.test(&supports.on(self.plane), &mut self.steps.compared);
        (verdict, Some(supports))
    }
}

impl Precuts for Evaluator {
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>) {
        nodes.clear();
        let Some(face) = cell.face(direction) else { return };
        self.clock.begin();
        self.steps.evaluations += 1;
        let sight = Sight { turn: cell.turn, direction };
        self.queues.waiting.clear();
        for &root in &self.tree.roots {
            if self.tree.nodes[root as usize].kind == Emission::Directional.code() {
                nodes.push(root);
            } else {
                self.queues.waiting.push(sight.start(&self.tree, root, root));
            }
        }
        self.face(cell.turn, direction);
        let (face, white) = (face.cuboid(direction), white(&face.region));
        let question = Question { sight, face, white, threshold: self.settings.threshold };
        self.evaluate(&question, &mut Sink::Nodes(nodes));
        nodes.sort_unstable();
        self.steps.output += nodes.len() as u64;
        self.clock.book(Part::Sorting);
    }

    fn steps(&self) -> &Steps {
        &self.steps
    }

    fn bytes(&self) -> u64 {
        let queues = [&self.queues.waiting, &self.queues.last, &self.queues.early];
        let queues: usize = queues.iter().map(|q| q.capacity() * size_of::<Cluster>()).sum();
        let orders = self.turns.values().flat_map(|facing| facing.orders.iter().flatten());
        let orders: u64 = orders.map(Order::bytes).sum();
        let shadows = self.shadows.capacity() * size_of::<Umbra>();
        let supports = self.queues.supports.capacity() * size_of::<Supports>();
        let lists = self.open.capacity() * size_of::<u32>() + self.seen.capacity();
        (queues + supports + shadows + lists) as u64
            + orders
            + self.sweep.bytes()
            + self.horizon.bytes()
    }
}

fn key(turn: Turn) -> [u64; 2] {
    turn.axis().to_array().map(f64::to_bits)
}
