//! glTF 2.0, text and binary. Read: node hierarchy, triangle meshes (lists, strips, fans; sparse
//! accessors), base colours with their textures and alpha modes, cameras, directional and spot
//! lights of `KHR_lights_punctual`. Not read: animation, skins, morph targets, other textures.
//!
//! The `gltf` crate parses and validates the JSON. Data are read by our own bounds-checked
//! accessor code, since that crate's readers trust the sizes in the file.

mod accessor;
mod container;
mod material;
mod nodes;
mod primitive;

use super::{Loaded, Source};
use crate::{Scene, SceneError};
use ::gltf::json;
use std::collections::BTreeMap;

/// Document, buffers and what has been built from them so far.
struct Reader<'a> {
    source: &'a Source<'a>,
    root: json::Root,
    buffers: Vec<Vec<u8>>,
    scene: Scene,
    warnings: Vec<String>,
    /// Texture coordinate set that each material's colour texture uses.
    uv_sets: Vec<u32>,
    /// Material for primitives that name none, once one was met.
    default_material: Option<u32>,
    /// Meshes of the scene made from each glTF mesh already met.
    meshes: BTreeMap<usize, Vec<u32>>,
}

pub fn parse(source: &Source<'_>) -> Result<Loaded, SceneError> {
    let (text, blob) = container::split(source)?;
    let root = document(source, text)?;
    let buffers = container::buffers(source, &root, blob)?;
    let mut reader = Reader {
        source,
        root,
        buffers,
        scene: Scene::default(),
        warnings: vec![],
        uv_sets: vec![],
        default_material: None,
        meshes: BTreeMap::new(),
    };
    reader.note_unsupported();
    reader.read_materials()?;
    reader.read_nodes()?;
    Ok(Loaded { scene: reader.scene, warnings: reader.warnings })
}

/// Parses and validates the JSON.
fn document(source: &Source<'_>, text: &[u8]) -> Result<json::Root, SceneError> {
    let root: json::Root =
        json::deserialize::from_slice(text).map_err(|e| source.error("glTF document", e))?;
    // The crate's validation looks up position accessors before it has checked their indices.
    for (m, mesh) in root.meshes.iter().enumerate() {
        let accessors = mesh.primitives.iter().flat_map(|p| p.attributes.values());
        if let Some(a) = accessors.map(|a| a.value()).find(|&a| a >= root.accessors.len()) {
            let reason = format!("accessor {a} of {}", root.accessors.len());
            return Err(source.error(format!("glTF document, mesh {m}"), reason));
        }
    }
    let document =
        ::gltf::Document::from_json(root).map_err(|e| source.error("glTF document", e))?;
    Ok(document.into_json())
}

impl Reader<'_> {
    fn error(&self, element: impl Into<String>, reason: impl std::fmt::Display) -> SceneError {
        self.source.error(element, reason)
    }

    fn warn(&mut self, message: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {message}", self.source.file));
    }

    fn note_unsupported(&mut self) {
        let ignored: Vec<String> = self
            .root
            .extensions_used
            .iter()
            .filter(|name| name.as_str() != "KHR_lights_punctual")
            .cloned()
            .collect();
        for name in ignored {
            self.warn(format!("extension {name} is ignored"));
        }
        let (animations, skins) = (self.root.animations.len(), self.root.skins.len());
        if animations + skins > 0 {
            self.warn(format!("{animations} animations and {skins} skins are ignored"));
        }
    }
}
