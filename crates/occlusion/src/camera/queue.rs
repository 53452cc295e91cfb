//! Nodes by distance.
//!
//! An entry is one number of 128 bits, distance above index: a comparison takes two instructions and
//! no branch, where pairs are compared part by part.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Nearest first; of nodes at the same distance, the lower index first.
#[derive(Clone, Debug, Default)]
pub(super) struct FrontToBack {
    heap: BinaryHeap<Reverse<Entry>>,
}

/// A node and its distance: less is nearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Entry(u128);

impl Entry {
    /// Any number has a place in the order, NaN behind all others.
    pub fn new(distance: f64, node: u32) -> Self {
        Self(u128::from(order(distance)) << 32 | u128::from(node))
    }

    pub fn node(self) -> u32 {
        self.0 as u32
    }
}

impl FrontToBack {
    pub fn clear(&mut self) {
        self.heap.clear();
    }

    pub fn is_empty(&self) -> bool {
        self.heap.is_empty()
    }

    /// Adds a node. Any number has a place in the order, NaN behind all others.
    pub fn push(&mut self, distance: f64, node: u32) {
        self.heap.push(Reverse(Entry::new(distance, node)));
    }

    pub fn pop(&mut self) -> Option<u32> {
        self.heap.pop().map(|Reverse(entry)| entry.node())
    }
}

/// An integer in the order of `f64::total_cmp`, with both zeros as one and every NaN last.
fn order(distance: f64) -> u64 {
    let bits = match distance.is_nan() {
        true => f64::NAN.abs().to_bits(),
        false => (distance + 0.0).to_bits(),
    };
    // Negative numbers turned over, the others above them.
    bits ^ ((bits as i64 >> 63) as u64 | 1 << 63)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_leave_front_to_back_and_ties_by_index() {
        let distances =
            [3.0, -1.0, 0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, -f64::NAN, 3.0, -2.0, 1e-300];
        let mut queue = FrontToBack::default();
        for (node, &distance) in distances.iter().enumerate() {
            queue.push(distance, node as u32);
        }
        let order: Vec<u32> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [5, 8, 1, 2, 3, 9, 0, 7, 4, 6]);
        assert!(queue.is_empty());
    }
}
