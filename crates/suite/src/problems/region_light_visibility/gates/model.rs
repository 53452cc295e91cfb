//! Facade-cluster visibility spelled out once more, so that each of its parts can be put wrong.
//!
//! Without a fault it is the technique: the gate `P1 model` holds it to that. What a fault of a part
//! does to the lights that are left out is then seen by rays, the same that judge the technique.

use super::worlds::World;
use dapple_many_lights::{
    Emission, Node,
    bound::{self, Region},
    cut::children,
    region::{
        Cuboid, Direction, Edge, FacadeCluster, Split, Turn, ViewCell,
        fusion::{Verdict, reference::Horizon},
        horizon::{Projection, Umbra, project, umbra},
    },
};
use glam::DVec3;

/// A part that is put wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A shadow is what any corner of the cell sees hidden, where all have to.
    AnyCorner,
    /// Shadows are as high as they are for the cell's lowest point.
    LowestPoint,
    /// Clusters are tested by their near face alone.
    NearFace,
    /// Nothing is wrong.
    None,
}

/// What an evaluation found.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// The precut.
    pub nodes: Vec<u32>,
    /// Nodes that were too weak.
    pub weak: Vec<u32>,
}

struct Model<'a> {
    world: &'a World,
    settings: &'a FacadeCluster,
    fault: Fault,
    /// Bounds below this many thresholds are too weak.
    thresholds: f64,
    turn: Turn,
    direction: Direction,
    face: Cuboid,
    white: Region,
    found: Found,
}

/// The precut of a cell's face, with a fault or without; what gives less than so many `thresholds` is
/// too weak: 1 of the technique's own.
pub fn precut(
    world: &World,
    (cell, direction): (&ViewCell, Direction),
    settings: &FacadeCluster,
    fault: Fault,
    thresholds: f64,
) -> Found {
    let Some(face) = cell.face(direction) else { return Found::default() };
    let mut model = Model {
        world,
        settings,
        fault,
        thresholds,
        turn: cell.turn,
        direction,
        face: face.cuboid(direction),
        white: Region { albedo: DVec3::ONE, ..face.region },
        found: Found::default(),
    };
    model.run();
    model.found.nodes.sort_unstable();
    model.found
}

