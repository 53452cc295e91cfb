//! What a camera sees through translucent surfaces, layer behind layer.

use crate::error::TraceError;
use crate::lists;
use crate::opacity::Opacities;
use crate::surface::Surface;
use crate::tracer::{Hit, Ray, Tracer};
use dapple_scene::Camera;
use rayon::prelude::*;

/// The most surfaces of a pixel.
pub const MAX_LAYERS: usize = 64;

/// The longest side of an image of layers.
pub const MAX_IMAGE_SIDE: u32 = 1 << 12;

/// The share of a pixel below which what still lies behind it no longer shows in 8 bits.
pub const LEAST_CAMERA_TRANSMITTANCE: f64 = 1.0 / 255.0;

/// The surfaces along the view ray through each pixel's centre, rows top to bottom, within a pixel
/// from front to back.
///
/// A pixel's list ends with its first opaque surface, with the one that leaves less than
/// [`LEAST_CAMERA_TRANSMITTANCE`] of what lies behind, or after [`MAX_LAYERS`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraLayers {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height + 1` places in `surfaces` and `alpha`: pixel p has those from `starts[p]`
    /// to before `starts[p + 1]`.
    pub starts: Vec<u32>,
    /// Where the ray meets what; normals on the camera's side.
    pub surfaces: Vec<Surface>,
    /// Opacity of each surface, 0..=1.
    pub alpha: Vec<f32>,
}

impl CameraLayers {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Where a pixel's surfaces lie; empty beyond the image.
    pub fn range(&self, pixel: usize) -> std::ops::Range<usize> {
        lists::range(&self.starts, pixel)
    }
}

/// The surfaces a camera sees.
///
/// # Errors
/// A side of more than [`MAX_IMAGE_SIDE`] pixels.
pub fn camera_layers(
    tracer: &Tracer,
    opacities: &Opacities,
    camera: &Camera,
    width: u32,
    height: u32,
) -> Result<CameraLayers, TraceError> {
    // So that no count overflows: 2^24 pixels of 2^6 layers.
    let limit = MAX_IMAGE_SIDE;
    if width.max(height) > limit {
        return Err(TraceError::MapSize { width, height, limit });
    }
    let aspect = f64::from(width) / f64::from(height.max(1));
    let row = |y: u32| {
        let (mut hits, mut counts) = (Vec::new(), Vec::with_capacity(width as usize));
        let mut surfaces = Vec::new();
        for x in 0..width {
            let (origin, direction) =
                camera.ray(lists::centre(x, width), lists::centre(y, height), aspect);
            let ray = Ray::new(origin, direction);
            tracer.all_once(&ray, &mut hits);
            let seen = &hits[..visible(&hits, opacities)];
            surfaces.extend(seen.iter().map(|hit| tracer.surface(&ray, hit)));
            counts.push(seen.len() as u32);
        }
        (counts, surfaces)
    };
    let rows: Vec<(Vec<u32>, Vec<Surface>)> = (0..height).into_par_iter().map(row).collect();

    let starts = lists::starts(rows.iter().flat_map(|row| &row.0).copied());
    let surfaces: Vec<Surface> = rows.into_iter().flat_map(|row| row.1).collect();
    let alpha = surfaces.iter().map(|s| opacities.alpha(s.triangle)).collect();
    Ok(CameraLayers { width, height, starts, surfaces, alpha })
}

/// How many of the hits, sorted by distance, show.
fn visible(hits: &[Hit], opacities: &Opacities) -> usize {
    let mut left = 1.0;
    for (i, hit) in hits.iter().enumerate().take(MAX_LAYERS) {
        left *= 1.0 - f64::from(opacities.alpha(hit.triangle));
        if left < LEAST_CAMERA_TRANSMITTANCE {
            return i + 1;
        }
    }
    hits.len().min(MAX_LAYERS)
}
