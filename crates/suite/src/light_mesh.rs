//! The scene's triangles as rasterisers of a light's map take them.

use dapple_gpu::light_space::{AlphaTexture, LightSpaceMesh, LightSpaceVertex, TriangleGroup};
use dapple_scene::{LightView, Material, Scene};
use glam::DVec3;
use std::collections::BTreeMap;

/// Transparency and alpha test (texture slot, cutoff): numbers in 0..=1, whose bits sort as they do.
type Kind = (u32, Option<(u32, u32)>);

/// All placed triangles in the light's space, projected in f64; one group an opacity and alpha test,
/// opaque ones first. Materials of opacity 0 are left out, as the ray tracer leaves them out.
pub fn light_space_mesh(scene: &Scene, view: &LightView) -> LightSpaceMesh {
    let mut out = LightSpaceMesh::default();
    let mut texture_slots = BTreeMap::new();
    let mut by_kind: BTreeMap<Kind, Vec<u32>> = BTreeMap::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        if material.opacity <= 0.0 {
            continue;
        }
        let base = out.vertices.len() as u32;
        out.vertices.extend(mesh.positions.iter().enumerate().map(|(i, p)| {
            let world = instance.transform.transform_point3(p.as_dvec3());
            let uv = mesh.uvs.get(i).map_or([0.0; 2], |uv| uv.to_array());
            vertex(view, world, uv)
        }));
        let alpha = material.alpha_test.map(|test| {
            let slot = *texture_slots.entry(test.texture).or_insert_with(|| {
                out.textures.push(alpha_texture(scene, material, test.texture));
                out.textures.len() as u32 - 1
            });
            (slot, test.cutoff.to_bits())
        });
        let transparency = (1.0 - material.opacity).max(0.0).to_bits();
        let indices = by_kind.entry((transparency, alpha)).or_default();
        indices.extend(mesh.triangles.iter().flatten().map(|i| base + i));
    }
    for ((transparency, alpha), indices) in by_kind {
        let opacity = 1.0 - f32::from_bits(transparency);
        let alpha = alpha.map(|(slot, bits)| (slot, f32::from_bits(bits)));
        let (first, count) = (out.indices.len() as u32, indices.len() as u32);
        out.groups.push(TriangleGroup { first, count, alpha, opacity });
        out.indices.extend(indices);
    }
    out
}

fn vertex(view: &LightView, world: DVec3, uv: [f32; 2]) -> LightSpaceVertex {
    let from_light = world - view.origin;
    let distance = from_light.dot(view.forward);
    // Affine in world space: u w = w / 2 + (d . right) / (2 half_extent), and likewise for v.
    let w = if view.perspective { distance } else { 1.0 };
    let along = |axis: DVec3| 0.5 * w + 0.5 * from_light.dot(axis) / view.half_extent;
    LightSpaceVertex {
        position: [along(view.right) as f32, along(view.down) as f32, w as f32],
        z: ((distance - view.near_m) / (view.far_m - view.near_m)) as f32,
        uv,
    }
}

/// The alpha channel of a texture; an empty one is opaque, as [`dapple_scene::Texture`] has it.
fn alpha_texture(scene: &Scene, material: &Material, index: u32) -> AlphaTexture {
    debug_assert!(material.alpha_test.is_some());
    let texture = &scene.textures[index as usize];
    if texture.texels.is_empty() {
        return AlphaTexture { width: 1, height: 1, alpha: vec![1.0] };
    }
    let alpha = texture.texels.iter().map(|t| f32::from(t[3]) / 255.0).collect();
    AlphaTexture { width: texture.width, height: texture.height, alpha }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_scene::{AlphaTest, Texture, generate};

    fn views(scene: &Scene) -> [LightView; 2] {
        let b = scene.bounds();
        let down = DVec3::new(-0.3, -1.0, 0.2);
        [
            LightView::fit_directional(down, &b).unwrap(),
            LightView::fit_spot(b.centre() - down * 20.0, down, 0.6, &b).unwrap(),
        ]
    }

    #[test]
    fn vertices_divide_to_the_views_projection() {
        let scene = generate::by_name("cube", 0).unwrap();
        for view in views(&scene) {
            let mesh = light_space_mesh(&scene, &view);
            mesh.check().unwrap();
            let corners: Vec<DVec3> = scene.world_triangles().flat_map(|(_, t)| t).collect();
            assert_eq!(mesh.indices.len(), corners.len());
            for (i, world) in mesh.indices.iter().zip(corners) {
                let v = mesh.vertices[*i as usize];
                let [u, down, w] = v.position.map(f64::from);
                let expected = view.project(world);
                let got = DVec3::new(u / w, down / w, f64::from(v.z));
                assert!(got.distance(expected) < 1e-6, "{got} {expected}");
            }
        }
    }

    #[test]
    fn cut_outs_are_grouped_apart_and_invisible_materials_left_out() {
        let mut scene = generate::by_name("cube", 0).unwrap();
        let texels = vec![[0, 0, 0, 255], [0, 0, 0, 51]];
        scene.textures.push(Texture { name: "leaf".into(), width: 2, height: 1, texels });
        let view = views(&scene)[0];
        let all = light_space_mesh(&scene, &view).indices.len();
        let material = scene.meshes[1].material as usize;
        scene.materials[material].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
        let mesh = light_space_mesh(&scene, &view);
        mesh.check().unwrap();
        assert_eq!(mesh.groups.len(), 2);
        assert_eq!((mesh.groups[0].alpha, mesh.groups[1].alpha), (None, Some((0, 0.5))));
        assert_eq!(mesh.textures[0].alpha, [1.0, 0.2]);
        assert_eq!(mesh.indices.len(), all);
        scene.materials[material].opacity = 0.0;
        let rest = light_space_mesh(&scene, &view);
        assert_eq!(rest.groups.len(), 1);
        assert!(rest.indices.len() < all && !rest.indices.is_empty());
    }
}