impl Model<'_> {
    fn run(&mut self) {
        let tree = &self.world.tree;
        let parallel = |root: &u32| tree.nodes[*root as usize].kind == Emission::Directional.code();
        let (parallel, placed): (Vec<u32>, Vec<u32>) = tree.roots.iter().partition(|r| parallel(r));
        self.found.nodes.extend(parallel);
        let mut open: Vec<(u32, Option<u32>)> = placed.into_iter().map(|n| (n, None)).collect();
        let front = self.face.w[1];
        let turned = self.world.occluders.turned(self.turn, self.settings.occluders);
        let solids = turned.solids.iter().map(|s| self.direction.cuboid(s.min, s.max));
        let mut solids: Vec<Cuboid> = solids.filter(|s| s.w[1] > front).collect();
        solids.sort_by(|a, b| a.w[1].total_cmp(&b.w[1]));
        let mut horizon = Horizon::new(self.settings.fusion);
        let mut plane = front;
        for next in planes(&solids, front, self.settings).into_iter().chain([f64::INFINITY]) {
            open = self.between(plane, next, &horizon, open);
            if open.is_empty() || next == f64::INFINITY {
                return;
            }
            horizon.reproject(&self.face, plane, next);
            let between = solids.iter().filter(|s| s.w[1] > plane && s.w[0] <= next);
            let shadows: Vec<Umbra> = between.filter_map(|s| self.shadow(s, next)).collect();
            horizon.add(&shadows);
            plane = next;
        }
    }

    /// Decides on all clusters that begin before the next plane; the others are returned.
    fn between(
        &mut self,
        plane: f64,
        next: f64,
        horizon: &Horizon,
        mut open: Vec<(u32, Option<u32>)>,
    ) -> Vec<(u32, Option<u32>)> {
        let world = self.world;
        let size = |n: u32| world.tree.nodes[n as usize].size;
        let mut kept = Vec::new();
        while let Some((index, levels)) = open.pop() {
            let node = &world.tree.nodes[index as usize];
            let cuboid = self.cuboid(node);
            let below = |levels| children(index, size).map(move |child| (child, levels));
            if cuboid.w[1] < self.face.w[0] {
                continue;
            }
            let is_between = cuboid.w[0] <= next;
            if is_between && cuboid.w[1] > next && !node.is_leaf() {
                open.extend(below(levels));
                continue;
            }
            if self.is_weak(node) {
                self.found.weak.push(index);
                continue;
            }
            let verdict = match horizon.is_empty() {
                true => Verdict::Free,
                false => horizon.test(&self.projection(&cuboid, plane), &mut 0),
            };
            if verdict == Verdict::Hidden {
                continue;
            }
            if !is_between {
                kept.push((index, levels));
                continue;
            }
            let levels = match self.settings.split {
                Split::All => Some(None),
                Split::Levels(most) => levels.unwrap_or(most).checked_sub(1).map(Some),
            };
            match levels {
                Some(levels) if verdict == Verdict::Partial && !node.is_leaf() => {
                    open.extend(below(levels));
                }
                _ => self.found.nodes.push(index),
            }
        }
        kept
    }

    fn cuboid(&self, node: &Node) -> Cuboid {
        let (min, max) = self.turn.around(node.min, node.max);
        self.direction.cuboid(min, max)
    }

    fn is_weak(&self, node: &Node) -> bool {
        let form = dapple_many_lights::BoundForm::Walter;
        let most = bound::region(form, node, &self.white, self.world.world.clamp_m);
        most < self.thresholds * self.settings.threshold || most == 0.0
    }

    fn projection(&self, cuboid: &Cuboid, plane: f64) -> Projection {
        match self.fault {
            Fault::NearFace => {
                let near = Cuboid { w: [cuboid.w[0]; 2], ..*cuboid };
                project(&self.face, &near, plane)
            }
            _ => project(&self.face, cuboid, plane),
        }
    }

    fn shadow(&self, solid: &Cuboid, plane: f64) -> Option<Umbra> {
        let Self { face, settings, .. } = self;
        match self.fault {
            Fault::AnyCorner => any_corner(face, solid, plane),
            Fault::LowestPoint => {
                let low = Cuboid { h: [face.h[0]; 2], ..*face };
                umbra(&low, solid, plane, settings.edge)
            }
            Fault::NearFace | Fault::None => umbra(face, solid, plane, settings.edge),
        }
    }
}

/// The rectangle around what single corners of a cell see hidden.
pub fn any_corner(cell: &Cuboid, solid: &Cuboid, plane: f64) -> Option<Umbra> {
    let of = |corner: Cuboid| umbra(&corner, solid, plane, Edge::Flat);
    corners(cell).into_iter().filter_map(of).reduce(|a, b| {
        let u = [a.u[0].min(b.u[0]), a.u[1].max(b.u[1])];
        Umbra::flat(u, a.foot.min(b.foot), a.highest().max(b.highest()))
    })
}

/// The corners of a box, as boxes.
pub fn corners(cell: &Cuboid) -> [Cuboid; 8] {
    std::array::from_fn(|corner| {
        let side = |bit: usize, ends: [f64; 2]| [ends[corner >> bit & 1]; 2];
        Cuboid { u: side(0, cell.u), w: side(1, cell.w), h: side(2, cell.h) }
    })
}

/// Where planes lie, for occluders in the order of their far faces.
pub fn planes(solids: &[Cuboid], front: f64, settings: &FacadeCluster) -> Vec<f64> {
    use dapple_many_lights::region::Planes;
    let mut planes = Vec::new();
    let mut last = front;
    for far in solids.iter().map(|solid| solid.w[1]) {
        let plane = match settings.planes {
            Planes::FarFaces => far,
            Planes::Behind(metres) => far + metres,
            Planes::Every(metres) => front + metres * ((far - front) / metres).ceil(),
        };
        if plane > last && plane - last >= settings.least_step_m {
            planes.push(plane);
            last = plane;
        }
    }
    planes
}
