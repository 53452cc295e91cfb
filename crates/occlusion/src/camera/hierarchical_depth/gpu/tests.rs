//! The device's form against drawing everything on the same device, and against the processor's
//! answers to the same depths.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::super::tests::{camera, differences, faults, path, place, world};
use super::super::{Fault, Place, Pyramid, Settings};
use super::{Culler, ItemBox, Slot, items};
use crate::camera::gpu::{Drawing, Renderer, Scene, Settings as GpuSettings, mirror};
use crate::camera::renderer::Renderer as _;
use crate::camera::{Bounds, Frame, Image, Objects, View};
use dapple_gpu::Gpu;
use dapple_gpu::testing::test_gpu;
use glam::{DVec3, Mat3, Vec3};

const NEAR: f64 = 0.1;

/// The adapter for one test at a time: they use both cores, and share one device.
fn exclusive_gpu() -> Option<(&'static Gpu, MutexGuard<'static, ()>)> {
    static ONE: Mutex<()> = Mutex::new(());
    let lock = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    test_gpu().map(|gpu| (gpu, lock))
}

fn across(across: u32) -> Settings {
    Settings { across, ..Settings::default() }
}

fn everything(renderer: &mut Renderer<'_>, objects: &Objects, view: &View) -> Image {
    let all: Vec<u32> = (0..objects.objects.len() as u32).collect();
    renderer.begin(view).unwrap();
    renderer.draw(&all).unwrap();
    renderer.end().unwrap();
    renderer.image().unwrap()
}

/// What draws everything, for comparison.
fn renderer<'g>(gpu: &'g Gpu, scene: &Scene) -> Renderer<'g> {
    let settings = GpuSettings { drawing: Drawing::Instanced, ..GpuSettings::default() };
    Renderer::new(gpu, scene, settings).unwrap()
}

/// A frame's list, with draws counted as the processor's forms do.
fn collected(culler: &Culler<'_>) -> Frame {
    let mut frame = Frame::default();
    culler.collect(&mut frame).unwrap();
    frame.work.draws = frame.drawn.len() as u64;
    frame
}

/// What the processor says of a box, against a pyramid.
fn shows(view: &View, bounds: &Bounds, pyramid: &Pyramid, across: u32) -> bool {
    match Place::of(view, bounds) {
        Place::Outside => false,
        Place::Near => true,
        Place::At(pixels, nearest) => nearest >= pyramid.farthest(pixels, across),
    }
}

#[test]
fn structs_have_the_layout_of_the_shaders() {
    let cull = "occlusion/hierarchical_cull.wgsl";
    mirror::<ItemBox>(cull, "Box", &[("low", 0), ("high", 12)]);
    let slot = [("first", 0), ("end", 4), ("vertices", 8)];
    mirror::<Slot>("occlusion/hierarchical_list.wgsl", "Slot", &slot);
}

#[test]
fn items_lie_in_the_order_of_their_templates() {
    let objects = world(1, 40);
    let items = items(&objects);
    let mut order = items.order.clone();
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..40));
    assert_eq!((items.slots.len(), items.solid), (3, 2));
    let mut next = 0;
    for slot in &items.slots {
        assert_eq!(slot.first, next);
        next = slot.end;
        let list = &items.order[slot.first as usize..slot.end as usize];
        assert!(list.is_sorted());
        let template = |o: &u32| objects.objects[*o as usize].template;
        assert!(list.iter().all(|o| template(o) == template(&list[0])));
    }
    assert_eq!(next, 40);
}

