//! What a bare model lacks to be measured: a sun, views, and ground to receive its shadow.

use crate::{Aabb, Camera, CameraPath, Instance, Light, Material, Mesh, Projection, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// Name of the mesh that [`add_ground`] adds; views frame what is not it.
pub const GROUND: &str = "ground (added)";

impl Scene {
    /// Adds what is missing: a sun along (-0.5, -1, -0.35) if there is no light; if there is no
    /// camera, one in three-quarter view from slightly above and one that grazes the ground; if
    /// there is no path, one between the first two cameras. Returns a sentence for each addition.
    ///
    /// The scene must be valid. Ground is only added by [`add_ground`], best before this.
    pub fn add_defaults(&mut self) -> Vec<String> {
        let mut added = vec![];
        if self.lights.is_empty() {
            let direction = DVec3::new(-0.5, -1.0, -0.35).normalize();
            self.lights.push(Light::Directional { direction });
            added.push("no light: a sun along (-0.5, -1, -0.35) was added".into());
        }
        if self.cameras.is_empty() {
            let views = default_views(&self.subject_bounds());
            self.cameras.extend(views);
            added.push("no camera: a three-quarter and a grazing view were added".into());
        }
        if self.paths.is_empty() && !self.cameras.is_empty() {
            let keys = self.cameras.iter().take(2).cloned().collect();
            self.paths.push(CameraPath { name: "between views".into(), keys, frames: 60 });
            added.push("no camera path: one between the first two views was added".into());
        }
        added
    }

    /// World bounds of everything but the ground, added or the file's own: a wide ground of few
    /// triangles would push the camera away from what stands on it.
    pub fn subject_bounds(&self) -> Aabb {
        let level = if self.has_ground() { self.ground_level() } else { f64::NEG_INFINITY };
        let subject = self.world_triangles().filter(|(_, t)| t.iter().any(|p| p.y > level));
        let bounds = subject.fold(Aabb::EMPTY, |b, (_, t)| t.into_iter().fold(b, Aabb::grow));
        if bounds.is_empty() { self.bounds() } else { bounds }
    }

    /// What lies below counts as ground: the lowest 2 % of the height.
    fn ground_level(&self) -> f64 {
        let b = self.bounds();
        b.min.y + 0.02 * (b.max.y - b.min.y)
    }

    /// Whether something is already there to receive a shadow: triangles within the lowest 2 % of
    /// the height cover half of the bounds seen from above.
    pub fn has_ground(&self) -> bool {
        let b = self.bounds();
        let size = b.max - b.min;
        let level = self.ground_level();
        let low = self.world_triangles().filter(|(_, t)| t.iter().all(|p| p.y <= level));
        let area: f64 = low.map(|(_, [a, b, c])| 0.5 * (b - a).cross(c - a).y.abs()).sum();
        area >= 0.5 * size.x * size.z && area > 0.0
    }
}

/// Adds a horizontal square just below the lowest point (0.1 % of the radius), centred, three
/// times as wide as the largest extent. The scene must be valid.
pub fn add_ground(scene: &mut Scene) {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return;
    }
    let half = 1.5 * (bounds.max - bounds.min).max_element().max(f64::MIN_POSITIVE);
    let centre = bounds.centre();
    let y = bounds.min.y - 1e-3 * bounds.radius();
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    scene.materials.push(Material { name: GROUND.into(), ..Material::default() });
    scene.meshes.push(Mesh {
        name: GROUND.into(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        normals: vec![Vec3::Y; 4],
        uvs: vec![],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: scene.materials.len() as u32 - 1,
    });
    // Placed by its f64 transform, so that it stays just below even far from the origin.
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(half),
        glam::DQuat::IDENTITY,
        DVec3::new(centre.x, y, centre.z),
    );
    scene.instances.push(Instance { mesh: scene.meshes.len() as u32 - 1, transform });
}

/// The views of [`Scene::add_defaults`]: three-quarter and grazing.
pub(crate) fn default_views(bounds: &Aabb) -> [Camera; 2] {
    let (centre, radius) = (bounds.centre(), bounds.radius());
    let fov_y_rad = 45.0_f64.to_radians();
    // The sphere around the bounds; its corners leave room for the shadow beside the subject.
    let distance = 1.05 * radius / (0.5 * fov_y_rad).sin();
    let view = |name: &str, target: DVec3, towards: DVec3| Camera {
        name: name.into(),
        position: target + towards.normalize() * distance,
        target,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad },
    };
    let foot = DVec3::new(centre.x, bounds.min.y, centre.z);
    [
        view("three-quarter", centre, DVec3::new(0.7, 0.45, 1.0)),
        view("grazing", foot + DVec3::Y * 0.1 * radius, DVec3::new(0.9, 0.08, 0.6)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bare() -> Scene {
        let mut s = crate::generate::by_name("closed_sphere", 1).unwrap();
        s.lights.clear();
        s.cameras.clear();
        s.paths.clear();
        s
    }

    #[test]
    fn defaults_fill_gaps_only() {
        let mut s = bare();
        assert_eq!(s.add_defaults().len(), 3);
        s.validate().unwrap();
        assert_eq!((s.lights.len(), s.cameras.len(), s.paths.len()), (1, 2, 1));
        assert!(s.add_defaults().is_empty());
        assert_eq!((s.lights.len(), s.cameras.len(), s.paths.len()), (1, 2, 1));
    }

    #[test]
    fn ground_is_found_when_there_and_lies_just_below_when_added() {
        for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e7)] {
            let mut s = bare();
            for i in &mut s.instances {
                i.transform.matrix3 *= scale;
                i.transform.translation = DVec3::splat(offset);
            }
            let before = s.bounds();
            assert!(!s.has_ground(), "a sphere is no ground");
            add_ground(&mut s);
            s.validate().unwrap();
            assert!(s.has_ground());
            let after = s.bounds();
            let gap = before.min.y - after.min.y;
            assert!(gap > 0.0 && gap < 0.002 * before.radius(), "gap {gap}");
            let wide = (after.max.x - after.min.x) / (before.max.x - before.min.x);
            assert!((wide - 3.0).abs() < 1e-6, "{wide} times as wide");
            s.add_defaults();
            s.validate().unwrap();
            // Framed on the sphere, not on its ground.
            let distance = s.cameras[0].position.distance(before.centre());
            assert!(distance < 6.0 * before.radius(), "{distance}");
        }
    }

    #[test]
    fn a_files_own_ground_does_not_push_the_camera_away() {
        let mut s = bare();
        let radius = s.bounds().radius();
        add_ground(&mut s);
        s.meshes.last_mut().unwrap().name = "lawn".into();
        s.instances.last_mut().unwrap().transform.matrix3 *= 100.0;
        s.add_defaults();
        let distance = s.cameras[0].position.distance(s.cameras[0].target);
        assert!(distance < 6.0 * radius, "{distance}");
    }

    #[test]
    fn default_views_hold_the_whole_subject() {
        let mut s = bare();
        s.add_defaults();
        let bounds = s.bounds();
        for c in &s.cameras[..1] {
            let forward = (c.target - c.position).normalize();
            for corner in bounds.corners() {
                let d = (corner - c.position).normalize();
                assert!(d.dot(forward) > 22.5_f64.to_radians().cos(), "{} misses {corner}", c.name);
            }
        }
    }
}
