//! Scene files: glTF 2.0 (`.gltf`, `.glb`), OBJ with MTL, PLY; hair as TressFX (`.tfx`) and HAIR
//! (`.hair`); cities as CityJSON (`.json`) and OpenStreetMap PBF (`.pbf`).
//!
//! A loaded scene has passed [`crate::Scene::validate`]. What a file leaves out stays out (no
//! light, no camera); what it holds but is not needed, or could not be found, is a warning.

mod gltf;
mod obj;
mod ply;
mod ply_payload;
mod strands;
mod texture;

use crate::{Scene, SceneError, Strands};
use std::path::Path;

/// Extensions that [`load`] reads, for messages.
const SCENES: &str = "glb, gltf, hair, json (CityJSON), obj, osm.pbf, ply, tfx";

/// Extensions that [`strands`] reads, for messages.
const STRANDS: &str = "hair, tfx";

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
    let (file, extension) = (path.display().to_string(), extension(path));
    let parse = match extension.as_str() {
        "gltf" | "glb" => gltf::parse,
        "obj" => obj::parse,
        "ply" => ply::parse,
        "tfx" => |source: &Source<'_>| strands::parse(source, strands::Format::Tfx),
        "hair" => |source: &Source<'_>| strands::parse(source, strands::Format::Hair),
        "json" | "pbf" => return city(path, &file),
        _ => return Err(SceneError::Extension { file, extension, known: SCENES }),
    };
    let bytes = read(path, &file)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut loaded = parse(&Source { bytes: &bytes, file: &file, folder })?;
    loaded.scene.name = stem(path);
    loaded.scene.validate_as(&file)?;
    Ok(loaded)
}

/// A city's objects as a scene, named after the city. Its window lights stay with the city.
fn city(path: &Path, file: &str) -> Result<Loaded, SceneError> {
    let crate::city::LoadedCity { city, warnings } = crate::city::load(path)?;
    let scene = city.scene().scene;
    scene.validate_as(file)?;
    Ok(Loaded { scene, warnings })
}

/// Reads the strands of a `.tfx` or `.hair` file (case does not matter), named after it, with one
/// sentence for each thing chosen or left out.
///
/// # Errors
/// [`SceneError`] for an unreadable or malformed file, another extension, or strands that do not
/// pass [`Strands::validate`].
pub fn strands(path: &Path) -> Result<(Strands, Vec<String>), SceneError> {
    let (file, extension) = (path.display().to_string(), extension(path));
    let format = match extension.as_str() {
        "tfx" => strands::Format::Tfx,
        "hair" => strands::Format::Hair,
        _ => return Err(SceneError::Extension { file, extension, known: STRANDS }),
    };
    let bytes = read(path, &file)?;
    let source = Source { bytes: &bytes, file: &file, folder: Path::new("") };
    strands::read(&source, format)
}

/// In lower case; empty if there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase()
}

pub(crate) fn stem(path: &Path) -> String {
    let name = path.file_stem().map(|s| s.to_string_lossy());
    name.map_or_else(|| path.display().to_string(), Into::into)
}

pub(crate) fn read(path: &Path, file: &str) -> Result<Vec<u8>, SceneError> {
    std::fs::read(path).map_err(|source| SceneError::Read { file: file.into(), source })
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
        let message = strands(Path::new("tree.obj")).unwrap_err().to_string();
        assert!(message.contains("\"obj\"") && message.contains("hair, tfx"), "{message}");
        for name in ["no/such.glb", "no/such.obj", "no/such.PLY", "no/such.Hair"] {
            let error = load(Path::new(name)).unwrap_err();
            assert!(matches!(&error, SceneError::Read { file, .. } if file == name), "{error}");
        }
    }
}
