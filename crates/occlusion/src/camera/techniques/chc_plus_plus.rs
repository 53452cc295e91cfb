//! Coherent hierarchical culling, revised: CHC++.
//!
//! Based on: Mattausch, Bittner, Wimmer 2008 (`mattausch2008`), sections 3 to 5; Conte 2018
//! (`conte2018`), section 2.2.1.
//!
//! Like [`super::chc`], and: nodes that were hidden wait in a queue and are asked a batch at a time,
//! those that are likely to stay so together ([`super::multiquery`]), each by boxes that fit it more
//! closely ([`super::tight_bounds`]). Leaves that were visible wait in a queue of their own, are
//! asked while there is nothing else to do or at the end of the frame, and count in the next frame.
//! A leaf that an answer showed is drawn without being asked for some frames, the first time for a
//! random part of them.
//!
//! Deviations, and what the source leaves open:
//! - The queue of hidden nodes is asked when it is full or the queue of the walk is empty, before
//!   anything is waited for.
//! - A leaf of the queue of visible ones counts as visible, with all that hold it, until an answer
//!   says that it is not; those that hold it then stay visible for one more frame.
//! - Such an answer is dealt with whenever its turn comes, in the frame that asked (where it is there
//!   while that waits for others) or in the next: what it says counts from the next frame on. It is
//!   waited for at the end of the next frame at the latest, so that batches do not pile up.
//! - A leaf asked in frame t and shown is asked again in frame t + 1 + n; n is the number of frames
//!   of assumed visibility, where it was hidden before random in 0..=n.
//! - Without the queue of visible leaves, these are asked with the hidden ones, each for itself.
//! - A group that showed is asked again node by node, at once, in one batch.
//! - With answers of the next frame, all nodes of a group that showed count as visible, and so does
//!   a node that the last frame did not visit.
//!
//! With batches of one and every option off, it does what CHC does.

use super::multiquery;
use super::walk::{Answer, Walk};
use crate::OcclusionError;
use crate::camera::settings::{Results, TightBounds};
use std::cmp::Reverse;

/// One frame.
pub(super) fn frame(walk: &mut Walk) -> Result<(), OcclusionError> {
    let same_frame = walk.settings.results == Results::SameFrame;
    walk.enter();
    while !walk.state.batches.is_empty() {
        if !walk.ready()? {
            if same_frame {
                break;
            }
            walk.out.work.stalls += 1;
        }
        deal_with_oldest(walk)?;
    }
    loop {
        while same_frame && !walk.state.batches.is_empty() {
            if !walk.ready()? {
                if !is_idle(walk) || !walk.awaits() {
                    break;
                }
                if !walk.state.room.visible.is_empty() {
                    ask_visible(walk)?;
                    continue;
                }
                walk.out.work.stalls += 1;
            }
            deal_with_oldest(walk)?;
        }
        if let Some(node) = walk.next() {
            visit(walk, node, same_frame)?;
        } else if !is_idle(walk) {
            ask_hidden(walk, same_frame)?;
        } else if !same_frame || !walk.awaits() {
            break;
        }
    }
    while walk.state.batches.front().is_some_and(|b| b.frame < walk.state.frame) {
        if !walk.ready()? {
            walk.out.work.stalls += 1;
        }
        deal_with_oldest(walk)?;
    }
    while !walk.state.room.visible.is_empty() {
        ask_visible(walk)?;
    }
    Ok(())
}

/// Whether there is nothing to walk and nothing hidden to ask.
fn is_idle(walk: &Walk) -> bool {
    let room = &walk.state.room;
    room.queue.is_empty() && room.hidden.is_empty() && room.drawn.is_empty()
}

fn visit(walk: &mut Walk, node: u32, same_frame: bool) -> Result<(), OcclusionError> {
    let frame = walk.state.frame;
    let before = walk.visit(node);
    let was = walk.was_visible(before) || !same_frame && walk.is_unknown(before);
    if walk.touches(node) {
        walk.pull_up(node, frame);
        walk.traverse(node);
        return Ok(());
    }
    if !was {
        let room = &mut walk.state.room;
        room.hidden.push((node, room.hidden.len() as u32));
    } else if walk.tree.is_leaf(node) {
        pass_visible(walk, node, before.next_query, same_frame);
    }
    let room = &walk.state.room;
    if room.hidden.len() + room.drawn.len() >= walk.settings.batch as usize {
        ask_hidden(walk, same_frame)?;
    }
    if was {
        walk.traverse(node);
    }
    Ok(())
}

