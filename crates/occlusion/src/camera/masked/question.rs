//! What a box asks of the buffer.

use super::buffer::Buffer;
use crate::camera::{Bounds, View};

/// The pixels of the buffer that a box may show in, and how near it is at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Question {
    /// Columns, half-open, within the buffer.
    x: [u32; 2],
    /// Rows, likewise.
    y: [u32; 2],
    /// Reversed depth.
    depth: f32,
}

impl Question {
    /// None for a box that reaches the near plane: it counts as visible. A buffer of the image's
    /// size is asked at pixel centres, any other in whole pixels.
    pub fn new(view: &View, bounds: &Bounds, size: [u32; 2]) -> Option<Self> {
        if view.touches(bounds) {
            return None;
        }
        let (rect, depth) = view.screen_rect(bounds)?;
        let exact_size = size == [view.width, view.height];
        let range = |low: f32, high: f32, image: u32, buffer: u32| {
            let scale = f64::from(buffer) / f64::from(image);
            let (low, high) = (f64::from(low) * scale, f64::from(high) * scale);
            // Rounding of the product is far below this.
            let (low, high) = (low - 1e-6, high + 1e-6);
            // Centres, or whole pixels.
            let half = if exact_size { 0.5 } else { 0.0 };
            let first = if exact_size { (low - half).ceil() } else { low.floor() };
            [first, (high - half).floor() + 1.0].map(|v| (v.max(0.0) as u32).min(buffer))
        };
        let x = range(rect[0], rect[2], view.width, size[0]);
        let y = range(rect[1], rect[3], view.height, size[1]);
        Some(Self { x, y, depth })
    }

    /// Pixels of the rectangle.
    pub fn pixels(&self) -> u64 {
        let side = |range: [u32; 2]| u64::from(range[1].saturating_sub(range[0]));
        side(self.x) * side(self.y)
    }

    /// Whether the box could show.
    pub fn shows(&self, buffer: &Buffer) -> bool {
        buffer.shows(self.x, self.y, self.depth)
    }
}
