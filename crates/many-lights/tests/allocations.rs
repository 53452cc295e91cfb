//! What a frame takes from the heap: nothing, once the same frames have been lit before.
//!
//! A binary of its own: the counters belong to the whole process, so it holds one test.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Absolute, BoundForm, Capped, Clustered, Emission, Form, LightBvh, LightTree, Lightcuts, Per,
    Relative, Reservoirs, Selection, Shaded, StochasticLightcuts, Technique, World,
    cut::{Given, Method, Starts, children, starting},
    make,
    worlds::{Cloud, WINDOW, cloud},
};
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

fn techniques() -> Vec<Technique> {
    let (threshold, bound) = (1e-4, BoundForm::Cheap);
    let cuts = [Selection::Heap, Selection::Scan].map(|selection| {
        Technique::Lightcuts(Lightcuts { epsilon: 0.02, most: 200, selection, bound })
    });
    let absolute =
        [Per::Pixel, Per::Tile].map(|per| Technique::Absolute(Absolute { threshold, bound, per }));
    let stochastic = [false, true]
        .map(|real_time| Technique::StochasticLightcuts(StochasticLightcuts { cut: 8, real_time }));
    let clustered = [false, true].map(|window| {
        Technique::Clustered(Clustered { cutoff: 1e-3, tile: 16, slices: 8, window })
    });
    let one = [
        Technique::BruteForce,
        Technique::Relative(Relative { epsilon: 0.1, bound }),
        Technique::LightBvh(LightBvh { samples: 4 }),
        Technique::Reservoirs(Reservoirs {
            candidates: 8,
            temporal: true,
            history: 20,
            neighbours: 3,
            radius_px: 10.0,
            unbiased: true,
        }),
        Technique::Capped(Capped { most: 64 }),
    ];
    [&cuts[..], &absolute, &stochastic, &clustered, &one].concat()
}

#[test]
fn a_frame_takes_nothing_once_it_has_been_lit() {
    // Inside the pool: handing work to it from outside takes a block of its queue now and then.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(|| {
        let emissions = vec![Emission::Omni, Emission::Oriented, WINDOW, Emission::Directional];
        let of = |lights, size| Cloud { lights, size, emissions, frames: 3, ..Cloud::default() };
        let open = cloud(&of.clone()(400, [70, 45])).world;
        let shadowed = cloud(&of(60, [20, 13])).with_shadows().unwrap();
        for world in [Arc::new(open), Arc::new(shadowed)] {
            let tree = Arc::new(LightTree::median(&world.lights).unwrap());
            techniques().iter().for_each(|technique| check(technique, &world, &tree));
            let cuts = techniques().into_iter().filter(|t| Method::of(t).is_some());
            cuts.for_each(|technique| check_starts(&technique, &world, &tree));
        }
    });
}

fn check(technique: &Technique, world: &Arc<World>, tree: &Arc<LightTree>) {
    let before = TAKEN.load(Relaxed);
    let mut lighting = make(Form::Cpu, technique, world, tree, None).unwrap();
    assert!(TAKEN.load(Relaxed) - before > 1000, "the counter counts");
    let mut shaded = Shaded::default();
    let mut along = || {
        let before = TAKEN.load(Relaxed);
        lighting.reset(3).unwrap();
        for count in [true, false] {
            for frame in 0..world.frames.len() {
                lighting.shade(frame, count).unwrap();
                lighting.read(&mut shaded).unwrap();
                assert!(shaded.radiance.iter().any(|rgb| rgb.x > 0.0), "{technique:?}");
            }
        }
        TAKEN.load(Relaxed) - before
    };
    // Lists grow as far as they have to; which thread lights what is by chance.
    for _ in 0..3 {
        along();
    }
    // The pool's threads may grow their queues of work late: the least of some.
    let taken = (0..3).map(|_| along()).min().unwrap();
    assert_eq!(taken, 0, "{technique:?} takes {taken} bytes in {} frames", 2 * world.frames.len());
}

/// The same of cuts whose starts are made anew before every frame, from two of them on.
fn check_starts(technique: &Technique, world: &Arc<World>, tree: &Arc<LightTree>) {
    let given = Given::new(technique, world, tree).unwrap();
    let mut lighting = starting(Form::Cpu, &given, None).unwrap();
    let size = |node: u32| tree.nodes[node as usize].size;
    let below: Vec<u32> = tree.roots.iter().flat_map(|&root| children(root, size)).collect();
    let never = vec![f32::NEG_INFINITY; below.len()];
    let mut starts = Starts::roots(&tree.roots);
    let mut frames = || {
        let before = TAKEN.load(Relaxed);
        for objects in [5, 3] {
            starts.restart(&tree.roots, objects);
            let list = starts.add_below(&below, &never).unwrap();
            (0..objects as u32).for_each(|object| starts.set(object, list).unwrap());
            lighting.start(&starts).unwrap();
            lighting.shade(0, true).unwrap();
        }
        TAKEN.load(Relaxed) - before
    };
    assert!(frames() > 0, "the counter counts");
    for _ in 0..2 {
        frames();
    }
    let taken = (0..3).map(|_| frames()).min().unwrap();
    assert_eq!(taken, 0, "{technique:?} takes {taken} bytes with other starts");
}
