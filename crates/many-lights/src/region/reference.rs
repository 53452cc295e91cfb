//! The lights that may reach a face, by the steps in their clear form: slow, to hold others against.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.4 and 5.3.3
//! (the steps of Table 5.V).
//! Deviations: planes lie at occluders' far faces, and the part of an occluder before a plane is
//! projected on it; a cluster that a plane cuts is divided before its potential is tested, so that
//! each one that is strong enough goes to exactly one of steps 9 and 11; nothing is projected where no
//! shadow is. [`FacadeCluster::cached`] changes nothing here.

use super::{
    Cuboid, Direction, FacadeCluster, Occluders, Planes, Precuts, Split, Steps, ViewCell,
    fusion::{Verdict, around, asked_part, nothing_yet, reference::Horizon},
    horizon::{Projection, project, umbra},
    potential::{is_weak, potential, white},
};
use crate::{Emission, LightTree, bound::Region, cut::children};
use std::sync::Arc;

/// Facade-cluster visibility without anything that makes it fast. Every shadow counts as compared.
pub struct Reference {
    tree: Arc<LightTree>,
    occluders: Arc<Occluders>,
    clamp_m: f64,
    settings: FacadeCluster,
    steps: Steps,
}

/// What stays the same during an evaluation.
struct View<'a> {
    cell: &'a ViewCell,
    direction: Direction,
    /// The face in the direction's space.
    face: Cuboid,
    /// Its surfaces, white.
    white: Region,
}

/// A plane with its shadows, and the next one.
struct Stage {
    plane: f64,
    next: f64,
    horizon: Horizon,
}

/// A node of the light tree that is not yet decided on.
#[derive(Clone, Copy)]
struct Open {
    node: u32,
    /// Levels by which it may still be divided for being hidden in part; `None` where no cluster above
    /// was, or any number.
    levels: Option<u32>,
}

impl Reference {
    /// Ready for the lights of a tree behind occluders. `clamp_m` is [`crate::World::clamp_m`].
    pub fn new(
        tree: Arc<LightTree>,
        occluders: Arc<Occluders>,
        clamp_m: f64,
        settings: FacadeCluster,
    ) -> Self {
        Self { tree, occluders, clamp_m, settings, steps: Steps::default() }
    }

    /// 6: all clusters up to the next plane are decided on; the others are returned.
    fn clusters(
        &mut self,
        view: &View<'_>,
        stage: &Stage,
        mut open: Vec<Open>,
        nodes: &mut Vec<u32>,
    ) -> Vec<Open> {
        let tree = Arc::clone(&self.tree);
        let parts = |of: Open, levels: Option<u32>| {
            children(of.node, |node| tree.nodes[node as usize].size)
                .map(move |node| Open { node, levels })
        };
        let mut kept = Vec::new();
        while let Some(cluster) = open.pop() {
            let node = &tree.nodes[cluster.node as usize];
            let (min, max) = view.cell.turn.around(node.min, node.max);
            let cuboid = view.direction.cuboid(min, max);
            let [near, far] = cuboid.w;
            if far < view.face.w[0] {
                continue;
            }
            if near <= stage.next && far > stage.next && !node.is_leaf() {
                self.steps.straddling += 1;
                open.extend(parts(cluster, cluster.levels));
                continue;
            }
            // 7 and 8
            self.steps.potential += 1;
            if is_weak(potential(node, &view.white, self.clamp_m), self.settings.threshold) {
                self.steps.potential_culled += 1;
                continue;
            }
            let is_between = near <= stage.next;
            *(if is_between { &mut self.steps.last } else { &mut self.steps.early }) += 1;
            let verdict = if stage.horizon.is_empty() {
                Verdict::Free
            } else {
                let Steps { last_projected, early_projected, .. } = &mut self.steps;
                *(if is_between { last_projected } else { early_projected }) += 1;
                let projection = project(&view.face, &cuboid, stage.plane);
                stage.horizon.test(&projection, &mut self.steps.compared)
            };
            match (is_between, verdict) {
                (false, Verdict::Hidden) => self.steps.early_culled += 1,
                (false, _) => kept.push(cluster),
                (true, Verdict::Hidden) => self.steps.last_culled += 1,
                (true, verdict) => match self.divided(&cluster, node.is_leaf(), verdict) {
                    Some(levels) => {
                        self.steps.last_divided += 1;
                        open.extend(parts(cluster, levels));
                    }
                    None => {
                        self.steps.last_output += 1;
                        nodes.push(cluster.node);
                    }
                },
            }
        }
        kept
    }

