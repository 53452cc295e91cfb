//! What every light tree has to hold.

use super::{LightTree, Node, fit::children};
use crate::{
    Light, LightsError,
    light::{Emission, angle},
};

/// Radiant intensities of parents and children agree to this share: sums are rounded.
const SUM: f64 = 1e-5;

/// Angles agree to so many radians.
const ANGLE: f64 = 1e-6;

impl LightTree {
    /// Refuses a tree of another number of lights, without a look at its nodes.
    ///
    /// # Errors
    /// [`LightsError::Value`] that tells both numbers.
    pub fn check_number(&self, lights: &[Light]) -> Result<(), LightsError> {
        let (leaves, lights) = (self.leaves.len(), lights.len());
        if leaves == lights {
            return Ok(());
        }
        Err(LightsError::value("light tree", format!("has {leaves} leaves for {lights} lights")))
    }

    /// Whether this is a tree over `lights`: every light is in one leaf, a node's subtree is its
    /// children's, its box and its cone hold theirs, its intensity is the sum of theirs, its
    /// representative lies in its box, and the light that stands for it is one of its own.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the first node or light that is not so.
    pub fn check(&self, lights: &[Light]) -> Result<(), LightsError> {
        self.check_shape(lights)?;
        for index in 0..self.nodes.len() {
            let node = &self.nodes[index];
            if let Err(limit) = self.check_node(lights, index, node) {
                return Err(LightsError::value(format!("node {index} of the light tree"), limit));
            }
        }
        self.check_cones(lights)
    }

    /// Roots cover all nodes, children cover all below a node, leaves are where they are said to be.
    fn check_shape(&self, lights: &[Light]) -> Result<(), LightsError> {
        let refuse = |what: String| Err(LightsError::value("light tree", what));
        let mut next = 0;
        for &root in &self.roots {
            let Some(node) = self.nodes.get(root as usize).filter(|_| root == next) else {
                return refuse(format!("a root at node {root} rather than {next}"));
            };
            next += node.size;
        }
        if next as usize != self.nodes.len() {
            return refuse(format!("roots hold {next} of {} nodes", self.nodes.len()));
        }
        let mut open: Vec<usize> = Vec::new();
        for (index, node) in self.nodes.iter().enumerate() {
            while open.last().is_some_and(|&end| end == index) {
                open.pop();
            }
            let end = index + node.size as usize;
            if node.size == 0 || end > open.last().copied().unwrap_or(self.nodes.len()) {
                return refuse(format!("node {index} ends outside of its parent"));
            }
            open.push(end);
        }
        self.check_number(lights)?;
        for (light, &leaf) in self.leaves.iter().enumerate() {
            let there = self.nodes.get(leaf as usize);
            if !there.is_some_and(|node| node.is_leaf() && node.light as usize == light) {
                return refuse(format!("light {light} is not at node {leaf}"));
            }
        }
        let leaves = self.nodes.iter().filter(|node| node.is_leaf()).count();
        if leaves != lights.len() {
            return refuse(format!("{leaves} leaves for {} lights", lights.len()));
        }
        Ok(())
    }

    fn check_node(&self, lights: &[Light], index: usize, node: &Node) -> Result<(), String> {
        let Some(light) = lights.get(node.light as usize) else {
            return Err(format!("stands for light {}, which there is not", node.light));
        };
        let leaf = self.leaves[node.light as usize] as usize;
        if !(index..index + node.size as usize).contains(&leaf) {
            return Err(format!("light {} that stands for it is not its own", node.light));
        }
        if light.emission.code() != node.kind {
            return Err("holds another kind of light".into());
        }
        if node.is_leaf() {
            return if *node == super::fit::leaf(light, node.light) {
                Ok(())
            } else {
                Err("differs from its light".into())
            };
        }
        if node.position.clamp(node.min, node.max) != node.position {
            return Err("its representative lies outside of its box".into());
        }
        if !(node.cone_rad >= 0.0 && node.cone_rad <= std::f64::consts::PI) {
            return Err("its cone is no angle".into());
        }
        let mut sum = glam::DVec3::ZERO;
        for child in children(&self.nodes, index).map(|child| &self.nodes[child]) {
            if child.min.min(node.min) != node.min || child.max.max(node.max) != node.max {
                return Err("its box does not hold a child's".into());
            }
            if child.half_angle_rad > node.half_angle_rad {
                return Err("its half angle is less than a child's".into());
            }
            sum += child.intensity;
        }
        if !(sum - node.intensity).abs().cmple(sum * SUM).all() {
            return Err("its intensity is not the sum of its children's".into());
        }
        Ok(())
    }

    /// The cone of every node holds the axes of the lights below.
    fn check_cones(&self, lights: &[Light]) -> Result<(), LightsError> {
        // Clusters above with the cosines of their cones: most lights lie clearly within.
        let mut above: Vec<(usize, f64)> = Vec::new();
        for (index, node) in self.nodes.iter().enumerate() {
            above.retain(|&(a, _)| a + self.nodes[a].size as usize > index);
            if !node.is_leaf() {
                above.push((index, node.cone_rad.cos()));
                continue;
            }
            let light = &lights[node.light as usize];
            if light.emission == Emission::Omni {
                continue;
            }
            let narrow = |&&(a, cosine): &&(usize, f64)| {
                let cluster = &self.nodes[a];
                cluster.axis.dot(light.axis) < cosine + ANGLE
                    && angle(cluster.axis, light.axis) > cluster.cone_rad + ANGLE
            };
            if let Some((cluster, _)) = above.iter().find(narrow) {
                let limit = format!("its cone does not hold the axis of light {}", node.light);
                return Err(LightsError::value(format!("node {cluster} of the light tree"), limit));
            }
        }
        Ok(())
    }
}
