//! PLY, ASCII and binary of either byte order. Vertices with `x y z`, optionally `nx ny nz` and
//! `u v` or `s t`; faces with `vertex_indices` or `vertex_index`, triangulated as fans.

use super::ply_payload::Payload;
use super::{Loaded, Source};
use crate::{Instance, Material, Mesh, Scene, SceneError};
use glam::{DAffine3, Vec2, Vec3};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, ElementDef, PropertyType};

pub fn parse(source: &Source<'_>) -> Result<Loaded, SceneError> {
    let mut rest = source.bytes;
    let header = Parser::<DefaultElement>::new()
        .read_header(&mut rest)
        .map_err(|e| source.error("PLY header", e))?;
    let mut payload = Payload::new(header.encoding, rest);
    let mut mesh = Mesh { name: "ply".into(), ..Mesh::default() };
    for (name, element) in &header.elements {
        // Each item takes a byte at least (a line end, in text), so a false count ends at once.
        let have = payload.remaining();
        if !element.properties.is_empty() && element.count > have {
            let reason = format!("{} items, but only {have} bytes are left", element.count);
            return Err(source.error(format!("element {name}"), reason));
        }
        match name.as_str() {
            "vertex" => vertices(source, element, &mut payload, &mut mesh)?,
            "face" => faces(source, element, &mut payload, &mut mesh)?,
            _ => skip(source, element, &mut payload)?,
        }
    }
    let instance = Instance { mesh: 0, transform: DAffine3::IDENTITY };
    let scene = Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        instances: vec![instance],
        ..Scene::default()
    };
    Ok(Loaded { scene, warnings: vec![] })
}

/// Reads one element's items; `each` gets (item number, property values, list values).
fn items(
    source: &Source<'_>,
    element: &ElementDef,
    payload: &mut Payload<'_>,
    list: usize,
    mut each: impl FnMut(usize, &[f64], &[f64]) -> Result<(), String>,
) -> Result<(), SceneError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let (mut scalars, mut wanted, mut other) = (vec![], vec![], vec![]);
    for i in 0..element.count {
        scalars.clear();
        wanted.clear();
        let fail = |reason: String| source.error(format!("{} {i}", element.name), reason);
        for (k, property) in element.properties.values().enumerate() {
            let list = if k == list { &mut wanted } else { &mut other };
            let value = payload.property(&property.data_type, list).map_err(fail)?;
            scalars.push(value);
        }
        payload.end_of_item();
        each(i, &scalars, &wanted).map_err(fail)?;
    }
    Ok(())
}

fn skip(
    source: &Source<'_>,
    element: &ElementDef,
    payload: &mut Payload<'_>,
) -> Result<(), SceneError> {
    items(source, element, payload, usize::MAX, |_, _, _| Ok(()))
}

fn vertices(
    source: &Source<'_>,
    element: &ElementDef,
    payload: &mut Payload<'_>,
    mesh: &mut Mesh,
) -> Result<(), SceneError> {
    let place = |name: &str| element.properties.get_index_of(name);
    let all = |names: &[&str]| names.iter().map(|n| place(n)).collect::<Option<Vec<_>>>();
    let Some(xyz) = all(&["x", "y", "z"]) else {
        return Err(source.error("element vertex", "lacks one of the properties x, y, z"));
    };
    let normal = all(&["nx", "ny", "nz"]);
    let uv =
        all(&["u", "v"]).or_else(|| all(&["s", "t"])).or_else(|| all(&["texture_u", "texture_v"]));
    items(source, element, payload, usize::MAX, |_, values, _| {
        let at = |k: usize| values[k] as f32;
        mesh.positions.push(Vec3::new(at(xyz[0]), at(xyz[1]), at(xyz[2])));
        if let Some(n) = &normal {
            mesh.normals.push(Vec3::new(at(n[0]), at(n[1]), at(n[2])));
        }
        if let Some(t) = &uv {
            // PLY writers count v from the bottom of the image, scenes from the top.
            mesh.uvs.push(Vec2::new(at(t[0]), 1.0 - at(t[1])));
        }
        Ok(())
    })
}

fn faces(
    source: &Source<'_>,
    element: &ElementDef,
    payload: &mut Payload<'_>,
    mesh: &mut Mesh,
) -> Result<(), SceneError> {
    let list = ["vertex_indices", "vertex_index"].iter().find_map(|name| {
        let (k, _, property) = element.properties.get_full(*name)?;
        matches!(property.data_type, PropertyType::List(..)).then_some(k)
    });
    let Some(list) = list else {
        return Err(source.error("element face", "lacks a list vertex_indices or vertex_index"));
    };
    let n = mesh.positions.len();
    items(source, element, payload, list, |_, _, corners| {
        if let Some(bad) =
            corners.iter().find(|&&x| !(x >= 0.0 && x < n as f64 && x.fract() == 0.0))
        {
            return Err(format!("vertex index {bad}, but there are {n} vertices"));
        }
        let index = |k: usize| corners[k] as u32;
        let fan = 1..corners.len().saturating_sub(1);
        mesh.triangles.extend(fan.map(|k| [index(0), index(k), index(k + 1)]));
        Ok(())
    })
}