    /// Around the projections on a plane of all clusters that wait.
    fn asked(&self, view: &View<'_>, plane: f64, open: &[Open]) -> Projection {
        let on_plane = |cluster: &Open| {
            let node = &self.tree.nodes[cluster.node as usize];
            let (min, max) = view.cell.turn.around(node.min, node.max);
            project(&view.face, &view.direction.cuboid(min, max), plane)
        };
        open.iter()
            .map(on_plane)
            .fold(nothing_yet(self.settings.fusion), |all, one| around(&all, &one))
    }

    /// The levels of a cluster's children, if it is to be divided.
    fn divided(&self, cluster: &Open, is_leaf: bool, verdict: Verdict) -> Option<Option<u32>> {
        if is_leaf || verdict != Verdict::Partial {
            return None;
        }
        match self.settings.split {
            Split::All => Some(None),
            Split::Levels(most) => cluster.levels.unwrap_or(most).checked_sub(1).map(Some),
        }
    }
}

impl Precuts for Reference {
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>) {
        nodes.clear();
        let Some(face) = cell.face(direction) else { return };
        self.steps.evaluations += 1;
        let view =
            View { cell, direction, face: face.cuboid(direction), white: white(&face.region) };
        let front = view.face.w[1];
        // 4
        let is_parallel =
            |root: &u32| self.tree.nodes[*root as usize].kind == Emission::Directional.code();
        let (parallel, placed): (Vec<u32>, Vec<u32>) =
            self.tree.roots.iter().partition(|r| is_parallel(r));
        nodes.extend(parallel);
        let mut open: Vec<Open> =
            placed.into_iter().map(|node| Open { node, levels: None }).collect();
        let turned = self.occluders.turned(cell.turn, self.settings.occluders);
        let mut solids: Vec<Cuboid> = turned
            .solids
            .iter()
            .map(|solid| direction.cuboid(solid.min, solid.max))
            .filter(|solid| solid.w[0] <= solid.w[1] && solid.w[1] > front)
            .collect();
        solids.sort_by(|a, b| a.w[1].total_cmp(&b.w[1]));
        // 5
        let horizon = Horizon::new(self.settings.fusion);
        let mut stage = Stage { plane: front, next: front, horizon };
        let mut planes = planes(&solids, front, &self.settings).into_iter();
        while !open.is_empty() {
            self.steps.iterations += 1;
            stage.next = planes.next().unwrap_or(f64::INFINITY);
            open = self.clusters(&view, &stage, open, nodes);
            if open.is_empty() || stage.next == f64::INFINITY {
                break;
            }
            let asked = self.asked(&view, stage.next, &open);
            // 13
            self.steps.reprojections += 1;
            if !stage.horizon.is_empty() {
                self.steps.moved +=
                    stage.horizon.reproject_asked(&view.face, [stage.plane, stage.next], &asked);
            }
            // 14: all that has a part between the two planes
            self.steps.projections += 1;
            let between = |solid: &&Cuboid| solid.w[1] > stage.plane && solid.w[0] <= stage.next;
            let mut shadows = Vec::new();
            for solid in solids.iter().filter(between) {
                self.steps.projected += 1;
                let shadow = umbra(&view.face, solid, stage.next, self.settings.edge);
                shadows.extend(shadow.and_then(|shadow| asked_part(&shadow, &asked)));
            }
            stage.horizon.add(&shadows);
            stage.plane = stage.next;
        }
        nodes.sort_unstable();
        self.steps.output += nodes.len() as u64;
    }

    fn steps(&self) -> &Steps {
        &self.steps
    }

    fn bytes(&self) -> u64 {
        size_of::<Self>() as u64
    }
}

/// All planes, for occluders in the order of their far faces.
fn planes(solids: &[Cuboid], front: f64, settings: &FacadeCluster) -> Vec<f64> {
    let mut planes: Vec<f64> = Vec::new();
    for solid in solids {
        let far = solid.w[1];
        let plane = match settings.planes {
            Planes::FarFaces => far,
            Planes::Behind(metres) => far + metres,
            Planes::Every(metres) => front + metres * ((far - front) / metres).ceil(),
        };
        let last = planes.last().copied().unwrap_or(front);
        if plane.is_finite() && plane > last && plane - last >= settings.least_step_m {
            planes.push(plane);
        }
    }
    planes
}
