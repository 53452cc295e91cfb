//! What is drawn into the buffer, and in what order.
//!
//! The largest occluders first, the nearest first among those of a size, until the triangles are
//! spent. Size is that of the rectangle on the buffer, in powers of four; what reaches the near
//! plane counts as large as the buffer. A node of the tree comes in its own size's turn and hands
//! on its children: no child is larger. What the buffer hides already is left out with all below
//! it, and so is what is smaller than a quarter of a subtile, which it could not fill.
//!
//! To pick large and near occluders is common practice; the classes, one queue over nodes and
//! occluders, and asking the buffer first are ours. More triangles continue the same sequence, so
//! they lower no reference depth.

use super::question::Question;
use super::{Buffer, Connectivity, Edges, Facing, Occluder};
use crate::OcclusionError;
use crate::camera::queue::FrontToBack;
use crate::camera::{Bounds, Objects, Tree, View};
use glam::Vec3;

/// Which occluders hide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occluders {
    /// Boxes that lie inside what is drawn. Given apart from the objects.
    InnerBoxes,
    /// The objects themselves, but for alpha-tested ones.
    Meshes,
    /// The boxes around the objects. Wrong: such a box hides more than its object does. For checks
    /// that have to catch it.
    OuterBoxesUnsound,
}

/// A box that hides in the place of something solid. Seen from outside of that, whatever lies behind
/// the box lies behind the solid's own surface; an eye within it may see what the box would hide, and
/// then it hides nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnerBox {
    /// In the order of [`Bounds::corners`], local space.
    pub corners: [Vec3; 8],
    /// Holds the solid that the box lies in.
    pub solid: Bounds,
}

/// Classes of size: a buffer has 2^28 pixels at most.
const CLASSES: usize = 15;
/// Pixels of an occluder's rectangle, at least.
const LEAST_PIXELS: u64 = 8;

/// Two triangles a side, [`Bounds::corners`]' order.
const BOX: [[u32; 3]; 12] = [
    [0, 2, 6],
    [0, 6, 4],
    [1, 5, 7],
    [1, 7, 3],
    [0, 4, 5],
    [0, 5, 1],
    [2, 3, 7],
    [2, 7, 6],
    [0, 1, 3],
    [0, 3, 2],
    [4, 6, 7],
    [4, 7, 5],
];

/// The occluders of one set of objects.
#[derive(Clone, Debug)]
pub(super) struct Set {
    kind: Occluders,
    boxes: Vec<InnerBox>,
    /// One a template, or that of [`BOX`].
    connectivity: Vec<Connectivity>,
    /// Room to work in.
    queues: [FrontToBack; CLASSES],
    positions: Vec<Vec3>,
}

impl Set {
    pub(super) fn new(kind: Occluders, objects: &Objects, boxes: &[InnerBox]) -> Self {
        let corners: [Vec3; 8] = std::array::from_fn(|i| Vec3::splat(i as f32));
        let connectivity = match kind {
            Occluders::Meshes => {
                let of =
                    |t: &crate::camera::Template| Connectivity::new(&t.positions, &t.triangles);
                objects.templates.iter().map(of).collect()
            }
            _ => vec![Connectivity::new(&corners, &BOX)],
        };
        let boxes = if kind == Occluders::InnerBoxes { boxes.to_vec() } else { Vec::new() };
        Self { kind, boxes, connectivity, queues: Default::default(), positions: Vec::new() }
    }

