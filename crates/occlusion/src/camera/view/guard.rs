//! The guard band: how much a box must grow so that what it holds cannot show beside it.
//!
//! A form that draws in f32 and snaps corners to a grid of 1/256 pixel does not draw the triangles
//! it is given, but, exactly, triangles whose corners lie a little elsewhere. Let `u = 2^-24`, `R` the
//! distance of the box's farthest corner from the eye, `D` its greatest and `d` its least distance
//! along the view direction, `d` no less than the near plane's.
//!
//! - *Position.* `p - eye` errs by `u R` an axis, each row of the matrix by a few `u R` in metres
//!   (three products, three sums, the rounded entries), the division and the viewport by a few `u`
//!   of a lateral distance that is at most `R`. Clipping at the near plane interpolates between such
//!   corners. Together less than `16 u R`.
//! - *Snapping* moves a corner by at most 1/256 pixel an axis (rounding down; half of that where
//!   the nearest is taken), so by `sqrt(2) / 256` pixel, whose side is largest at `D`.
//! - *Depth.* Interpolation over a triangle errs by some `8 u` of the greatest depth in it, `near /
//!   d`; depth falls by `near / D^2` a metre at `D`, so that is `8 u D^2 / d` metres along the view
//!   direction, and at most that times the secant of the image's corner along a ray (parallel rays:
//!   `8 u` of the depth range).
//!
//! Placement needs nothing here: bounds hold placed triangles however they are rounded. Call the
//! sum `e`. What is drawn of triangles in the box lies within `e` of the box. The grown box is drawn
//! by the same means, so its faces move by at most its own `e`; they form a closed surface (faces
//! that share an edge must share its cut with the near plane), hence they hold all that lies deeper
//! than that below the true ones. Growing every side by `4 e` is enough where the grown box's `e` is
//! at most `3 e`: a pixel's ray that meets what is drawn passes through the drawn box, and enters it
//! no farther away. That holds since a pixel is at most [`MAX_PIXEL`] times as wide as it is far,
//! which keeps the snapping's part below 0.4 `D`, since `d` is halved (or the near plane's, if `4 e`
//! is more than that), and since a box whose depths cannot be told apart, `4 e > D`, is grown around
//! the eye: it counts as visible.

#[cfg(test)]
mod tests;

use super::View;
use crate::camera::objects::{Bounds, round_down, round_up};
use glam::{DVec2, DVec3};

/// Rounding of f32, relative.
const UNIT: f64 = 1.0 / 16_777_216.0;

/// Widest pixel, in terms of its distance.
pub(super) const MAX_PIXEL: f64 = 16.0;

impl View {
    /// The box grown by the guard band on all sides. Everything inside `bounds` that covers a
    /// pixel's centre on any form is covered by the grown box, no farther away. The derivation
    /// stands at the head of `guard.rs`.
    #[must_use]
    pub fn guarded(&self, bounds: &Bounds) -> Bounds {
        if bounds.is_empty() {
            return *bounds;
        }
        bounds.grown(self.guard_m(bounds))
    }

    /// By how much [`Self::guarded`] grows `bounds`, metres.
    pub fn guard_m(&self, bounds: &Bounds) -> f64 {
        let [near, far] = self.distances(bounds);
        let far = far.max(self.near_m);
        let radius = self.farthest(bounds);
        let snap = std::f64::consts::SQRT_2 / 256.0 * self.pixel_m(far);
        let aside = 4.0 * (16.0 * UNIT * radius + snap);
        if self.parallel {
            return aside + 4.0 * 8.0 * UNIT * self.range_m;
        }
        let secant = (1.0 + self.half_extent.length_squared()).sqrt();
        let along = |near: f64| 4.0 * 8.0 * UNIT * secant * far * far / near.max(self.near_m);
        let half = 0.5 * near;
        let growth = aside + along(half);
        if growth <= half {
            return growth;
        }
        let depth = along(self.near_m);
        if depth > far { 4.0 * radius } else { aside + depth }
    }

    /// Distance of the eye from the farthest corner, metres.
    pub(super) fn farthest(&self, bounds: &Bounds) -> f64 {
        let (a, b) = (bounds.min.as_dvec3() - self.eye, bounds.max.as_dvec3() - self.eye);
        a.abs().max(b.abs()).length()
    }

    /// Where the grown box may show: left, top, right and bottom in pixels, not cut to the image,
    /// and the greatest reversed depth of any of it, all rounded outwards. None where it reaches
    /// the near plane: then it counts as visible.
    pub fn screen_rect(&self, bounds: &Bounds) -> Option<([f32; 4], f32)> {
        if bounds.is_empty() {
            return None;
        }
        let grown = self.guarded(bounds);
        let nearest = self.distance(&grown);
        if nearest.is_nan() || nearest <= self.near_distance() {
            return None;
        }
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in grown.corners() {
            let pixel = self.pixel(corner.as_dvec3());
            low = low.min(pixel);
            high = high.max(pixel);
        }
        // f64 rounding, far below f32's.
        let slack = 1e-12 * (low.abs().max(high.abs()) + 1.0);
        let (low, high) = (low - slack, high + slack);
        let rect = [round_down(low.x), round_down(low.y), round_up(high.x), round_up(high.y)];
        Some((rect, round_up(self.depth(nearest).min(1.0))))
    }

    /// Pixel coordinates (x right, y down, centres at halves) of a point in front of the eye.
    pub fn pixel(&self, p: DVec3) -> DVec2 {
        let d = p - self.eye;
        let scale = if self.parallel { 1.0 } else { d.dot(self.forward) };
        let ndc = DVec2::new(d.dot(self.right), d.dot(self.up)) / (self.half_extent * scale);
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        (DVec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * size
    }
}
