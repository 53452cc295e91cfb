//! What is counted.

use crate::oracle::count_range;
use crate::support::*;
use dapple_gpu::Gpu;
use dapple_occlusion::camera::gpu::{Counting, Fault, Renderer, Scene, Settings};
use dapple_occlusion::camera::renderer::Renderer as _;
use dapple_occlusion::camera::software::{Reference, owners};
use dapple_occlusion::camera::{Bounds, Image, Objects, Query, Readiness, View};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Ways of counting that this device has.
fn countings(gpu: &Gpu) -> Vec<Counting> {
    let mut countings = vec![Counting::Auto, Counting::Atomic];
    if gpu.abilities.occlusion_exact_counts {
        countings.push(Counting::Query);
    }
    if gpu.abilities.occlusion_boolean {
        countings.push(Counting::Boolean);
    }
    countings
}

/// As a way of counting gives it.
fn told(counting: Counting, counts: &[u32]) -> Vec<u32> {
    let most = if counting == Counting::Boolean { 1 } else { u32::MAX };
    counts.iter().map(|count| *count.min(&most)).collect()
}

/// A wall over the left half at 16 m, and what its boxes at 32 m should count: front and back face
/// of 20 x 10 pixels, before and after it is drawn.
fn wall() -> (Objects, View, [Bounds; 5], [u32; 5], [u32; 5]) {
    let mut objects = Objects::default();
    add(&mut objects, rectangle([-40.0, 0.0], [-40.0, 40.0], -16.0));
    let view = square_on(&objects, 64, 64);
    let boxes = [
        flat_box([-10.0, 10.0], [-5.0, 5.0], -32.0),
        flat_box([-20.0, 0.0], [-5.0, 5.0], -32.0),
        flat_box([0.0, 20.0], [-5.0, 5.0], -32.0),
        flat_box([100.0, 120.0], [-5.0, 5.0], -32.0),
        // In front of the wall: 20 x 10 pixels again.
        flat_box([-2.5, 2.5], [-1.25, 1.25], -8.0),
    ];
    (objects, view, boxes, [400, 400, 400, 0, 400], [200, 0, 400, 0, 400])
}

fn with_counting(counting: Counting) -> Settings {
    Settings { counting, ..Settings::default() }
}

#[test]
fn known_rectangles_are_counted_exactly_by_all_countings() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (objects, view, boxes, before, after) = wall();
    for counting in countings(gpu) {
        let mut renderer = renderer(gpu, &objects, with_counting(counting));
        assert_ne!(renderer.settings().counting, Counting::Auto);
        for _ in 0..3 {
            renderer.begin(&view).unwrap();
            let open = counts(&mut renderer, &boxes);
            renderer.draw(&[0]).unwrap();
            let hidden = counts(&mut renderer, &boxes);
            renderer.end().unwrap();
            assert_eq!(open, told(counting, &before), "{counting:?}");
            assert_eq!(hidden, told(counting, &after), "{counting:?}");
        }
        // Queries leave no trace.
        let asked = renderer.image().unwrap();
        assert!(asked == draw_all(&mut renderer, &view, &objects));
    }
}

#[test]
fn a_query_may_have_many_boxes_or_none() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (objects, view, boxes, ..) = wall();
    let queries = [0..5, 3..3, 1..3, 2..5, 3..4].map(|boxes| Query { boxes });
    for counting in countings(gpu) {
        let mut renderer = renderer(gpu, &objects, with_counting(counting));
        renderer.begin(&view).unwrap();
        renderer.draw(&[0]).unwrap();
        renderer.ask(&boxes, &queries).unwrap();
        renderer.ask(&[], &[]).unwrap();
        renderer.end().unwrap();
        let mut counts = Vec::new();
        renderer.collect(&mut counts).unwrap();
        assert_eq!(counts, told(counting, &[1000, 0, 400, 800, 0]), "{counting:?}");
        renderer.collect(&mut counts).unwrap();
        assert_eq!(counts.len(), 5);
    }
}

#[test]
fn more_queries_than_a_set_holds_are_counted() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (objects, view, ..) = wall();
    let boxes: Vec<Bounds> = (0..10_000)
        .map(|i| {
            let (x, y) = ((i % 64) as f32 - 32.0, (i / 64 % 64) as f32 - 32.0);
            flat_box([x, x + 1.0], [y, y + 1.0], -32.0)
        })
        .collect();
    for counting in countings(gpu) {
        let mut renderer = renderer(gpu, &objects, with_counting(counting));
        renderer.begin(&view).unwrap();
        renderer.draw(&[0]).unwrap();
        let counts = counts(&mut renderer, &boxes);
        renderer.end().unwrap();
        let right: Vec<u32> = (0..10_000).map(|i| if i % 64 < 32 { 0 } else { 2 }).collect();
        assert_eq!(counts, told(counting, &right), "{counting:?}");
    }
}

/// Whether the boxes of objects that are not drawn yet count at least the pixels that these come to
/// own (P23).
fn counts_hold(renderer: &mut Renderer<'_>, objects: &Objects, view: &View) -> bool {
    let bounds = |object: &u32| objects.objects[*object as usize].bounds;
    let (asked, others): (Vec<u32>, Vec<u32>) =
        all(objects).iter().partition(|object| **object % 4 == 0 && !view.touches(&bounds(object)));
    let boxes: Vec<Bounds> = asked.iter().map(bounds).collect();
    renderer.begin(view).unwrap();
    renderer.draw(&others).unwrap();
    let counts = counts(renderer, &boxes);
    renderer.draw(&asked).unwrap();
    renderer.end().unwrap();
    let owned = owners(&renderer.image().unwrap(), objects.objects.len());
    assert!(asked.iter().filter(|object| owned[**object as usize] > 0).count() > 5);
    let boolean = renderer.settings().counting == Counting::Boolean;
    asked.iter().zip(counts).all(|(object, count)| {
        let owned = owned[*object as usize];
        count >= if boolean { owned.min(1) } else { owned }
    })
}

