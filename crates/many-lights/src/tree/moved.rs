//! A tree that follows a light.
//!
//! Nodes know no parents: the way from a root to a leaf is found by sizes.

use super::{
    LightTree, Node, PackedTree, Representative,
    cones::{CANCELS, cone},
    fit::{Mean, children, drawn, gather, leaf, stand_for},
};
use crate::{
    Light, LightsError,
    light::{angle, luminance},
};
use std::f64::consts::PI;

impl LightTree {
    /// Follows a change of one light, its kind aside; returns how many nodes were visited, which are
    /// those on its way from the root and their children. Boxes, sums and weighted positions become
    /// those of a tree made anew. Where the light's axis or intensity changed, or another light stands
    /// for a cluster, axes are means of the children's axes, and cones hold the children's cones:
    /// still valid, a little wider. The light that stands for a weighted cluster is the nearest of
    /// those that stand for its children.
    ///
    /// # Errors
    /// [`LightsError::Value`] for another number of lights than the tree's, for a light that
    /// [`Light::check`] refuses or that has become of another kind; the tree is then as before.
    pub fn moved(
        &mut self,
        lights: &[Light],
        light: u32,
        representative: Representative,
    ) -> Result<usize, LightsError> {
        let now = self.checked(lights, light)?;
        let (way, mut visits) = self.way(light);
        let Some((&leaf_index, above)) = way.split_last() else { return Ok(0) };
        let root = way[0];
        let before = self.nodes[leaf_index];
        let turned = before.axis != now.axis || before.intensity != now.intensity;
        self.nodes[leaf_index] = leaf(now, light);
        for &index in above.iter().rev() {
            visits += children(&self.nodes, index).count();
            refit(lights, &mut self.nodes, index, root, turned, representative);
        }
        Ok(visits)
    }

    fn checked<'l>(&self, lights: &'l [Light], light: u32) -> Result<&'l Light, LightsError> {
        self.check_number(lights)?;
        let name = format!("light {light}");
        let Some(now) = lights.get(light as usize) else {
            return Err(LightsError::value(name, format!("there are {}", lights.len())));
        };
        now.check(light as usize)?;
        let kind = self.nodes[self.leaves[light as usize] as usize].kind;
        if now.emission.code() != kind {
            return Err(LightsError::value(name, "became of another kind: its tree is another"));
        }
        Ok(now)
    }

    /// Nodes from a root down to a light, and how many were looked at to find them.
    fn way(&self, light: u32) -> (Vec<usize>, usize) {
        let leaf = self.leaves[light as usize] as usize;
        let holds = |index: usize| (index..index + self.nodes[index].size as usize).contains(&leaf);
        let mut way = Vec::new();
        let mut visits = 0;
        let mut roots = self.roots.iter().map(|&root| root as usize).inspect(|_| visits += 1);
        let mut next = roots.find(|&root| holds(root));
        while let Some(index) = next {
            way.push(index);
            next = children(&self.nodes, index).inspect(|_| visits += 1).find(|&c| holds(c));
        }
        (way, visits)
    }
}

impl PackedTree {
    /// Follows [`LightTree::moved`]: packs the nodes above a light anew.
    pub fn moved(&mut self, tree: &LightTree, light: u32) {
        for index in tree.way(light).0 {
            self.nodes[index] = tree.nodes[index].pack();
        }
    }
}

/// One node, its children being right.
fn refit(
    lights: &[Light],
    nodes: &mut [Node],
    index: usize,
    root: usize,
    turned: bool,
    representative: Representative,
) {
    gather(nodes, index);
    let mean = Mean::over(children(nodes, index).map(|child| {
        let child = &nodes[child];
        let (weight, count) = (luminance(child.intensity), f64::from(child.size));
        Mean { position: child.position, axis: child.axis, weight, count }
    }));
    let mut node = nodes[index];
    node.position = mean.position.clamp(node.min, node.max);
    let near = |&light: &u32| lights[light as usize].position.distance_squared(node.position);
    let nearest = children(nodes, index)
        .map(|child| nodes[child].light)
        .min_by(|a, b| near(a).total_cmp(&near(b)).then(a.cmp(b)));
    let axis_before = node.axis;
    match representative {
        Representative::Weighted => {
            node.light = nearest.unwrap_or(node.light);
            if turned {
                node.axis = mean.axis.normalize_or(node.axis);
            }
        }
        Representative::Nearest => {
            let light = nearest.unwrap_or(node.light);
            stand_for(&mut node, lights, light);
        }
        Representative::Random { seed } => {
            stand_for(&mut node, lights, drawn(nodes, index, seed, index - root));
        }
    }
    if turned || node.axis != axis_before {
        let cancels = representative == Representative::Weighted
            && (mean.axis.length() < CANCELS
                || children(nodes, index).any(|child| nodes[child].cone_rad >= PI));
        node.cone_rad = cone(&node, cancels, || {
            let reach = |child: &Node| angle(node.axis, child.axis) + child.cone_rad;
            children(nodes, index).map(|child| reach(&nodes[child])).fold(0.0, f64::max)
        });
    }
    nodes[index] = node;
}
