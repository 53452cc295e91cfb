//! Writing a scene as GLB, so that generated scenes can be opened elsewhere and read back.

use crate::{Camera, CameraPath, Light, Material, Mesh, Projection, Scene, SceneError, Texture};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// Writes `scene`, which must be valid, to `path` and returns what the format could not hold.
///
/// Meshes, materials, textures and placements keep their order and, but for these, their bits:
/// transforms, lights and cameras are rounded to `f32`, and cameras keep their view axis but not
/// the distance of their target. Area lights and camera paths go into the scene's `extras`, which
/// only this program reads (to an ulp or so of `f64`); on reading they follow the other lights. A cut-out whose texture is
/// not the colour texture gets a merged copy.
///
/// # Errors
/// [`SceneError::Invalid`] for an invalid scene, [`SceneError::Format`] above 4 GiB,
/// [`SceneError::Write`] if the file cannot be written.
pub fn write_glb(scene: &Scene, path: &Path) -> Result<Vec<String>, SceneError> {
    scene.validate()?;
    let file = path.display().to_string();
    let (bytes, warnings) = encode(scene, &file)?;
    std::fs::write(path, bytes).map_err(|source| SceneError::Write { file, source })?;
    Ok(warnings)
}

/// What the format has no element for.
#[derive(Serialize, Deserialize)]
pub(crate) struct Extras {
    dapple: Beside,
}

#[derive(Serialize, Deserialize)]
struct Beside {
    /// Centre, half_u, half_v.
    area_lights: Vec<[DVec3; 3]>,
    paths: Vec<Keys>,
}

#[derive(Serialize, Deserialize)]
struct Keys {
    name: String,
    frames: u32,
    keys: Vec<Key>,
}

#[derive(Serialize, Deserialize)]
struct Key {
    position: DVec3,
    target: DVec3,
    up: DVec3,
    /// Of the two, the one that the projection has.
    fov_y_rad: Option<f64>,
    height_m: Option<f64>,
}

impl Extras {
    fn of(scene: &Scene) -> Self {
        let area = |l: &Light| match *l {
            Light::Area { centre, half_u, half_v } => Some([centre, half_u, half_v]),
            _ => None,
        };
        let key = |c: &Camera| {
            let (fov_y_rad, height_m) = match c.projection {
                Projection::Perspective { fov_y_rad } => (Some(fov_y_rad), None),
                Projection::Orthographic { height_m } => (None, Some(height_m)),
            };
            Key { position: c.position, target: c.target, up: c.up, fov_y_rad, height_m }
        };
        let keys = |p: &CameraPath| Keys {
            name: p.name.clone(),
            frames: p.frames,
            keys: p.keys.iter().map(key).collect(),
        };
        let area_lights = scene.lights.iter().filter_map(area).collect();
        Self { dapple: Beside { area_lights, paths: scene.paths.iter().map(keys).collect() } }
    }

    /// Area lights and paths, not yet validated.
    pub(crate) fn into_scene(self) -> (Vec<Light>, Vec<CameraPath>) {
        let light = |[centre, half_u, half_v]: [DVec3; 3]| Light::Area { centre, half_u, half_v };
        let path = |p: Keys| {
            let key = |k: Key| Camera {
                name: p.name.clone(),
                position: k.position,
                target: k.target,
                up: k.up,
                projection: match (k.fov_y_rad, k.height_m) {
                    (Some(fov_y_rad), _) => Projection::Perspective { fov_y_rad },
                    // Neither: NaN, which validation refuses by name.
                    (None, h) => Projection::Orthographic { height_m: h.unwrap_or(f64::NAN) },
                },
            };
            let keys = p.keys.into_iter().map(key).collect();
            CameraPath { name: p.name, keys, frames: p.frames }
        };
        let beside = self.dapple;
        let lights = beside.area_lights.into_iter().map(light).collect();
        (lights, beside.paths.into_iter().map(path).collect())
    }
}

