//! What a frame of the fast software renderer takes from the heap, and of the techniques that draw
//! with it: nothing once they have been along the path.
//!
//! A binary of its own: the counters belong to the whole process, so it holds one test.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_occlusion::camera::hierarchical_depth::{self, Traversal, cpu};
use dapple_occlusion::camera::software::Fast;
use dapple_occlusion::camera::{
    Bounds, Frame, Objects, Query, Readiness, Renderer, Settings, State, Technique, Tree, View,
    masked, techniques,
};
use dapple_scene::{Scene, generate};
use std::alloc::{GlobalAlloc, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Counts bytes taken, given back or not.
struct Counting;

static TAKEN: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is the system allocator's; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: std::alloc::Layout) -> *mut u8 {
        TAKEN.fetch_add(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: std::alloc::Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: std::alloc::Layout, size: usize) -> *mut u8 {
        TAKEN.fetch_add(size, Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static HEAP: Counting = Counting;

/// Inside the pool: handing work to it from outside takes a block of its queue now and then.
fn in_pool(test: impl FnOnce() + Send) {
    rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap().install(test);
}

#[test]
fn a_frame_takes_nothing_once_one_has_been_drawn() {
    let scene = generate::by_name("city_small", 1).unwrap();
    let (objects, _) = Objects::from_scene(&scene, 1024).unwrap();
    let objects = Arc::new(objects);
    in_pool(|| renderer(&scene, &objects));
    in_pool(|| all_techniques(&scene, &objects));
}

fn renderer(scene: &Scene, objects: &Arc<Objects>) {
    let view = View::new(&scene.cameras[0], objects, 160, 90, 0.1).unwrap();
    let list: Vec<u32> = (0..objects.objects.len() as u32).collect();
    let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
    let queries: Vec<Query> = (0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }).collect();
    let mut renderer = Fast::new(objects.clone(), Readiness::Modelled(2)).unwrap();
    let mut counts = Vec::new();
    let mut frame = || {
        let before = TAKEN.load(Relaxed);
        counts.clear();
        renderer.begin(&view).unwrap();
        renderer.draw(&list).unwrap();
        list.iter().for_each(|&one| renderer.draw(&[one]).unwrap());
        renderer.ask(&boxes, &queries).unwrap();
        renderer.collect(&mut counts).unwrap();
        renderer.end().unwrap();
        assert!(counts.iter().any(|&n| n > 0));
        TAKEN.load(Relaxed) - before
    };
    assert!(frame() > 100_000, "the counter counts");
    frame();
    let again: usize = (0..4).map(|_| frame()).sum();
    // The pool's threads may grow their queues of work late.
    assert!(again < 20_000, "{again} bytes in four frames");
}

/// Along the same path again and again, each time from nothing known.
fn all_techniques(scene: &Scene, objects: &Arc<Objects>) {
    let tree = &Tree::bottom_up(objects).unwrap();
    let path = scene.paths.iter().find(|p| p.name == "street").unwrap();
    let view = |i| View::new(&path.camera(i).unwrap(), objects, 160, 90, 0.1).unwrap();
    let views: Vec<View> = (0..path.frames).step_by(4).map(view).collect();
    let renderer = &mut Fast::new(objects.clone(), Readiness::Modelled(8)).unwrap();

    for technique in Technique::ALL {
        let (settings, mut state) = (Settings::new(technique), State::new(tree));
        check(technique.name(), &views, |view, out| {
            if std::ptr::eq(view, &views[0]) {
                state.reset(renderer).unwrap();
            }
            techniques::frame(&settings, objects, tree, view, &mut state, renderer, out).unwrap();
        });
    }
    for traversal in [Traversal::Flat, Traversal::Tree] {
        let settings = hierarchical_depth::Settings { traversal, ..Default::default() };
        let mut state = cpu::State::new(objects, tree);
        check("hierarchical depth", &views, |view, out| {
            cpu::frame(&settings, objects, tree, view, &mut state, renderer, out).unwrap();
        });
    }
    let settings = masked::Settings {
        form: masked::Form::Fast,
        occluders: masked::Occluders::Meshes,
        columns: None,
        most_triangles: 10_000,
    };
    let mut culler = masked::Culler::new(settings, objects, &[]).unwrap();
    check("masked", &views, |view, out| {
        culler.frame(objects, tree, view, renderer, out).unwrap();
    });
}

fn check(name: &str, views: &[View], mut frame: impl FnMut(&View, &mut Frame)) {
    let mut out = Frame::default();
    let mut along = || {
        let before = TAKEN.load(Relaxed);
        for view in views {
            frame(view, &mut out);
            assert!(!out.drawn.is_empty(), "{name}");
        }
        TAKEN.load(Relaxed) - before
    };
    let first = along();
    along();
    let again = along();
    // The pool's threads may grow their queues of work late.
    assert!(first > 1_000 && again < 5_000, "{name}: {first} bytes, later {again}");
}