#[test]
fn the_image_is_that_of_everything_on_the_device() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut drawn = [0; 2];
    for (seed, size) in [(1, (64, 48)), (2, (33, 9)), (3, (129, 65)), (4, (1, 1))] {
        let objects = world(seed, 300);
        let scene = Scene::new(gpu, &objects).unwrap();
        let mut full = renderer(gpu, &scene);
        for texels in [1, 2, 64] {
            let mut culler = Culler::new(gpu, &scene, &objects, &across(texels)).unwrap();
            for camera in path(seed, 10) {
                let view = View::new(&camera, &objects, size.0, size.1, NEAR).unwrap();
                culler.frame(&view).unwrap();
                let frame = collected(&culler);
                let (image, all) =
                    (culler.image().unwrap(), everything(&mut full, &objects, &view));
                assert_eq!(faults(&objects, &view, &frame, &image, &all), 0, "{seed}, {texels}");
                drawn[0] += frame.drawn.len();
                drawn[1] += objects.objects.len();
            }
        }
    }
    assert!(drawn[0] > 0 && 2 * drawn[0] < drawn[1], "{drawn:?}");
}

/// Negative control.
#[test]
fn a_pyramid_of_the_nearest_draws_a_wrong_image_on_the_device() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = world(3, 300);
    let scene = Scene::new(gpu, &objects).unwrap();
    let mut full = renderer(gpu, &scene);
    let mut culler = Culler::with_fault(gpu, &scene, &objects, &across(2), Fault::Nearest).unwrap();
    let mut wrong = 0;
    for camera in path(3, 12) {
        let view = View::new(&camera, &objects, 64, 48, NEAR).unwrap();
        culler.frame(&view).unwrap();
        wrong += differences(&culler.image().unwrap(), &everything(&mut full, &objects, &view));
    }
    assert!(wrong > 0);
}

#[test]
fn the_pyramid_is_the_processors() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = world(7, 300);
    let scene = Scene::new(gpu, &objects).unwrap();
    let mut culler = Culler::new(gpu, &scene, &objects, &across(2)).unwrap();
    let mut checked = 0;
    // 1100 pixels need a third dispatch.
    for (width, height) in [(1, 1), (2, 1), (33, 9), (64, 64), (257, 129), (1100, 3)] {
        for camera in path(7, 2) {
            let view = View::new(&camera, &objects, width, height, NEAR).unwrap();
            culler.frame(&view).unwrap();
            let mut pyramid = Pyramid::default();
            pyramid.build(width, height, &culler.image().unwrap().depth);
            let expected = &pyramid.texels()[(width * height) as usize..];
            let texels = &culler.sized.as_ref().unwrap().texels;
            let found = gpu.read::<f32>(texels, 0, expected.len()).unwrap();
            assert_eq!(found, expected, "{width} x {height}");
            checked += found.len();
        }
    }
    assert!(checked > 20_000);
}

/// The device's answer about a box is the processor's, or the processor's about the box grown or
/// shrunk by a sixteenth of its guard band; and that is rare.
#[test]
fn answers_are_the_processors_within_a_sixteenth_of_the_guard_band() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = world(11, 3000);
    let scene = Scene::new(gpu, &objects).unwrap();
    let (mut checked, mut seen, mut within) = (0, 0, 0);
    for texels in [1, 2, 64] {
        let mut culler = Culler::new(gpu, &scene, &objects, &across(texels)).unwrap();
        for camera in path(11, 12) {
            let view = View::new(&camera, &objects, 160, 91, NEAR).unwrap();
            culler.frame(&view).unwrap();
            let mut pyramid = Pyramid::default();
            pyramid.build(160, 91, &culler.image().unwrap().depth);
            for (object, found) in objects.objects.iter().zip(culler.visible().unwrap()) {
                let answer = |part: f64| {
                    let bounds = object.bounds.grown(part * view.guard_m(&object.bounds));
                    shows(&view, &bounds, &pyramid, texels)
                };
                checked += 1;
                seen += usize::from(found);
                if found != answer(0.0) {
                    within += 1;
                    let [less, more] = [-1.0 / 16.0, 1.0 / 16.0].map(answer);
                    assert!(less != more, "{object:?}: {found}");
                }
            }
        }
    }
    assert!(seen > 1000 && seen < checked, "{seen} of {checked}");
    assert!(1000 * within < checked, "{within} of {checked} within the band");
}

