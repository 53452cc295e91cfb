//! Every fragment of a parallel light's map by filling triangles: each is visited once a band of
//! rows instead of once a ray, and nothing has to be searched.
//!
//! Corners are projected in `f64`, equal ones to equal points, and whether a texel's centre is
//! covered is decided as for rays (`watertight.rs`). So rays and this agree but for the last bit:
//! where an edge runs through a texel's centre, they may choose different sides of it.

use crate::error::TraceError;
use crate::light_fragments::{LightFragments, check_count, check_size, parts};
use crate::tracer::{Leaf, Tracer, UNTRACED};
use crate::watertight::{Corners, Crossing, weigh};
use dapple_scene::LightView;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bands of rows that are filled in parallel. More balance better, but each looks through the rows
/// of every triangle.
const BANDS: u32 = 64;

/// Whether and how [`fill`] can draw this view: parallel, and finite in units of texels.
pub(crate) fn raster(tracer: &Tracer, view: &LightView, size: [u32; 2]) -> Option<Raster> {
    let [width, height] = size;
    let depth_range = view.far_m - view.near_m;
    let from_centre = tracer.space.centre - view.origin;
    // From normalised space: u = 0.5 + 0.5 (p · right) / half_extent, and so on.
    let axis = |axis: DVec3, scale: f64, offset: f64| {
        let row = axis * (scale / tracer.space.scale);
        (row, from_centre.dot(axis) * scale + offset)
    };
    let texels = |n: u32| 0.5 * f64::from(n) / view.half_extent;
    // A texel's centre has whole coordinates.
    let offset = |n: u32| 0.5 * f64::from(n) - 0.5;
    let (x, x0) = axis(view.right, texels(width), offset(width));
    let (y, y0) = axis(view.down, texels(height), offset(height));
    let (z, z0) = axis(view.forward, 1.0 / depth_range, -view.near_m / depth_range);
    let finite = [x, y, z, DVec3::new(x0, y0, z0)].iter().all(|row| row.is_finite());
    (finite && !view.perspective).then_some(Raster { size, x, y, z, offset: [x0, y0, z0] })
}

/// The map from normalised space to texels and linear depth.
pub(crate) struct Raster {
    size: [u32; 2],
    x: DVec3,
    y: DVec3,
    z: DVec3,
    offset: [f64; 3],
}

/// A triangle on the map: texels from the first texel's centre, and linear depth.
struct Projected {
    corners: [[f64; 2]; 3],
    depth: [f64; 3],
}

/// Whole numbers in lo..=hi and 0..n, as `start..end`.
fn whole(lo: f64, hi: f64, n: u32) -> (u32, u32) {
    let n = f64::from(n);
    // The casts saturate; an empty range stays empty.
    let (start, end) = (lo.ceil().clamp(0.0, n), (hi.floor() + 1.0).clamp(0.0, n));
    (start as u32, end as u32)
}

impl Raster {
    fn project(&self, corners: &Corners) -> Projected {
        let points = corners.map(DVec3::from_array);
        let [x0, y0, z0] = self.offset;
        Projected {
            corners: points.map(|p| [self.x.dot(p) + x0, self.y.dot(p) + y0]),
            depth: points.map(|p| self.z.dot(p) + z0),
        }
    }

    /// The rows whose centres a triangle can cover.
    fn rows(&self, leaf: &Leaf) -> (u16, u16) {
        let [a, b, c] = leaf.corners.map(|p| self.y.dot(DVec3::from_array(p)) + self.offset[1]);
        let (start, end) = whole(a.min(b).min(c), a.max(b).max(c), self.size[1]);
        (start as u16, end as u16)
    }
}

