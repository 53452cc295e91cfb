//! Scenes that only these judges need.

use dapple_scene::{
    Camera, Instance, Light, Material, Mesh, Projection, Scene,
    generate::{self, mesh},
};
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use rand::{RngExt, SeedableRng};

/// Name of [`slats`].
pub const SLATS: &str = "random slats";
/// The generated spheres of 80 triangles each.
pub const SPHERES_COARSE: &str = "spheres of 80 triangles";
/// The generated spheres of 20,480 triangles each.
pub const SPHERES_FINE: &str = "spheres of 20480 triangles";

/// 700 thin slats of 0.5 to 1.6 m, turned at random, in the 4 m above a floor of 6 x 6 m: the
/// light meets about three of them on its way, at any distance from one another.
pub fn slats(seed: u64) -> Scene {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut parts = Vec::new();
    for _ in 0..700 {
        let mut within = |least: f64, most: f64| rng.random_range(least..most);
        let half = DVec3::new(within(0.25, 0.8), 0.006, within(0.03, 0.09));
        let turn = DQuat::from_euler(
            EulerRot::YXZ,
            within(0.0, std::f64::consts::TAU),
            within(-0.4, 0.4),
            within(-0.4, 0.4),
        );
        let at = DVec3::new(within(-2.6, 2.6), within(0.15, 4.0), within(-2.6, 2.6));
        let mut slat = mesh::cuboid(Vec3::ZERO, half.as_vec3());
        let place = DAffine3::from_rotation_translation(turn, at);
        for p in &mut slat.positions {
            *p = place.transform_point3(p.as_dvec3()).as_vec3();
        }
        for n in &mut slat.normals {
            *n = (turn * n.as_dvec3()).as_vec3();
        }
        parts.push(slat);
    }
    let floor = mesh::quad(Vec3::ZERO, Vec3::Z * 3.0, Vec3::X * 3.0);
    let camera = Camera {
        name: "under the slats".into(),
        position: DVec3::new(3.6, 2.4, 3.2),
        target: DVec3::new(0.2, 0.6, 0.0),
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 0.8 },
    };
    Scene {
        name: SLATS.into(),
        meshes: vec![
            Mesh { name: "floor".into(), ..floor },
            Mesh { name: "slats".into(), ..mesh::join(&parts) },
        ],
        materials: vec![Material::default()],
        instances: (0..2).map(|mesh| Instance { mesh, transform: DAffine3::IDENTITY }).collect(),
        lights: vec![Light::Directional { direction: DVec3::new(-0.35, -1.0, -0.25) }],
        cameras: vec![camera],
        ..Scene::default()
    }
}

/// The generated spheres with another tessellation.
pub fn spheres(subdivisions: u32) -> Scene {
    let mut scene = generate::by_name("spheres", 0).unwrap_or_default();
    for sphere in scene.meshes.iter_mut().filter(|m| m.name == "sphere") {
        let material = sphere.material;
        let finer = mesh::icosphere(Vec3::ZERO, 1.0, subdivisions);
        *sphere = Mesh { name: "sphere".into(), material, ..finer };
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_change_the_slats_and_subdivision_the_triangles() {
        assert_ne!(slats(0).hash(), slats(1).hash());
        assert!(slats(0).validate().is_ok());
        let count = |s: &Scene| s.world_triangles().count();
        assert_eq!(count(&spheres(1)), 16 * 80 + 2);
        assert_eq!(count(&spheres(5)), 16 * 20_480 + 2);
    }
}
