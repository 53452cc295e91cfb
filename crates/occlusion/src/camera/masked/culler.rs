//! The technique: draw occluders, then walk the tree and ask the buffer.
//!
//! What is drawn into the buffer, see `occluders.rs`. Then nodes are taken front to back. A node that is outside the frustum, or whose rectangle is hidden
//! at its nearest depth, is left with all below it; what the near plane touches counts as visible.
//! Nothing is remembered between frames, nothing waits for the renderer, and what is drawn may be
//! drawn anywhere: silhouettes are moved inwards by as much as renderers may differ.
//!
//! A buffer of the image's size is asked at pixel centres. Any other stands for whole pixels: edges
//! are moved inwards by half a pixel more, so that what covers a pixel of the buffer covers all
//! centres of the image in it.

use super::buffer::{Buffer, Form};
use super::occluders::{InnerBox, Occluders, Set};
use super::question::Question;
use super::silhouette::MOVED;
use crate::OcclusionError;
use crate::camera::queue::FrontToBack;
use crate::camera::{Bounds, Frame, Objects, Renderer, Tree, View};

/// Knobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How the buffer is computed.
    pub form: Form,
    /// What hides.
    pub occluders: Occluders,
    /// Columns of the buffer, 1..=16384; its rows follow from the image's shape. `None`: the
    /// image's size.
    pub columns: Option<u32>,
    /// Most triangles of occluders in a frame; the largest on the image are taken.
    pub most_triangles: u64,
}

/// The technique and its buffer, for one set of objects.
#[derive(Clone, Debug)]
pub struct Culler {
    settings: Settings,
    set: Set,
    buffer: Buffer,
    occluder_triangles: u64,
    queue: FrontToBack,
    run: Vec<u32>,
}

impl Culler {
    /// For `objects`, and the boxes inside them where these are to hide.
    ///
    /// # Errors
    /// A buffer without columns or with too many, an inner box that is not finite.
    pub fn new(
        settings: Settings,
        objects: &Objects,
        inner_boxes: &[InnerBox],
    ) -> Result<Self, OcclusionError> {
        for (index, inner) in inner_boxes.iter().enumerate() {
            let Bounds { min, max } = inner.solid;
            if inner.corners.iter().chain([&min, &max]).any(|p| !p.is_finite()) {
                return Err(OcclusionError::value(format!("inner box {index}"), "is not finite"));
            }
        }
        Ok(Self {
            settings,
            set: Set::new(settings.occluders, objects, inner_boxes),
            buffer: Buffer::new(settings.form, settings.columns.unwrap_or(1), 1)?,
            occluder_triangles: 0,
            queue: FrontToBack::default(),
            run: Vec::new(),
        })
    }

    /// The buffer as the latest frame left it.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Triangles of occluders in the latest frame.
    pub fn occluder_triangles(&self) -> u64 {
        self.occluder_triangles
    }

    /// Draws one frame; what was drawn stands in `out`. A question to the buffer counts as a query
    /// of one box, and as wasted where it culled nothing; there are no batches and no stalls. What is
    /// asked to choose occluders is not counted.
    ///
    /// # Errors
    /// Occluders that are not finite, or the renderer's.
    pub fn frame(
        &mut self,
        objects: &Objects,
        tree: &Tree,
        view: &View,
        renderer: &mut dyn Renderer,
        out: &mut Frame,
    ) -> Result<(), OcclusionError> {
        out.clear();
        renderer.begin(view)?;
        let [width, height] = self.fit(view)?;
        self.buffer.clear();
        let exact_size = [width, height] == [view.width, view.height];
        let inset = if exact_size {
            MOVED
        } else {
            // Steps of the image in steps of the buffer.
            let coarse = |of: u32, by: u32| of.div_ceil(by);
            128 + MOVED * coarse(width, view.width).max(coarse(height, view.height))
        };
        let most = self.settings.most_triangles;
        self.occluder_triangles =
            self.set.draw(objects, tree, view, most, inset.min(4096), &mut self.buffer)?;

        self.queue.clear();
        self.run.clear();
        if !tree.nodes.is_empty() {
            self.queue.push(0.0, 0);
        }
        while let Some(index) = self.queue.pop() {
            let node = &tree.nodes[index as usize];
            out.work.nodes += 1;
            if !view.sees(&node.bounds) || !self.may_show(view, &node.bounds, out) {
                continue;
            }
            if tree.is_leaf(index) {
                self.run.extend_from_slice(tree.objects_of(index));
            }
            for child in node.children.clone() {
                self.queue.push(view.distance(&tree.nodes[child as usize].bounds), child);
            }
        }
        renderer.draw(&self.run)?;
        out.drew(objects, &self.run);
        renderer.end()
    }

    /// Gives the buffer its size for `view`.
    fn fit(&mut self, view: &View) -> Result<[u32; 2], OcclusionError> {
        let size = match self.settings.columns {
            None => [view.width, view.height],
            Some(columns) => {
                let rows = u64::from(columns) * u64::from(view.height) / u64::from(view.width);
                [columns, rows.clamp(1, 16_384) as u32]
            }
        };
        if self.buffer.size() != size {
            self.buffer = Buffer::new(self.settings.form, size[0], size[1])?;
        }
        Ok(size)
    }

    fn may_show(&self, view: &View, bounds: &Bounds, out: &mut Frame) -> bool {
        let Some(question) = Question::new(view, bounds, self.buffer.size()) else { return true };
        out.work.queries += 1;
        out.work.boxes += 1;
        let shows = question.shows(&self.buffer);
        out.work.wasted += u64::from(shows);
        shows
    }
}
