//! Refusing scenes that no kernel should ever see.

use crate::{Camera, Light, Material, Mesh, Projection, Scene, SceneError, Texture};
use glam::{DAffine3, DVec3};

/// Largest world coordinate, metres: beyond it `f64` still has 1e-7 m, but no scene is real.
pub const MAX_COORDINATE_M: f64 = 1e9;
/// Most placed triangles: item buffers and BVH nodes index them with 32 bits, some spare.
pub const MAX_TRIANGLES: usize = 1 << 28;
/// Longest side of a texture: the common limit of graphics adapters.
pub const MAX_TEXTURE_SIDE: u32 = 16384;

type Check = Result<(), (String, String)>;

fn fail<T>(element: impl Into<String>, limit: impl Into<String>) -> Result<T, (String, String)> {
    Err((element.into(), limit.into()))
}

impl Scene {
    /// Checks every rule that the other crates rely on: all numbers finite, all indices inside
    /// their tables, attributes empty or one a vertex, transforms invertible, world coordinates
    /// within [`MAX_COORDINATE_M`], at most [`MAX_TRIANGLES`], textures within
    /// [`MAX_TEXTURE_SIDE`], at least one triangle placed, usable lights, cameras and paths.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first broken rule, labelled with the scene's name.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_as(&self.name)
    }

    /// [`Self::validate`], with errors labelled `label` (a file path).
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn validate_as(&self, label: &str) -> Result<(), SceneError> {
        self.check().map_err(|(element, limit)| SceneError::Invalid {
            scene: if label.is_empty() { "scene".into() } else { label.into() },
            element,
            limit,
        })
    }

    fn check(&self) -> Check {
        for (i, texture) in self.textures.iter().enumerate() {
            check_texture(i, texture)?;
        }
        for (i, material) in self.materials.iter().enumerate() {
            check_material(i, material, self.textures.len())?;
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            check_mesh(i, mesh, self.materials.len())?;
        }
        self.check_instances()?;
        for (i, light) in self.lights.iter().enumerate() {
            check_light(light).or_else(|limit| fail(format!("light {i}"), limit))?;
        }
        for (i, camera) in self.cameras.iter().enumerate() {
            check_camera(camera)
                .or_else(|limit| fail(format!("camera {i} \"{}\"", camera.name), limit))?;
        }
        for (i, path) in self.paths.iter().enumerate() {
            let element = format!("path {i} \"{}\"", path.name);
            if path.keys.is_empty() || path.frames == 0 {
                let (keys, frames) = (path.keys.len(), path.frames);
                return fail(
                    element,
                    format!("has {keys} keys and {frames} frames, needs 1 of each"),
                );
            }
            for (k, key) in path.keys.iter().enumerate() {
                check_camera(key).or_else(|limit| fail(format!("{element}, key {k}"), limit))?;
            }
        }
        Ok(())
    }

    fn check_instances(&self) -> Check {
        let mut total = 0usize;
        for (i, instance) in self.instances.iter().enumerate() {
            let Some(mesh) = self.meshes.get(instance.mesh as usize) else {
                let (index, count) = (instance.mesh, self.meshes.len());
                return fail(format!("instance {i}"), format!("mesh {index} of {count}"));
            };
            check_transform(&instance.transform)
                .or_else(|limit| fail(format!("instance {i} of mesh \"{}\"", mesh.name), limit))?;
            total = total.saturating_add(mesh.triangles.len());
            if total > MAX_TRIANGLES {
                return fail(
                    format!("instance {i}"),
                    format!("{total} placed triangles, at most {MAX_TRIANGLES} are allowed"),
                );
            }
            let world = |p: &glam::Vec3| instance.transform.transform_point3(p.as_dvec3());
            if let Some((v, p)) =
                mesh.positions.iter().map(world).enumerate().find(|(_, p)| outside(*p))
            {
                return fail(
                    format!(
                        "instance {i}, {}, vertex {v}",
                        mesh_label(instance.mesh as usize, mesh)
                    ),
                    format!("world position {p} m, at most {MAX_COORDINATE_M:e} m is allowed"),
                );
            }
        }
        if total == 0 {
            return fail(
                "instances",
                format!(
                    "no triangle is placed ({} instances); a scene needs one",
                    self.instances.len()
                ),
            );
        }
        Ok(())
    }

    /// Placed triangles without area ([`is_degenerate`]). They are allowed, since exporters write
    /// them, and hit by no ray.
    ///
    /// The scene must be valid.
    pub fn degenerate_triangles(&self) -> usize {
        self.world_triangles().filter(|(_, t)| is_degenerate(t)).count()
    }
}

