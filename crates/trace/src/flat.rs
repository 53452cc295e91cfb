//! The tree and its triangles as plain f32 arrays, for a device to trace shadow rays with.

use crate::error::TraceError;
use crate::tracer::{OPAQUE, Tracer};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use obvhs::bvh2::Bvh2;

/// The farthest that a corner may lie from the origin, metres: products of three such lengths, which
/// a triangle test takes, stay finite in f32.
pub const MAX_FLAT_M: f64 = 1e12;

/// A node of a [`FlatTree`]. 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FlatNode {
    /// Lower corner, metres, rounded down.
    pub low: Vec3,
    /// Triangles of a leaf; 0 for a node with two children.
    pub count: u32,
    /// Upper corner, metres, rounded up.
    pub high: Vec3,
    /// A leaf's first triangle; else the first child, which the second one follows.
    pub first: u32,
}

/// A triangle of a [`FlatTree`]. 48 bytes; the fourth numbers are 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FlatTriangle {
    /// Metres, each rounded to the nearest f32: corners that were one stay one.
    pub corners: [[f32; 4]; 3],
}

/// A tree of two children a node over triangles, relative to an origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatTree {
    /// The root comes first; none where nothing is traced.
    pub nodes: Vec<FlatNode>,
    /// In the order that leaves refer to.
    pub triangles: Vec<FlatTriangle>,
    /// Levels below the root: what waits in a walk that goes down into one child at a time and puts
    /// the other aside is never more.
    pub depth: usize,
}

impl Tracer {
    /// The tree in f32, relative to `origin` (world space). Every box holds its triangles as they
    /// are here, rounded, and goes beyond them by `grow_m` to each side.
    ///
    /// # Errors
    /// Triangles with an alpha test, which is not here, or a corner beyond [`MAX_FLAT_M`].
    pub fn flat(&self, origin: DVec3, grow_m: f64) -> Result<FlatTree, TraceError> {
        let cut_out = self.leaves.iter().filter(|leaf| leaf.cut_out != OPAQUE).count();
        if cut_out > 0 {
            return Err(TraceError::CutOut { triangles: cut_out });
        }
        let mut triangles = Vec::with_capacity(self.leaves.len());
        for leaf in &self.leaves {
            let corners = leaf.corners.map(|p| self.space.leave(DVec3::from_array(p)) - origin);
            let farthest_m = corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
            if farthest_m > MAX_FLAT_M {
                return Err(TraceError::Flat { farthest_m });
            }
            let corners = corners.map(|p| p.as_vec3().extend(0.0).to_array());
            triangles.push(FlatTriangle { corners });
        }
        let nodes =
            if triangles.is_empty() { Vec::new() } else { boxes(&self.bvh, &triangles, grow_m) };
        // Two more than its levels: see `build.rs`.
        Ok(FlatTree { nodes, triangles, depth: self.stack_size.saturating_sub(2) })
    }
}

