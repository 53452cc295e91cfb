//! The node hierarchy: placements, cameras, lights.

use super::Reader;
use crate::validate::check_transform;
use crate::write::Extras;
use crate::{Camera, Instance, Light, Projection, SceneError};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::scene::Node;
use gltf::json::validation::Checked;

impl Reader<'_> {
    /// Walks the default scene (else the first, else all roots), depth first in file order.
    pub(super) fn read_nodes(&mut self) -> Result<(), SceneError> {
        let scene = self.root.scene.map_or(0, |s| s.value());
        let roots: Vec<usize> = match self.root.scenes.get(scene) {
            Some(scene) => scene.nodes.iter().map(|n| n.value()).collect(),
            None => self.roots(),
        };
        let mut seen = vec![false; self.root.nodes.len()];
        let mut stack: Vec<(usize, DAffine3)> =
            roots.into_iter().rev().map(|n| (n, DAffine3::IDENTITY)).collect();
        while let Some((n, parent)) = stack.pop() {
            let element = format!("node {n}");
            let (Some(node), Some(seen)) = (self.root.nodes.get(n).cloned(), seen.get_mut(n))
            else {
                return Err(self.error(element, "does not exist"));
            };
            // Also ends cycles: the format asks for strict trees.
            if std::mem::replace(seen, true) {
                return Err(self.error(element, "has two parents, or is its own descendant"));
            }
            let world = parent * local(&node);
            self.read_node(n, &node, world)?;
            let children = node.children.unwrap_or_default();
            stack.extend(children.into_iter().rev().map(|c| (c.value(), world)));
        }
        self.read_extras(scene)
    }

    fn roots(&self) -> Vec<usize> {
        let mut root = vec![true; self.root.nodes.len()];
        for child in self.root.nodes.iter().filter_map(|n| n.children.as_ref()).flatten() {
            if let Some(flag) = root.get_mut(child.value()) {
                *flag = false;
            }
        }
        (0..root.len()).filter(|&i| root[i]).collect()
    }

    fn read_node(&mut self, n: usize, node: &Node, world: DAffine3) -> Result<(), SceneError> {
        let label = node.name.clone().unwrap_or_else(|| format!("node{n}"));
        if let Some(mesh) = node.mesh {
            // Exporters hide objects by a scale of zero: that is no reason to refuse the file.
            if world.is_finite() && check_transform(&world).is_err() {
                self.warn(format!("node {n} \"{label}\" is scaled flat; its mesh is ignored"));
            } else {
                for mesh in self.meshes_of(mesh.value())? {
                    self.scene.instances.push(Instance { mesh, transform: world });
                }
            }
        }
        if let Some(camera) = node.camera {
            self.read_camera(camera.value(), &label, world)?;
        }
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        match light {
            Some(light) => self.read_light(light.light.value(), world),
            None => Ok(()),
        }
    }

    /// A glTF camera looks along -z with +y up; its aspect ratio and clip planes are not used.
    fn read_camera(
        &mut self,
        index: usize,
        label: &str,
        world: DAffine3,
    ) -> Result<(), SceneError> {
        let element = format!("camera {index}");
        let Some(camera) = self.root.cameras.get(index) else {
            return Err(self.error(element, "does not exist"));
        };
        let projection = match (&camera.type_, &camera.perspective, &camera.orthographic) {
            (Checked::Valid(gltf::json::camera::Type::Perspective), Some(p), _) => {
                Projection::Perspective { fov_y_rad: f64::from(p.yfov) }
            }
            (Checked::Valid(gltf::json::camera::Type::Orthographic), _, Some(o)) => {
                Projection::Orthographic { height_m: 2.0 * f64::from(o.ymag) }
            }
            _ => return Err(self.error(element, "lacks the projection that its type names")),
        };
        let axis = |v: DVec3| world.transform_vector3(v).try_normalize().unwrap_or(DVec3::ZERO);
        self.scene.cameras.push(Camera {
            name: camera.name.clone().unwrap_or_else(|| label.into()),
            position: world.translation,
            target: world.translation + axis(DVec3::NEG_Z),
            up: axis(DVec3::Y),
            projection,
        });
        Ok(())
    }

    fn read_light(&mut self, index: usize, world: DAffine3) -> Result<(), SceneError> {
        let lights = self.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let Some(light) = lights.and_then(|l| l.lights.get(index)) else {
            return Err(self.error(format!("light {index}"), "does not exist"));
        };
        let forward = world.transform_vector3(DVec3::NEG_Z);
        let direction = forward.try_normalize().unwrap_or(DVec3::ZERO);
        match (&light.type_, &light.spot) {
            (Checked::Valid(Type::Directional), _) => {
                self.scene.lights.push(Light::Directional { direction });
            }
            (Checked::Valid(Type::Spot), Some(spot)) => {
                // The format allows half a turn; a plane cannot hold that view.
                let widest = std::f64::consts::FRAC_PI_2 * 0.999;
                self.scene.lights.push(Light::Spot {
                    position: world.translation,
                    direction,
                    half_angle_rad: f64::from(spot.outer_cone_angle).min(widest),
                });
            }
            _ => self.warn(format!("light {index} is a point light; it is ignored")),
        }
        Ok(())
    }

    /// What `write` kept beside the format's own elements.
    fn read_extras(&mut self, scene: usize) -> Result<(), SceneError> {
        let text = self.root.scenes.get(scene).and_then(|s| s.extras.as_ref()).map(|e| e.get());
        let Some(text) = text.filter(|t| t.contains("\"dapple\"")) else { return Ok(()) };
        let extras: Extras = serde_json::from_str(text)
            .map_err(|e| self.error(format!("scene {scene}, extras.dapple"), e))?;
        let (lights, paths) = extras.into_scene();
        self.scene.lights.extend(lights);
        self.scene.paths.extend(paths);
        Ok(())
    }
}

/// A node's own transform, in `f64`.
fn local(node: &Node) -> DAffine3 {
    if let Some(m) = node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&m.map(f64::from)));
    }
    let vector =
        |v: Option<[f32; 3]>, or: DVec3| v.map_or(or, |v| DVec3::from_array(v.map(f64::from)));
    let rotation = node.rotation.as_ref().map_or(DQuat::IDENTITY, |q| {
        let q = DQuat::from_array(q.0.map(f64::from));
        // Stored in f32, so only nearly of unit length.
        if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
    });
    DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn translation_rotation_scale_apply_scale_first() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let node = Node {
            // A quarter turn about y takes x to -z.
            rotation: Some(gltf::json::scene::UnitQuaternion([0.0, half, 0.0, half])),
            scale: Some([2.0, 1.0, 1.0]),
            translation: Some([10.0, 0.0, 0.0]),
            ..Default::default()
        };
        let p = local(&node).transform_point3(DVec3::X);
        assert!((p - DVec3::new(10.0, 0.0, -2.0)).length() < 1e-7, "{p}");
    }
}
