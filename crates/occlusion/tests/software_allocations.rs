//! What a frame of the fast software renderer takes from the heap: nothing once one has been drawn.
//!
//! A binary of its own: the counters belong to the whole process, so it holds one test.

use dapple_occlusion::camera::software::Fast;
use dapple_occlusion::camera::{Bounds, Objects, Query, Readiness, Renderer, View};
use dapple_scene::generate;
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

#[test]
fn a_frame_takes_nothing_once_one_has_been_drawn() {
    let scene = generate::by_name("city_small", 1).unwrap();
    let (objects, _) = Objects::from_scene(&scene, 1024).unwrap();
    let objects = Arc::new(objects);
    let view = View::new(&scene.cameras[0], &objects, 160, 90, 0.1).unwrap();
    let list: Vec<u32> = (0..objects.objects.len() as u32).collect();
    let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
    let queries: Vec<Query> = (0..boxes.len() as u32).map(|i| Query { boxes: i..i + 1 }).collect();
    let mut renderer = Fast::new(objects, Readiness::Modelled(2)).unwrap();
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
    // Inside the pool: handing work to it from outside takes a block of its queue now and then.
    rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap().install(|| {
        assert!(frame() > 100_000, "the counter counts");
        frame();
        let again: usize = (0..4).map(|_| frame()).sum();
        // The pool's threads may grow their queues of work late.
        assert!(again < 20_000, "{again} bytes in four frames");
    });
}