fn boxes(bvh: &Bvh2, triangles: &[FlatTriangle], grow_m: f64) -> Vec<FlatNode> {
    let mut nodes = vec![FlatNode::default(); bvh.nodes.len()];
    // Parents before their children.
    let mut order = vec![0_u32];
    let mut next = 0;
    while let Some(node) = order.get(next).and_then(|&i| bvh.nodes.get(i as usize)) {
        if !node.is_leaf() {
            order.extend([node.first_index, node.first_index + 1]);
        }
        next += 1;
    }
    for &index in order.iter().rev() {
        let node = &bvh.nodes[index as usize];
        let first = node.first_index as usize;
        let (low, high) = if node.is_leaf() {
            let held = &triangles[first..first + node.prim_count as usize];
            let corners =
                held.iter().flat_map(|t| t.corners).map(|[x, y, z, _]| Vec3::new(x, y, z));
            let (low, high) = corners
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                    (low.min(p), high.max(p))
                });
            let down = (low.as_dvec3() - grow_m).as_vec3().to_array().map(f32::next_down);
            let up = (high.as_dvec3() + grow_m).as_vec3().to_array().map(f32::next_up);
            (Vec3::from_array(down), Vec3::from_array(up))
        } else {
            let (a, b) = (nodes[first], nodes[first + 1]);
            (a.low.min(b.low), a.high.max(b.high))
        };
        nodes[index as usize] =
            FlatNode { low, count: node.prim_count, high, first: node.first_index };
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_scene::generate;

    // Every triangle is in one leaf, inside all boxes above it by what was asked.
    #[test]
    fn boxes_hold_their_triangles_and_every_triangle_is_in_one() {
        let scene = generate::by_name("city_small", 1).unwrap();
        let tracer = Tracer::build(&scene).unwrap();
        for (origin, grow_m) in [(DVec3::ZERO, 0.0), (DVec3::new(1e4, -3.0, 77.7), 0.01)] {
            let flat = tracer.flat(origin, grow_m).unwrap();
            assert_eq!(flat.triangles.len(), tracer.traced_triangles());
            let mut seen = vec![0; flat.triangles.len()];
            let mut open = vec![(0_u32, Vec::new(), 0)];
            let mut deepest = 0;
            while let Some((index, mut above, level)) = open.pop() {
                let node = flat.nodes[index as usize];
                above.push(node);
                deepest = deepest.max(level);
                if node.count == 0 {
                    open.push((node.first, above.clone(), level + 1));
                    open.push((node.first + 1, above, level + 1));
                    continue;
                }
                for i in node.first..node.first + node.count {
                    seen[i as usize] += 1;
                    for p in flat.triangles[i as usize].corners {
                        let p = Vec3::new(p[0], p[1], p[2]).as_dvec3();
                        for node in &above {
                            assert!((p - grow_m).cmpge(node.low.as_dvec3()).all());
                            assert!((p + grow_m).cmple(node.high.as_dvec3()).all());
                        }
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
            assert_eq!(flat.depth, deepest);
        }
    }

    #[test]
    fn corners_are_where_the_scene_has_them() {
        let scene = generate::by_name("city_small", 1).unwrap();
        let tracer = Tracer::build(&scene).unwrap();
        let origin = DVec3::new(5.0, 6.0, 7.0);
        let flat = tracer.flat(origin, 0.0).unwrap();
        let world: Vec<_> = scene.world_triangles().map(|(_, corners)| corners).collect();
        for (leaf, triangle) in tracer.leaves.iter().zip(&flat.triangles) {
            for (exact, p) in world[leaf.id as usize].iter().zip(triangle.corners) {
                let p = Vec3::new(p[0], p[1], p[2]).as_dvec3();
                let exact = *exact - origin;
                assert!((exact - p).abs().max_element() <= 1e-7 * exact.abs().max_element() + 1e-9);
            }
        }
    }

    #[test]
    fn nothing_traced_has_no_node_and_what_is_not_here_is_refused() {
        let empty = Tracer::build(&dapple_scene::Scene::default()).unwrap();
        assert_eq!(empty.flat(DVec3::ZERO, 0.0).unwrap().nodes, []);
        let city = Tracer::build(&generate::by_name("city_small", 1).unwrap()).unwrap();
        let far = city.flat(DVec3::X * 1e13, 0.0).unwrap_err();
        assert!(matches!(far, TraceError::Flat { .. }), "{far}");
        let mut scene = generate::by_name("city_small", 1).unwrap();
        scene.textures.push(dapple_scene::Texture::default());
        let test = dapple_scene::AlphaTest { texture: 0, cutoff: 0.5 };
        for material in &mut scene.materials {
            material.alpha_test = Some(test);
        }
        let refused = Tracer::build(&scene).unwrap().flat(DVec3::ZERO, 0.0).unwrap_err();
        assert!(matches!(refused, TraceError::CutOut { .. }), "{refused}");
    }
}
