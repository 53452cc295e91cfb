//! Baselines: everything, the frustum, and queries that are waited for one by one.
//!
//! Based on: Conte 2018 (`conte2018`), table 5.III (everything in no order; the frustum alone, by
//! the traversal of CHC++) and figure 2.4, top (stop and wait), after Bittner et al. 2004
//! (`bittner2004`).
//!
//! Deviations: none known.

use super::walk::Walk;
use crate::OcclusionError;
use crate::camera::settings::TightBounds;

/// Draws all objects in their order.
pub(super) fn none(walk: &mut Walk) {
    walk.state.room.queue.clear();
    for object in 0..walk.objects.objects.len() as u32 {
        walk.draw(&[object]);
    }
}

/// Draws what the frustum holds, front to back.
pub(super) fn frustum(walk: &mut Walk) {
    while let Some(node) = walk.next() {
        walk.traverse(node);
    }
}

/// Asks every node and waits for its answer, front to back. Every answer is a stall: it is asked
/// for as soon as the question is put, with nothing else to do.
pub(super) fn stop_and_wait(walk: &mut Walk) -> Result<(), OcclusionError> {
    while let Some(node) = walk.next() {
        if walk.touches(node) {
            walk.traverse(node);
            continue;
        }
        walk.query(&[node], false, TightBounds::OFF);
        walk.ask(true)?;
        walk.out.work.stalls += 1;
        let batch = walk.collect()?;
        while let Some(answer) = walk.answer(batch) {
            walk.remember(&answer);
            if answer.visible {
                walk.traverse(node);
            }
        }
    }
    Ok(())
}
