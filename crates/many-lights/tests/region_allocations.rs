//! What from-region visibility takes from the heap: nothing, once the same cells have been asked for.
//!
//! A binary of its own: the counter belongs to the whole process, so it holds one test.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_evaluate_support;

use dapple_many_lights::region::{
    Direction, Edge, FacadeCluster, Fusion, Precuts, Turn, ViewCell, evaluate::Evaluator,
};
use region_evaluate_support::random;
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

/// Bytes taken by asking for every direction of the cells.
fn taken(of: &mut Evaluator, cells: &[ViewCell], nodes: &mut Vec<u32>) -> usize {
    let before = TAKEN.load(Relaxed);
    for cell in cells {
        for direction in Direction::ALL {
            of.precut(cell, direction, nodes);
        }
    }
    TAKEN.load(Relaxed) - before
}

#[test]
fn an_evaluation_takes_nothing_once_its_turn_was_met_and_lists_have_grown() {
    let mut shadows = 0;
    for fusion in [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered] {
        for edge in [Edge::Flat, Edge::Hull] {
            for cached in [false, true] {
                for seed in 0..40 {
                    let turn = Turn::degrees(seed % 2 * 20);
                    let case = random(seed, 1.0, turn);
                    let settings = FacadeCluster {
                        fusion,
                        edge,
                        cached,
                        threshold: 0.0,
                        ..FacadeCluster::default()
                    };
                    let mut evaluator = case.evaluator(settings);
                    let mut nodes = Vec::new();
                    let cells = [case.cell];
                    assert!(taken(&mut evaluator, &cells, &mut nodes) > 100, "the counter counts");
                    // Two lists that take turns: the second time each may stand in for the other.
                    taken(&mut evaluator, &cells, &mut nodes);
                    let more = taken(&mut evaluator, &cells, &mut nodes);
                    assert_eq!(more, 0, "{fusion:?} {edge:?} {seed}");
                    shadows += evaluator.steps().compared;
                }
            }
        }
    }
    assert!(shadows > 10_000, "{shadows}");
}
