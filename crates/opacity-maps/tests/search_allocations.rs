//! What a searching frame takes from the heap: next to nothing once the first has been.
//!
//! A binary of its own: the counters belong to the whole process, so it holds one test.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

#[path = "search/rays.rs"]
mod rays;

use dapple_opacity_maps::{
    Bins, Blend, Code, Criterion, EndMap, Format, Layered, Layout, Lookup, Packing, Settings,
    Split, SplitKind, Storage,
    search::{Layers, Plan, Scorer, Scoring, Search},
};
use std::alloc::{GlobalAlloc, System};
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

fn taken<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = TAKEN.load(Relaxed);
    let result = work();
    (result, TAKEN.load(Relaxed) - before)
}

const SIDE: u32 = 64;
const LAYERS: u32 = 16;

fn bounding() -> Settings {
    Settings::plain(Code::Layered(Layered {
        layout: Layout::Bounded {
            split: Split { lambda: 0.0, kind: SplitKind::Normalised, width: 512 },
            bins: Bins::Full,
        },
        layers: LAYERS,
        lookup: Lookup::Lerp,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Targets(8),
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
        write_bias: 0.0,
        soft_start: false,
    }))
}

#[test]
fn after_the_first_frame_a_search_takes_next_to_nothing_from_the_heap() {
    let fragments = rays::volume(SIDE, 1, 20.0, 0.2);
    let sums = rays::sums(&fragments, 0.5, LAYERS as usize);
    let layers = LAYERS as usize;
    let maps = Layers::new((SIDE, SIDE), layers, layers, 0, &sums).unwrap();
    let map_bytes = (SIDE * SIDE * LAYERS * 4) as usize;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        for criterion in [
            Criterion::Sad,
            Criterion::Correlation,
            Criterion::MutualInformation,
            Criterion::EqualOpacity,
            Criterion::EqualTransmittance,
        ] {
            let mut scorer = Scorer::new(Scoring::plain(criterion));
            let (_, first) = taken(|| scorer.score(&maps).unwrap());
            assert!(first > 0, "{criterion:?}: the counter counts");
            let (_, again) = taken(|| scorer.score(&maps).unwrap());
            assert_eq!(again, 0, "{criterion:?}");
        }
        for (criterion, tile) in [
            (Criterion::Correlation, 0),
            (Criterion::EqualTransmittance, 0),
            (Criterion::EqualTransmittance, 1),
            (Criterion::Correlation, 8),
        ] {
            let plan = Plan { tile, repeat: true, ..Plan::plain(bounding(), criterion) };
            let (mut search, needed) = taken(|| Search::new(SIDE, SIDE, plan).unwrap());
            assert!(needed >= 2 * map_bytes, "both sets of maps");
            search.frame(&fragments).unwrap();
            for frame in 0..25 {
                let (_, more) = taken(|| search.frame(&fragments).unwrap());
                // Building maps may take a texel's worth of room a task.
                assert!(more < map_bytes / 16, "{criterion:?} {tile}, frame {frame}: {more}");
            }
        }
        // The oracle sorts all fragments of every frame it scores, and the counter sees it.
        let plan = Plan::plain(bounding(), Criterion::Oracle);
        let mut search = Search::new(SIDE, SIDE, plan).unwrap();
        search.frame(&fragments).unwrap();
        let (_, more) = taken(|| search.frame(&fragments).unwrap());
        assert!(more > 8 * fragments.items.len(), "{more}");
    });
}
