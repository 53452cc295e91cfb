//! What every form of two-pass culling must do, on random worlds and cameras.

use super::{Fault, Settings, ShowsDepth, Traversal, cpu, reference};
use crate::camera::software::{Fast, Reference, owners};
use crate::camera::{
    Bounds, Frame, Image, Mask, Object, Objects, Readiness, Renderer, Template, Tree, View,
};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Mat3, Vec2, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;

const NOW: Readiness = Readiness::Modelled(0);
const NEAR: f64 = 0.1;

/// Ways through the processor's form; the widest asks every pixel of the images here.
pub(super) const SETTINGS: [Settings; 5] = [
    Settings { traversal: Traversal::Flat, across: 1 },
    Settings { traversal: Traversal::Flat, across: 2 },
    Settings { traversal: Traversal::Flat, across: 64 },
    Settings { traversal: Traversal::Tree, across: 2 },
    Settings { traversal: Traversal::Tree, across: 5 },
];

/// Adds a placement of `template` whose box holds its corners.
pub(super) fn place(world: &mut Objects, template: u32, linear: Mat3, translation: Vec3) {
    let mut object = Object { template, linear, translation, bounds: Bounds::EMPTY };
    for &p in &world.templates[template as usize].positions {
        let p = object.place(p);
        object.bounds = object.bounds.union(Bounds { min: p, max: p });
    }
    world.objects.push(object);
}

/// The 12 triangles of the unit cube around the origin.
fn cube() -> Template {
    let half = Vec3::splat(0.5);
    let positions = Bounds { min: -half, max: half }.corners().to_vec();
    let faces: [[u32; 4]; 6] =
        [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 3, 5, 7]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [b, c, d]]).collect();
    Template { positions, triangles, ..Template::default() }
}

/// A unit quad that faces z, with mask 0 if `masked`.
fn quad(masked: bool) -> Template {
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    Template {
        positions: uvs.iter().map(|uv| (*uv - 0.5).extend(0.0)).collect(),
        uvs: if masked { uvs.to_vec() } else { Vec::new() },
        triangles: vec![[0, 1, 2], [1, 2, 3]],
        mask: masked.then_some(0),
        ..Template::default()
    }
}

/// A mask whose left half is there.
fn half_mask() -> Mask {
    Mask { width: 2, height: 1, words: vec![1] }
}

/// Blocks, walls and alpha-tested walls at all places around the origin, and points.
pub(super) fn world(seed: u64, count: usize) -> Arc<Objects> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut world = Objects {
        templates: vec![cube(), quad(false), quad(true)],
        masks: vec![half_mask()],
        ..Objects::default()
    };
    for i in 0..count {
        let mut vector =
            |low: f32, high: f32| Vec3::from_array([0; 3].map(|_| random.random_range(low..high)));
        let at = vector(-20.0, 20.0) * Vec3::new(1.0, 0.3, 1.0);
        let size = match i % 13 {
            0 => Vec3::ZERO,
            1..=3 => vector(4.0, 15.0),
            _ => vector(0.1, 2.0),
        };
        let turn = Mat3::from_rotation_y(random.random_range(0.0..6.0));
        place(&mut world, [0, 0, 1, 2][i % 4], turn * Mat3::from_diagonal(size), at);
    }
    Arc::new(world)
}

pub(super) fn camera(position: DVec3, target: DVec3) -> Camera {
    let projection = Projection::Perspective { fov_y_rad: 1.2 };
    Camera { name: "test".into(), position, target, up: DVec3::Y, projection }
}

/// Steps, turns, stands still, and now and then jumps; every seventh view has parallel rays.
pub(super) fn path(seed: u64, frames: usize) -> Vec<Camera> {
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x5eed);
    let (mut at, mut angle) = (DVec3::ZERO, 0.0_f64);
    let mut cameras = Vec::new();
    for i in 0..frames {
        match random.random_range(0..5) {
            0 => {
                at = DVec3::from_array([0; 3].map(|_| random.random_range(-25.0..25.0)));
                angle = random.random_range(0.0..6.3);
            }
            1 => {}
            _ => {
                angle += random.random_range(-0.2..0.2);
                at += DVec3::new(angle.sin(), 0.0, angle.cos()) * 0.7;
            }
        }
        let mut camera = camera(at, at + DVec3::new(angle.sin(), -0.1, angle.cos()));
        if i % 7 == 6 {
            camera.projection = Projection::Orthographic { height_m: 12.0 };
        }
        cameras.push(camera);
    }
    cameras
}

