//! Every fragment of a parallel light's map by filling triangles: each is visited once a band of
//! rows instead of once a ray, and nothing has to be searched.
//!
//! Corners are projected in `f64`, equal ones to equal points, and whether a texel's centre is
//! covered is decided as for rays (`watertight.rs`). So rays and this agree but for the last bit:
//! where an edge runs through a texel's centre, they may choose different sides of it.

use crate::error::TraceError;
use crate::light_fragments::{LightFragments, check_size};
use crate::lists::gather;
use crate::tracer::{Leaf, Tracer};
use crate::watertight::{Corners, Crossing, weigh};
use dapple_scene::LightView;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Beyond this many texels products of two coordinates could overflow.
const FARTHEST: f64 = 1e150;

/// The map from normalised space to texels, of which a centre has whole coordinates, and to linear
/// depth.
pub(crate) struct Raster {
    pub size: [u32; 2],
    x: DVec3,
    y: DVec3,
    z: DVec3,
    offset: [f64; 3],
}

/// A triangle on the map.
pub(crate) struct Projected {
    corners: [[f64; 2]; 3],
    depth: [f64; 3],
}

/// Whole numbers in lo..=hi and 0..n.
pub(crate) fn whole(lo: f64, hi: f64, n: u32) -> Range<u32> {
    let n = f64::from(n);
    let (start, end) = (lo.ceil().clamp(0.0, n), (hi.floor() + 1.0).clamp(0.0, n));
    start as u32..end as u32
}

impl Raster {
    /// `None` for a perspective view, or one that is not finite in units of texels.
    pub fn of(tracer: &Tracer, view: &LightView, size: [u32; 2]) -> Option<Self> {
        let [width, height] = size;
        let depth_range = view.far_m - view.near_m;
        let from_centre = tracer.space.centre - view.origin;
        // From normalised space: u = 0.5 + 0.5 (p · right) / half_extent, and so on.
        let axis = |axis: DVec3, scale: f64, offset: f64| {
            let row = axis * (scale / tracer.space.scale);
            (row, from_centre.dot(axis) * scale + offset)
        };
        let texels = |n: u32| 0.5 * f64::from(n) / view.half_extent;
        let offset = |n: u32| 0.5 * f64::from(n) - 0.5;
        let (x, x0) = axis(view.right, texels(width), offset(width));
        let (y, y0) = axis(view.down, texels(height), offset(height));
        let (z, z0) = axis(view.forward, 1.0 / depth_range, -view.near_m / depth_range);
        let finite = |row: &DVec3| row.is_finite() && row.abs().max_element() < FARTHEST;
        let usable = [x, y, z, DVec3::new(x0, y0, z0)].iter().all(finite) && !view.perspective;
        usable.then_some(Self { size, x, y, z, offset: [x0, y0, z0] })
    }

    pub fn project(&self, corners: &Corners) -> Projected {
        let points = corners.map(DVec3::from_array);
        let [x0, y0, z0] = self.offset;
        Projected {
            corners: points.map(|p| [self.x.dot(p) + x0, self.y.dot(p) + y0]),
            depth: points.map(|p| self.z.dot(p) + z0),
        }
    }

    /// Where map point (u, v) lies in texels.
    pub fn place(&self, u: f64, v: f64) -> [f64; 2] {
        let [width, height] = self.size.map(f64::from);
        [u * width - 0.5, v * height - 0.5]
    }

    /// The rows of each leaf of `slots`, from `reach` texels above it to as many below.
    pub fn rows(&self, tracer: &Tracer, slots: &[u32], reach: f64) -> Vec<(u16, u16)> {
        let rows = |leaf: &Leaf| {
            let [a, b, c] = leaf.corners.map(|p| self.y.dot(DVec3::from_array(p)) + self.offset[1]);
            let rows = whole(a.min(b).min(c) - reach, a.max(b).max(c) + reach, self.size[1]);
            (rows.start as u16, rows.end as u16)
        };
        // None of a triangle that is not traced.
        let of = |&slot: &u32| tracer.leaves.get(slot as usize).map_or((0, 0), rows);
        slots.par_iter().map(of).collect()
    }