/// Whether a triangle has no area: two corners coincide, or the height above the longest edge is
/// below 1e-12 of it. In any unit.
pub fn is_degenerate([a, b, c]: &[DVec3; 3]) -> bool {
    let (ab, bc, ca) = (*b - *a, *c - *b, *a - *c);
    let longest = ab.length_squared().max(bc.length_squared()).max(ca.length_squared());
    ab.cross(ca).length() <= 1e-12 * longest
}

fn mesh_label(i: usize, mesh: &Mesh) -> String {
    format!("mesh {i} \"{}\"", mesh.name)
}

fn check_texture(i: usize, t: &Texture) -> Check {
    let element = format!("texture {i} \"{}\"", t.name);
    let sides = 1..=MAX_TEXTURE_SIDE;
    if !sides.contains(&t.width) || !sides.contains(&t.height) {
        let limit =
            format!("{} x {} texels, sides must be 1..={MAX_TEXTURE_SIDE}", t.width, t.height);
        return fail(element, limit);
    }
    let expected = t.width as usize * t.height as usize;
    if t.texels.len() != expected {
        return fail(element, format!("{} texels, its size needs {expected}", t.texels.len()));
    }
    Ok(())
}

fn check_material(i: usize, m: &Material, textures: usize) -> Check {
    let element = || format!("material {i} \"{}\"", m.name);
    let unit = |x: f32| (0.0..=1.0).contains(&x);
    if !m.albedo.to_array().into_iter().all(unit) {
        return fail(element(), format!("albedo {} is outside 0..=1", m.albedo));
    }
    if !unit(m.opacity) {
        return fail(element(), format!("opacity {} is outside 0..=1", m.opacity));
    }
    let cut = m.alpha_test;
    if let Some(t) = cut.filter(|t| !unit(t.cutoff)) {
        return fail(element(), format!("alpha cutoff {} is outside 0..=1", t.cutoff));
    }
    for texture in cut.map(|t| t.texture).into_iter().chain(m.albedo_texture) {
        if texture as usize >= textures {
            return fail(element(), format!("texture {texture} of {textures}"));
        }
    }
    Ok(())
}

fn check_mesh(i: usize, m: &Mesh, materials: usize) -> Check {
    let label = || mesh_label(i, m);
    let n = m.positions.len();
    if m.material as usize >= materials {
        return fail(label(), format!("material {} of {materials}", m.material));
    }
    if m.triangles.len() > MAX_TRIANGLES {
        let limit = format!("{} triangles, at most {MAX_TRIANGLES}", m.triangles.len());
        return fail(label(), limit);
    }
    for (what, len) in [("normals", m.normals.len()), ("uvs", m.uvs.len())] {
        if len != 0 && len != n {
            return fail(label(), format!("{len} {what} for {n} vertices; needs none or one each"));
        }
    }
    if let Some((v, p)) = m.positions.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        return fail(format!("{}, vertex {v}", label()), format!("position {p} is not finite"));
    }
    if let Some((v, p)) = m.normals.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        return fail(format!("{}, vertex {v}", label()), format!("normal {p} is not finite"));
    }
    if let Some((v, p)) = m.uvs.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        return fail(format!("{}, vertex {v}", label()), format!("uv {p} is not finite"));
    }
    let bad = m.triangles.iter().enumerate().find(|(_, t)| t.iter().any(|&k| k as usize >= n));
    if let Some((t, corners)) = bad {
        let element = format!("{}, triangle {t}", label());
        return fail(element, format!("vertex indices {corners:?}, but there are {n} vertices"));
    }
    Ok(())
}

/// The volume ratio, not the determinant: a scene in micrometres is as invertible as one in metres.
pub(crate) fn check_transform(t: &DAffine3) -> Result<(), String> {
    if !t.is_finite() {
        return Err("transform is not finite".into());
    }
    let m = t.matrix3;
    let boxed = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let volume = m.determinant().abs();
    if !(boxed > 0.0 && volume > 1e-12 * boxed) {
        return Err(format!("transform is not invertible (determinant {:e})", m.determinant()));
    }
    Ok(())
}

