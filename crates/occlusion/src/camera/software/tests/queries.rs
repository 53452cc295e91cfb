//! What boxes answer.

use super::super::project::Projection;
use super::super::{owners, reference};
use super::*;
use crate::camera::Query;
use proptest::prelude::*;

const CUBE: Bounds = Bounds { min: Vec3::new(2.25, 2.25, -6.0), max: Vec3::new(5.75, 4.75, -5.0) };

fn ask(renderer: &mut dyn Renderer, boxes: &[Bounds]) -> Vec<u32> {
    let queries: Vec<Query> = (0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }).collect();
    renderer.ask(boxes, &queries).unwrap();
    let mut counts = Vec::new();
    renderer.collect(&mut counts).unwrap();
    counts
}

fn both(objects: &Arc<Objects>, view: &View, boxes: &[Bounds]) -> [Vec<u32>; 2] {
    [ask(&mut super::reference(objects, view), boxes), ask(&mut fast(objects, view), boxes)]
}

fn wall(z: f32) -> Arc<Objects> {
    let corner = |x: f32, y: f32| Vec3::new(x, y, z);
    objects(
        &[
            [corner(-9.0, -9.0), corner(99.0, -9.0), corner(-9.0, 99.0)],
            [corner(99.0, -9.0), corner(99.0, 99.0), corner(-9.0, 99.0)],
        ],
        2,
    )
}

#[test]
fn a_box_in_front_counts_its_pixels_on_both_faces() {
    // Columns 2..=5 have centres 2.5..=5.5, rows 2.5..=4.5: 4 x 3 pixels, seen through two faces;
    // the other four are seen edge-on, and growing them takes them nowhere near a centre.
    for objects in [Arc::new(Objects::default()), wall(-7.0)] {
        let mut view = flat(&wall(-7.0), 8, 8);
        if objects.objects.is_empty() {
            view = flat(&wall(-9.0), 8, 8);
        }
        for counts in both(&objects, &view, &[CUBE]) {
            assert_eq!(counts, [24]);
        }
    }
}

#[test]
fn a_box_behind_counts_nothing() {
    let objects = wall(-3.0);
    let view = flat(&objects, 8, 8);
    for counts in both(&objects, &view, &[CUBE]) {
        assert_eq!(counts, [0]);
    }
}

#[test]
fn ties_pass() {
    // Grown, the near face stands before the wall, whose depth it would share; the far face hides.
    let objects = wall(-5.0);
    let view = flat(&objects, 8, 8);
    for counts in both(&objects, &view, &[CUBE]) {
        assert_eq!(counts, [12]);
    }
    // Not grown, the box's face and the wall have equal depths.
    let renderer = super::reference(&objects, &view);
    let projection = Projection::new(&view);
    assert_eq!(reference::passing(&projection, &CUBE, &renderer.image().depth), 12);
}

#[test]
fn several_boxes_of_a_query_add_up() {
    let objects = wall(-7.0);
    let view = flat(&objects, 8, 8);
    let boxes =
        [CUBE, CUBE, Bounds { min: CUBE.min - 20.0 * Vec3::Z, max: CUBE.max - 20.0 * Vec3::Z }];
    let queries = [Query { boxes: 0..3 }, Query { boxes: 2..3 }, Query { boxes: 1..1 }];
    let mut renderers: [Box<dyn Renderer>; 2] =
        [Box::new(super::reference(&objects, &view)), Box::new(fast(&objects, &view))];
    for renderer in &mut renderers {
        renderer.ask(&boxes, &queries).unwrap();
        let mut counts = vec![7];
        renderer.collect(&mut counts).unwrap();
        assert_eq!(counts, [7, 48, 0, 0]);
    }
}

#[test]
fn asking_draws_nothing() {
    let objects = objects(&soup(3, 30, 4), 3);
    let view = view(&objects, &camera(DVec3::new(0.0, 0.0, 9.0), DVec3::ZERO), 32, 32);
    let mut renderer = fast(&objects, &view);
    let before = renderer.image().clone();
    let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
    assert!(ask(&mut renderer, &boxes).iter().any(|&n| n > 0));
    assert_eq!(renderer.image(), &before);
}

#[test]
fn answers_come_in_order_and_across_frames() {
    let objects = wall(-7.0);
    let view = flat(&objects, 8, 8);
    let mut renderer = Fast::new(objects.clone(), Readiness::Modelled(3)).unwrap();
    assert!(renderer.ready().unwrap());
    renderer.begin(&view).unwrap();
    renderer.ask(&[CUBE], &[Query { boxes: 0..1 }]).unwrap();
    assert!(!renderer.ready().unwrap());
    renderer.draw(&[0]).unwrap();
    renderer.ask(&[CUBE; 2], &[Query { boxes: 0..2 }, Query { boxes: 0..0 }]).unwrap();
    // One object and two boxes later the first batch is there.
    assert!(renderer.ready().unwrap());
    renderer.end().unwrap();
    renderer.begin(&view).unwrap();
    let mut counts = Vec::new();
    renderer.collect(&mut counts).unwrap();
    assert_eq!(counts, [24]);
    assert!(!renderer.ready().unwrap());
    renderer.collect(&mut counts).unwrap();
    assert_eq!(counts, [24, 48, 0]);
    assert!(renderer.ready().unwrap());
    assert!(renderer.collect(&mut counts).is_err());
}

