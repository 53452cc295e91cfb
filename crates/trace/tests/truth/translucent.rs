//! Scenes that let light through, built here.

use crate::shapes::{level_patch, mesh, rng, scene, unit_vector};
use dapple_scene::{AlphaTest, Instance, Material, Mesh, Scene, Texture};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use rand::RngExt;

/// Meshes in place, each of an opacity.
pub fn layered(meshes: Vec<(Mesh, f32)>) -> Scene {
    let materials =
        meshes.iter().map(|&(_, opacity)| Material { opacity, ..Material::default() }).collect();
    let place = |(mesh, _)| (mesh, DAffine3::IDENTITY);
    let mut scene = scene(meshes.into_iter().map(place).collect());
    for (i, mesh) in scene.meshes.iter_mut().enumerate() {
        mesh.material = i as u32;
    }
    Scene { materials, ..scene }
}

/// Level sheets over -1..1, one a height, in this order.
pub fn sheets(heights_and_opacities: &[(f64, f32)]) -> Scene {
    let sheet = |&(y, opacity)| (level_patch([-1.0, 1.0], y, [-1.0, 1.0], 1), opacity);
    layered(heights_and_opacities.iter().map(sheet).collect())
}

/// Quads of side `2 size` turned every way, with centres in the cube -1..1, as one mesh with
/// texture coordinates 0..1 on each.
pub fn leaves(count: usize, size: f64, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let (mut positions, mut triangles, mut uvs) = (Vec::<Vec3>::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        let centre = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let normal = unit_vector(&mut rng);
        let side = normal.any_orthonormal_vector() * size;
        let up = normal.cross(side);
        let first = positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            positions.push((centre + side * x + up * y).as_vec3());
            uvs.push(Vec2::new(x as f32, y as f32) * 0.5 + 0.5);
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    Mesh { uvs, ..mesh(positions, triangles) }
}

/// Ribbons of `segments` quads from the surface of a unit sphere outwards, turned towards
/// `camera`, as one mesh.
pub fn hair(strands: u32, segments: u32, width: f64, camera: DVec3, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let (mut positions, mut triangles) = (Vec::<Vec3>::new(), Vec::new());
    for _ in 0..strands {
        let root = unit_vector(&mut rng);
        let bend = unit_vector(&mut rng) * 0.4 + DVec3::NEG_Y * 0.6;
        let at = |s: f64| root * (1.0 + s) + bend * s * s;
        for k in 0..=segments {
            let s = f64::from(k) / f64::from(segments);
            let along = at(s + 1e-3) - at(s - 1e-3);
            let across = along.cross(camera - at(s)).normalize_or_zero() * 0.5 * width;
            let i = positions.len() as u32;
            positions.extend([at(s) - across, at(s) + across].map(|p| p.as_vec3()));
            if k < segments {
                triangles.extend([[i, i + 1, i + 2], [i + 1, i + 3, i + 2]]);
            }
        }
    }
    mesh(positions, triangles)
}

/// The same scene with its first material cut out by a checkered texture.
pub fn cut_out(mut scene: Scene) -> Scene {
    let texels = (0..64).map(|i| [255, 255, 255, if (i + i / 8) % 2 == 0 { 255 } else { 0 }]);
    let texture = Texture { name: String::new(), width: 8, height: 8, texels: texels.collect() };
    scene.textures = vec![texture];
    scene.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
    scene
}

/// The same scene with every instance moved and scaled.
pub fn transformed(mut scene: Scene, transform: DAffine3) -> Scene {
    let place = |i: &mut Instance| i.transform = transform * i.transform;
    scene.instances.iter_mut().for_each(place);
    scene
}