/// What is drawn of everything.
fn everything<R: Renderer>(renderer: &mut R, objects: &Objects, view: &View) {
    let all: Vec<u32> = (0..objects.objects.len() as u32).collect();
    renderer.begin(view).unwrap();
    renderer.draw(&all).unwrap();
    renderer.end().unwrap();
}

/// Pixels where two images differ in more than which of two equal depths was drawn.
pub(super) fn differences(a: &Image, b: &Image) -> usize {
    assert_eq!((a.width, a.height), (b.width, b.height));
    a.depth.iter().zip(&b.depth).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
        + a.ids.iter().zip(&b.ids).filter(|(a, b)| (a[0] == 0) != (b[0] == 0)).count()
}

/// Holds a frame against the image of everything and against itself; gives the wrong pixels.
pub(super) fn faults(
    objects: &Objects,
    view: &View,
    frame: &Frame,
    image: &Image,
    all: &Image,
) -> usize {
    let mut drawn = vec![false; objects.objects.len()];
    for &object in &frame.drawn {
        assert!(!std::mem::replace(&mut drawn[object as usize], true), "{object} is drawn twice");
        assert!(view.sees(&objects.objects[object as usize].bounds), "{object} is out of sight");
    }
    let shown = owners(image, drawn.len());
    assert!(shown.iter().zip(&drawn).all(|(pixels, drawn)| *pixels == 0 || *drawn));
    assert_eq!(frame.work.draws, frame.drawn.len() as u64);
    let triangles = frame.drawn.iter().map(|&o| u64::from(objects.triangle_count(o))).sum::<u64>();
    assert_eq!(frame.work.triangles, triangles);
    differences(image, all)
}