/// `max_element` alone would pass over a NaN.
fn outside(v: DVec3) -> bool {
    !v.is_finite() || v.abs().max_element() > MAX_COORDINATE_M
}

fn finite(what: &str, v: DVec3) -> Result<(), String> {
    if outside(v) {
        return Err(format!(
            "{what} {v}: coordinates must be finite, at most {MAX_COORDINATE_M:e}"
        ));
    }
    Ok(())
}

fn has_length(what: &str, v: DVec3) -> Result<(), String> {
    finite(what, v)?;
    v.try_normalize().map(|_| ()).ok_or_else(|| format!("{what} {v} has no length"))
}

fn check_light(light: &Light) -> Result<(), String> {
    match *light {
        Light::Directional { direction } => has_length("direction", direction),
        Light::Spot { position, direction, half_angle_rad } => {
            finite("position", position)?;
            has_length("direction", direction)?;
            if !(half_angle_rad > 0.0 && half_angle_rad < std::f64::consts::FRAC_PI_2) {
                return Err(format!("spot half angle {half_angle_rad} rad is outside (0, pi/2)"));
            }
            Ok(())
        }
        Light::Area { centre, half_u, half_v } => {
            finite("centre", centre)?;
            finite("half_u", half_u)?;
            finite("half_v", half_v)?;
            let area = 4.0 * half_u.cross(half_v).length();
            if area.is_nan() || area <= 1e-12 * half_u.length() * half_v.length() {
                return Err(format!("area light has area {area:e} m^2; needs more than 0"));
            }
            Ok(())
        }
    }
}

