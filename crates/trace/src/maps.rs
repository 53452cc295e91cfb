//! Images of rays: depth maps and item buffers, in parallel over rows.

use crate::lists::centre;
use crate::surface::Surface;
use crate::tracer::{Hit, Ray, Tracer};
use dapple_scene::{Camera, LightView};
use rayon::prelude::*;

fn image<T: Send>(width: u32, height: u32, pixel: impl Fn(f64, f64) -> T + Sync) -> Vec<T> {
    (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let pixel = &pixel;
            (0..width).map(move |x| pixel(centre(x, width), centre(y, height)))
        })
        .collect()
}

/// Linear depth 0..=1 of the nearest surface through each texel's centre, rows top to bottom, 1
/// where nothing lies between `near_m` and `far_m`.
pub fn depth_map(tracer: &Tracer, view: &LightView, width: u32, height: u32) -> Vec<f32> {
    image(width, height, |u, v| {
        let (origin, direction) = view.ray(u, v);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: 1.0 };
        tracer.closest(&ray).map_or(1.0, |hit| hit.t as f32)
    })
}

/// The ray through each pixel's centre and what it hits first, rows top to bottom; `None` where it
/// hits nothing. Distances are in metres.
pub fn item_buffer(
    tracer: &Tracer,
    camera: &Camera,
    width: u32,
    height: u32,
) -> Vec<Option<(Ray, Hit)>> {
    let aspect = f64::from(width) / f64::from(height.max(1));
    image(width, height, |x, y| {
        let (origin, direction) = camera.ray(x, y, aspect);
        let ray = Ray::new(origin, direction);
        tracer.closest(&ray).map(|hit| (ray, hit))
    })
}

/// The surfaces of an item buffer, in its order.
pub fn surfaces(tracer: &Tracer, items: &[Option<(Ray, Hit)>]) -> Vec<Option<Surface>> {
    items.par_iter().map(|item| item.as_ref().map(|(ray, hit)| tracer.surface(ray, hit))).collect()
}