/// Wrong pixels, objects drawn and objects on the screen over a path.
fn over(
    objects: &Arc<Objects>,
    cameras: &[Camera],
    size: (u32, u32),
    state: &mut cpu::State,
    settings: &Settings,
) -> [usize; 3] {
    let tree = Tree::bottom_up(objects).unwrap();
    let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
    let mut full = Fast::new(objects.clone(), NOW).unwrap();
    let mut frame = Frame::default();
    let mut sums = [0; 3];
    for camera in cameras {
        let view = View::new(camera, objects, size.0, size.1, NEAR).unwrap();
        cpu::frame(settings, objects, &tree, &view, state, &mut renderer, &mut frame).unwrap();
        everything(&mut full, objects, &view);
        sums[0] += faults(objects, &view, &frame, renderer.image(), full.image());
        sums[1] += frame.drawn.len();
        sums[2] += objects.objects.iter().filter(|o| view.sees(&o.bounds)).count();
    }
    sums
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The image is that of everything, whatever was visible before.
    #[test]
    fn the_image_is_that_of_everything(
        seed in any::<u64>(),
        width in 1u32..65,
        height in 1u32..49,
        way in 0..SETTINGS.len(),
    ) {
        let objects = world(seed, 120);
        let tree = Tree::bottom_up(&objects).unwrap();
        let mut state = cpu::State::new(&objects, &tree);
        let cameras = path(seed, 12);
        let [wrong, _, _] = over(&objects, &cameras, (width, height), &mut state, &SETTINGS[way]);
        prop_assert_eq!(wrong, 0);
    }

    /// By the scalar renderer, and every pixel of every rectangle.
    #[test]
    fn the_references_image_is_that_of_everything(seed in any::<u64>(), side in 1u32..40) {
        let objects = world(seed, 80);
        let mut state = reference::State::new(&objects);
        let mut renderer = Reference::new(objects.clone(), NOW).unwrap();
        let mut full = Reference::new(objects.clone(), NOW).unwrap();
        let mut frame = Frame::default();
        for camera in path(seed, 6) {
            let view = View::new(&camera, &objects, side, 40 - side, NEAR).unwrap();
            reference::frame(&objects, &view, &mut state, &mut renderer, &mut frame).unwrap();
            everything(&mut full, &objects, &view);
            prop_assert_eq!(faults(&objects, &view, &frame, renderer.image(), full.image()), 0);
        }
    }

    /// The tree finds the same objects with fewer questions; asking every pixel finds those of the
    /// reference; fewer texels find no fewer visible objects.
    #[test]
    fn ways_of_asking_agree(seed in any::<u64>()) {
        let objects = world(seed, 200);
        let tree = Tree::bottom_up(&objects).unwrap();
        let way = |traversal, across| Settings { traversal, across };
        let ways = [
            way(Traversal::Flat, 2),
            way(Traversal::Tree, 2),
            way(Traversal::Flat, 64),
            way(Traversal::Tree, 64),
        ];
        let mut states = ways.map(|_| cpu::State::new(&objects, &tree));
        let mut plain = reference::State::new(&objects);
        let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
        let mut frame = Frame::default();
        for camera in path(seed, 8) {
            let view = View::new(&camera, &objects, 64, 36, NEAR).unwrap();
            let mut drawn = Vec::new();
            for (settings, state) in ways.iter().zip(&mut states) {
                cpu::frame(settings, &objects, &tree, &view, state, &mut renderer, &mut frame)
                    .unwrap();
                frame.drawn.sort_unstable();
                drawn.push(frame.drawn.clone());
            }
            reference::frame(&objects, &view, &mut plain, &mut renderer, &mut frame).unwrap();
            frame.drawn.sort_unstable();
            prop_assert_eq!(&drawn[0], &drawn[1]);
            prop_assert_eq!(&drawn[2], &drawn[3]);
            prop_assert_eq!(&drawn[2], &frame.drawn);
            prop_assert_eq!(states[0].visible(), states[1].visible());
            prop_assert_eq!(states[2].visible(), plain.visible());
            let fewer = states[0].visible().iter().zip(plain.visible()).all(|(few, all)| few >= all);
            prop_assert!(fewer);
        }
    }

    /// A scene and its cameras, larger or smaller, and far from the origin: the same is drawn.
    #[test]
    fn scale_does_not_matter(seed in any::<u64>(), power in -20i32..21) {
        let objects = world(seed, 100);
        let scale = 2.0_f32.powi(power);
        let mut scaled = (*objects).clone();
        for object in &mut scaled.objects {
            object.linear *= scale;
            object.translation *= scale;
            object.bounds =
                Bounds { min: object.bounds.min * scale, max: object.bounds.max * scale };
        }
        scaled.origin = DVec3::new(2e8, -1e8, 3e8) * f64::from(scale);
        let scaled = Arc::new(scaled);
        let drawn = |objects: &Arc<Objects>, scale: f64| {
            let tree = Tree::bottom_up(objects).unwrap();
            let mut state = cpu::State::new(objects, &tree);
            let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
            let mut frame = Frame::default();
            let mut drawn = Vec::new();
            for mut camera in path(seed, 6) {
                // Steps of a thousandth are exact at any of these origins.
                let near = |p: DVec3| (p * 1024.0).round() / 1024.0 * scale;
                camera.position = near(camera.position) + objects.origin;
                camera.target = near(camera.target) + objects.origin;
                camera.projection = Projection::Perspective { fov_y_rad: 1.2 };
                let view = View::new(&camera, objects, 48, 32, NEAR * scale).unwrap();
                let settings = Settings::default();
                cpu::frame(&settings, objects, &tree, &view, &mut state, &mut renderer, &mut frame)
                    .unwrap();
                drawn.push(frame.drawn.clone());
            }
            drawn
        };
        prop_assert_eq!(drawn(&objects, 1.0), drawn(&scaled, f64::from(scale)));
    }
}

/// Large worlds are culled, not only drawn rightly.
#[test]
fn much_is_culled() {
    let objects = world(3, 2000);
    let tree = Tree::bottom_up(&objects).unwrap();
    let step = |i: usize| DVec3::new(0.3 * i as f64, 0.0, 0.0);
    let cameras: Vec<_> =
        (0..20).map(|i| camera(step(i), step(i) + DVec3::new(1.0, 0.0, 0.2))).collect();
    for settings in SETTINGS {
        let mut state = cpu::State::new(&objects, &tree);
        let [wrong, drawn, seen] = over(&objects, &cameras, (160, 90), &mut state, &settings);
        assert_eq!(wrong, 0);
        assert!(2 * drawn < seen, "{settings:?}: {drawn} of {seen} in the frustum");
    }
}

