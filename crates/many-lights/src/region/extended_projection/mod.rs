//! Extended projections: from-region visibility on a raster, the baseline.
//!
//! Based on: F. Durand et al., "Conservative visibility preprocessing using extended projections",
//! 2000, sections 3 (extended projections), 4 (depth map, planes, reprojection by erosion), as section
//! 2.3.3 of Melino Conte, "Real-time Rendering of Cities at Night", 2018, tells it.
//! Deviations: texels are covered by the closed form of a box's umbra rather than by a stencil that
//! counts corners, so that the map is conservative at any resolution: a texel is hidden only if all of
//! it is, by one occluder or by two that touch, and an occludee touches every texel that it reaches.
//! Planes follow far faces of occluders up to a number ([`planes`]); occluders are drawn anew on each,
//! so that only what is joined is eroded again and again. The plane's window is finite: it holds what
//! may be hidden and may hide lights. The map is the full raster, although occluders that stand on the
//! ground would need no more than a height for each column.

mod beyond;
mod grid;
mod map;
mod planes;

use super::horizon::{Projection, Umbra, project, reproject, umbra};
use super::potential::{is_weak, potential, white};
use super::{Cuboid, Direction, Edge, Face, OccluderMode, Occluders, Precuts, Steps, ViewCell};
use crate::{Emission, LightTree, LightsError, bound::Region, cut::children};
use map::{Drawn, Map, Verdict};
use planes::Planes;
use std::sync::Arc;

/// The most texels a side: 16 bytes each of their squares.
pub const MOST_TEXELS: u32 = 4096;

/// Share of the greatest coordinate by which windows of nearer planes are larger than those of farther
/// ones: far more than projections are by [`super::horizon::SLACK`].
const MARGIN: f64 = 1e-9;

/// The technique, made ready for one light tree.
pub struct ExtendedProjection {
    tree: Arc<LightTree>,
    occluders: Arc<Occluders>,
    clamp_m: f64,
    /// Of the current plane and of the one before it.
    maps: [Map; 2],
    planes: Planes,
    drawn: Vec<Drawn>,
    queue: Vec<u32>,
    next: Vec<u32>,
    steps: Steps,
}

/// What an evaluation goes on.
struct Given<'a> {
    cell: &'a ViewCell,
    direction: Direction,
    cuboid: Cuboid,
    region: Region,
}

impl ExtendedProjection {
    /// Maps of `texels` x `texels`; distances below `clamp_m` count as that.
    ///
    /// # Errors
    /// [`LightsError::Value`]: `texels` is not in 1..=[`MOST_TEXELS`].
    pub fn new(
        tree: Arc<LightTree>,
        occluders: Arc<Occluders>,
        clamp_m: f64,
        texels: u32,
    ) -> Result<Self, LightsError> {
        if !(1..=MOST_TEXELS).contains(&texels) {
            let limit = format!("{texels} is not in 1..={MOST_TEXELS}");
            return Err(LightsError::value("texels", limit));
        }
        Ok(Self {
            tree,
            occluders,
            clamp_m,
            maps: [0, 1].map(|_| Map::new(texels as usize)),
            planes: Planes::default(),
            drawn: vec![],
            queue: vec![],
            next: vec![],
            steps: Steps::default(),
        })
    }

    /// All lights that have a place, in the space of the direction; `None` without any.
    fn lights(&self, cell: &ViewCell, direction: Direction) -> Option<Cuboid> {
        let nodes = self.tree.roots.iter().map(|root| &self.tree.nodes[*root as usize]);
        let placed = nodes.filter(|node| node.kind != Emission::Directional.code());
        placed
            .map(|node| {
                let (min, max) = cell.turn.around(node.min, node.max);
                direction.cuboid(min, max)
            })
            .reduce(|a, b| Cuboid { u: span(a.u, b.u), w: span(a.w, b.w), h: span(a.h, b.h) })
    }