fn check_camera(c: &Camera) -> Result<(), String> {
    finite("position", c.position)?;
    finite("target", c.target)?;
    let Some(forward) = (c.target - c.position).try_normalize() else {
        return Err(format!("target equals position {}", c.position));
    };
    has_length("up", c.up)?;
    let sine = forward.cross(c.up.normalize()).length();
    if sine.is_nan() || sine <= 1e-6 {
        return Err(format!("up {} is parallel to the view axis {forward}", c.up));
    }
    match c.projection {
        Projection::Perspective { fov_y_rad } => {
            if !(fov_y_rad > 0.0 && fov_y_rad < std::f64::consts::PI) {
                return Err(format!("vertical opening {fov_y_rad} rad is outside (0, pi)"));
            }
        }
        Projection::Orthographic { height_m } => {
            if !(height_m > 0.0 && height_m <= MAX_COORDINATE_M) {
                return Err(format!(
                    "image height {height_m} m is outside (0, {MAX_COORDINATE_M:e}]"
                ));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AlphaTest, CameraPath, Instance};
    use glam::{DMat3, Vec2, Vec3};

    fn good() -> Scene {
        crate::generate::by_name("cube", 1).unwrap()
    }

    /// Applies `damage` to a good scene and returns the message.
    fn refused(damage: impl FnOnce(&mut Scene)) -> String {
        let mut scene = good();
        scene.validate().unwrap();
        damage(&mut scene);
        scene.validate().unwrap_err().to_string()
    }

    #[test]
    fn each_broken_rule_names_scene_element_and_limit() {
        let message = refused(|s| s.meshes[1].positions[3].y = f32::NAN);
        assert!(message.starts_with("cube: mesh 1 \"cube\", vertex 3: "), "{message}");
        assert!(refused(|s| s.meshes[0].positions[0].x = f32::INFINITY).contains("vertex 0"));
        let message = refused(|s| s.meshes[1].triangles[5][2] = 9999);
        assert!(message.contains("triangle 5") && message.contains("9999"), "{message}");
        assert!(refused(|s| s.meshes[0].material = 77).contains("material 77 of"));
        assert!(refused(|s| s.instances[0].mesh = 5).contains("instance 0: mesh 5 of 2"));
        assert!(refused(|s| s.meshes[0].uvs = vec![Vec2::ZERO]).contains("1 uvs for"));
        assert!(refused(|s| s.meshes[0].normals = vec![Vec3::Y]).contains("1 normals for"));
        assert!(refused(|s| s.materials[0].albedo_texture = Some(0)).contains("texture 0 of 0"));
        assert!(refused(|s| s.materials[0].opacity = -0.1).contains("opacity -0.1"));
        assert!(refused(|s| s.materials[0].albedo.x = f32::NAN).contains("albedo"));
        assert!(refused(|s| s.instances.clear()).contains("no triangle"));
        assert!(
            refused(
                |s| s.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: f32::NAN })
            )
            .contains("cutoff")
        );
        let message = refused(|s| s.instances[0].transform.translation.x = 2e9);
        assert!(message.contains("1e9 m is allowed"), "{message}");
        assert!(refused(|s| s.instances[0].transform.translation.x = f64::NAN).contains("finite"));
        assert!(
            refused(|s| s.instances[0].transform.matrix3 =
                DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)))
            .contains("invertible")
        );
    }

    #[test]
    fn textures_lights_cameras_and_paths_are_checked() {
        let texture =
            |w, h, n| Texture { name: "t".into(), width: w, height: h, texels: vec![[0; 4]; n] };
        assert!(refused(|s| s.textures.push(texture(0, 1, 0))).contains("texture 0 \"t\""));
        assert!(refused(|s| s.textures.push(texture(16385, 1, 16385))).contains("16384"));
        assert!(refused(|s| s.textures.push(texture(2, 2, 3))).contains("needs 4"));
        let zero = DVec3::ZERO;
        let light = |l: Light| refused(|s| s.lights.push(l));
        assert!(light(Light::Directional { direction: zero }).contains("light 1: direction"));
        for half_angle_rad in [0.0, f64::NAN, std::f64::consts::FRAC_PI_2, -1.0] {
            let spot = Light::Spot { position: zero, direction: DVec3::Y, half_angle_rad };
            assert!(light(spot).contains("spot half angle"));
        }
        let flat = Light::Area { centre: zero, half_u: DVec3::X, half_v: DVec3::X };
        assert!(light(flat).contains("needs more than 0"));
        let point = Light::Area { centre: zero, half_u: zero, half_v: zero };
        assert!(light(point).contains("needs more than 0"));
        assert!(refused(|s| s.cameras[0].target = s.cameras[0].position).contains("camera 0"));
        assert!(
            refused(|s| s.cameras[0].up = s.cameras[0].target - s.cameras[0].position)
                .contains("parallel")
        );
        for bad in [f64::NAN, f64::INFINITY, 2e9] {
            assert!(refused(|s| s.cameras[0].position.y = bad).contains("position"));
            assert!(refused(|s| s.paths[0].keys[2].target.z = bad).contains("key 2: target"));
            let direction = DVec3::new(1.0, bad, 0.0);
            assert!(light(Light::Directional { direction }).contains("direction"));
        }
        assert!(refused(|s| s.paths[0].keys.clear()).contains("path 0"));
        assert!(refused(|s| s.paths[0].frames = 0).contains("0 frames"));
        let empty = CameraPath { name: "p".into(), keys: vec![], frames: 3 };
        assert!(refused(|s| s.paths.push(empty)).contains("\"p\""));
    }

    #[test]
    fn tiny_and_far_but_sane_scenes_pass() {
        for scale in [1e-6, 1e6] {
            let mut scene = good();
            for instance in &mut scene.instances {
                instance.transform = DAffine3::from_scale(DVec3::splat(scale));
            }
            scene.validate().unwrap();
        }
    }

    #[test]
    fn degenerate_triangles_are_counted_not_refused() {
        let mut scene = good();
        assert_eq!(scene.degenerate_triangles(), 0);
        let mesh = &mut scene.meshes[1];
        mesh.triangles.push([0, 0, 1]);
        mesh.triangles.push([2, 2, 2]);
        let n = mesh.positions.len() as u32;
        mesh.positions.extend([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
        mesh.normals.extend([Vec3::Y; 3]);
        mesh.uvs.clear();
        mesh.triangles.push([n, n + 1, n + 2]);
        scene.validate().unwrap();
        assert_eq!(scene.degenerate_triangles(), 3);
        // Counted once a placement.
        scene.instances.push(Instance { mesh: 1, transform: DAffine3::from_translation(DVec3::X) });
        assert_eq!(scene.degenerate_triangles(), 6);
    }
}
