//! A scene's identity: what truth caches and records are keyed by.

use crate::{Camera, Light, Projection, Scene};
use glam::{DAffine3, DVec3};

/// Bytes are little-endian; every list is preceded by its length and every variant by a tag, so
/// that no two different scenes give the same stream.
struct Stream(blake3::Hasher);

impl Stream {
    fn u32(&mut self, x: u32) {
        self.0.update(&x.to_le_bytes());
    }

    fn f64(&mut self, x: f64) {
        self.0.update(&x.to_bits().to_le_bytes());
    }

    fn vec(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|x| self.f64(x));
    }

    /// One list of equally sized items, through a buffer: blake3 is slow on tiny updates.
    fn list<T, const N: usize>(&mut self, items: &[T], bytes: impl Fn(&T) -> [u8; N]) {
        self.0.update(&(items.len() as u64).to_le_bytes());
        let mut buffer = Vec::with_capacity(N * items.len().min(4096));
        for chunk in items.chunks(4096) {
            buffer.clear();
            chunk.iter().for_each(|item| buffer.extend_from_slice(&bytes(item)));
            self.0.update(&buffer);
        }
    }

    fn transform(&mut self, t: &DAffine3) {
        t.to_cols_array().into_iter().for_each(|x| self.f64(x));
    }

    fn option(&mut self, x: Option<u32>) {
        self.u32(u32::from(x.is_some()));
        self.u32(x.unwrap_or(0));
    }

    fn camera(&mut self, c: &Camera) {
        [c.position, c.target, c.up].into_iter().for_each(|v| self.vec(v));
        match c.projection {
            Projection::Perspective { fov_y_rad } => {
                self.u32(0);
                self.f64(fov_y_rad);
            }
            Projection::Orthographic { height_m } => {
                self.u32(1);
                self.f64(height_m);
            }
        }
    }

    fn light(&mut self, light: &Light) {
        match *light {
            Light::Directional { direction } => {
                self.u32(0);
                self.vec(direction);
            }
            Light::Spot { position, direction, half_angle_rad } => {
                self.u32(1);
                self.vec(position);
                self.vec(direction);
                self.f64(half_angle_rad);
            }
            Light::Area { centre, half_u, half_v } => {
                self.u32(2);
                [centre, half_u, half_v].into_iter().for_each(|v| self.vec(v));
            }
        }
    }

    fn geometry(&mut self, scene: &Scene) {
        self.u32(scene.meshes.len() as u32);
        for mesh in &scene.meshes {
            self.list(&mesh.positions, |p| le3(p.to_array().map(f32::to_bits)));
            self.list(&mesh.normals, |p| le3(p.to_array().map(f32::to_bits)));
            self.list(&mesh.uvs, |p| join(p.x.to_le_bytes(), p.y.to_le_bytes()));
            self.list(&mesh.triangles, |t| le3(*t));
            self.u32(mesh.material);
        }
        self.u32(scene.materials.len() as u32);
        for m in &scene.materials {
            m.albedo.to_array().into_iter().for_each(|x| self.u32(x.to_bits()));
            self.u32(m.opacity.to_bits());
            self.option(m.alpha_test.map(|t| t.texture));
            self.option(m.alpha_test.map(|t| t.cutoff.to_bits()));
            self.option(m.albedo_texture);
        }
        self.u32(scene.textures.len() as u32);
        for t in &scene.textures {
            self.u32(t.width);
            self.u32(t.height);
            self.list(&t.texels, |texel| *texel);
        }
        self.u32(scene.instances.len() as u32);
        for i in &scene.instances {
            self.u32(i.mesh);
            self.transform(&i.transform);
        }
    }

    fn digits(&self) -> String {
        self.0.finalize().to_hex()[..16].to_owned()
    }
}

fn join(a: [u8; 4], b: [u8; 4]) -> [u8; 8] {
    std::array::from_fn(|i| if i < 4 { a[i] } else { b[i - 4] })
}

fn le3(v: [u32; 3]) -> [u8; 12] {
    let words = v.map(u32::to_le_bytes);
    std::array::from_fn(|i| words[i / 4][i % 4])
}

fn stream() -> Stream {
    let mut hasher = blake3::Hasher::new();
    // Changing the stream's layout must change every hash: caches hold results by it.
    hasher.update(b"dapple scene 1");
    Stream(hasher)
}

impl Scene {
    /// 16 hexadecimal digits of BLAKE3 over geometry, materials, texels, placements, lights,
    /// cameras and paths, by bits. Names do not count; the order of elements does.
    pub fn hash(&self) -> String {
        let mut s = stream();
        s.geometry(self);
        s.u32(self.lights.len() as u32);
        self.lights.iter().for_each(|l| s.light(l));
        s.u32(self.cameras.len() as u32);
        self.cameras.iter().for_each(|c| s.camera(c));
        s.u32(self.paths.len() as u32);
        for path in &self.paths {
            s.u32(path.frames);
            s.u32(path.keys.len() as u32);
            path.keys.iter().for_each(|c| s.camera(c));
        }
        s.digits()
    }

