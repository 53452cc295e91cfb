mod coverage;
mod fast;
mod queries;
mod rays;
mod refusals;

use super::super::{Bounds, Image, Mask, Object, Objects, Readiness, Renderer, Template, View};
use super::{Fast, Reference};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Mat3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;

pub const NEAR: f64 = 0.1;
pub const NOW: Readiness = Readiness::Modelled(0);

pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Multiples of 1/1024: sums and differences of them are exact.
pub fn dyadic(random: &mut Pcg64Mcg, reach: i32) -> f32 {
    random.random_range(-1024 * reach..1024 * reach) as f32 / 1024.0
}

pub fn point(random: &mut Pcg64Mcg, reach: i32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| dyadic(random, reach)))
}

/// Triangles of many sizes, some degenerate.
pub fn soup(seed: u64, count: usize, reach: i32) -> Vec<[Vec3; 3]> {
    let mut random = random(seed);
    let triangle = |i: usize| {
        let middle = point(&mut random, reach);
        let size = [reach, 1, 1, 1][i % 4];
        let mut corner = || middle + point(&mut random, size);
        let (a, b, c) = (corner(), corner(), corner());
        match i % 29 {
            27 => [a, a, b],
            28 => [a, b, a + 2.0 * (b - a)],
            _ => [a, b, c],
        }
    };
    (0..count).map(triangle).collect()
}

pub fn bounds_of(points: impl IntoIterator<Item = Vec3>) -> Bounds {
    points.into_iter().fold(Bounds::EMPTY, |bounds, p| bounds.union(Bounds { min: p, max: p }))
}

/// One object a chunk of triangles.
pub fn objects(triangles: &[[Vec3; 3]], chunk: usize) -> Arc<Objects> {
    let mut world = Objects::default();
    for part in triangles.chunks(chunk) {
        let positions = part.as_flattened().to_vec();
        let bounds = bounds_of(positions.iter().copied());
        let triangles = (0..part.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        add(&mut world, Template { positions, triangles, ..Template::default() }, bounds);
    }
    Arc::new(world)
}

pub fn add(world: &mut Objects, template: Template, bounds: Bounds) {
    world.objects.push(Object {
        template: world.templates.len() as u32,
        linear: Mat3::IDENTITY,
        translation: Vec3::ZERO,
        bounds,
    });
    world.templates.push(template);
}

/// A mask of a checkerboard of `side` x `side` texels.
pub fn checkerboard(side: u32) -> Mask {
    let mut words = vec![0; (side * side).div_ceil(32) as usize];
    for texel in (0..side * side).filter(|t| (t % side + t / side).is_multiple_of(2)) {
        words[(texel / 32) as usize] |= 1 << (texel % 32);
    }
    Mask { width: side, height: side, words }
}

/// Every other object gets the mask, its texture repeated.
pub fn masked(world: &Objects) -> Arc<Objects> {
    let mut world = world.clone();
    world.masks.push(checkerboard(5));
    for template in world.templates.iter_mut().step_by(2) {
        template.mask = Some(0);
        template.uvs = (0..template.positions.len())
            .map(|i| [Vec2::ZERO, Vec2::X, Vec2::Y][i % 3] * 1.5)
            .collect();
    }
    Arc::new(world)
}

pub fn camera(position: DVec3, target: DVec3) -> Camera {
    let projection = Projection::Perspective { fov_y_rad: 1.0 };
    Camera { name: "test".into(), position, target, up: DVec3::Y, projection }
}

pub fn view(objects: &Objects, camera: &Camera, width: u32, height: u32) -> View {
    View::new(camera, objects, width, height, NEAR).unwrap()
}

/// Looks along -z from the origin.
pub fn straight(objects: &Objects, width: u32, height: u32) -> View {
    view(objects, &camera(DVec3::ZERO, DVec3::NEG_Z), width, height)
}

/// Looks along -z, one metre a pixel, pixel (0, 0) at x 0..1, y `height - 1`..`height`.
pub fn flat(objects: &Objects, width: u32, height: u32) -> View {
    let middle = DVec3::new(f64::from(width), f64::from(height), 0.0) * 0.5;
    let projection = Projection::Orthographic { height_m: f64::from(height) };
    let camera = Camera { projection, ..camera(middle, middle - DVec3::Z) };
    view(objects, &camera, width, height)
}

pub fn all(objects: &Objects) -> Vec<u32> {
    (0..objects.objects.len() as u32).collect()
}

pub fn reference(objects: &Arc<Objects>, view: &View) -> Reference {
    let mut renderer = Reference::new(objects.clone(), NOW).unwrap();
    renderer.begin(view).unwrap();
    renderer.draw(&all(objects)).unwrap();
    renderer.end().unwrap();
    renderer
}

pub fn fast(objects: &Arc<Objects>, view: &View) -> Fast {
    let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
    renderer.begin(view).unwrap();
    renderer.draw(&all(objects)).unwrap();
    renderer.end().unwrap();
    renderer
}

pub fn drawn(image: &Image) -> usize {
    image.ids.iter().filter(|id| id[0] > 0).count()
}

/// Distance in pixels of the centre of pixel `index` from the nearest edge of any of `triangles` as
/// clipped and projected, and whether the triangle comes near the centre at all.
pub fn edge_distance(view: &View, triangle: &[Vec3; 3], index: usize) -> f64 {
    use super::project::{Corner, Polygon, Projection};
    let projection = Projection::new(view);
    let corners = triangle.map(|p| Corner { clip: projection.clip(p), uv: glam::DVec2::ZERO });
    let (x, y) = (index as u32 % view.width, index as u32 / view.width);
    let centre = glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let mut least = f64::INFINITY;
    for part in Polygon::clipped(&corners).triangles() {
        let screen = part.map(|c| {
            let at = projection.screen(c.clip);
            glam::DVec2::new(at.x, at.y)
        });
        for i in 0..3 {
            let (a, b) = (screen[i], screen[(i + 1) % 3]);
            let along = b - a;
            let t = ((centre - a).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
            least = least.min((a + along * t - centre).length());
        }
    }
    least
}
