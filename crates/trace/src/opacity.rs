//! How much of the light each triangle stops.

use crate::build::check_indices;
use crate::error::TraceError;
use dapple_scene::Scene;

/// The opacity of every placed triangle, in the order of `Scene::world_triangles`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opacities {
    alpha: Vec<f32>,
}

impl Opacities {
    /// Each triangle's material decides. Alpha tests are no part of it: what they cut away is not
    /// met by any ray.
    ///
    /// # Errors
    /// An index out of range, or an opacity outside 0..=1.
    pub fn of(scene: &Scene) -> Result<Self, TraceError> {
        check_indices(scene)?;
        let bad = |&(_, &opacity): &(usize, &f32)| !(0.0..=1.0).contains(&opacity);
        let opacities: Vec<f32> = scene.materials.iter().map(|m| m.opacity).collect();
        if let Some((material, &opacity)) = opacities.iter().enumerate().find(bad) {
            return Err(TraceError::Opacity { material, opacity });
        }
        let of_instance = scene.instances.iter().flat_map(|instance| {
            let mesh = &scene.meshes[instance.mesh as usize];
            std::iter::repeat_n(opacities[mesh.material as usize], mesh.triangles.len())
        });
        Ok(Self { alpha: of_instance.collect() })
    }

    /// Opacity α of a placed triangle, 0..=1; 0 where there is no such triangle.
    #[inline]
    pub fn alpha(&self, triangle: u32) -> f32 {
        self.alpha.get(triangle as usize).copied().unwrap_or(0.0)
    }

    /// Whether a triangle stops all light: α is 1.
    #[inline]
    pub fn is_opaque(&self, triangle: u32) -> bool {
        self.alpha(triangle) >= 1.0
    }

    /// Number of placed triangles.
    pub fn triangles(&self) -> usize {
        self.alpha.len()
    }
}
