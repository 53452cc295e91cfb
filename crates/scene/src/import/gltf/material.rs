//! Materials: base colour, and what its alpha means.

use super::Reader;
use super::container::{Place, locate};
use crate::import::texture;
use crate::{AlphaTest, Material, SceneError, Texture};
use glam::Vec3;
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

/// Cut-out level for blended materials, which name none: half covered counts as there.
const BLEND_CUTOFF: f32 = 0.5;

impl Reader<'_> {
    /// All materials in the document's order, and the textures their base colours use.
    pub(super) fn read_materials(&mut self) -> Result<(), SceneError> {
        let images = self.read_images()?;
        for m in std::mem::take(&mut self.root.materials) {
            let info = m.pbr_metallic_roughness.base_color_texture.as_ref();
            self.uv_sets.push(info.map_or(0, |t| t.tex_coord));
            let image = info.and_then(|t| self.image_of(t.index.value()));
            let texture = image.and_then(|i| images.get(i).copied().flatten());
            let material = build(&m, self.scene.materials.len(), texture, &self.scene.textures);
            self.scene.materials.push(material);
            // Only the count is still needed: primitives are checked against it.
            self.root.materials.push(m);
        }
        Ok(())
    }

    fn image_of(&self, texture: usize) -> Option<usize> {
        self.root.textures.get(texture).map(|t| t.source.value())
    }

    /// Decodes the images that base colours use; index into the scene's textures for each image.
    fn read_images(&mut self) -> Result<Vec<Option<u32>>, SceneError> {
        let used = self.root.materials.iter().filter_map(|m| {
            let info = m.pbr_metallic_roughness.base_color_texture.as_ref()?;
            self.image_of(info.index.value())
        });
        let mut needed = vec![false; self.root.images.len()];
        for image in used {
            if let Some(flag) = needed.get_mut(image) {
                *flag = true;
            }
        }
        let mut places = vec![];
        for (i, needed) in needed.into_iter().enumerate() {
            let texture = self.read_image(i, needed)?;
            places.push(texture.map(|texture| {
                self.scene.textures.push(texture);
                self.scene.textures.len() as u32 - 1
            }));
        }
        Ok(places)
    }

    fn read_image(&mut self, i: usize, needed: bool) -> Result<Option<Texture>, SceneError> {
        let element = format!("image {i}");
        let Some(image) = self.root.images.get(i) else { return Ok(None) };
        let name = image.name.clone().unwrap_or_else(|| element.clone());
        if let Some(view) = image.buffer_view {
            if !needed {
                return Ok(None);
            }
            let bytes = self.view_bytes(view, &element)?;
            return texture::decode(self.source, &name, bytes).map(Some);
        }
        let Some(uri) = image.uri.clone() else {
            return Err(self.error(element, "has neither a URI nor a buffer view"));
        };
        match locate(self.source, &element, &uri) {
            Ok(Place::Inline(bytes)) if needed => {
                texture::decode(self.source, &name, &bytes).map(Some)
            }
            Ok(Place::File(file)) if needed => {
                texture::read(self.source, &file, &mut self.warnings)
            }
            Ok(Place::File(file)) => {
                texture::note_if_absent(self.source, &file, &mut self.warnings);
                Ok(None)
            }
            Err(error) if needed => Err(error),
            _ => Ok(None),
        }
    }
}

/// What alpha means here, where a surface is either there or not:
/// - `MASK`: cut-out where texture alpha times factor is below the cutoff;
/// - `BLEND` with a texture that is not opaque: cut-out at one half, the factor is the opacity;
/// - `BLEND` otherwise: the factor is the opacity.
fn build(m: &json::Material, index: usize, texture: Option<u32>, textures: &[Texture]) -> Material {
    let [r, g, b, a] = m.pbr_metallic_roughness.base_color_factor.0;
    let mut material = Material {
        name: m.name.clone().unwrap_or_else(|| format!("material{index}")),
        albedo: Vec3::new(r, g, b),
        opacity: 1.0,
        alpha_test: None,
        albedo_texture: texture,
    };
    match m.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => {
            let cutoff = m.alpha_cutoff.map_or(0.5, |c| c.0);
            match texture {
                // alpha * a >= cutoff, with the factor moved to the other side.
                Some(texture) if cutoff <= a && a > 0.0 => {
                    material.alpha_test = Some(AlphaTest { texture, cutoff: cutoff / a });
                }
                _ if a < cutoff => material.opacity = 0.0,
                _ => {}
            }
        }
        Checked::Valid(AlphaMode::Blend) => {
            material.opacity = a;
            let holes = texture
                .filter(|&t| textures.get(t as usize).is_some_and(|t| texture::min_alpha(t) < 255));
            material.alpha_test = holes.map(|texture| AlphaTest { texture, cutoff: BLEND_CUTOFF });
        }
        _ => {}
    }
    material
}
