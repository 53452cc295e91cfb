//! Scene files: glTF 2.0 (`.gltf`, `.glb`), OBJ with MTL, PLY.
//!
//! A loaded scene has passed [`crate::Scene::validate`]. What a file leaves out stays out (no
//! light, no camera); what it holds but is not needed, or could not be found, is a warning.

mod gltf;
mod obj;
mod ply;
mod ply_payload;
mod texture;

use crate::{Scene, SceneError};
use std::path::Path;

/// A scene and what was left out of it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Valid, with at least one placed triangle; lights and cameras only if the file has them.
    pub scene: Scene,
    /// One sentence each, naming the file and the element: absent textures, unsupported parts.
    pub warnings: Vec<String>,
}

/// Loads a scene file by its extension (case does not matter).
///
/// # Errors
/// [`SceneError`] for an unreadable or malformed file, an unknown extension, or a scene that does
/// not validate. An absent texture is a warning.
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    let file = path.display().to_string();
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    let parse = match extension.as_str() {
        "gltf" | "glb" => gltf::parse,
        "obj" => obj::parse,
        "ply" => ply::parse,
        _ => return Err(SceneError::Extension { file, extension }),
    };
    let bytes =
        std::fs::read(path).map_err(|source| SceneError::Read { file: file.clone(), source })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut loaded = parse(&Source { bytes: &bytes, file: &file, folder })?;
    loaded.scene.name = path.file_stem().map_or(file.clone(), |s| s.to_string_lossy().into());
    loaded.scene.validate_as(&file)?;
    Ok(loaded)
}

/// A file in memory, and where the files it names lie.
struct Source<'a> {
    bytes: &'a [u8],
    /// Path as given, for messages.
    file: &'a str,
    folder: &'a Path,
}

impl Source<'_> {
    fn error(&self, element: impl Into<String>, reason: impl std::fmt::Display) -> SceneError {
        SceneError::format(self.file, element, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_extension_and_missing_file_are_named() {
        let message = load(Path::new("a/b/tree.fbx")).unwrap_err().to_string();
        assert!(message.contains("a/b/tree.fbx") && message.contains("\"fbx\""), "{message}");
        assert!(load(Path::new("noextension")).unwrap_err().to_string().contains("\"\""));
        for name in ["no/such.glb", "no/such.obj", "no/such.PLY"] {
            let error = load(Path::new(name)).unwrap_err();
            assert!(matches!(&error, SceneError::Read { file, .. } if file == name), "{error}");
        }
    }
}
