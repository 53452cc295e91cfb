//! Putting a scene together.

use super::mesh;
use crate::{Camera, CameraPath, Instance, Light, Material, Mesh, Projection, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

/// A scene under construction.
pub struct Builder(pub Scene);

impl Builder {
    /// A scene with one parallel light.
    pub fn new(name: &str, light: DVec3) -> Self {
        Self(Scene {
            name: name.into(),
            lights: vec![Light::Directional { direction: light.normalize() }],
            ..Scene::default()
        })
    }

    /// An opaque square ground of 16.42 m at y = 0 under light from straight above.
    pub fn outdoors(name: &str) -> Self {
        let mut b = Self::new(name, DVec3::NEG_Y);
        b.floor(8.21);
        b
    }

    /// A material that lets light through.
    pub fn translucent(&mut self, name: &str, albedo: [f32; 3], opacity: f32) -> u32 {
        let index = self.material(name, albedo);
        self.0.materials[index as usize].opacity = opacity;
        index
    }

    pub fn material(&mut self, name: &str, albedo: [f32; 3]) -> u32 {
        let albedo = Vec3::from_array(albedo);
        self.0.materials.push(Material { name: name.into(), albedo, ..Material::default() });
        self.0.materials.len() as u32 - 1
    }

    pub fn mesh(&mut self, name: &str, material: u32, mesh: Mesh) -> u32 {
        self.0.meshes.push(Mesh { name: name.into(), material, ..mesh });
        self.0.meshes.len() as u32 - 1
    }

    pub fn place(&mut self, mesh: u32, transform: DAffine3) {
        self.0.instances.push(Instance { mesh, transform });
    }

    /// A mesh placed once, where its coordinates say.
    pub fn add(&mut self, name: &str, material: u32, mesh: Mesh) {
        let mesh = self.mesh(name, material, mesh);
        self.place(mesh, DAffine3::IDENTITY);
    }

    /// A grey square floor at y = 0, facing up.
    pub fn floor(&mut self, half: f32) {
        let material = self.material("floor", [0.7; 3]);
        self.add("floor", material, mesh::quad(Vec3::ZERO, Vec3::Z * half, Vec3::X * half));
    }

    pub fn camera(&mut self, name: &str, eye: DVec3, target: DVec3, fov_y_deg: f64) {
        self.0.cameras.push(camera(name, eye, target, fov_y_deg));
    }

    /// 60 frames about the vertical through `target`, `degrees` to each side of `eye`.
    pub fn orbit(&mut self, eye: DVec3, target: DVec3, fov_y_deg: f64, degrees: f64) {
        let key = |i: i32| {
            let turn = DQuat::from_rotation_y((degrees * f64::from(i) / 4.0).to_radians());
            camera("orbit", target + turn * (eye - target), target, fov_y_deg)
        };
        let keys = (-4..=4).map(key).collect();
        self.0.paths.push(CameraPath { name: "orbit".into(), keys, frames: 60 });
    }
}

fn camera(name: &str, position: DVec3, target: DVec3, fov_y_deg: f64) -> Camera {
    Camera {
        name: name.into(),
        position,
        target,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: fov_y_deg.to_radians() },
    }
}
