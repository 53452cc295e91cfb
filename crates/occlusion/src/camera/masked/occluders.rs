//! What is drawn into the buffer.

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
    boxes: Vec<[Vec3; 8]>,
    /// One a template, or that of [`BOX`].
    connectivity: Vec<Connectivity>,
    /// Room to work in.
    queue: FrontToBack,
    positions: Vec<Vec3>,
}

impl Set {
    pub(super) fn new(kind: Occluders, objects: &Objects, boxes: &[[Vec3; 8]]) -> Self {
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
        Self { kind, boxes, connectivity, queue: FrontToBack::default(), positions: Vec::new() }
    }

    /// Draws occluders in sight front to back, as many as `most` triangles hold. Gives the number
    /// of triangles.
    pub(super) fn draw(
        &mut self,
        objects: &Objects,
        tree: &Tree,
        view: &View,
        most: u64,
        inset: u32,
        buffer: &mut Buffer,
    ) -> Result<u64, OcclusionError> {
        self.queue.clear();
        let over_tree = self.kind != Occluders::InnerBoxes;
        if over_tree && !tree.nodes.is_empty() {
            self.queue.push(0.0, 0);
        }
        for (index, corners) in self.boxes.iter().enumerate() {
            let bounds = around(corners);
            if view.sees(&bounds) {
                self.queue.push(view.distance(&bounds), index as u32);
            }
        }
        let mut triangles = 0;
        while let Some(next) = self.queue.pop() {
            let object = if over_tree {
                let node = &tree.nodes[next as usize];
                if !view.sees(&node.bounds) {
                    continue;
                }
                if !tree.is_leaf(next) {
                    for child in node.children.clone() {
                        self.queue.push(view.distance(&tree.nodes[child as usize].bounds), child);
                    }
                    continue;
                }
                tree.objects_of(next)[0]
            } else {
                next
            };
            if over_tree && !objects.occludes(object) {
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
                self.positions.extend(self.boxes[index as usize].map(placed));
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
