//! Pixels that nodes cover.
//!
//! Based on: Conte 2018 (`conte2018`), section 4.1: the count that an answer gives is kept with its
//! node. It is an upper estimate: what is drawn later may hide counted pixels.
//!
//! Deviations: the source leaves open what an inner node in sight covers, which is not asked, and
//! what becomes of a node that is not asked for a while: see [`Coverage`](super::Coverage). In all
//! of them a node outside the frustum covers 0, and a node that cannot be asked because the near
//! plane cuts it covers the whole image.

use super::Tree;
use crate::OcclusionError;

/// The pixels of each node of `tree` from those of each object, into `out`.
///
/// # Errors
/// An object of the tree without a number, or another number of nodes in `out`.
pub fn exact_coverage(
    tree: &Tree,
    per_object_pixels: &[u32],
    out: &mut [u32],
) -> Result<(), OcclusionError> {
    if out.len() != tree.nodes.len() {
        let limit = format!("{} nodes, where the tree has {}", out.len(), tree.nodes.len());
        return Err(OcclusionError::value("coverage", limit));
    }
    let mut before = Vec::with_capacity(tree.objects.len() + 1);
    let mut sum = 0u64;
    before.push(sum);
    for &object in &tree.objects {
        let pixels = per_object_pixels.get(object as usize).ok_or_else(|| {
            let limit = format!("no pixels given: there are {} numbers", per_object_pixels.len());
            OcclusionError::value(format!("object {object}"), limit)
        })?;
        sum += u64::from(*pixels);
        before.push(sum);
    }
    for (node, out) in tree.nodes.iter().zip(out) {
        let pixels = before[node.objects.end as usize] - before[node.objects.start as usize];
        *out = u32::try_from(pixels).unwrap_or(u32::MAX);
    }
    Ok(())
}

/// Gives each of `inner`, which lists parents before their children, the sum of its children.
pub(super) fn sum_up(tree: &Tree, inner: &[u32], coverage: &mut [u32]) {
    for &node in inner.iter().rev() {
        let children = tree.nodes[node as usize].children.clone();
        let children = &coverage[children.start as usize..children.end as usize];
        coverage[node as usize] = children.iter().fold(0, |sum: u32, c| sum.saturating_add(*c));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Bounds, Node};

    /// A root over a leaf of two objects and an inner node over two leaves of one.
    fn tree() -> Tree {
        let node =
            |parent, children, objects| Node { bounds: Bounds::EMPTY, parent, children, objects };
        Tree {
            nodes: vec![
                node(0, 1..3, 0..4),
                node(0, 0..0, 0..2),
                node(0, 3..5, 2..4),
                node(2, 0..0, 2..3),
                node(2, 0..0, 3..4),
            ],
            objects: vec![3, 0, 2, 1],
        }
    }

    #[test]
    fn exact_coverage_adds_the_objects_below() {
        let mut out = [9; 5];
        exact_coverage(&tree(), &[1, 20, 300, 4000], &mut out).unwrap();
        assert_eq!(out, [4321, 4001, 320, 300, 20]);
    }

    #[test]
    fn too_many_pixels_stay_at_the_most_that_can_be_counted() {
        let mut out = [0; 5];
        exact_coverage(&tree(), &[u32::MAX; 4], &mut out).unwrap();
        assert_eq!(out, [u32::MAX; 5]);
    }

    #[test]
    fn missing_objects_and_another_tree_are_named() {
        let short = exact_coverage(&tree(), &[1, 2], &mut [0; 5]).unwrap_err().to_string();
        assert_eq!(short, "object 3: no pixels given: there are 2 numbers");
        let other = exact_coverage(&tree(), &[0; 4], &mut [0; 2]).unwrap_err().to_string();
        assert_eq!(other, "coverage: 2 nodes, where the tree has 5");
    }

    #[test]
    fn sums_go_bottom_up_over_visited_nodes_only() {
        let mut coverage = [7, 1, 9, 30, 200];
        sum_up(&tree(), &[0, 2], &mut coverage);
        assert_eq!(coverage, [231, 1, 230, 30, 200]);
        let mut unvisited = [7, 1, 9, 30, 200];
        sum_up(&tree(), &[0], &mut unvisited);
        assert_eq!(unvisited, [10, 1, 9, 30, 200], "what is below a culled node stays as it was");
    }
}
