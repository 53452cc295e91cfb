//! Primitives: each becomes one mesh.

use super::Reader;
use crate::{Material, Mesh, SceneError};
use glam::{Vec2, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

impl Reader<'_> {
    /// The scene's meshes of glTF mesh `index`, built when first met.
    pub(super) fn meshes_of(&mut self, index: usize) -> Result<Vec<u32>, SceneError> {
        if let Some(known) = self.meshes.get(&index) {
            return Ok(known.clone());
        }
        let Some(mesh) = self.root.meshes.get(index).cloned() else {
            return Err(self.error(format!("mesh {index}"), "does not exist"));
        };
        let name = mesh.name.unwrap_or_else(|| format!("mesh{index}"));
        let mut made = vec![];
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let label = match mesh.primitives.len() {
                1 => name.clone(),
                _ => format!("{name}#{p}"),
            };
            if let Some(mesh) = self.primitive(&label, primitive)? {
                made.push(self.scene.meshes.len() as u32);
                self.scene.meshes.push(mesh);
            }
        }
        self.meshes.insert(index, made.clone());
        Ok(made)
    }

    fn primitive(&mut self, name: &str, p: &Primitive) -> Result<Option<Mesh>, SceneError> {
        let element = format!("mesh \"{name}\"");
        let mode = match p.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            _ => {
                self.warn(format!("{element} has points or lines; they are ignored"));
                return Ok(None);
            }
        };
        let attribute = |s: Semantic| p.attributes.get(&Checked::Valid(s)).copied();
        let Some(positions) = attribute(Semantic::Positions) else {
            self.warn(format!("{element} has no positions; it is ignored"));
            return Ok(None);
        };
        let material = self.material_of(p)?;
        let uv_set = self.uv_sets.get(material as usize).copied().unwrap_or(0);
        let positions = self.vectors::<3>(positions, "positions")?;
        let normals = match attribute(Semantic::Normals) {
            Some(a) => self.vectors::<3>(a, "normals")?,
            None => vec![],
        };
        let uvs = match attribute(Semantic::TexCoords(uv_set)) {
            Some(a) => self.vectors::<2>(a, "texture coordinates")?,
            None => vec![],
        };
        let corners = match p.indices {
            Some(a) => self.indices(a)?,
            None => (0..positions.len() as u32).collect(),
        };
        let n = positions.len();
        if let Some((i, &v)) = corners.iter().enumerate().find(|&(_, &v)| v as usize >= n) {
            let reason = format!("vertex index {v}, but there are {n} vertices");
            return Err(self.error(format!("{element}, corner {i} (triangle {})", i / 3), reason));
        }
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            let reason = format!("{} corners are no whole number of triangles", corners.len());
            return Err(self.error(element, reason));
        }
        Ok(Some(Mesh {
            name: name.into(),
            positions: positions.into_iter().map(Vec3::from_array).collect(),
            normals: normals.into_iter().map(Vec3::from_array).collect(),
            uvs: uvs.into_iter().map(Vec2::from_array).collect(),
            triangles: triangles(mode, &corners),
            material,
        }))
    }

    fn material_of(&mut self, p: &Primitive) -> Result<u32, SceneError> {
        match p.material {
            Some(m) if m.value() < self.root.materials.len() => Ok(m.value() as u32),
            Some(m) => Err(self.error(format!("material {}", m.value()), "does not exist")),
            None => Ok(*self.default_material.get_or_insert_with(|| {
                self.scene.materials.push(Material::default());
                self.scene.materials.len() as u32 - 1
            })),
        }
    }
}

/// Corners to triangles; strips flip every other one so that all wind alike.
fn triangles(mode: Mode, c: &[u32]) -> Vec<[u32; 3]> {
    let last = c.len().saturating_sub(2);
    match mode {
        Mode::TriangleStrip => {
            (0..last)
                .map(|i| {
                    if i % 2 == 0 { [c[i], c[i + 1], c[i + 2]] } else { [c[i + 1], c[i], c[i + 2]] }
                })
                .collect()
        }
        Mode::TriangleFan => (0..last).map(|i| [c[0], c[i + 1], c[i + 2]]).collect(),
        _ => c.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_wind_alike() {
        let quad = [0, 1, 2, 3];
        assert_eq!(triangles(Mode::TriangleStrip, &quad), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(triangles(Mode::TriangleFan, &quad), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 2, 1, 3]), [[0, 1, 2], [2, 1, 3]]);
        assert!(triangles(Mode::TriangleStrip, &[0]).is_empty());
    }
}
