//! The technique on the plain software renderer: what it draws shows the image of everything.

use super::*;
use crate::camera::techniques::tests::world::World;
use crate::camera::{Bounds, Frame, Image, Object, Renderer, View};
use glam::DVec3;

pub fn settings(occluders: Occluders, columns: Option<u32>) -> Settings {
    Settings { form: Form::Fast, occluders, columns, most_triangles: u64::MAX }
}

/// Boxes inside cubes: a little smaller.
pub fn inner_boxes(world: &World) -> Vec<InnerBox> {
    let cubes = world.objects.objects.iter().filter(|o| o.template == 0);
    let unit = Bounds { min: Vec3::splat(0.01), max: Vec3::splat(0.99) };
    let inner =
        |o: &Object| InnerBox { corners: unit.corners().map(|p| o.place(p)), solid: o.bounds };
    cubes.map(inner).collect()
}

pub fn play(world: &World, settings: Settings, view: &View) -> (Frame, Image) {
    let mut renderer = world.renderer(0);
    let mut culler = Culler::new(settings, &world.objects, &inner_boxes(world)).unwrap();
    let mut frame = Frame::default();
    culler.frame(&world.objects, &world.tree, view, &mut renderer, &mut frame).unwrap();
    (frame, renderer.image().clone())
}

pub fn everything(world: &World, view: &View) -> Image {
    let mut renderer = world.renderer(0);
    let all: Vec<u32> = (0..world.objects.objects.len() as u32).collect();
    renderer.begin(view).unwrap();
    renderer.draw(&all).unwrap();
    renderer.end().unwrap();
    renderer.image().clone()
}

pub fn views(world: &World, seed: u64) -> Vec<View> {
    let mut views = world.walk(6);
    views.extend(world.jumps(seed, 6));
    views
}

/// Depths; which of two things at equal depth owns a pixel is left to the order of drawing.
pub fn same(a: &Image, b: &Image) -> bool {
    a.depth == b.depth
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn the_image_is_that_of_everything(
        seed: u64,
        count in 0..120u32,
        columns in prop::option::of(1..200u32),
        meshes: bool,
        far: bool,
    ) {
        let mut world = World::town(seed, count);
        if far {
            world = world.scaled(64.0).moved(DVec3::new(1e7, 3e6, -2e7));
        }
        let occluders = if meshes { Occluders::Meshes } else { Occluders::InnerBoxes };
        for view in views(&world, seed) {
            let (frame, image) = play(&world, settings(occluders, columns), &view);
            prop_assert!(same(&image, &everything(&world, &view)));
            let mut once = frame.drawn.clone();
            once.sort_unstable();
            once.dedup();
            prop_assert_eq!(once.len(), frame.drawn.len());
        }
    }
}

#[test]
fn much_is_culled() {
    for occluders in [Occluders::InnerBoxes, Occluders::Meshes] {
        for columns in [None, Some(192)] {
            let (mut drawn, mut seen) = (0, 0);
            for seed in 0..8 {
                let world = World::town(seed, 300);
                for view in world.walk(4) {
                    let none = Settings { most_triangles: 0, ..settings(occluders, columns) };
                    drawn += play(&world, settings(occluders, columns), &view).0.drawn.len();
                    seen += play(&world, none, &view).0.drawn.len();
                }
            }
            assert!(2 * drawn < seen, "{occluders:?} {columns:?}: {drawn} of {seen}");
        }
    }
}

/// The control: boxes around objects hide what the objects do not.
#[test]
fn outer_boxes_are_caught() {
    let wrong = (0..8u64).flat_map(|seed| {
        let world = World::town(seed, 120);
        let of = |view: &View| {
            let settings = settings(Occluders::OuterBoxesUnsound, None);
            !same(&play(&world, settings, view).1, &everything(&world, view))
        };
        views(&world, seed).iter().map(of).collect::<Vec<bool>>()
    });
    assert!(wrong.filter(|&w| w).count() > 5);
}

/// A small box stands for a large house. From outside it may hide what is in the house and behind
/// it; an eye in the house sees around in it, and past the box to what the box would hide.
#[test]
fn a_box_hides_nothing_from_an_eye_within_its_house() {
    let world = World::boxes(&[
        (Vec3::new(0.0, -10.0, -10.0), Vec3::splat(20.0)),
        (Vec3::new(15.0, -0.5, -0.5), Vec3::ONE),
    ]);
    let small = Bounds { min: Vec3::new(8.0, -2.0, -2.0), max: Vec3::new(12.0, 2.0, 2.0) };
    let solid = world.objects.objects[0].bounds;
    let drawn = |eye: f64, solid: Bounds| {
        let view = world.view(DVec3::new(eye, 0.0, 0.0), 0.0, 0.0);
        let boxes = [InnerBox { corners: small.corners(), solid }];
        let settings = settings(Occluders::InnerBoxes, None);
        let mut culler = Culler::new(settings, &world.objects, &boxes).unwrap();
        let (mut renderer, mut frame) = (world.renderer(0), Frame::default());
        culler.frame(&world.objects, &world.tree, &view, &mut renderer, &mut frame).unwrap();
        let complete = same(renderer.image(), &everything(&world, &view));
        (frame.drawn.contains(&1), complete)
    };
    assert_eq!(drawn(-20.0, solid), (false, true), "hidden from outside");
    assert_eq!(drawn(2.0, solid), (true, true), "seen from within");
    // The control: a box that is all there is to its solid.
    assert_eq!(drawn(2.0, small), (false, false));
}

/// Fences with holes hide nothing, and are drawn.
#[test]
fn alpha_tested_objects_hide_nothing() {
    let mut world = World::boxes(&[
        (Vec3::new(2.0, -5.0, -5.0), Vec3::new(0.1, 10.0, 10.0)),
        (Vec3::new(5.0, 0.0, 0.0), Vec3::ONE),
    ]);
    let view = world.view(DVec3::new(0.0, 0.5, 0.5), 0.0, 0.0);
    assert_eq!(play(&world, settings(Occluders::Meshes, None), &view).0.drawn, [0]);
    let mut objects = crate::camera::Objects::clone(&world.objects);
    objects.templates[0].mask = Some(0);
    objects.templates[0].uvs = vec![glam::Vec2::ZERO; 8];
    world.objects = objects.into();
    assert_eq!(play(&world, settings(Occluders::Meshes, None), &view).0.drawn, [0, 1]);
}

#[test]
fn a_buffer_without_columns_and_boxes_that_are_not_finite_are_refused() {
    let world = World::town(1, 3);
    let new = |columns, boxes: &[InnerBox]| {
        let settings = settings(Occluders::InnerBoxes, columns);
        Culler::new(settings, &world.objects, boxes).map(drop).unwrap_err().to_string()
    };
    assert!(new(Some(0), &[]).contains("1..=16384"));
    assert!(
        new(None, &[InnerBox { corners: [Vec3::NAN; 8], solid: Bounds::EMPTY }])
            .contains("inner box 0")
    );
}
