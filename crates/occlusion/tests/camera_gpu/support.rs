//! Scenes by hand, cameras, and frames.

use std::sync::{Mutex, MutexGuard, PoisonError};

use dapple_gpu::Gpu;
use dapple_gpu::testing::test_gpu;
use dapple_occlusion::camera::gpu::{Renderer, Scene, Settings};
use dapple_occlusion::camera::renderer::Renderer as _;
use dapple_occlusion::camera::{Bounds, Image, Mask, Object, Objects, Query, Template, View};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Mat3, Quat, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub const NEAR: f64 = 0.5;

/// The adapter for one test at a time: they use both cores, and share one device.
pub fn exclusive_gpu() -> Option<(&'static Gpu, MutexGuard<'static, ()>)> {
    static ONE: Mutex<()> = Mutex::new(());
    let lock = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    test_gpu().map(|gpu| (gpu, lock))
}

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

pub fn camera(position: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera {
        name: "test".into(),
        position: position.into(),
        target: target.into(),
        up: DVec3::Y,
        projection,
    }
}

/// Looks along -z from the origin, 90 degrees: at a distance of `height / 2` m a pixel is 1 m.
pub fn square_on(objects: &Objects, width: u32, height: u32) -> View {
    let right_angle = Projection::Perspective { fov_y_rad: std::f64::consts::FRAC_PI_2 };
    let camera = camera([0.0; 3], [0.0, 0.0, -1.0], right_angle);
    View::new(&camera, objects, width, height, NEAR).unwrap()
}

/// A rectangle across the view direction.
pub fn rectangle(x: [f32; 2], y: [f32; 2], z: f32) -> Template {
    let corner = |i: usize, j: usize| Vec3::new(x[i], y[j], z);
    Template {
        positions: vec![corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)],
        uvs: [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(Vec2::from).to_vec(),
        triangles: vec![[0, 1, 2], [2, 1, 3]],
        mask: None,
        albedo: Vec3::new(0.25, 0.5, 1.0),
    }
}

/// A box without depth.
pub fn flat_box(x: [f32; 2], y: [f32; 2], z: f32) -> Bounds {
    Bounds { min: Vec3::new(x[0], y[0], z), max: Vec3::new(x[1], y[1], z) }
}

pub fn add_template(objects: &mut Objects, template: Template) -> u32 {
    objects.templates.push(template);
    objects.templates.len() as u32 - 1
}

pub fn place(objects: &mut Objects, template: u32, linear: Mat3, translation: Vec3) -> u32 {
    let mut object = Object { template, linear, translation, bounds: Bounds::EMPTY };
    for p in &objects.templates[template as usize].positions {
        let p = object.place(*p);
        let slack = 1e-5 * (1.0 + p.abs().max_element());
        object.bounds = object.bounds.union(Bounds { min: p - slack, max: p + slack });
    }
    objects.objects.push(object);
    objects.objects.len() as u32 - 1
}

pub fn add(objects: &mut Objects, template: Template) -> u32 {
    let template = add_template(objects, template);
    place(objects, template, Mat3::IDENTITY, Vec3::ZERO)
}

/// Stars of triangles, a block, a single triangle, and leaves with holes, placed all over, some of
/// them mirrored, around the origin.
pub fn heap(seed: u64, count: usize) -> Objects {
    let mut rng = rng(seed);
    let mut objects = Objects::default();
    objects.masks.push(Mask { width: 5, height: 7, words: vec![0x5a5a_f0f1, 0b101] });
    for triangles in [1, 9, 4] {
        let mut star = Template { albedo: Vec3::splat(0.3), ..Template::default() };
        for i in 0..triangles {
            let mut corner =
                || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            star.positions.extend([corner(), corner(), corner()]);
            star.triangles.push([3 * i, 3 * i + 2, 3 * i + 1]);
        }
        add_template(&mut objects, star);
    }
    let mut leaf = Template { mask: Some(0), ..rectangle([-2.0, 2.0], [-1.0, 1.0], 0.0) };
    for uv in &mut leaf.uvs {
        *uv = *uv * 3.0 - 1.3;
    }
    add_template(&mut objects, leaf);
    add_template(&mut objects, rectangle([-1.0, 1.0], [-1.0, 1.0], 0.0));
    for _ in 0..count {
        let template = rng.random_range(0..objects.templates.len() as u32);
        let mut number = |reach: f32| rng.random_range(-reach..reach);
        let turn = Quat::from_xyzw(number(1.0), number(1.0), number(1.0), number(1.0));
        let stretch = Vec3::new(number(3.0), number(3.0), number(3.0));
        let linear = Mat3::from_quat(turn.normalize()) * Mat3::from_diagonal(stretch);
        let translation = Vec3::new(number(20.0), number(12.0), number(20.0));
        place(&mut objects, template, linear, translation);
    }
    objects
}

/// Cameras outside, inside, and of parallel rays.
pub fn views(objects: &Objects, width: u32, height: u32) -> Vec<View> {
    let opening = Projection::Perspective { fov_y_rad: 1.1 };
    let parallel = Projection::Orthographic { height_m: 30.0 };
    [
        camera([3.0, 5.0, 45.0], [0.0, 0.0, 0.0], opening),
        camera([1.0, -2.0, 3.0], [9.0, 1.0, -7.0], opening),
        camera([-30.0, 20.0, 10.0], [0.0, 0.0, 0.0], parallel),
    ]
    .iter()
    .map(|camera| View::new(camera, objects, width, height, NEAR).unwrap())
    .collect()
}

pub fn all(objects: &Objects) -> Vec<u32> {
    (0..objects.objects.len() as u32).collect()
}

/// Draws everything as one frame.
pub fn draw_all(renderer: &mut Renderer<'_>, view: &View, objects: &Objects) -> Image {
    renderer.begin(view).unwrap();
    renderer.draw(&all(objects)).unwrap();
    renderer.end().unwrap();
    renderer.image().unwrap()
}

pub fn renderer<'g>(gpu: &'g Gpu, objects: &Objects, settings: Settings) -> Renderer<'g> {
    Renderer::new(gpu, &Scene::new(gpu, objects).unwrap(), settings).unwrap()
}

/// One query a box.
pub fn one_each(boxes: usize) -> Vec<Query> {
    (0..boxes as u32).map(|i| Query { boxes: i..i + 1 }).collect()
}

/// Asks one query a box and waits.
pub fn counts(renderer: &mut Renderer<'_>, boxes: &[Bounds]) -> Vec<u32> {
    renderer.ask(boxes, &one_each(boxes.len())).unwrap();
    let mut counts = Vec::new();
    renderer.collect(&mut counts).unwrap();
    counts
}