/// Negative control.
#[test]
fn a_pyramid_of_the_nearest_draws_a_wrong_image() {
    let objects = world(3, 300);
    let tree = Tree::bottom_up(&objects).unwrap();
    for settings in SETTINGS {
        let mut state = cpu::State::with_fault(&objects, &tree, Fault::Nearest);
        let [wrong, _, _] = over(&objects, &path(3, 12), (64, 48), &mut state, &settings);
        // Rectangles of single pixels are asked at the image itself, which the fault leaves alone.
        assert_eq!(wrong > 0, settings.across < 64, "{settings:?}: {wrong}");
    }
}

#[test]
fn the_first_frame_draws_all_in_sight_and_a_still_camera_only_what_shows() {
    let objects = world(5, 400);
    let tree = Tree::bottom_up(&objects).unwrap();
    let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
    let view = View::new(&path(5, 1)[0], &objects, 80, 60, NEAR).unwrap();
    for settings in SETTINGS {
        let mut state = cpu::State::new(&objects, &tree);
        let mut frames = vec![Frame::default(); 4];
        for frame in &mut frames {
            cpu::frame(&settings, &objects, &tree, &view, &mut state, &mut renderer, frame)
                .unwrap();
        }
        let draws: Vec<_> = frames.iter().map(|f| f.work.draws).collect();
        assert!(draws[1] < draws[0] && draws[2..].iter().all(|d| *d == draws[1]), "{draws:?}");
        // One pyramid where the second pass draws nothing.
        let texels: Vec<_> = frames.iter().map(|f| f.work.pyramid_texels).collect();
        assert!(texels[0] == 2 * texels[1] && texels[2] == texels[1], "{texels:?}");

        state.reset();
        let mut again = Frame::default();
        cpu::frame(&settings, &objects, &tree, &view, &mut state, &mut renderer, &mut again)
            .unwrap();
        assert_eq!(again, frames[0]);
    }
}

/// A wall, a window in it, and blocks behind: `masked` is the window's mask.
fn window(masked: Mask) -> Arc<Objects> {
    let mut world =
        Objects { templates: vec![cube(), quad(true)], masks: vec![masked], ..Objects::default() };
    let flat = |x: f32, y: f32| Mat3::from_diagonal(Vec3::new(x, y, 1.0));
    place(&mut world, 1, flat(40.0, 40.0), Vec3::new(0.0, 0.0, -5.0));
    for x in [-12.0, 12.0] {
        place(&mut world, 0, Mat3::IDENTITY, Vec3::new(x, 0.0, -30.0));
    }
    Arc::new(world)
}

/// An alpha-tested wall hides by the pixels that it draws, and by no others.
#[test]
fn alpha_tested_objects_hide_what_is_behind_their_pixels() {
    for (mask, behind) in [(half_mask(), vec![2]), (Mask { words: vec![3], ..half_mask() }, vec![])]
    {
        let objects = window(mask);
        let tree = Tree::bottom_up(&objects).unwrap();
        let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
        let camera = camera(DVec3::ZERO, DVec3::NEG_Z);
        let view = View::new(&camera, &objects, 64, 64, NEAR).unwrap();
        // One texel across says little of boxes that lie astride texels of all levels.
        for settings in SETTINGS.into_iter().filter(|s| s.across > 1) {
            let mut state = cpu::State::new(&objects, &tree);
            let mut frame = Frame::default();
            for _ in 0..2 {
                cpu::frame(
                    &settings,
                    &objects,
                    &tree,
                    &view,
                    &mut state,
                    &mut renderer,
                    &mut frame,
                )
                .unwrap();
            }
            frame.drawn.sort_unstable();
            let expected: Vec<u32> = [vec![0], behind.clone()].concat();
            assert_eq!(frame.drawn, expected, "{settings:?}");
        }
    }
}

