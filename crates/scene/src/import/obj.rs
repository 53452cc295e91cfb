//! Wavefront OBJ with MTL. One mesh per (object or group, material); polygons become fans.
//!
//! The `tobj` crate parses. Face indices are checked here first: its errors do not say which face,
//! and far-out relative indices overflow in it. Of the MTL only colour, opacity and their maps are
//! handed to it, since it stops at the first line it cannot read, needed or not.

use super::{Loaded, Source, texture};
use crate::{AlphaTest, Instance, Material, Mesh, Scene, SceneError};
use glam::{DAffine3, Vec2, Vec3};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

/// Cut-out level; MTL names none.
const CUTOFF: f32 = 0.5;

pub fn parse(source: &Source<'_>) -> Result<Loaded, SceneError> {
    let text = String::from_utf8_lossy(source.bytes);
    // A backslash at the end of a line continues it.
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    check_faces(source, &text)?;
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let (warnings, names) = (RefCell::new(vec![]), RefCell::new(BTreeMap::new()));
    let failure = RefCell::new(None);
    let (models, materials) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |library| {
        match read_mtl(source, library, &mut warnings.borrow_mut()) {
            Ok(text) => {
                let loaded = tobj::load_mtl_buf(&mut text.as_bytes());
                if let Ok((_, map)) = &loaded {
                    names.borrow_mut().extend(map.keys().map(|k| (k.clone(), ())));
                }
                loaded
            }
            Err(error) => {
                *failure.borrow_mut() = Some(error);
                Err(tobj::LoadError::GenericFailure)
            }
        }
    })
    .map_err(|e| source.error("OBJ", e))?;
    if let Some(error) = failure.into_inner() {
        return Err(error);
    }
    let materials = materials.map_err(|e| source.error("MTL", e))?;
    let mut warnings = warnings.into_inner();
    note_unknown_materials(source, &text, &names.into_inner(), &mut warnings);
    let mut scene = Scene::default();
    read_materials(source, materials, &mut scene, &mut warnings)?;
    add_models(source, models, &mut scene, &mut warnings);
    Ok(Loaded { scene, warnings })
}

/// Every index of every face lies in the list it refers to, as far as that has been filled.
/// (The format allows positive indices ahead of their vertex; nothing writes them, and `tobj`
/// resolves them at the end of the object, so the whole file's count is the bound for those.)
fn check_faces(source: &Source<'_>, text: &str) -> Result<(), SceneError> {
    let starts =
        |tag: &str| text.lines().filter(|l| l.split_whitespace().next() == Some(tag)).count();
    let totals = [starts("v"), starts("vt"), starts("vn")];
    let (mut so_far, mut face) = ([0usize; 3], 0usize);
    for (line, content) in text.lines().enumerate() {
        let mut words = content.split_whitespace();
        match words.next() {
            Some("v") => so_far[0] += 1,
            Some("vt") => so_far[1] += 1,
            Some("vn") => so_far[2] += 1,
            Some("f" | "l") => {
                for corner in words {
                    check_corner(corner, so_far, totals).map_err(|reason| {
                        source.error(format!("line {}, face {face}", line + 1), reason)
                    })?;
                }
                face += 1;
            }
            _ => {}
        }
    }
    Ok(())
}

fn check_corner(corner: &str, so_far: [usize; 3], totals: [usize; 3]) -> Result<(), String> {
    for (k, part) in corner.split('/').enumerate() {
        let what = ["vertex", "texture coordinate", "normal"];
        let (Some(what), true) = (what.get(k), k > 0 || !part.is_empty()) else {
            return Err(format!("\"{corner}\" is not of the form v/vt/vn"));
        };
        if part.is_empty() {
            continue;
        }
        let index: i64 = part.parse().map_err(|_| format!("\"{corner}\" is not an index"))?;
        let inside = match index {
            1.. => index as u64 <= totals[k] as u64,
            0 => false,
            _ => index.unsigned_abs() <= so_far[k] as u64,
        };
        if !inside {
            return Err(format!("{what} index {index}, but there are {}", totals[k]));
        }
    }
    Ok(())
}

/// The lines of a material library that matter, or none if it is absent.
fn read_mtl(
    source: &Source<'_>,
    library: &Path,
    warnings: &mut Vec<String>,
) -> Result<String, SceneError> {
    let path = source.folder.join(library);
    let Ok(bytes) = std::fs::read(&path) else {
        warnings.push(format!(
            "{}: material library \"{}\" is absent; materials are grey",
            source.file,
            library.display()
        ));
        return Ok(String::new());
    };
    let mut kept = String::new();
    for (i, line) in String::from_utf8_lossy(&bytes).lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let bad = |reason: &str| {
            SceneError::format(&path.display().to_string(), format!("line {}", i + 1), reason)
        };
        let number = |w: &&str| w.parse::<f32>().is_ok();
        match words.as_slice() {
            ["newmtl", name, ..] if !name.is_empty() => kept.push_str(line.trim()),
            ["Kd", rgb @ ..] if rgb.len() >= 3 && rgb[..3].iter().all(number) => {
                kept.push_str(&format!("Kd {} {} {}", rgb[0], rgb[1], rgb[2]));
            }
            ["Kd", "spectral" | "xyz", ..] => {}
            ["Kd", ..] => return Err(bad("Kd needs three numbers")),
            ["d", x] | ["d", "-halo", x] if number(x) => kept.push_str(&format!("d {x}")),
            ["Tr", x] => match x.parse::<f32>() {
                Ok(x) => kept.push_str(&format!("d {}", 1.0 - x)),
                Err(_) => return Err(bad("Tr needs a number")),
            },
            ["d", ..] => return Err(bad("d needs a number")),
            [map @ ("map_Kd" | "map_d"), .., _] => {
                let rest = line.trim()[map.len()..].trim();
                // Options come first; a file name with blanks is only possible without them.
                let file = if rest.starts_with('-') { words[words.len() - 1] } else { rest };
                kept.push_str(&format!("{map} {file}"));
            }
            [map, .., file]
                if map.starts_with("map_")
                    || matches!(*map, "bump" | "norm" | "disp" | "decal") =>
            {
                texture::note_if_absent(source, file, warnings);
            }
            _ => {}
        }
        kept.push('\n');
    }
    Ok(kept)
}

