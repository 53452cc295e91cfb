//! Coherent hierarchical culling.
//!
//! Based on: Bittner, Wimmer, Piringer, Purgathofer 2004 (`bittner2004`), section 4, figure 5;
//! Conte 2018 (`conte2018`), section 2.2.1.
//!
//! What was visible in the last frame is traversed and drawn at once; only its leaves are asked,
//! for the next frame's sake. What was not is asked, and traversed when an answer shows it.
//! Meanwhile the walk goes on: it waits only where the queue is empty.
//!
//! Deviations: none of substance. What the sources leave open is said in [`super`], and: a leaf is
//! asked before it is drawn; one that was drawn because it was visible is not drawn again when its
//! answer comes; with answers of the next frame, a node that the last frame did not visit counts
//! as visible, so that what is missing is missing for one frame only.

use super::walk::{Answer, Walk};
use crate::OcclusionError;
use crate::camera::settings::{Results, TightBounds};

/// One frame.
pub(super) fn frame(walk: &mut Walk) -> Result<(), OcclusionError> {
    let same_frame = walk.settings.results == Results::SameFrame;
    walk.enter();
    // Answers of earlier frames are there only where they are of the next frame.
    while !walk.state.batches.is_empty() {
        let ready = walk.ready()?;
        deal_with_oldest(walk, ready)?;
    }
    loop {
        while same_frame && !walk.state.batches.is_empty() {
            let ready = walk.ready()?;
            if !ready && !walk.state.room.queue.is_empty() {
                break;
            }
            deal_with_oldest(walk, ready)?;
        }
        let Some(node) = walk.next() else {
            if walk.state.batches.is_empty() || !same_frame {
                return Ok(());
            }
            continue;
        };
        let before = walk.visit(node);
        let was = walk.was_visible(before) || !same_frame && walk.is_unknown(before);
        if walk.touches(node) {
            walk.pull_up(node, walk.state.frame);
            walk.traverse(node);
            continue;
        }
        if walk.tree.is_leaf(node) || !was {
            walk.query(&[node], was, TightBounds::OFF);
            walk.ask(same_frame)?;
        }
        if was {
            walk.traverse(node);
        }
    }
}

/// Collects a batch, waiting if it is not ready.
fn deal_with_oldest(walk: &mut Walk, ready: bool) -> Result<(), OcclusionError> {
    if !ready {
        walk.out.work.stalls += 1;
    }
    let batch = walk.collect()?;
    while let Some(answer) = walk.answer(batch) {
        walk.remember(&answer);
        deal_with(walk, &answer);
    }
    Ok(())
}

fn deal_with(walk: &mut Walk, answer: &Answer) {
    let Some(&node) = walk.state.room.answered.first() else { return };
    if !answer.visible {
        return;
    }
    walk.pull_up(node, answer.frame);
    if !answer.drawn && answer.frame == walk.state.frame {
        walk.traverse(node);
    }
}
