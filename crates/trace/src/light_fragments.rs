//! Everything a light meets through each texel's centre: the uncompressed deep shadow map.

use crate::error::TraceError;
use crate::tracer::{Ray, Tracer};
use dapple_scene::LightView;
use rayon::prelude::*;
use std::{ops::ControlFlow, sync::atomic};

/// The longest side of a light's map.
pub const MAX_MAP_SIDE: u32 = 1 << 14;

/// The most fragments a map may have: 2 GiB of them.
pub const MAX_LIGHT_FRAGMENTS: usize = 1 << 28;

/// What the light ray through each texel's centre meets at depths 0..=1, translucent and opaque
/// surfaces alike, row-major from the top; within a texel in the order of triangles, which is the
/// order they are drawn in.
///
/// A ray through an edge that two triangles share meets one of them ([`Tracer::all_once`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightFragments {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height + 1` places in `depth` and `triangle`: texel t has those from `starts[t]`
    /// to before `starts[t + 1]`.
    pub starts: Vec<u32>,
    /// Linear light depth of each fragment, 0..=1.
    pub depth: Vec<f32>,
    /// The placed triangle it lies on.
    pub triangle: Vec<u32>,
}

impl LightFragments {
    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Where a texel's fragments lie; empty beyond the map.
    pub fn range(&self, texel: usize) -> std::ops::Range<usize> {
        match (self.starts.get(texel), self.starts.get(texel + 1)) {
            (Some(&start), Some(&end)) => start as usize..end as usize,
            _ => 0..0,
        }
    }
}

/// All fragments of a light's map.
///
/// # Errors
/// A side of more than [`MAX_MAP_SIDE`] texels, or more than [`MAX_LIGHT_FRAGMENTS`] fragments.
pub fn light_fragments(
    tracer: &Tracer,
    view: &LightView,
    width: u32,
    height: u32,
) -> Result<LightFragments, TraceError> {
    light_fragments_by_rays(tracer, view, width, height)
}

/// [`light_fragments`] with one ray a texel, for any view.
///
/// # Errors
/// As [`light_fragments`].
pub fn light_fragments_by_rays(
    tracer: &Tracer,
    view: &LightView,
    width: u32,
    height: u32,
) -> Result<LightFragments, TraceError> {
    check_size(width, height)?;
    let total = atomic::AtomicUsize::new(0);
    let rows: Vec<Row> = (0..height)
        .into_par_iter()
        .map(|y| {
            // Once there are too many the rest need not be found.
            if total.load(atomic::Ordering::Relaxed) > MAX_LIGHT_FRAGMENTS {
                return Row::default();
            }
            let row = row_by_rays(tracer, view, [width, height], y);
            total.fetch_add(row.fragments.len(), atomic::Ordering::Relaxed);
            row
        })
        .collect();
    check_count(total.into_inner())?;
    let mut map = LightFragments { width, height, starts: vec![0], ..LightFragments::default() };
    let mut end = 0;
    for row in rows {
        for count in row.counts {
            end += count;
            map.starts.push(end);
        }
        map.triangle.extend(row.fragments.iter().map(|f| f.0));
        map.depth.extend(row.fragments.iter().map(|f| f.1));
    }
    Ok(map)
}

#[derive(Default)]
struct Row {
    counts: Vec<u32>,
    fragments: Vec<(u32, f32)>,
}

fn row_by_rays(tracer: &Tracer, view: &LightView, [width, height]: [u32; 2], y: u32) -> Row {
    let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let mut row = Row { counts: Vec::with_capacity(width as usize), fragments: Vec::new() };
    for x in 0..width {
        let (origin, direction) = view.ray(centre(x, width), centre(y, height));
        let first = row.fragments.len();
        tracer.visit_once(&Ray { origin, direction, t_min: 0.0, t_max: 1.0 }, |hit| {
            row.fragments.push((hit.triangle, hit.t as f32));
            ControlFlow::Continue(())
        });
        row.fragments[first..].sort_unstable_by_key(|f| f.0);
        row.counts.push((row.fragments.len() - first) as u32);
    }
    row
}

fn check_size(width: u32, height: u32) -> Result<(), TraceError> {
    let limit = MAX_MAP_SIDE;
    let fits = width.max(height) <= limit;
    if fits { Ok(()) } else { Err(TraceError::MapSize { width, height, limit }) }
}

fn check_count(count: usize) -> Result<(), TraceError> {
    let limit = MAX_LIGHT_FRAGMENTS;
    if count <= limit { Ok(()) } else { Err(TraceError::Fragments { limit }) }
}
