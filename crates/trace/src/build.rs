//! From a scene to the arrays that traversal reads.

use crate::error::TraceError;
use crate::space::{Space, padded_box};
use crate::tracer::{CutOut, Leaf, MeshUvs, OPAQUE, Tracer, UNTRACED};
use dapple_scene::{Mesh, Scene, is_degenerate};
use glam::{DVec3, Vec2};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;
use std::{sync::OnceLock, time::Duration};

// A tree of n leaves has 2n - 1 nodes with u32 indices; the top id is a sentinel.
const MAX_TRIANGLES: usize = 1 << 30;

pub(crate) fn check_indices(scene: &Scene) -> Result<(), TraceError> {
    for (texture, t) in scene.textures.iter().enumerate() {
        let (width, height, texels) = (t.width, t.height, t.texels.len());
        if texels != 0 && texels as u64 != u64::from(width) * u64::from(height) {
            return Err(TraceError::TexelCount { texture, texels, width, height });
        }
    }
    for (material, m) in scene.materials.iter().enumerate() {
        if let Some(test) = m.alpha_test
            && test.texture as usize >= scene.textures.len()
        {
            let textures = scene.textures.len();
            return Err(TraceError::AlphaTexture { material, texture: test.texture, textures });
        }
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        check_mesh(i, mesh, scene.materials.len())?;
    }
    let meshes = scene.meshes.len();
    for (instance, placed) in scene.instances.iter().enumerate() {
        if placed.mesh as usize >= meshes {
            return Err(TraceError::InstanceMesh { instance, mesh: placed.mesh, meshes });
        }
    }
    let count = scene.triangle_count();
    if count > MAX_TRIANGLES {
        return Err(TraceError::TooMany { count, limit: MAX_TRIANGLES });
    }
    Ok(())
}

fn check_mesh(index: usize, mesh: &Mesh, materials: usize) -> Result<(), TraceError> {
    let vertices = mesh.positions.len();
    if mesh.material as usize >= materials {
        let material = mesh.material;
        return Err(TraceError::MeshMaterial { mesh: index, material, materials });
    }
    if !mesh.uvs.is_empty() && mesh.uvs.len() != vertices {
        return Err(TraceError::UvCount { mesh: index, uvs: mesh.uvs.len(), vertices });
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(TraceError::VertexIndex { mesh: index, triangle, vertex, vertices });
        }
    }
    Ok(())
}

// Levels below the root: the most entries a depth-first traversal can keep.
fn depth(bvh: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0_u32, 0_usize)];
    while let Some((node, level)) = open.pop() {
        deepest = deepest.max(level);
        if let Some(node) = bvh.nodes.get(node as usize)
            && !node.is_leaf()
        {
            open.push((node.first_index, level + 1));
            open.push((node.first_index + 1, level + 1));
        }
    }
    deepest
}

impl Tracer {
    /// Builds the tree over everything placed; materials of opacity 0 and triangles
    /// without area are left out. An empty scene
    /// is fine: every ray misses.
    ///
    /// # Errors
    /// An index out of range, a texture or mesh whose arrays disagree in length, a corner that is
    /// not finite, a scene wider than 1e300 m, or more than 2^30 triangles.
    pub fn build(scene: &Scene) -> Result<Self, TraceError> {
        check_indices(scene)?;
        for ((instance, triangle), corners) in scene.world_triangles() {
            if !corners.iter().all(|p| p.is_finite()) {
                return Err(TraceError::NonFinite { instance, triangle });
            }
        }
        let bounds = scene.bounds();
        let empty = bounds.is_empty();
        let (min, max) = if empty { (DVec3::ZERO, DVec3::ZERO) } else { (bounds.min, bounds.max) };
        let extent_m = (max - min).max_element();
        let space = Space::of(min, max).ok_or(TraceError::TooLarge { extent_m })?;

        let (mut leaves, cut_outs) = gather_leaves(scene, &space);
        let mut bvh = Bvh2::default();
        if !leaves.is_empty() {
            let boxes: Vec<_> = leaves.par_iter().map(|leaf| padded_box(&leaf.corners)).collect();
            bvh = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
            leaves = bvh.primitive_indices.iter().map(|&i| leaves[i as usize]).collect();
        }
        let mut slot_of_triangle = vec![UNTRACED; scene.triangle_count()];
        for (slot, leaf) in leaves.iter().enumerate() {
            slot_of_triangle[leaf.id as usize] = slot as u32;
        }
        let mut instance_starts = Vec::with_capacity(scene.instances.len());
        let mut start = 0;
        for instance in &scene.instances {
            instance_starts.push(start);
            start += scene.meshes[instance.mesh as usize].triangles.len() as u32;
        }
        let mesh_uvs = scene.meshes.iter().map(|mesh| {
            let triangles = if mesh.uvs.is_empty() { Vec::new() } else { mesh.triangles.clone() };
            MeshUvs { triangles, uvs: mesh.uvs.clone(), material: mesh.material }
        });
        Ok(Self {
            stack_size: depth(&bvh) + 2,
            bvh,
            leaves,
            slot_of_triangle,
            cut_outs,
            textures: scene.textures.clone(),
            instance_starts,
            instance_meshes: scene.instances.iter().map(|i| i.mesh).collect(),
            mesh_uvs: mesh_uvs.collect(),
            bounds,
            space,
            sheets: OnceLock::new(),
        })
    }
}

fn gather_leaves(scene: &Scene, space: &Space) -> (Vec<Leaf>, Vec<CutOut>) {
    let (mut leaves, mut cut_outs) = (Vec::new(), Vec::new());
    for (id, ((instance, triangle), corners)) in scene.world_triangles().enumerate() {
        let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        if material.opacity <= 0.0 {
            continue;
        }
        let corners = corners.map(|p| space.enter(p));
        // No ray hits it. Kept, it would join surfaces that have nothing else in common
        // (`sheets.rs`), and thousands at one point make a tree as deep as they are many.
        if is_degenerate(&corners) {
            continue;
        }
        let corners = corners.map(|p| p.to_array());
        let mut cut_out = OPAQUE;
        if let Some(test) = material.alpha_test {
            cut_out = cut_outs.len() as u32;
            let corner_uv =
                |v: u32| mesh.uvs.get(v as usize).copied().unwrap_or(Vec2::ZERO).as_dvec2();
            let uvs = mesh.triangles[triangle as usize].map(corner_uv);
            cut_outs.push(CutOut { uvs, texture: test.texture, cutoff: test.cutoff });
        }
        leaves.push(Leaf { corners, id: id as u32, cut_out });
    }
    (leaves, cut_outs)
}
