//! Scenes that objects can be made of. Looser than `Scene::validate`: any scale and place will do.

use crate::OcclusionError;
use dapple_scene::{MAX_TRIANGLES, Material, Mesh, Scene};

/// Indices within their tables, lengths that agree, numbers that are finite, a triangle placed.
pub(super) fn check(scene: &Scene) -> Result<(), OcclusionError> {
    for (i, material) in scene.materials.iter().enumerate() {
        check_material(i, material, scene)?;
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        check_mesh(i, mesh, scene)?;
    }
    let mut total = 0_usize;
    for (i, instance) in scene.instances.iter().enumerate() {
        let Some(mesh) = scene.meshes.get(instance.mesh as usize) else {
            let limit = format!("mesh {} of {}", instance.mesh, scene.meshes.len());
            return Err(OcclusionError::value(format!("instance {i}"), limit));
        };
        if !instance.transform.is_finite() {
            let element = format!("instance {i} of mesh \"{}\"", mesh.name);
            return Err(OcclusionError::value(element, "transform is not finite"));
        }
        total = total.saturating_add(mesh.triangles.len());
        if total > MAX_TRIANGLES {
            let limit = format!("{total} placed triangles, at most {MAX_TRIANGLES} are allowed");
            return Err(OcclusionError::value(format!("instance {i}"), limit));
        }
    }
    if total == 0 {
        let limit = format!("no triangle is placed ({} instances)", scene.instances.len());
        return Err(OcclusionError::value(format!("scene \"{}\"", scene.name), limit));
    }
    Ok(())
}

fn check_material(i: usize, material: &Material, scene: &Scene) -> Result<(), OcclusionError> {
    let refuse = |limit: String| {
        Err(OcclusionError::value(format!("material {i} \"{}\"", material.name), limit))
    };
    if !material.opacity.is_finite() || !material.albedo.is_finite() {
        return refuse(format!(
            "opacity {} or albedo {} is not finite",
            material.opacity, material.albedo
        ));
    }
    let Some(test) = material.alpha_test else { return Ok(()) };
    let Some(texture) = scene.textures.get(test.texture as usize) else {
        return refuse(format!("texture {} of {}", test.texture, scene.textures.len()));
    };
    let (texels, size) =
        (texture.texels.len() as u64, u64::from(texture.width) * u64::from(texture.height));
    // The index of a texel has 32 bits.
    if texels != 0 && (texels != size || size > u64::from(u32::MAX)) {
        return refuse(format!(
            "texture \"{}\" has {texels} texels for {} x {}",
            texture.name, texture.width, texture.height
        ));
    }
    if !test.cutoff.is_finite() {
        return refuse(format!("alpha cutoff {} is not finite", test.cutoff));
    }
    Ok(())
}

fn check_mesh(i: usize, mesh: &Mesh, scene: &Scene) -> Result<(), OcclusionError> {
    let label = || format!("mesh {i} \"{}\"", mesh.name);
    let vertices = mesh.positions.len();
    if mesh.material as usize >= scene.materials.len() {
        let limit = format!("material {} of {}", mesh.material, scene.materials.len());
        return Err(OcclusionError::value(label(), limit));
    }
    if !mesh.uvs.is_empty() && mesh.uvs.len() != vertices {
        let limit = format!("{} uvs for {vertices} vertices", mesh.uvs.len());
        return Err(OcclusionError::value(label(), limit));
    }
    for (t, corners) in mesh.triangles.iter().enumerate() {
        if corners.iter().any(|&c| c as usize >= vertices) {
            let limit = format!("vertices {corners:?}, but there are {vertices}");
            return Err(OcclusionError::value(format!("{}, triangle {t}", label()), limit));
        }
    }
    if let Some(v) = mesh.positions.iter().position(|p| !p.is_finite()) {
        let limit = format!("position {} is not finite", mesh.positions[v]);
        return Err(OcclusionError::value(format!("{}, vertex {v}", label()), limit));
    }
    if let Some(v) = mesh.uvs.iter().position(|p| !p.is_finite()) {
        let limit = format!("uv {} is not finite", mesh.uvs[v]);
        return Err(OcclusionError::value(format!("{}, vertex {v}", label()), limit));
    }
    Ok(())
}
