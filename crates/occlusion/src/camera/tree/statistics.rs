//! Checking a hierarchy, and its shape in figures.

use super::{Objects, Tree};
use crate::OcclusionError;

/// The shape of a hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Nodes, leaves included.
    pub nodes: u64,
    /// Nodes without children.
    pub leaves: u64,
    /// Levels below the root of the deepest leaf.
    pub depth_most: u32,
    /// Mean level of the leaves.
    pub depth_mean: f64,
    /// Most children of one node.
    pub children_most: u32,
    /// Surface area of all inner nodes' boxes over that of the root's: the mean number of them that a
    /// random ray through the root meets. 0 where the root has no area.
    pub area_ratio: f64,
}

impl Tree {
    /// Checks all that users rely on: every object is below exactly one leaf, children lie behind
    /// their parent and divide its objects in order, boxes hold what is below.
    ///
    /// # Errors
    /// The first node that breaks a rule.
    pub fn validate(&self, objects: &Objects) -> Result<Statistics, OcclusionError> {
        let refuse = |index: usize, limit: &str| {
            Err(OcclusionError::value(format!("tree, node {index}"), limit))
        };
        let count = objects.objects.len();
        let mut seen = vec![false; count];
        for &object in &self.objects {
            let once = seen.get_mut(object as usize).is_some_and(|s| !std::mem::replace(s, true));
            if !once {
                return refuse(0, &format!("object {object} of {count} is not there just once"));
            }
        }
        if self.objects.len() != count || self.nodes.is_empty() != (count == 0) {
            return refuse(0, &format!("{} of {count} objects are below", self.objects.len()));
        }
        let Some(root) = self.nodes.first() else { return Ok(Statistics::default()) };
        if root.parent != 0 || root.objects != (0..count as u32) {
            return refuse(0, "the root is its own parent and holds all objects");
        }
        let mut next = 1;
        let mut parents = vec![None; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            if node.objects.is_empty() {
                return refuse(index, "has no objects");
            }
            if node.children.is_empty() {
                for &object in self.objects_of(index as u32) {
                    let inner = objects.objects[object as usize].bounds;
                    if node.bounds.union(inner) != node.bounds {
                        return refuse(index, &format!("does not hold object {object}"));
                    }
                }
                continue;
            }
            let children = node.children.start as usize..node.children.end as usize;
            if children.start <= index || children.end > self.nodes.len() {
                return refuse(index, "children must lie behind their parent");
            }
            next += children.len();
            let mut start = node.objects.start;
            for child in children {
                let below = &self.nodes[child];
                if parents[child].replace(index).is_some() || below.parent as usize != index {
                    return refuse(child, "has not one parent");
                }
                if below.objects.start != start {
                    return refuse(child, "does not go on where the child before it ended");
                }
                start = below.objects.end;
                if node.bounds.union(below.bounds) != node.bounds {
                    return refuse(index, &format!("does not hold its child {child}"));
                }
            }
            if start != node.objects.end {
                return refuse(index, "its children do not hold all of its objects");
            }
        }
        if next != self.nodes.len() {
            return refuse(0, "not every node is below");
        }
        Ok(self.statistics())
    }

    /// Level of every node: 0 for the root.
    pub fn levels(&self) -> Vec<u32> {
        let mut levels = vec![0_u32; self.nodes.len()];
        for index in 1..self.nodes.len() {
            levels[index] = levels[self.nodes[index].parent as usize] + 1;
        }
        levels
    }

    /// The shape in figures.
    pub fn statistics(&self) -> Statistics {
        let mut s = Statistics { nodes: self.nodes.len() as u64, ..Statistics::default() };
        let (mut levels, mut area) = (0_u64, 0.0_f64);
        for (node, level) in self.nodes.iter().zip(self.levels()) {
            s.children_most = s.children_most.max(node.children.len() as u32);
            if node.children.is_empty() {
                s.leaves += 1;
                levels += u64::from(level);
                s.depth_most = s.depth_most.max(level);
            } else {
                area += f64::from(node.bounds.surface_area());
            }
        }
        s.depth_mean = levels as f64 / s.leaves.max(1) as f64;
        let whole = self.nodes.first().map_or(0.0, |root| f64::from(root.bounds.surface_area()));
        s.area_ratio = if whole > 0.0 { area / whole } else { 0.0 };
        s
    }
}
