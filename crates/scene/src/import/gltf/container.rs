//! The GLB container and the buffers that a document refers to.

use super::super::Source;
use crate::SceneError;
use gltf::json;
use std::path::PathBuf;

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

/// The JSON text, and the binary chunk of a GLB.
pub fn split<'a>(source: &Source<'a>) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let all = source.bytes;
    if !all.starts_with(b"glTF") {
        return Ok((all, None));
    }
    let truncated = |what: &str, need: usize| {
        source.error(what, format!("truncated: needs {need} bytes, the file has {}", all.len()))
    };
    let (Some(version), Some(length)) = (word(all, 4), word(all, 8)) else {
        return Err(truncated("GLB header", 12));
    };
    if version != 2 {
        return Err(source.error("GLB header", format!("version {version}, only 2 is known")));
    }
    let length = length as usize;
    let body = all.get(..length).ok_or_else(|| truncated("GLB header", length))?;
    let (mut text, mut blob, mut at) = (None, None, 12);
    while at < body.len() {
        let (Some(size), Some(kind)) = (word(body, at), word(body, at + 4)) else {
            return Err(truncated("GLB chunk header", at + 8));
        };
        let end = (at + 8).saturating_add(size as usize);
        let chunk = body.get(at + 8..end).ok_or_else(|| truncated("GLB chunk", end))?;
        match kind {
            JSON if text.is_none() => text = Some(chunk),
            BIN if blob.is_none() => blob = Some(chunk),
            // The format asks to skip chunks of unknown kind.
            _ => {}
        }
        at = end;
    }
    match text {
        // The crate would take this for a GLB of its own, whose header it trusts.
        Some(text) if !text.starts_with(b"glTF") => Ok((text, blob)),
        _ => Err(source.error("GLB", "holds no JSON chunk")),
    }
}

/// Where a URI's bytes are.
pub enum Place {
    Inline(Vec<u8>),
    File(String),
}

/// Resolves a URI: base64 data, or a path relative to the document.
pub fn locate(source: &Source<'_>, element: &str, uri: &str) -> Result<Place, SceneError> {
    if uri.starts_with("data:") {
        let data = gltf::buffer::Data::from_source(gltf::buffer::Source::Uri(uri), None)
            .map_err(|e| source.error(element, format!("data URI: {e}")))?;
        return Ok(Place::Inline(data.0));
    }
    if uri.contains("://") || uri.starts_with("file:") {
        let reason = format!("URI \"{uri}\" is not relative to the file");
        return Err(source.error(element, reason));
    }
    percent_decode(uri)
        .map(Place::File)
        .ok_or_else(|| source.error(element, format!("URI \"{uri}\" is not valid UTF-8")))
}

fn percent_decode(uri: &str) -> Option<String> {
    let digit = |b: Option<&u8>| b.and_then(|&b| char::from(b).to_digit(16));
    let (bytes, mut out, mut i) = (uri.as_bytes(), Vec::with_capacity(uri.len()), 0);
    while let Some(&byte) = bytes.get(i) {
        match (byte, digit(bytes.get(i + 1)), digit(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            _ => {
                out.push(byte);
                i += 1;
            }
        }
    }
    String::from_utf8(out).ok()
}

/// Every buffer of the document, at least as long as it says.
pub fn buffers(
    source: &Source<'_>,
    root: &json::Root,
    blob: Option<&[u8]>,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let mut all = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let element = format!("buffer {i}");
        let bytes = match &buffer.uri {
            Some(uri) => match locate(source, &element, uri)? {
                Place::Inline(bytes) => bytes,
                Place::File(name) => {
                    let path: PathBuf = source.folder.join(name);
                    std::fs::read(&path).map_err(|e| SceneError::Read {
                        file: path.display().to_string(),
                        source: e,
                    })?
                }
            },
            None if i == 0 => match blob {
                Some(blob) => blob.to_vec(),
                None => return Err(source.error(element, "has no URI and the file no BIN chunk")),
            },
            None => return Err(source.error(element, "only buffer 0 may be the BIN chunk")),
        };
        let (need, have) = (buffer.byte_length.0, bytes.len() as u64);
        if have < need {
            return Err(source.error(element, format!("truncated: {have} of {need} bytes")));
        }
        all.push(bytes);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::percent_decode;

    #[test]
    fn percent_escapes_decode_and_stray_ones_stay() {
        assert_eq!(percent_decode("a%20b.png").unwrap(), "a b.png");
        assert_eq!(percent_decode("100%.png").unwrap(), "100%.png");
        assert_eq!(percent_decode("%").unwrap(), "%");
        assert_eq!(percent_decode("%C3%A9").unwrap(), "é");
        assert!(percent_decode("%FF").is_none());
    }
}
