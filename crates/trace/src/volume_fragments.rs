//! Volumes as a light's map takes them: each chord cut into slices.

use crate::error::TraceError;
use crate::light_fragments::{MAX_LIGHT_FRAGMENTS, check_count, check_size};
use crate::lists;
use crate::tracer::Ray;
use crate::volume::{Ball, ball_bounds};
use dapple_scene::LightView;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the light ray through each texel's centre meets of volumes at depths 0..=1, row-major from
/// the top; within a texel ball by ball, along a ball from front to back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolumeFragments {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height + 1` places in `depth` and `thickness`, as in
    /// [`crate::LightFragments::starts`].
    pub starts: Vec<u32>,
    /// Linear light depth of each slice's middle, 0..=1.
    pub depth: Vec<f32>,
    /// Its optical thickness, > 0: light of e to the minus it passes.
    pub thickness: Vec<f32>,
}

impl VolumeFragments {
    /// Where a texel's fragments lie; empty beyond the map.
    pub fn range(&self, texel: usize) -> std::ops::Range<usize> {
        lists::range(&self.starts, texel)
    }
}

/// The chords of some balls, each in `slices` of equal length (0 counts as 1).
///
/// A texel's thicknesses add up to the exact optical depth of its ray whatever the number of
/// slices, and what lies in front of a depth is off by half a slice a ball at most.
///
/// # Errors
/// A bad ball, a side of more than [`crate::MAX_MAP_SIDE`] texels, or more than
/// [`MAX_LIGHT_FRAGMENTS`].
pub fn volume_fragments(
    balls: &[Ball],
    view: &LightView,
    width: u32,
    height: u32,
    slices: u16,
) -> Result<VolumeFragments, TraceError> {
    up_to(MAX_LIGHT_FRAGMENTS, balls, view, [width, height], slices)
}

fn up_to(
    limit: usize,
    balls: &[Ball],
    view: &LightView,
    [width, height]: [u32; 2],
    slices: u16,
) -> Result<VolumeFragments, TraceError> {
    ball_bounds(balls)?;
    check_size(width, height)?;
    let total = AtomicUsize::new(0);
    let row = |y: u32| {
        let (mut lengths, mut fragments) =
            (Vec::with_capacity(width as usize), Vec::<(f32, f32)>::new());
        for x in 0..width {
            let (origin, direction) = view.ray(lists::centre(x, width), lists::centre(y, height));
            let first = fragments.len();
            for ball in balls {
                // Once there are too many the rest need not be found.
                if total.load(Ordering::Relaxed) + fragments.len() <= limit {
                    slice(ball, &Ray { origin, direction, t_min: 0.0, t_max: 1.0 }, slices, |f| {
                        fragments.push(f);
                    });
                }
            }
            lengths.push((fragments.len() - first) as u32);
        }
        total.fetch_add(fragments.len(), Ordering::Relaxed);
        (lengths, fragments)
    };
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
    check_count(total.into_inner(), limit)?;
    let (depth, thickness) = rows.iter().flat_map(|row| &row.1).copied().unzip();
    let starts = lists::starts(rows.iter().flat_map(|row| &row.0).copied());
    Ok(VolumeFragments { width, height, starts, depth, thickness })
}

/// Depth and thickness of each slice of a ball along a ray.
fn slice(ball: &Ball, ray: &Ray, slices: u16, mut emit: impl FnMut((f32, f32))) {
    let Some((enter, leave)) = ball.chord(ray) else { return };
    let (from, to) = (enter.max(ray.t_min), leave.min(ray.t_max));
    let slices = u32::from(slices.max(1));
    let at = |i: u32| from + (to - from) * (f64::from(i) / f64::from(slices));
    for i in 0..slices {
        let part = Ray { t_min: at(i), t_max: at(i + 1), ..*ray };
        let thickness = ball.optical_depth(&part) as f32;
        if thickness > 0.0 {
            emit((((part.t_min + part.t_max) * 0.5) as f32, thickness));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Profile;
    use dapple_scene::Aabb;
    use glam::DVec3;

    #[test]
    fn more_fragments_than_there_is_room_for_are_refused() {
        let profile = Profile::Soft;
        let balls = [Ball { centre: DVec3::ZERO, radius: 1.0, extinction: 1.0, profile }; 3];
        let bounds = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
        let view = LightView::fit_directional(DVec3::X, &bounds).unwrap();
        let count = volume_fragments(&balls, &view, 9, 7, 50).unwrap().depth.len();
        assert!(count > 5000, "{count}");
        assert!(up_to(count, &balls, &view, [9, 7], 50).is_ok());
        for limit in [count - 1, 10, 0] {
            let refused = Err(TraceError::Fragments { limit });
            assert_eq!(up_to(limit, &balls, &view, [9, 7], 50), refused);
        }
    }
}
