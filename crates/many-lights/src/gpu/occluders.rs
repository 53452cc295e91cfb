//! What casts shadows, on a device.
//!
//! Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", Journal of
//! Computer Graphics Techniques 2(1), 2013, section 3.
//! Deviations: edges are as wide as rounding (`common/shadow_rays.wgsl` has the reason).
//!
//! All is in f32, relative to [`World::origin`]. Let u = 2^-24 and R the farthest coordinate of
//! what occludes or is lit: then
//!
//! - Points and corners are rounded by at most u R along an axis. A point is up to 2 sqrt(3) u R =
//!   3.5 u R below what it lies on.
//! - A corner relative to the ray's start is rounded by 2 u R. What the shear takes off is at most
//!   2 R, and its factor, a division of 2.5 ulp, is off by 5 u; product and difference round once
//!   more. So a sheared corner is off by at most 18 u R, and where the plane lies nearly along the
//!   ray, the ray's height above it by as much.
//! - A ray that starts 21.5 u R above what its point lies on therefore never meets that:
//!   [`LIFT`] = 32 u. Real corners are nearer than 2 R, and what is measured needs far less.
//! - A slab's distance is off by 7 u of itself, of at most 2 R: 14 u R across the slab. What the
//!   triangle test takes lies within 18 u R of the triangle. A slope below 2^-23 of the longest
//!   component is replaced, by which the ray drifts 4 u R. Boxes grown by [`GROWTH`] = 64 u, more
//!   than all of them together, lose nothing that the triangle test would take: what is hidden does
//!   not depend on the tree.
//!
//! So a thing of less than 32 u R does not shade what it stands on (1 mm where R is 500 m), and
//! elsewhere only what passes a silhouette within some u R is decided otherwise than in f64: of
//! 500,000 rays and more a view, at most 3 in the small city, 5 in the large one, and 18 in Helsinki,
//! nearly all at grazing angles, where the two lifts differ most.

use super::scene::storage;
use crate::{LightsError, World};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::{Gpu, wgpu};
use dapple_trace::{FlatTree, TraceError, Tracer};

/// How far rays stay away from both ends, over the farthest coordinate.
pub const LIFT: f64 = 1.0 / (1 << 19) as f64;

/// How far boxes are grown, over the farthest coordinate.
const GROWTH: f64 = 1.0 / (1 << 18) as f64;

/// Nodes that a walk of `common/shadow_rays.wgsl` can put aside: Helsinki's tree has 96 levels.
const STACK: usize = 128;

/// Mirrors `ShadowParams` of `common/shadow_rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct ShadowParams {
    lift: f32,
    short: f32,
    nodes: u32,
    pad: u32,
}

/// What casts shadows, uploaded: bindings 0, 1 and 2 of group 2 of `common/shadow_rays.wgsl`. Where
/// nothing does, kernels see no node.
#[derive(Debug)]
pub struct Occluders {
    params: wgpu::Buffer,
    nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    there: bool,
}

impl Occluders {
    /// Uploads what casts shadows in a world, if anything does.
    ///
    /// # Errors
    /// Alpha-tested surfaces, coordinates that f32 does not hold, a tree deeper than kernels can
    /// walk, or a buffer over a limit of the device, by name.
    pub fn new(gpu: &Gpu, world: &World) -> Result<Self, LightsError> {
        Self::apart(gpu, world, [LIFT; 2])
    }

    /// The same with rays that start and end by other shares of the farthest coordinate away from
    /// point and light: to see what the right one is worth.
    ///
    /// # Errors
    /// As [`Occluders::new`].
    pub fn apart(gpu: &Gpu, world: &World, apart: [f64; 2]) -> Result<Self, LightsError> {
        let (tree, [lift, short]) = match &world.occluders {
            None => (FlatTree::default(), [0.0; 2]),
            Some(tracer) => {
                let farthest_m = farthest(world, tracer);
                let apart_m = apart.map(|share| (share * farthest_m) as f32);
                (flat(world, tracer, GROWTH * farthest_m)?, apart_m)
            }
        };
        let nodes = tree.nodes.len() as u32;
        let params = ShadowParams { lift, short, nodes, pad: 0 };
        Ok(Self {
            params: gpu.uniform("shadow rays", &params)?,
            nodes: storage(gpu, "nodes of what casts shadows", &tree.nodes)?,
            triangles: storage(gpu, "triangles that cast shadows", &tree.triangles)?,
            there: world.occluders.is_some(),
        })
    }

    /// Bindings 0, 1 and 2, in order.
    pub fn buffers(&self) -> [&wgpu::Buffer; 3] {
        [&self.params, &self.nodes, &self.triangles]
    }

    /// Whether anything casts shadows.
    pub fn are_there(&self) -> bool {
        self.there
    }

    /// The constant `SHADOWS` of `common/lights_shadow.wgsl`.
    pub fn constant(&self) -> (&'static str, f64) {
        ("SHADOWS", f64::from(u8::from(self.there)))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.buffers().iter().map(|buffer| buffer.size()).sum()
    }
}

fn flat(world: &World, tracer: &Tracer, grow_m: f64) -> Result<FlatTree, LightsError> {
    let refuse = |what: String| LightsError::value("gpu form: occluders", what);
    let tree = tracer.flat(world.origin, grow_m).map_err(|error| match error {
        TraceError::CutOut { triangles } => {
            refuse(format!("scene has alpha-tested surfaces ({triangles} triangles)"))
        }
        other => refuse(other.to_string()),
    })?;
    // The node that is looked at does not wait, its two children may.
    if tree.depth >= STACK {
        return Err(refuse(format!(
            "their tree has {} levels, the limit is {STACK}",
            tree.depth + 1
        )));
    }
    Ok(tree)
}

/// The farthest coordinate of what occludes or is lit, relative to the origin, metres.
fn farthest(world: &World, tracer: &Tracer) -> f64 {
    let bounds = tracer.bounds();
    let corners = [bounds.min, bounds.max].map(|corner| (corner - world.origin).abs());
    let points = world.frames.iter().flat_map(|frame| &frame.points);
    let points = points.filter(|point| point.is_there());
    let positions = points.map(|point| point.position.abs().as_dvec3());
    let all = if bounds.is_empty() { Vec::new() } else { corners.to_vec() };
    all.into_iter().chain(positions).map(|p| p.max_element()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn params_and_tree_have_the_layout_of_the_shader() {
        let path = "many-lights/shadow_rays.wgsl";
        let fields = [("lift", 0), ("short", 4), ("nodes", 8), ("pad", 12)];
        crate::gpu::mirror::<ShadowParams>(path, "ShadowParams", &fields);
        let fields = [("low", 0), ("count", 12), ("high", 16), ("first", 28)];
        crate::gpu::mirror::<dapple_trace::FlatNode>(path, "ShadowNode", &fields);
        let fields = [("a", 0), ("b", 16), ("c", 32)];
        crate::gpu::mirror::<dapple_trace::FlatTriangle>(path, "ShadowTriangle", &fields);
        let source = dapple_shaders::source(path).unwrap();
        assert!(source.contains(&format!("const SHADOW_STACK = {STACK}u;")));
    }
}