/// More items than one workgroup has lanes for sums; nothing is left out or drawn twice.
#[test]
fn long_lists_hold_every_object_once() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = world(13, 70_000);
    let scene = Scene::new(gpu, &objects).unwrap();
    let mut culler = Culler::new(gpu, &scene, &objects, &across(2)).unwrap();
    let view = View::new(&path(13, 1)[0], &objects, 96, 64, NEAR).unwrap();
    culler.frame(&view).unwrap();
    // Nothing was visible before, nothing drawn: all that may cover a pixel is drawn.
    let mut first = collected(&culler);
    let nothing = Pyramid::default();
    let expected: Vec<u32> = (0..70_000)
        .filter(|&o| shows(&view, &objects.objects[o as usize].bounds, &nothing, 2))
        .collect();
    first.drawn.sort_unstable();
    let (missing, more) = (
        expected.iter().filter(|o| first.drawn.binary_search(o).is_err()).count(),
        first.drawn.iter().filter(|o| expected.binary_search(o).is_err()).count(),
    );
    assert!(first.drawn.len() > 5000 && missing + more < 20, "{missing} missing, {more} more");

    culler.frame(&view).unwrap();
    let second = collected(&culler);
    assert!(second.drawn.len() < first.drawn.len() / 2);
    let all = everything(&mut renderer(gpu, &scene), &objects, &view);
    let image = culler.image().unwrap();
    assert_eq!(faults(&objects, &view, &second, &image, &all), 0);

    // Again from nothing: the same lists in the same order, nothing of which depends on chance.
    culler.reset();
    assert!(culler.visible().unwrap().iter().all(|v| !v));
    culler.frame(&view).unwrap();
    let mut again = collected(&culler);
    again.drawn.sort_unstable();
    assert_eq!(again.drawn, first.drawn);
    culler.frame(&view).unwrap();
    assert_eq!(collected(&culler), second);
}

#[test]
fn a_scene_of_nothing_is_an_empty_image() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = Objects::default();
    let scene = Scene::new(gpu, &objects).unwrap();
    let mut culler = Culler::new(gpu, &scene, &objects, &across(2)).unwrap();
    assert!(culler.image().is_err());
    let looks = camera(DVec3::ZERO, DVec3::NEG_Z);
    let view = View::new(&looks, &objects, 5, 4, NEAR).unwrap();
    culler.frame(&view).unwrap();
    assert_eq!(culler.image().unwrap().depth, vec![0.0; 20]);
    assert_eq!(collected(&culler), Frame::default());
    assert_eq!(culler.visible().unwrap(), Vec::<bool>::new());
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = world(1, 5);
    let scene = Scene::new(gpu, &objects).unwrap();
    let error = Culler::new(gpu, &scene, &world(1, 6), &across(2)).unwrap_err();
    assert_eq!(error.to_string(), "objects: 6, the scene has 5");
    let error = Culler::new(gpu, &scene, &objects, &across(0)).unwrap_err();
    assert_eq!(error.to_string(), "texels across: 0 is not within 1 to 64");
}

/// Only listed objects are drawn: one behind a wall is in no list of the second frame.
#[test]
fn what_a_wall_hides_is_not_drawn() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut objects = (*world(1, 0)).clone();
    let wall = Mat3::from_diagonal(Vec3::new(40.0, 40.0, 1.0));
    place(&mut objects, 1, wall, Vec3::new(0.0, 0.0, -5.0));
    for x in [-3.0, 0.5, 2.0] {
        place(&mut objects, 0, Mat3::IDENTITY, Vec3::new(x, 0.3, -20.0));
    }
    let scene = Scene::new(gpu, &objects).unwrap();
    let mut culler = Culler::new(gpu, &scene, &objects, &across(2)).unwrap();
    let looks = camera(DVec3::ZERO, DVec3::NEG_Z);
    let view = View::new(&looks, &objects, 64, 64, NEAR).unwrap();
    let mut lists = Vec::new();
    for _ in 0..2 {
        culler.frame(&view).unwrap();
        let mut frame = collected(&culler);
        frame.drawn.sort_unstable();
        lists.push(frame.drawn);
    }
    assert_eq!(lists, [vec![0, 1, 2, 3], vec![0]]);
}