    /// [`Self::hash`] without lights, cameras and paths: two files of the same objects agree.
    pub fn geometry_hash(&self) -> String {
        let mut s = stream();
        s.geometry(self);
        s.digits()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AlphaTest, Texture};
    use glam::{Vec2, Vec3};
    use std::collections::BTreeMap;

    fn full() -> Scene {
        let mut s = crate::generate::by_name("cube", 3).unwrap();
        let texels = vec![[1, 2, 3, 4], [5, 6, 7, 8]];
        s.textures.push(Texture { name: "t".into(), width: 2, height: 1, texels });
        s.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
        s.materials[0].albedo_texture = Some(0);
        let (a, b) = (DVec3::X, DVec3::Y);
        s.lights.push(Light::Spot { position: a, direction: b, half_angle_rad: 0.5 });
        s.lights.push(Light::Area { centre: a, half_u: a, half_v: b });
        s.cameras[0].projection = Projection::Orthographic { height_m: 2.0 };
        s
    }

    #[test]
    fn any_single_change_changes_the_hash() {
        type Change = fn(&mut Scene);
        let changes: &[(&str, Change)] = &[
            ("position", |s| s.meshes[0].positions[0].x = s.meshes[0].positions[0].x.next_up()),
            ("normal", |s| s.meshes[0].normals[0] = Vec3::X),
            ("uv", |s| s.meshes[0].uvs = vec![Vec2::ZERO; s.meshes[0].positions.len()]),
            ("winding", |s| s.meshes[0].triangles[0].swap(0, 1)),
            ("triangle", |s| s.meshes[0].triangles.truncate(1)),
            ("material of mesh", |s| s.meshes[0].material ^= 1),
            ("albedo", |s| s.materials[0].albedo.z *= 0.5),
            ("opacity", |s| s.materials[0].opacity = 0.25),
            ("cutoff", |s| s.materials[0].alpha_test.as_mut().unwrap().cutoff = 0.25),
            ("no test", |s| s.materials[0].alpha_test = None),
            ("no albedo texture", |s| s.materials[0].albedo_texture = None),
            ("texel", |s| s.textures[0].texels[1][3] ^= 1),
            ("texture shape", |s| (s.textures[0].width, s.textures[0].height) = (1, 2)),
            ("placement", |s| s.instances[0].transform.translation.y += 1e-12),
            ("mesh placed", |s| s.instances[0].mesh ^= 1),
            ("light", |s| s.lights[0] = Light::Directional { direction: DVec3::NEG_Y * 2.0 }),
            ("spot", |s| {
                if let Light::Spot { half_angle_rad, .. } = &mut s.lights[1] {
                    *half_angle_rad += 1e-9;
                }
            }),
            ("area", |s| {
                if let Light::Area { half_v, .. } = &mut s.lights[2] {
                    half_v.x += 1e-9;
                }
            }),
            ("lights swapped", |s| s.lights.swap(0, 1)),
            ("camera", |s| s.cameras[0].target.x += 1e-9),
            ("projection", |s| {
                s.cameras[0].projection = Projection::Perspective { fov_y_rad: 2.0 };
            }),
            ("frames", |s| s.paths[0].frames += 1),
            ("key", |s| drop(s.paths[0].keys.pop())),
        ];
        let mut seen = BTreeMap::from([(full().hash(), "unchanged")]);
        for (what, change) in changes {
            let mut scene = full();
            change(&mut scene);
            if let Some(other) = seen.insert(scene.hash(), what) {
                panic!("\"{what}\" hashes like \"{other}\"");
            }
        }
        assert_eq!(seen.len(), changes.len() + 1);
    }

    #[test]
    fn names_do_not_count() {
        let mut s = full();
        let before = (s.hash(), s.geometry_hash());
        s.name = "x".into();
        s.meshes[0].name = "x".into();
        s.materials[0].name = "x".into();
        s.textures[0].name = "x".into();
        s.cameras[0].name = "x".into();
        s.paths[0].name = "x".into();
        assert_eq!((s.hash(), s.geometry_hash()), before);
        assert_eq!(before.0.len(), 16);
        assert!(before.0.chars().all(|c| c.is_ascii_hexdigit()));
    }

    #[test]
    fn the_geometry_hash_leaves_out_lights_and_views() {
        let mut s = full();
        let before = s.geometry_hash();
        s.lights.clear();
        s.cameras.clear();
        s.paths.clear();
        assert_eq!(s.geometry_hash(), before);
        s.meshes[0].positions[0].x += 1.0;
        assert_ne!(s.geometry_hash(), before);
    }
}