/// A leaf that was visible: it is asked if its time has come.
fn pass_visible(walk: &mut Walk, node: u32, next_query: u32, same_frame: bool) {
    let frame = walk.state.frame;
    let due = next_query <= frame;
    if due {
        walk.state.nodes[node as usize].next_query = walk.next_query(node, frame, false);
        match walk.settings.visible_queue {
            true => walk.state.room.visible.push_back(node),
            false => walk.state.room.drawn.push(node),
        }
    }
    if !due || walk.settings.visible_queue && same_frame {
        walk.pull_up(node, frame);
    }
}

/// Asks one batch of the leaves in sight.
fn ask_visible(walk: &mut Walk) -> Result<(), OcclusionError> {
    for _ in 0..walk.settings.batch {
        let Some(node) = walk.state.room.visible.pop_front() else { break };
        walk.query(&[node], true, TightBounds::OFF);
    }
    walk.ask(false)
}

/// Asks all nodes that wait to be, as one batch.
fn ask_hidden(walk: &mut Walk, same_frame: bool) -> Result<(), OcclusionError> {
    let tight = walk.settings.tight_bounds;
    let mut hidden = std::mem::take(&mut walk.state.room.hidden);
    let mut group = std::mem::take(&mut walk.state.room.again);
    let visits = |walk: &Walk, node: u32| walk.state.nodes[node as usize].hidden;
    if walk.settings.multiqueries {
        hidden.sort_unstable_by_key(|&(node, order)| (Reverse(visits(walk, node)), order));
    }
    let mut rest = &hidden[..];
    while !rest.is_empty() {
        let size = match walk.settings.multiqueries {
            true => multiquery::first_group(rest.iter().map(|&(node, _)| visits(walk, node))),
            false => 1,
        };
        let (first, others) = rest.split_at(size.max(1));
        group.clear();
        group.extend(first.iter().map(|&(node, _)| node));
        walk.query(&group, false, tight);
        rest = others;
    }
    hidden.clear();
    group.clear();
    walk.state.room.hidden = hidden;
    walk.state.room.again = group;
    let mut drawn = std::mem::take(&mut walk.state.room.drawn);
    for node in drawn.drain(..) {
        walk.query(&[node], true, TightBounds::OFF);
    }
    walk.state.room.drawn = drawn;
    walk.ask(same_frame)
}

/// Collects a batch, waiting if need be, and asks again what has to be.
fn deal_with_oldest(walk: &mut Walk) -> Result<(), OcclusionError> {
    let batch = walk.collect()?;
    while let Some(answer) = walk.answer(batch) {
        walk.remember(&answer);
        let nodes = std::mem::take(&mut walk.state.room.answered);
        deal_with(walk, &answer, &nodes);
        walk.state.room.answered = nodes;
    }
    let mut again = std::mem::take(&mut walk.state.room.again);
    for node in again.drain(..) {
        walk.query(&[node], false, walk.settings.tight_bounds);
    }
    walk.state.room.again = again;
    walk.ask(true)
}

fn deal_with(walk: &mut Walk, answer: &Answer, nodes: &[u32]) {
    let now = answer.frame == walk.state.frame;
    if !answer.visible {
        if answer.drawn {
            for &node in nodes {
                walk.state.nodes[node as usize].visible = 0;
            }
        }
    } else if now && nodes.len() > 1 {
        walk.state.room.again.extend_from_slice(nodes);
    } else {
        for &node in nodes {
            walk.pull_up(node, answer.frame);
            if !answer.drawn {
                let next_query = walk.next_query(node, answer.frame, true);
                walk.state.nodes[node as usize].next_query = next_query;
                if now {
                    walk.traverse(node);
                }
            }
        }
    }
}
