//! Texture files: only those a material's colour or cut-out needs are decoded.

use super::Source;
use crate::validate::MAX_TEXTURE_SIDE;
use crate::{SceneError, Texture};
use std::io::Cursor;

/// Decodes PNG or JPEG bytes to 8-bit RGBA.
pub fn decode(source: &Source<'_>, name: &str, bytes: &[u8]) -> Result<Texture, SceneError> {
    let fail = |e: &dyn std::fmt::Display| source.error(format!("texture \"{name}\""), e);
    let mut reader =
        image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| fail(&e))?;
    // A header may claim any size: refuse before the memory is taken.
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    let rgba = reader.decode().map_err(|e| fail(&e))?.into_rgba8();
    let (width, height) = rgba.dimensions();
    let texels = rgba.pixels().map(|p| p.0).collect();
    Ok(Texture { name: name.into(), width, height, texels })
}

/// Reads a texture file named by the scene file; absent gives a warning and `None`.
pub fn read(
    source: &Source<'_>,
    name: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<Texture>, SceneError> {
    match std::fs::read(source.folder.join(name)) {
        Ok(bytes) => decode(source, name, &bytes).map(Some),
        Err(_) => {
            warnings.push(absent(source.file, name, "its materials go without it"));
            Ok(None)
        }
    }
}

/// Reports a texture file that is not needed here, if it is not there either.
pub fn note_if_absent(source: &Source<'_>, name: &str, warnings: &mut Vec<String>) {
    if !source.folder.join(name).is_file() {
        warnings.push(absent(source.file, name, "it is not needed here"));
    }
}

fn absent(file: &str, name: &str, consequence: &str) -> String {
    format!("{file}: texture \"{name}\" is absent; {consequence}")
}

/// The least alpha of a texture, 0..=255.
pub fn min_alpha(texture: &Texture) -> u8 {
    texture.texels.iter().map(|t| t[3]).min().unwrap_or(255)
}