#[test]
fn a_box_counts_the_pixels_of_what_it_holds() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    for seed in 20..23 {
        let objects = heap(seed, 200);
        let scene = Scene::new(gpu, &objects).unwrap();
        for view in views(&objects, 90, 70) {
            for counting in countings(gpu) {
                let settings = with_counting(counting);
                let mut renderer = Renderer::new(gpu, &scene, settings).unwrap();
                assert!(counts_hold(&mut renderer, &objects, &view), "{counting:?}");
                // Control: with its depth test reversed, a query loses what is in front.
                let fault = Fault::ReversedQuery;
                let mut renderer = Renderer::with_fault(gpu, &scene, settings, fault).unwrap();
                assert!(!counts_hold(&mut renderer, &objects, &view), "{counting:?}");
            }
        }
    }
}

#[test]
fn counts_are_those_of_every_sample_and_of_the_software_reference() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let objects = heap(31, 200);
    let drawn: Vec<u32> = (0..100).collect();
    let mut reference = Reference::new(Arc::new(objects.clone()), Readiness::Modelled(0)).unwrap();
    for view in views(&objects, 90, 70) {
        // Faces that reach the near plane have corners so far off the image that f32 snaps them worse.
        let ahead = |b: &Bounds| view.screen_rect(b).is_some();
        let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).filter(ahead).collect();
        // Edges may fall on the one or the other side of centres; most counts leave little choice.
        let check = |counts: &[u32], image: &Image| {
            let (mut all, mut choice) = (0, 0);
            for (i, (count, bounds)) in counts.iter().zip(&boxes).enumerate() {
                let [least, most] = count_range(&view, bounds, image);
                assert!((least..=most).contains(count), "box {i}: {count} of {least} to {most}");
                all += least;
                choice += most - least;
            }
            assert!(all > 1000 && choice < all / 8, "{choice} of {all}");
        };
        let mut found = Vec::new();
        for counting in [Counting::Auto, Counting::Atomic] {
            let mut renderer = renderer(gpu, &objects, with_counting(counting));
            renderer.begin(&view).unwrap();
            renderer.draw(&drawn).unwrap();
            found.push(counts(&mut renderer, &boxes));
            renderer.end().unwrap();
            check(&found[0], &renderer.image().unwrap());
        }
        // On one device all count the same.
        assert_eq!(found[0], found[1]);
        reference.begin(&view).unwrap();
        reference.draw(&drawn).unwrap();
        reference.ask(&boxes, &one_each(boxes.len())).unwrap();
        reference.end().unwrap();
        let mut counts = Vec::new();
        reference.collect(&mut counts).unwrap();
        check(&counts, reference.image());
    }
}

#[test]
fn answers_come_when_the_model_says() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (objects, view, boxes, ..) = wall();
    let settings = Settings { readiness: Readiness::Modelled(7), ..Settings::default() };
    let mut renderer = renderer(gpu, &objects, settings);
    renderer.begin(&view).unwrap();
    assert!(renderer.ready().unwrap());
    renderer.ask(&boxes, &one_each(5)).unwrap();
    assert!(!renderer.ready().unwrap());
    renderer.draw(&[0; 4]).unwrap();
    assert!(!renderer.ready().unwrap());
    renderer.ask(&boxes[..3], &one_each(3)).unwrap();
    assert!(renderer.ready().unwrap());
    let mut counts = Vec::new();
    renderer.collect(&mut counts).unwrap();
    assert!(!renderer.ready().unwrap());
    renderer.end().unwrap();
    renderer.collect(&mut counts).unwrap();
    assert_eq!(counts, [400, 400, 400, 0, 400, 200, 0, 400]);
    assert!(renderer.ready().unwrap());
}

#[test]
fn answers_come_when_the_device_says_and_in_later_frames() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let (objects, view, ..) = wall();
    let mut renderer = renderer(gpu, &objects, Settings::default());
    renderer.begin(&view).unwrap();
    assert!(renderer.ready().unwrap());
    renderer.draw(&[0]).unwrap();
    let boxes = [flat_box([-10.0, 10.0], [-4.0, 4.0], -32.0)];
    renderer.ask(&boxes, &one_each(1)).unwrap();
    renderer.end().unwrap();
    // Another frame, of another size, before the answer is asked for.
    renderer.begin(&square_on(&objects, 32, 32)).unwrap();
    renderer.ask(&boxes, &one_each(1)).unwrap();
    let start = Instant::now();
    while !renderer.ready().unwrap() {
        assert!(start.elapsed() < Duration::from_secs(60), "no answer comes");
        std::thread::yield_now();
    }
    renderer.end().unwrap();
    let mut counts = Vec::new();
    renderer.collect(&mut counts).unwrap();
    renderer.collect(&mut counts).unwrap();
    // The second frame has a quarter of the pixels, and drew no wall.
    assert_eq!(counts, [160, 80]);
    let error = renderer.collect(&mut counts).unwrap_err();
    assert_eq!(error.to_string(), "queries: no batch is left to collect");
}
