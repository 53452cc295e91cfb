//! Baselines: everything, the frustum, and queries that are waited for one by one.
//!
//! Based on: Conte 2018 (`conte2018`), table 5.III (everything in no order; the frustum alone, by
//! the traversal of CHC++) and figure 2.4, top (stop and wait), after Bittner et al. 2004
//! (`bittner2004`).
//!
//! Deviations: none known.
//!
//! Limit of the frustum alone: nodes in the order of memory, most of them wholly inside, and a sort of
//! the leaves by numbers of 16 bytes. Seen: 25 ns a node met (31,255 of `city`, 0.8 ms a frame; with a
//! queue 153 ns and 4.8 ms). More in larger cities, 77 ns a node (71,972 of `city_9`): in the
//! order of distance, the 76 bytes of each object lie anywhere.

use super::walk::Walk;
use crate::OcclusionError;
use crate::camera::queue::Entry;
use crate::camera::settings::TightBounds;

/// Draws all objects in their order.
pub(super) fn none(walk: &mut Walk) {
    for object in 0..walk.objects.objects.len() as u32 {
        walk.draw(&[object]);
    }
}

/// Draws what the frustum holds, front to back. As nothing is asked in between, nodes are met as the
/// tree stores them, and leaves are sorted in the end: that is the order of a queue, since no node is
/// nearer than what holds it.
pub(super) fn frustum(walk: &mut Walk) {
    let mut open = std::mem::take(&mut walk.state.room.open);
    let mut leaves = std::mem::take(&mut walk.state.room.leaves);
    open.clear();
    leaves.clear();
    open.extend(walk.root());
    while let Some(node) = open.pop() {
        if walk.tree.is_leaf(node) {
            let distance = walk.view.distance(&walk.tree.nodes[node as usize].bounds);
            leaves.push(Entry::new(distance, node));
        } else {
            walk.open(node, |_, child| open.push(child));
        }
    }
    leaves.sort_unstable();
    for leaf in &leaves {
        walk.draw(walk.tree.objects_of(leaf.node()));
    }
    walk.state.room.open = open;
    walk.state.room.leaves = leaves;
}

/// Asks every node and waits for its answer, front to back. Every answer is a stall: it is asked
/// for as soon as the question is put, with nothing else to do.
pub(super) fn stop_and_wait(walk: &mut Walk) -> Result<(), OcclusionError> {
    walk.enter();
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