    fn evaluate(
        &mut self,
        cell: &ViewCell,
        direction: Direction,
        face: &Face,
        nodes: &mut Vec<u32>,
    ) {
        let given =
            Given { cell, direction, cuboid: face.cuboid(direction), region: white(&face.region) };
        let directional = Emission::Directional.code();
        let (all, placed): (Vec<u32>, Vec<u32>) =
            self.tree.roots.iter().partition(|r| self.tree.nodes[**r as usize].kind == directional);
        nodes.extend(all);
        self.queue.clear();
        self.queue.extend(placed);
        let Some(lights) = self.lights(cell, direction) else { return };
        let front = given.cuboid.w[1];
        let turned = self.occluders.turned(cell.turn, OccluderMode::Leaf);
        self.planes.fill(&turned.solids, direction, [front, lights.w[1]]);
        // Everything between the cell and a light lies in the smallest box around both.
        let hull =
            Projection { u: span(given.cuboid.u, lights.u), h: span(given.cuboid.h, lights.h) };
        let ends = [hull.u, hull.h];
        let margin = MARGIN * ends.as_flattened().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        // What the plane before hides lies in this.
        let mut hidden: Option<Umbra> = None;
        self.look(&given, front, 0, nodes);
        for index in 0..self.planes.planes.len() {
            if self.queue.is_empty() {
                return;
            }
            let plane = self.planes.planes[index];
            let margin = margin * (self.planes.planes.len() - index) as f64;
            let hull = Projection { u: grown(hull.u, margin), h: grown(hull.h, margin) };
            hidden = self.map(&given.cuboid, plane, hidden.as_ref(), &hull);
            self.look(&given, plane, index + 1, nodes);
        }
        self.look(&given, f64::INFINITY, self.planes.planes.len(), nodes);
    }

    /// Makes the map of a plane from that of the one before; returns a rectangle that holds all that it
    /// hides, if it hides anything.
    fn map(
        &mut self,
        cell: &Cuboid,
        plane: f64,
        hidden: Option<&Umbra>,
        hull: &Projection,
    ) -> Option<Umbra> {
        let before = self.maps[0].plane;
        self.maps.swap(0, 1);
        let [map, last] = &mut self.maps;
        let carried = hidden.and_then(|hidden| reproject(cell, hidden, before, plane));
        self.drawn.clear();
        for occluder in self.planes.occluders.iter().take_while(|o| o.w[0] <= plane) {
            let depth = occluder.w[1].min(plane);
            if let Some(umbra) = umbra(cell, occluder, plane, Edge::Hull) {
                self.drawn.push(Drawn { umbra, depth });
            }
        }
        self.steps.projections += 1;
        self.steps.projected += self.drawn.len() as u64;
        let rectangle = |u: &Umbra| (u.u, u.foot, u.highest());
        let all =
            self.drawn.iter().map(|d| rectangle(&d.umbra)).chain(carried.as_ref().map(rectangle));
        let around = all.reduce(|a, b| (span(a.0, b.0), a.1.min(b.1), a.2.max(b.2)));
        let window = around.map(|(u, foot, top)| Projection {
            u: common(u, hull.u),
            h: common([foot, top], hull.h),
        });
        let Some(window) = window.filter(|w| w.u[0] < w.u[1] && w.h[0] < w.h[1]) else {
            // Nothing: of a window without any size.
            let at = Projection { u: [hull.u[0]; 2], h: [hull.h[0]; 2] };
            map.clear(plane, &at);
            map.finish();
            return None;
        };
        map.clear(plane, &window);
        map.draw(&self.drawn);
        if carried.is_some() {
            self.steps.reprojections += 1;
            map.erode(cell, last);
        }
        map.finish();
        Some(Umbra::flat(window.u, window.h[0], window.h[1]))
    }