fn note_unknown_materials(
    source: &Source<'_>,
    text: &str,
    known: &BTreeMap<String, ()>,
    warnings: &mut Vec<String>,
) {
    let mut unknown = BTreeMap::new();
    for line in text.lines().filter_map(|l| l.trim().strip_prefix("usemtl ")) {
        if !known.contains_key(line.trim()) {
            unknown.insert(line.trim(), ());
        }
    }
    for name in unknown.keys() {
        warnings.push(format!("{}: material \"{name}\" is not defined; it is grey", source.file));
    }
}

fn read_materials(
    source: &Source<'_>,
    materials: Vec<tobj::Material>,
    scene: &mut Scene,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let mut textures: BTreeMap<String, Option<u32>> = BTreeMap::new();
    for m in materials {
        let mut load = |name: &Option<String>| -> Result<Option<u32>, SceneError> {
            let Some(name) = name else { return Ok(None) };
            if let Some(known) = textures.get(name) {
                return Ok(*known);
            }
            let index = texture::read(source, name, warnings)?.map(|t| {
                scene.textures.push(t);
                scene.textures.len() as u32 - 1
            });
            textures.insert(name.clone(), index);
            Ok(index)
        };
        let albedo_texture = load(&m.diffuse_texture)?;
        let alpha_texture = match load(&m.dissolve_texture)? {
            Some(t) => {
                // A map without an alpha channel carries it as grey levels.
                if let Some(map) = scene.textures.get_mut(t as usize)
                    && Some(t) != albedo_texture
                    && texture::min_alpha(map) == 255
                {
                    map.texels.iter_mut().for_each(|texel| texel[3] = texel[0]);
                }
                Some(t)
            }
            None => {
                albedo_texture.filter(|&t| texture::min_alpha(&scene.textures[t as usize]) < 255)
            }
        };
        scene.materials.push(Material {
            name: m.name,
            albedo: m.diffuse.map_or(Material::default().albedo, Vec3::from_array),
            opacity: m.dissolve.unwrap_or(1.0),
            alpha_test: alpha_texture.map(|texture| AlphaTest { texture, cutoff: CUTOFF }),
            albedo_texture,
        });
    }
    Ok(())
}

fn add_models(
    source: &Source<'_>,
    models: Vec<tobj::Model>,
    scene: &mut Scene,
    warnings: &mut Vec<String>,
) {
    let mut known: BTreeMap<(String, Option<usize>), usize> = BTreeMap::new();
    let mut default_material = None;
    for model in models.into_iter().filter(|m| !m.mesh.indices.is_empty()) {
        let m = model.mesh;
        let key = (model.name, m.material_id);
        let index = match known.get(&key) {
            Some(&index) => index,
            None => {
                let material = key.1.map(|m| m as u32).unwrap_or_else(|| {
                    *default_material.get_or_insert_with(|| {
                        scene.materials.push(Material::default());
                        scene.materials.len() as u32 - 1
                    })
                });
                let index = scene.meshes.len();
                scene.meshes.push(Mesh { name: key.0.clone(), material, ..Mesh::default() });
                let placed = Instance { mesh: index as u32, transform: DAffine3::IDENTITY };
                scene.instances.push(placed);
                known.insert(key, index);
                index
            }
        };
        append(source, &mut scene.meshes[index], &m, warnings);
    }
}

/// Joins a piece onto a mesh. Attributes that some corners lack are dropped for all.
fn append(source: &Source<'_>, mesh: &mut Mesh, m: &tobj::Mesh, warnings: &mut Vec<String>) {
    let (first, new) = (mesh.positions.len(), m.positions.len() / 3);
    let three = |v: &[f32]| v.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    mesh.positions.extend(three(&m.positions));
    let mut partial = |what: &str, had: usize, get: usize| {
        if (had, get) == (first, new) {
            return true;
        }
        if had + get > 0 {
            let name = &mesh.name;
            warnings.push(format!(
                "{}: mesh \"{name}\": some corners lack {what}; {what} are dropped",
                source.file
            ));
        }
        false
    };
    if partial("normals", mesh.normals.len(), m.normals.len() / 3) {
        mesh.normals.extend(three(&m.normals));
    } else {
        mesh.normals.clear();
    }
    if partial("uvs", mesh.uvs.len(), m.texcoords.len() / 2) {
        // OBJ counts v from the bottom of the image, scenes from the top.
        mesh.uvs.extend(m.texcoords.chunks_exact(2).map(|t| Vec2::new(t[0], 1.0 - t[1])));
    } else {
        mesh.uvs.clear();
    }
    let first = first as u32;
    mesh.triangles.extend(m.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| t[k] + first)));
}