/// Binary chunk, and the views and accessors into it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, data: impl IntoIterator<Item = u8>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(data);
        let length = self.bytes.len() - offset;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, items: &[[f32; N]]) -> usize {
        let view = self.view(items.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let extreme = |pick: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
            (0..N).map(|k| items.iter().map(|v| v[k]).fold(start, pick)).collect()
        };
        let (min, max) = (extreme(f32::min, f32::INFINITY), extreme(f32::max, f32::NEG_INFINITY));
        self.accessors.push(json!({
            "bufferView": view, "componentType": 5126, "count": items.len(),
            "type": format!("VEC{N}"), "min": min, "max": max,
        }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let view = self.view(triangles.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let count = 3 * triangles.len();
        self.accessors.push(json!({
            "bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }

    fn mesh(&mut self, m: &Mesh) -> Value {
        let arrays = |v: &[glam::Vec3]| v.iter().map(|p| p.to_array()).collect::<Vec<_>>();
        let mut attributes = json!({"POSITION": self.floats(&arrays(&m.positions))});
        if !m.normals.is_empty() {
            attributes["NORMAL"] = self.floats(&arrays(&m.normals)).into();
        }
        if !m.uvs.is_empty() {
            let uvs: Vec<[f32; 2]> = m.uvs.iter().map(|t| t.to_array()).collect();
            attributes["TEXCOORD_0"] = self.floats(&uvs).into();
        }
        let indices = self.indices(&m.triangles);
        json!({"name": m.name, "primitives": [
            {"attributes": attributes, "indices": indices, "material": m.material}]})
    }
}

fn encode(scene: &Scene, file: &str) -> Result<(Vec<u8>, Vec<String>), SceneError> {
    let mut warnings = vec![];
    let mut textures = scene.textures.clone();
    let materials: Vec<Value> =
        scene.materials.iter().map(|m| material(m, &mut textures, &mut warnings)).collect();
    let mut bin = Binary::default();
    // A glTF mesh may not be empty; unplaced indices must still line up, so it stays and is named.
    if let Some(m) = scene.meshes.iter().find(|m| m.triangles.is_empty()) {
        let reason = "has no triangles, which the format does not allow";
        return Err(SceneError::format(file, format!("mesh \"{}\"", m.name), reason));
    }
    let meshes: Vec<Value> = scene.meshes.iter().map(|m| bin.mesh(m)).collect();
    let mut images = vec![];
    for t in &textures {
        let png =
            png(t).map_err(|e| SceneError::format(file, format!("texture \"{}\"", t.name), e))?;
        let view = bin.view(png);
        images.push(json!({"name": t.name, "bufferView": view, "mimeType": "image/png"}));
    }
    let sources: Vec<Value> =
        (0..images.len()).map(|i| json!({"source": i, "sampler": 0})).collect();
    let mut nodes: Vec<Value> = placements(scene, &mut warnings);
    let cameras: Vec<Value> = scene.cameras.iter().map(camera).collect();
    for (i, c) in scene.cameras.iter().enumerate() {
        let matrix = look(c.position, c.target - c.position, c.up);
        nodes.push(json!({"name": c.name, "camera": i, "matrix": matrix}));
    }
    let lights: Vec<(Value, [f32; 16])> = scene.lights.iter().filter_map(light).collect();
    for (i, (_, matrix)) in lights.iter().enumerate() {
        let extension = json!({"KHR_lights_punctual": {"light": i}});
        nodes.push(json!({"matrix": matrix, "extensions": extension}));
    }
    let all: Vec<usize> = (0..nodes.len()).collect();
    let extras = serde_json::to_value(Extras::of(scene))
        .map_err(|e| SceneError::format(file, "extras", e))?;
    let mut root = json!({
        "asset": {"version": "2.0", "generator": concat!("dapple ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"name": scene.name, "nodes": all, "extras": extras}],
        "nodes": nodes, "meshes": meshes, "materials": materials,
        "buffers": [{"byteLength": bin.bytes.len()}],
        "bufferViews": bin.views, "accessors": bin.accessors,
    });
    // Empty lists are not allowed.
    if !cameras.is_empty() {
        root["cameras"] = cameras.into();
    }
    if !images.is_empty() {
        root["images"] = images.into();
        root["textures"] = sources.into();
        root["samplers"] = json!([{"magFilter": 9728, "minFilter": 9728}]);
    }
    if !lights.is_empty() {
        let lights: Vec<Value> = lights.into_iter().map(|l| l.0).collect();
        root["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
        root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    }
    Ok((container(root.to_string().into_bytes(), bin.bytes, file)?, warnings))
}

fn container(mut text: Vec<u8>, bin: Vec<u8>, file: &str) -> Result<Vec<u8>, SceneError> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + bin.len();
    let length = u32::try_from(total).map_err(|_| {
        SceneError::format(
            file,
            "GLB",
            format!("{total} bytes, the format's limit is {}", u32::MAX),
        )
    })?;
    let mut out = Vec::with_capacity(total);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(length.to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bin)] {
        // Fits: it is part of `length`.
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    Ok(out)
}

fn material(m: &Material, textures: &mut Vec<Texture>, warnings: &mut Vec<String>) -> Value {
    let [r, g, b] = m.albedo.to_array();
    let mut surface = json!({"baseColorFactor": [r, g, b, m.opacity], "metallicFactor": 0.0});
    let mut out = json!({"name": m.name, "doubleSided": true});
    let mut texture = m.albedo_texture;
    match m.alpha_test {
        Some(test) => {
            if texture != Some(test.texture) {
                texture = Some(merged(textures, texture, test.texture));
            }
            if m.opacity < 1.0 {
                out["alphaMode"] = "BLEND".into();
                if test.cutoff != 0.5 {
                    let (name, cutoff) = (&m.name, test.cutoff);
                    warnings.push(format!(
                        "material \"{name}\": cutoff {cutoff} is lost: the format has none beside opacity"
                    ));
                }
            } else {
                out["alphaMode"] = "MASK".into();
                out["alphaCutoff"] = json!(test.cutoff);
            }
        }
        None if m.opacity < 1.0 => out["alphaMode"] = "BLEND".into(),
        None => {}
    }
    if let Some(t) = texture {
        surface["baseColorTexture"] = json!({"index": t});
    }
    out["pbrMetallicRoughness"] = surface;
    out
}

/// A texture of the cut-out's size with its alpha and the nearest texel's colour (white if none).
fn merged(textures: &mut Vec<Texture>, colour: Option<u32>, alpha: u32) -> u32 {
    let mut texture = textures[alpha as usize].clone();
    let (w, h) = (texture.width as usize, texture.height as usize);
    for (i, texel) in texture.texels.iter_mut().enumerate() {
        let [r, g, b] = match colour.map(|c| &textures[c as usize]) {
            Some(c) => {
                let (cw, ch) = (c.width as usize, c.height as usize);
                let [r, g, b, _] = c.texels[(i / w * ch / h) * cw + i % w * cw / w];
                [r, g, b]
            }
            None => [255; 3],
        };
        *texel = [r, g, b, texel[3]];
    }
    texture.name.push_str(" (merged)");
    textures.push(texture);
    textures.len() as u32 - 1
}

fn png(t: &Texture) -> Result<Vec<u8>, image::ImageError> {
    use image::ImageEncoder;
    let mut out = vec![];
    let encoder = image::codecs::png::PngEncoder::new(&mut out);
    let flat: Vec<u8> = t.texels.iter().flatten().copied().collect();
    encoder.write_image(&flat, t.width, t.height, image::ExtendedColorType::Rgba8)?;
    Ok(out)
}

fn placements(scene: &Scene, warnings: &mut Vec<String>) -> Vec<Value> {
    let (mut nodes, mut worst) = (vec![], 0.0_f64);
    for instance in &scene.instances {
        let matrix = DMat4::from(instance.transform).to_cols_array();
        let rounded = matrix.map(|x| x as f32);
        for k in 12..15 {
            worst = worst.max((matrix[k] - f64::from(rounded[k])).abs());
        }
        nodes.push(json!({"mesh": instance.mesh, "matrix": rounded}));
    }
    if worst > 1e-6 {
        warnings.push(format!("placements are rounded to f32, by up to {worst:.1e} m"));
    }
    nodes
}

/// Column-major matrix of a view along -z with +y up.
fn look(position: DVec3, forward: DVec3, up: DVec3) -> [f32; 16] {
    let back = -forward.normalize_or(DVec3::NEG_Z);
    let right = up.cross(back).normalize_or(DVec3::X);
    let axes = DMat3::from_cols(right, back.cross(right), back);
    let matrix = DMat4::from(DAffine3::from_mat3_translation(axes, position));
    matrix.to_cols_array().map(|x| x as f32)
}

fn camera(c: &Camera) -> Value {
    // The format wants clip planes; nothing here uses them.
    let (near, far) = (1e-3, 1e6);
    match c.projection {
        Projection::Perspective { fov_y_rad } => json!({"name": c.name, "type": "perspective",
            "perspective": {"yfov": fov_y_rad, "znear": near, "zfar": far}}),
        Projection::Orthographic { height_m } => json!({"name": c.name, "type": "orthographic",
            "orthographic": {"xmag": 0.5 * height_m, "ymag": 0.5 * height_m, "znear": near, "zfar": far}}),
    }
}

fn light(l: &Light) -> Option<(Value, [f32; 16])> {
    let (kind, position, direction) = match *l {
        Light::Directional { direction } => {
            (json!({"type": "directional"}), DVec3::ZERO, direction)
        }
        Light::Spot { position, direction, half_angle_rad } => {
            let spot = json!({"type": "spot", "spot": {"outerConeAngle": half_angle_rad}});
            (spot, position, direction)
        }
        Light::Area { .. } => return None,
    };
    let up = direction.any_orthonormal_vector();
    Some((kind, look(position, direction, up)))
}