    /// Sorts the queue out at a plane, after so many maps were `made`: what lies before it is tested for
    /// the last time, the rest stays if it is not hidden.
    fn look(&mut self, given: &Given<'_>, plane: f64, made: usize, nodes: &mut Vec<u32>) {
        self.steps.iterations += 1;
        let tree = Arc::clone(&self.tree);
        let size = |node: u32| tree.nodes[node as usize].size;
        while let Some(index) = self.queue.pop() {
            let node = &tree.nodes[index as usize];
            let (min, max) = given.cell.turn.around(node.min, node.max);
            let cuboid = given.direction.cuboid(min, max);
            let [near, far] = cuboid.w;
            if far <= given.cuboid.w[0] {
                continue;
            }
            let straddles = near < plane && far > plane;
            if (straddles || near <= given.cuboid.w[0]) && !node.is_leaf() {
                self.steps.straddling += 1;
                self.queue.extend(children(index, size));
                continue;
            }
            self.steps.potential += 1;
            if is_weak(potential(node, &given.region, self.clamp_m), 0.0) {
                self.steps.potential_culled += 1;
                continue;
            }
            if far > plane {
                self.steps.early += 1;
                self.steps.early_projected += u64::from(made > 0);
                match self.test(given, &cuboid, plane, made) {
                    Verdict::Hidden => self.steps.early_culled += 1,
                    Verdict::Partial | Verdict::Free => self.next.push(index),
                }
                continue;
            }
            self.steps.last += 1;
            self.steps.last_projected += u64::from(made > 0);
            match self.test(given, &cuboid, plane, made) {
                Verdict::Hidden => self.steps.last_culled += 1,
                Verdict::Partial if !node.is_leaf() => {
                    self.steps.last_divided += 1;
                    self.queue.extend(children(index, size));
                }
                Verdict::Partial | Verdict::Free => {
                    self.steps.last_output += 1;
                    nodes.push(index);
                }
            }
        }
        std::mem::swap(&mut self.queue, &mut self.next);
    }

    /// What the maps say of an occludee: that of the current plane, and, if the occludee lies before
    /// it, that of the plane before.
    fn test(&self, given: &Given<'_>, occludee: &Cuboid, plane: f64, made: usize) -> Verdict {
        let nearest = occludee.w[0];
        let [map, last] = &self.maps;
        let onto = |map: &Map| map.test(&project(&given.cuboid, occludee, map.plane), nearest);
        if made == 0 || nearest <= given.cuboid.w[1] {
            return Verdict::Free;
        }
        // Behind the plane, or behind the last of all.
        if nearest >= map.plane {
            return onto(map);
        }
        let before = if made > 1 && nearest >= last.plane { onto(last) } else { Verdict::Free };
        if before == Verdict::Hidden {
            return before;
        }
        let behind = beyond::beyond(&given.cuboid, occludee, plane).map(|p| map.test(&p, nearest));
        match behind {
            Some(Verdict::Hidden) => Verdict::Hidden,
            Some(Verdict::Partial) => Verdict::Partial,
            Some(Verdict::Free) | None => before,
        }
    }
}

fn span(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

fn common(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

fn grown([low, high]: [f64; 2], by: f64) -> [f64; 2] {
    [low - by, high + by]
}

impl Precuts for ExtendedProjection {
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>) {
        nodes.clear();
        let Some(face) = cell.face(direction) else { return };
        self.steps.evaluations += 1;
        self.evaluate(cell, direction, face, nodes);
        nodes.sort_unstable();
        self.steps.output += nodes.len() as u64;
    }

    fn steps(&self) -> &Steps {
        &self.steps
    }

    fn bytes(&self) -> u64 {
        let maps = self.maps.iter().map(Map::bytes).sum::<u64>();
        let lists = self.queue.capacity() + self.next.capacity();
        maps + self.planes.bytes() + (self.drawn.capacity() * size_of::<Drawn>() + 4 * lists) as u64
    }
}