#[test]
fn a_box_about_the_eye_would_show_everywhere() {
    let objects = wall(-3.0);
    let view = straight(&objects, 8, 6);
    let around = Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    assert_eq!(fast(&objects, &view).would_show(&around), 48);
    assert_eq!(super::reference(&objects, &view).would_show(&around), 48);
    let nothing_yet = Fast::new(objects, NOW).unwrap();
    assert_eq!(nothing_yet.would_show(&around), 0);
}

/// The objects that own more pixels than their box was told would show: none may.
fn undercounted(image: &Image, counts: &[u32]) -> usize {
    owners(image, counts.len()).iter().zip(counts).filter(|(own, count)| own > count).count()
}

fn crowd(seed: u64, scale: f32) -> (Arc<Objects>, View) {
    let triangles: Vec<[Vec3; 3]> =
        soup(seed, 120, 5).iter().map(|t| t.map(|p| p * scale)).collect();
    let objects = objects(&triangles, 1);
    let eye = DVec3::new(0.3, 0.7, 11.0) * f64::from(scale);
    let camera = camera(eye, DVec3::ZERO);
    let view = View::new(&camera, &objects, 48, 40, NEAR * f64::from(scale)).unwrap();
    (objects, view)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_box_counts_at_least_what_its_object_owns(seed: u64, exponent in -6_i32..=6) {
        let (objects, view) = crowd(seed, 10_f32.powi(exponent));
        let bounds: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
        let mut reference = super::reference(&objects, &view);
        let mut fast = fast(&objects, &view);
        let everywhere = view.width * view.height;
        let touched = |counts: Vec<u32>| -> Vec<u32> {
            let one = |(n, b): (u32, &Bounds)| if view.touches(b) { everywhere } else { n };
            counts.into_iter().zip(&bounds).map(one).collect()
        };
        let counts = touched(ask(&mut reference, &bounds));
        prop_assert_eq!(undercounted(reference.image(), &counts), 0);
        let counts = touched(ask(&mut fast, &bounds));
        prop_assert_eq!(undercounted(fast.image(), &counts), 0);
        prop_assert!(drawn(fast.image()) > 50);
    }
}

/// Draws all but `last`, counts with `count`, draws `last`: how much its box was told, and how much
/// it owns.
fn told_and_owned<R: Renderer>(
    renderer: &mut R,
    scene: &(Arc<Objects>, View),
    last: u32,
    count: impl Fn(&mut R, &Bounds) -> u32,
    image: impl Fn(&R) -> &Image,
) -> (u32, u32) {
    let (objects, view) = scene;
    let others: Vec<u32> = all(objects).into_iter().filter(|&i| i != last).collect();
    renderer.begin(view).unwrap();
    renderer.draw(&others).unwrap();
    let bounds = &objects.objects[last as usize].bounds;
    let told =
        if view.touches(bounds) { view.width * view.height } else { count(renderer, bounds) };
    renderer.draw(&[last]).unwrap();
    (told, owners(image(renderer), objects.objects.len())[last as usize])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_box_counts_at_least_what_shows_of_its_object_when_drawn(seed: u64, last in 0_u32..120) {
        let scene = crowd(seed, 1.0);
        let mut reference = super::reference(&scene.0, &scene.1);
        let count = |renderer: &mut Reference, b: &Bounds| ask(renderer, &[*b])[0];
        let (told, owned) = told_and_owned(&mut reference, &scene, last, count, Reference::image);
        prop_assert!(told >= owned, "{told} of {owned}");
        let mut fast = fast(&scene.0, &scene.1);
        let count = |renderer: &mut Fast, b: &Bounds| ask(renderer, &[*b])[0];
        let (told, owned) = told_and_owned(&mut fast, &scene, last, count, Fast::image);
        prop_assert!(told >= owned, "{told} of {owned}");
    }
}

#[test]
fn a_reversed_depth_test_is_caught() {
    let undercounted_by = |sign: f32| {
        let mut undercounted = 0;
        for last in 0..120 {
            let scene = crowd(1, 1.0);
            let projection = Projection::new(&scene.1);
            let count = |renderer: &mut Reference, bounds: &Bounds| {
                let mut count = 0;
                for triangle in &projection.triangles_of(&scene.1.guarded(bounds)) {
                    reference::samples(&projection, triangle, |pixel, depth, _| {
                        count += u32::from(sign * depth >= sign * renderer.image().depth[pixel]);
                    });
                }
                count
            };
            let mut renderer = super::reference(&scene.0, &scene.1);
            let (told, owned) =
                told_and_owned(&mut renderer, &scene, last, count, Reference::image);
            undercounted += u32::from(told < owned);
        }
        undercounted
    };
    assert_eq!(undercounted_by(1.0), 0);
    assert!(undercounted_by(-1.0) >= 5, "{}", undercounted_by(-1.0));
}
