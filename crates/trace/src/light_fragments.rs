//! Everything a light meets through each texel's centre: the uncompressed deep shadow map.

use crate::error::TraceError;
use crate::light_raster::{Raster, light_fragments_by_raster};
use crate::lists;
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
        lists::range(&self.starts, texel)
    }

    /// Sorts each texel's fragments by depth, those at one depth in the order they are drawn in.
    pub fn sort_by_depth(&mut self) {
        let row = (self.width as usize).max(1);
        let depth = lists::split(&self.starts, row, &mut self.depth);
        let triangle = lists::split(&self.starts, row, &mut self.triangle);
        let starts = self.starts.par_windows(row + 1).step_by(row);
        let rows = depth.into_par_iter().zip(triangle).zip(starts);
        rows.for_each(|((depth, triangle), starts)| {
            let mut texel = Vec::new();
            for list in starts.windows(2) {
                let list = (list[0] - starts[0]) as usize..(list[1] - starts[0]) as usize;
                let (depth, triangle) = (&mut depth[list.clone()], &mut triangle[list]);
                texel.clear();
                texel.extend(depth.iter().copied().zip(triangle.iter().copied()));
                texel.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                for (i, &fragment) in texel.iter().enumerate() {
                    (depth[i], triangle[i]) = fragment;
                }
            }
        });
    }
}

/// All fragments of a light's map: by filling triangles where the light is parallel, by rays where it
/// is not. Where an edge runs exactly through a texel's centre the two may choose different sides of
/// it; nothing else differs.
///
/// # Errors
/// A side of more than [`MAX_MAP_SIDE`] texels, or more than [`MAX_LIGHT_FRAGMENTS`] fragments.
pub fn light_fragments(
    tracer: &Tracer,
    view: &LightView,
    width: u32,
    height: u32,
) -> Result<LightFragments, TraceError> {
    match Raster::of(tracer, view, [width, height]) {
        Some(raster) => light_fragments_by_raster(tracer, &raster, MAX_LIGHT_FRAGMENTS),
        None => light_fragments_by_rays(tracer, view, width, height),
    }
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
    by_rays(tracer, view, [width, height], MAX_LIGHT_FRAGMENTS)
}

fn by_rays(
    tracer: &Tracer,
    view: &LightView,
    [width, height]: [u32; 2],
    limit: usize,
) -> Result<LightFragments, TraceError> {
    check_size(width, height)?;
    let total = atomic::AtomicUsize::new(0);
    let rows: Vec<Row> = (0..height)
        .into_par_iter()
        .map(|y| {
            // Once there are too many the rest need not be found.
            if total.load(atomic::Ordering::Relaxed) > limit {
                return Row::default();
            }
            let row = row_by_rays(tracer, view, [width, height], y);
            total.fetch_add(row.fragments.len(), atomic::Ordering::Relaxed);
            row
        })
        .collect();
    check_count(total.into_inner(), limit)?;
    let starts = lists::starts(rows.iter().flat_map(|row| &row.counts).copied());
    let (triangle, depth) = rows.iter().flat_map(|row| &row.fragments).copied().unzip();
    Ok(LightFragments { width, height, starts, depth, triangle })
}

#[derive(Default)]
struct Row {
    counts: Vec<u32>,
    fragments: Vec<(u32, f32)>,
}

fn row_by_rays(tracer: &Tracer, view: &LightView, [width, height]: [u32; 2], y: u32) -> Row {
    let mut row = Row { counts: Vec::with_capacity(width as usize), fragments: Vec::new() };
    for x in 0..width {
        let (origin, direction) = view.ray(lists::centre(x, width), lists::centre(y, height));
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

pub(crate) fn check_size(width: u32, height: u32) -> Result<(), TraceError> {
    let limit = MAX_MAP_SIDE;
    let fits = width.max(height) <= limit;
    if fits { Ok(()) } else { Err(TraceError::MapSize { width, height, limit }) }
}

pub(crate) fn check_count(count: usize, limit: usize) -> Result<(), TraceError> {
    if count <= limit { Ok(()) } else { Err(TraceError::Fragments { limit }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_scene::{Instance, Material, Mesh, Scene};
    use glam::{DAffine3, DVec3, Vec3};

    #[test]
    fn a_map_with_too_many_fragments_is_refused_by_either_way() {
        let positions = vec![Vec3::ZERO, Vec3::X * 4.0, Vec3::Z * 4.0];
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2]; 3], ..Mesh::default() };
        let instance = Instance { mesh: 0, transform: DAffine3::IDENTITY };
        let scene = Scene {
            meshes: vec![mesh],
            materials: vec![Material::default()],
            instances: vec![instance],
            ..Scene::default()
        };
        let tracer = Tracer::build(&scene).unwrap();
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        let size = [40, 100];
        let raster = Raster::of(&tracer, &view, size).unwrap();
        let count = light_fragments(&tracer, &view, size[0], size[1]).unwrap().depth.len();
        assert!(count > 3000, "{count}");
        for limit in [count - 1, 100, 0] {
            let refused = Err(TraceError::Fragments { limit });
            assert_eq!(light_fragments_by_raster(&tracer, &raster, limit), refused);
            assert_eq!(by_rays(&tracer, &view, size, limit), refused);
        }
        assert!(light_fragments_by_raster(&tracer, &raster, count).is_ok());
        assert!(by_rays(&tracer, &view, size, count).is_ok());
    }
}