    /// Draws occluders in sight, as many as `most` triangles hold. Gives the number of triangles.
    pub(super) fn draw(
        &mut self,
        objects: &Objects,
        tree: &Tree,
        view: &View,
        most: u64,
        inset: u32,
        buffer: &mut Buffer,
    ) -> Result<u64, OcclusionError> {
        self.queues.iter_mut().for_each(FrontToBack::clear);
        let size = buffer.size();
        if self.kind == Occluders::InnerBoxes {
            for index in 0..self.boxes.len() as u32 {
                self.add(tree, view, index, size);
            }
        } else if !tree.nodes.is_empty() {
            self.add(tree, view, 0, size);
        }
        let mut triangles = 0;
        while let Some(next) = self.queues.iter_mut().rev().find_map(FrontToBack::pop) {
            let question = Question::new(view, &self.bounds(tree, next), size);
            if question.is_some_and(|question| !question.shows(buffer)) {
                continue;
            }
            let object = if self.kind == Occluders::InnerBoxes {
                next
            } else if tree.is_leaf(next) {
                tree.objects_of(next)[0]
            } else {
                for child in tree.nodes[next as usize].children.clone() {
                    self.add(tree, view, child, size);
                }
                continue;
            };
            if self.kind != Occluders::InnerBoxes && !objects.occludes(object) {
                continue;
            }
            let count = self.triangles(objects, object);
            if triangles + count > most {
                break;
            }
            triangles += count;
            self.one(objects, object, view, inset, buffer)?;
        }
        Ok(triangles)
    }

    /// Puts a box or a node where it belongs.
    fn add(&mut self, tree: &Tree, view: &View, index: u32, size: [u32; 2]) {
        let bounds = self.bounds(tree, index);
        if !view.sees(&bounds) {
            return;
        }
        let whole = u64::from(size[0]) * u64::from(size[1]);
        let question = Question::new(view, &bounds, size);
        if self.kind == Occluders::InnerBoxes {
            // The eye, or the near plane behind which walls are cut away, may be within the wall.
            let solid = &self.boxes[index as usize].solid;
            if question.is_none() || view.touches(solid) {
                return;
            }
        }
        let pixels = question.map_or(whole, |q| q.pixels());
        if pixels >= LEAST_PIXELS {
            let class = pixels.ilog2() as usize / 2;
            self.queues[class.min(CLASSES - 1)].push(view.distance(&bounds), index);
        }
    }

    fn bounds(&self, tree: &Tree, index: u32) -> Bounds {
        match self.kind {
            Occluders::InnerBoxes => around(&self.boxes[index as usize].corners),
            Occluders::Meshes | Occluders::OuterBoxesUnsound => tree.nodes[index as usize].bounds,
        }
    }

    fn triangles(&self, objects: &Objects, index: u32) -> u64 {
        match self.kind {
            Occluders::Meshes => u64::from(objects.triangle_count(index)),
            Occluders::InnerBoxes | Occluders::OuterBoxesUnsound => BOX.len() as u64,
        }
    }

    fn one(
        &mut self,
        objects: &Objects,
        index: u32,
        view: &View,
        inset: u32,
        buffer: &mut Buffer,
    ) -> Result<(), OcclusionError> {
        // Relative to the eye, as all forms place corners.
        let placed = |p: Vec3| p - view.eye_f32;
        self.positions.clear();
        let (triangles, connectivity) = match self.kind {
            Occluders::InnerBoxes => {
                self.positions.extend(self.boxes[index as usize].corners.map(placed));
                (&BOX[..], 0)
            }
            Occluders::OuterBoxesUnsound => {
                let corners = objects.objects[index as usize].bounds.corners();
                self.positions.extend(corners.map(placed));
                (&BOX[..], 0)
            }
            Occluders::Meshes => {
                let object = &objects.objects[index as usize];
                let template = &objects.templates[object.template as usize];
                let corners = template.positions.iter().map(|&p| placed(object.place(p)));
                self.positions.extend(corners);
                (&template.triangles[..], object.template as usize)
            }
        };
        let occluder = Occluder {
            positions: &self.positions,
            triangles,
            facing: Facing::Both,
            edges: Edges::Silhouette(inset, &self.connectivity[connectivity]),
        };
        buffer.rasterise(&occluder, &view.clip_f32)
    }
}

fn around(corners: &[Vec3; 8]) -> Bounds {
    corners.iter().fold(Bounds::EMPTY, |bounds, &p| bounds.union(Bounds { min: p, max: p }))
}
