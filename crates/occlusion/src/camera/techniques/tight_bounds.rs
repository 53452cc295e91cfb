//! Boxes that stand for a node in its query.
//!
//! Based on: Mattausch, Bittner, Wimmer 2008 (`mattausch2008`), section 4.3: the boxes of
//! descendants, at most so many levels below, while their surfaces add up to at most so many
//! times the node's.
//!
//! Deviations: none known. Levels are opened one after the other; a node whose children would make
//! the surface too large stays closed, others of its level may still be opened.

use crate::camera::{Tree, settings::TightBounds};

/// Nodes that together hold what `node` holds, into `cut`, each with its level below `node`.
pub(super) fn cut(tree: &Tree, node: u32, bounds: TightBounds, cut: &mut Vec<(u32, u32)>) {
    cut.clear();
    cut.push((node, 0));
    let area = |node: u32| f64::from(tree.nodes[node as usize].bounds.surface_area());
    let most = area(node) * f64::from(bounds.area);
    let mut sum = area(node);
    // A node is looked at once; its children join the end.
    let mut at = 0;
    let mut kept = 0;
    while at < cut.len() {
        let (this, level) = cut[at];
        at += 1;
        let children = tree.nodes[this as usize].children.clone();
        let opened = sum - area(this) + children.clone().map(area).sum::<f64>();
        if level < bounds.depth && !children.is_empty() && opened <= most {
            sum = opened;
            cut.extend(children.map(|child| (child, level + 1)));
        } else {
            cut[kept] = (this, level);
            kept += 1;
        }
    }
    cut.truncate(kept);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Bounds, Node};
    use glam::Vec3;

    /// A row of `2^levels` unit cubes, `gap` apart, halved again and again.
    fn row(levels: u32, gap: f32) -> Tree {
        let mut nodes = Vec::new();
        let mut todo = std::collections::VecDeque::from([(0u32, 0u32, 1u32 << levels)]);
        let mut next = 1u32;
        while let Some((parent, first, count)) = todo.pop_front() {
            let bounds = Bounds {
                min: Vec3::new(first as f32 * (1.0 + gap), 0.0, 0.0),
                max: Vec3::new((first + count - 1) as f32 * (1.0 + gap) + 1.0, 1.0, 1.0),
            };
            let children = if count > 1 { next..next + 2 } else { 0..0 };
            let this = nodes.len() as u32;
            if count > 1 {
                next += 2;
                todo.push_back((this, first, count / 2));
                todo.push_back((this, first + count / 2, count / 2));
            }
            nodes.push(Node { bounds, parent, children, objects: first..first + count });
        }
        Tree { nodes, objects: (0..1 << levels).collect() }
    }

    fn nodes(tree: &Tree, bounds: TightBounds) -> Vec<u32> {
        let mut out = Vec::new();
        cut(tree, 0, bounds, &mut out);
        out.into_iter().map(|(node, _)| node).collect()
    }

    #[test]
    fn depth_and_area_limit_the_cut() {
        let apart = row(4, 3.0);
        assert_eq!(nodes(&apart, TightBounds::OFF), [0]);
        assert_eq!(nodes(&apart, TightBounds { depth: 1, area: 1.4 }), [1, 2]);
        assert_eq!(nodes(&apart, TightBounds { depth: 3, area: 1.4 }), (7..15).collect::<Vec<_>>());
        assert_eq!(
            nodes(&apart, TightBounds { depth: 4, area: 1.4 }),
            (15..31).collect::<Vec<_>>()
        );
        // 16 touching cubes: 66 faces' worth; 2 x 34 = 68, 4 x 18 = 72, 8 x 10 = 80, 16 x 6 = 96.
        let close = row(4, 0.0);
        assert_eq!(nodes(&close, TightBounds { depth: 4, area: 1.0 }), [0]);
        assert_eq!(nodes(&close, TightBounds { depth: 4, area: 1.05 }), [1, 2]);
        assert_eq!(nodes(&close, TightBounds { depth: 4, area: 1.1 }), [3, 4, 5, 6]);
        assert_eq!(nodes(&close, TightBounds { depth: 4, area: 1.07 }), [2, 3, 4]);
        assert_eq!(nodes(&close, TightBounds { depth: 3, area: 9.0 }).len(), 8);
    }

    #[test]
    fn the_cut_holds_every_object_once() {
        for area in [1.0f32, 1.03, 1.1, 1.2, 1.4, 2.0] {
            for depth in 0..=4 {
                let tree = row(4, 0.25);
                let mut objects: Vec<u32> = nodes(&tree, TightBounds { depth, area })
                    .iter()
                    .flat_map(|&n| tree.objects_of(n).iter().copied())
                    .collect();
                objects.sort_unstable();
                assert_eq!(objects, (0..16).collect::<Vec<_>>());
            }
        }
    }
}