    /// Calls `visit` with slot, projection and row of every leaf of `slots` in every row of `band`
    /// that `rows` gives it, leaf after leaf, until it returns false.
    pub fn each_row(
        &self,
        tracer: &Tracer,
        slots: &[u32],
        rows: &[(u16, u16)],
        band: Range<u32>,
        mut visit: impl FnMut(u32, &Projected, u32) -> bool,
    ) {
        for (&(start, end), &slot) in rows.iter().zip(slots) {
            let own = u32::from(start).max(band.start)..u32::from(end).min(band.end);
            if own.is_empty() {
                continue;
            }
            let projected = self.project(&tracer.leaves[slot as usize].corners);
            for y in own {
                if !visit(slot, &projected, y) {
                    return;
                }
            }
        }
    }
}

impl Projected {
    /// Columns whose centres lie within `reach` of the triangle's part between heights `y - reach`
    /// and `y + reach`; never too few.
    pub fn columns(&self, y: f64, reach: f64, width: u32) -> Range<u32> {
        let [a, b, c] = self.corners;
        // Far above the rounding of the lines below, far below a texel.
        let farthest = self.corners.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let margin = reach + 1e-9 * (1.0 + farthest);
        let (top, bottom) = (y - margin, y + margin);
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut add = |x: f64| (lo, hi) = (lo.min(x), hi.max(x));
        for [p, q] in [[a, b], [b, c], [c, a]] {
            if p[1].min(q[1]) > bottom || p[1].max(q[1]) < top {
                continue;
            }
            let slope = (q[0] - p[0]) / (q[1] - p[1]);
            if slope.is_finite() {
                add(p[0] + (p[1].clamp(top, bottom) - p[1]) * slope);
                add(p[0] + (q[1].clamp(top, bottom) - p[1]) * slope);
            } else {
                add(p[0]);
                add(q[0]);
            }
        }
        let (left, right) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
        whole((lo - margin).max(left - reach), (hi + margin).min(right + reach), width)
    }

    /// Where the light meets the triangle above (x, y).
    #[inline(always)]
    pub fn cover(&self, [x, y]: [f64; 2]) -> Option<Crossing> {
        let [a, b, c] = self.corners.map(|p| [p[0] - x, p[1] - y]);
        let weights = weigh::<true>(a, b, c)?;
        let [az, bz, cz] = self.depth;
        let depth = (weights.a * az + weights.b * bz + weights.c * cz) * weights.inverse;
        // Of a triangle seen edge-on the weights are noise.
        let t = depth.max(az.min(bz).min(cz)).min(az.max(bz).max(cz));
        Some(Crossing { t, u: weights.b * weights.inverse, v: weights.c * weights.inverse })
    }
}

/// [`crate::light_fragments`] of a parallel view, `limit` fragments at most.
pub(crate) fn light_fragments_by_raster(
    tracer: &Tracer,
    raster: &Raster,
    limit: usize,
) -> Result<LightFragments, TraceError> {
    let [width, height] = raster.size;
    check_size(width, height)?;
    let slots = &tracer.slot_of_triangle;
    let rows = raster.rows(tracer, slots, 0.0);
    let fill = |band: Range<u32>, emit: &mut dyn FnMut(u32, (f32, u32)) -> bool| {
        let top = band.start;
        raster.each_row(tracer, slots, &rows, band, |slot, projected, y| {
            let leaf = &tracer.leaves[slot as usize];
            let row = (y - top) * width;
            projected.columns(f64::from(y), 0.0, width).all(|x| {
                match projected.cover([f64::from(x), f64::from(y)]) {
                    Some(hit) if (0.0..=1.0).contains(&hit.t) && tracer.is_there(leaf, &hit) => {
                        emit(row + x, (hit.t as f32, leaf.id))
                    }
                    _ => true,
                }
            })
        });
    };
    let gathered = gather(raster.size, limit, fill);
    let (starts, fragments) = gathered.ok_or(TraceError::Fragments { limit })?;
    let (depth, triangle) = fragments.into_iter().unzip();
    Ok(LightFragments { width, height, starts, depth, triangle })
}