/// A block that shows through a slit of one pixel between two walls, at the image's edge and within.
#[test]
fn what_shows_through_a_slit_is_drawn() {
    let (width, height) = (37, 21);
    for column in [0, 1, 17, 35, 36] {
        let mut world = Objects { templates: vec![quad(false)], ..Objects::default() };
        // Parallel rays, a metre a pixel: columns are at x - width / 2.
        let wall = |from: f32, to: f32| (0.5 * (from + to), to - from);
        let left = column as f32 - 0.5 * width as f32;
        for (middle, size) in [wall(-40.0, left), wall(left + 1.0, 40.0)] {
            let linear = Mat3::from_diagonal(Vec3::new(size, 60.0, 1.0));
            place(&mut world, 0, linear, Vec3::new(middle, 0.0, -5.0));
        }
        let linear = Mat3::from_diagonal(Vec3::new(90.0, 90.0, 1.0));
        place(&mut world, 0, linear, Vec3::new(0.0, 0.0, -9.0));
        let objects = Arc::new(world);
        let tree = Tree::bottom_up(&objects).unwrap();
        let projection = Projection::Orthographic { height_m: f64::from(height) };
        let camera = Camera { projection, ..camera(DVec3::ZERO, DVec3::NEG_Z) };
        for settings in SETTINGS {
            let mut state = cpu::State::new(&objects, &tree);
            let cameras = vec![camera.clone(); 3];
            let [wrong, drawn, _] =
                over(&objects, &cameras, (width, height), &mut state, &settings);
            // At the image's edge one of the walls is beside it.
            let beside = usize::from(column == 0 || column == width - 1);
            assert_eq!((wrong, drawn), (0, 3 * (3 - beside)), "column {column}, {settings:?}");
        }
    }
}

#[test]
fn empty_and_tiny_worlds_are_drawn() {
    let camera = camera(DVec3::ZERO, DVec3::NEG_Z);
    let mut point = Objects { templates: vec![cube()], ..Objects::default() };
    place(&mut point, 0, Mat3::ZERO, Vec3::new(0.0, 0.0, -3.0));
    let mut around = Objects { templates: vec![cube()], ..Objects::default() };
    place(&mut around, 0, Mat3::IDENTITY, Vec3::ZERO);
    for (world, expected) in [(Objects::default(), 0), (point, 1), (around, 1)] {
        let objects = Arc::new(world);
        let tree = Tree::bottom_up(&objects).unwrap();
        let view = View::new(&camera, &objects, 3, 3, NEAR).unwrap();
        let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
        let mut frame = Frame::default();
        for settings in SETTINGS {
            let mut state = cpu::State::new(&objects, &tree);
            cpu::frame(&settings, &objects, &tree, &view, &mut state, &mut renderer, &mut frame)
                .unwrap();
            assert_eq!(frame.drawn.len(), expected);
        }
        let mut state = reference::State::new(&objects);
        reference::frame(&objects, &view, &mut state, &mut renderer, &mut frame).unwrap();
        assert_eq!(frame.drawn.len(), expected);
        assert_eq!(renderer.depth().len(), 9);
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let (objects, others) = (world(1, 5), world(1, 6));
    let (tree, another) = (Tree::bottom_up(&objects).unwrap(), Tree::bottom_up(&others).unwrap());
    let view = View::new(&path(1, 1)[0], &objects, 8, 8, NEAR).unwrap();
    let mut renderer = Fast::new(objects.clone(), NOW).unwrap();
    let mut frame = Frame::default();
    let mut state = cpu::State::new(&objects, &tree);
    let mut refusal = |settings: &Settings, objects: &Objects, tree: &Tree| {
        cpu::frame(settings, objects, tree, &view, &mut state, &mut renderer, &mut frame)
            .unwrap_err()
            .to_string()
    };
    for across in [0, 65] {
        let settings = Settings { across, ..Settings::default() };
        let limit = format!("texels across: {across} is not within 1 to 64");
        assert_eq!(refusal(&settings, &objects, &tree), limit);
    }
    let settings = Settings::default();
    assert_eq!(refusal(&settings, &others, &tree), "objects: 6, but the state is of 5");
    assert_eq!(refusal(&settings, &objects, &another), "tree: 11 nodes, not 9");
    let mut state = reference::State::new(&objects);
    let error = reference::frame(&others, &view, &mut state, &mut renderer, &mut frame);
    assert_eq!(error.unwrap_err().to_string(), "objects: 6, but the state is of 5");
}