impl Projected {
    /// Columns of row `y` that the triangle may cover, and never fewer than it does.
    fn columns(&self, y: f64, width: u32) -> (u32, u32) {
        let [a, b, c] = self.corners;
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut add = |x: f64| (lo, hi) = (lo.min(x), hi.max(x));
        for [p, q] in [[a, b], [b, c], [c, a]] {
            if p[1].min(q[1]) > y || p[1].max(q[1]) < y {
                continue;
            }
            if p[1] == q[1] {
                add(p[0]);
                add(q[0]);
            } else {
                add(p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1])));
            }
        }
        // Far above the rounding of the line above, far below a texel.
        let longest = a[0].abs().max(b[0].abs()).max(c[0].abs());
        let margin = 1e-9 * (1.0 + longest);
        let (left, right) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
        whole((lo - margin).max(left), (hi + margin).min(right), width)
    }

    /// Where the light meets the triangle above texel (x, y), if it does between near and far.
    #[inline(always)]
    fn cover(&self, x: f64, y: f64) -> Option<Crossing> {
        let [a, b, c] = self.corners.map(|p| [p[0] - x, p[1] - y]);
        let weights = weigh::<true>(a, b, c)?;
        let [az, bz, cz] = self.depth;
        let depth = (weights.a * az + weights.b * bz + weights.c * cz) * weights.inverse;
        // Of a triangle seen edge-on the weights are noise.
        let t = depth.clamp(az.min(bz).min(cz), az.max(bz).max(cz));
        let crossing =
            Crossing { t, u: weights.b * weights.inverse, v: weights.c * weights.inverse };
        (0.0..=1.0).contains(&t).then_some(crossing)
    }
}

/// Calls `emit` with texel of the band, depth and triangle of each fragment of rows `band`,
/// triangle after triangle, until it returns false.
fn fill(
    tracer: &Tracer,
    raster: &Raster,
    rows: &[(u16, u16)],
    band: (u32, u32),
    mut emit: impl FnMut(usize, f32, u32) -> bool,
) {
    let width = raster.size[0];
    for (triangle, &(start, end)) in rows.iter().enumerate() {
        let (first, end) = (u32::from(start).max(band.0), u32::from(end).min(band.1));
        if first >= end {
            continue;
        }
        let leaf = &tracer.leaves[tracer.slot_of_triangle[triangle] as usize];
        let projected = raster.project(&leaf.corners);
        for y in first..end {
            let row = (y - band.0) as usize * width as usize;
            let (left, right) = projected.columns(f64::from(y), width);
            for x in left..right {
                if let Some(crossing) = projected.cover(f64::from(x), f64::from(y))
                    && tracer.is_there(leaf, &crossing)
                    && !emit(row + x as usize, crossing.t as f32, triangle as u32)
                {
                    return;
                }
            }
        }
    }
}

/// [`crate::light_fragments`] of a view that [`raster`] can draw, `limit` fragments at most: counted
/// first, then filled in.
pub(crate) fn light_fragments_by_raster(
    tracer: &Tracer,
    raster: &Raster,
    limit: usize,
) -> Result<LightFragments, TraceError> {
    let [width, height] = raster.size;
    check_size(width, height)?;
    let texels = width as usize * height as usize;
    let mut map =
        LightFragments { width, height, starts: vec![0; texels + 1], ..LightFragments::default() };
    if texels == 0 {
        return Ok(map);
    }
    let rows: Vec<(u16, u16)> = tracer
        .slot_of_triangle
        .par_iter()
        .map(
            |&slot| {
                if slot == UNTRACED { (0, 0) } else { raster.rows(&tracer.leaves[slot as usize]) }
            },
        )
        .collect();
    let band_rows = height.div_ceil(BANDS);
    let band = |i: usize| {
        let start = i as u32 * band_rows;
        (start, (start + band_rows).min(height))
    };
    let band_texels = band_rows as usize * width as usize;

    let total = AtomicUsize::new(0);
    map.starts[1..].par_chunks_mut(band_texels).enumerate().for_each(|(i, counts)| {
        let mut found = total.load(Ordering::Relaxed);
        let before = found;
        fill(tracer, raster, &rows, band(i), |texel, _, _| {
            counts[texel] += 1;
            found += 1;
            found <= limit
        });
        total.fetch_add(found - before, Ordering::Relaxed);
    });
    let total = total.into_inner();
    check_count(total, limit)?;
    let mut end = 0;
    for start in &mut map.starts {
        end += *start;
        *start = end;
    }

    (map.depth, map.triangle) = (vec![0.0; total], vec![0; total]);
    parts(&map.starts, band_texels, &mut map.depth, &mut map.triangle)
        .into_par_iter()
        .enumerate()
        .for_each(|(i, part)| {
            let mut next: Vec<u32> = part.starts.iter().map(|s| s - part.starts[0]).collect();
            fill(tracer, raster, &rows, band(i), |texel, depth, triangle| {
                let place = next[texel] as usize;
                next[texel] += 1;
                (part.depth[place], part.triangle[place]) = (depth, triangle);
                true
            });
        });
    Ok(map)
}
