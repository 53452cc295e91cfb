//! Surfaces of a CityJSON geometry: rings of vertices, what they mean, their triangles.

use super::model::{Geometry, Semantics};
use glam::{DVec2, DVec3};
use serde_json::Value;

/// What a surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The underside.
    Ground,
    Wall,
    Roof,
}

/// One planar polygon, world space.
pub struct Surface {
    /// The outer ring, then holes.
    pub rings: Vec<Vec<DVec3>>,
    /// By its semantics; otherwise by where it faces.
    pub role: Role,
}

/// Slower than this the normal rises: a wall.
const STEEP: f64 = 0.1;

/// The surfaces of a geometry: outer shells of solids, or surfaces as they are. Also gives the number
/// of inner shells (cavities) that are left aside and of surfaces without area.
///
/// # Errors
/// Element and reason: another nesting than the type asks for, an index out of range.
pub fn surfaces(
    geometry: &Geometry,
    vertices: &[DVec3],
) -> Result<(Vec<Surface>, [u64; 2]), (String, String)> {
    let mut found = Found { surfaces: vec![], cavities: 0, flat: 0, vertices };
    let semantics = geometry.semantics.as_ref();
    let values = semantics.map_or(&Value::Null, |s| &s.values);
    match geometry.kind.as_str() {
        "MultiSurface" | "CompositeSurface" => {
            found.shell(&geometry.boundaries, semantics, values)?
        }
        "Solid" => found.solid(&geometry.boundaries, semantics, values)?,
        "MultiSolid" | "CompositeSolid" => {
            for (i, solid) in list(&geometry.boundaries, "boundaries")?.iter().enumerate() {
                found.solid(solid, semantics, child(values, i))?;
            }
        }
        other => return Err(("geometry".into(), format!("type \"{other}\" is not read here"))),
    }
    Ok((found.surfaces, [found.cavities, found.flat]))
}

struct Found<'a> {
    surfaces: Vec<Surface>,
    cavities: u64,
    flat: u64,
    vertices: &'a [DVec3],
}

impl Found<'_> {
    fn solid(
        &mut self,
        shells: &Value,
        semantics: Option<&Semantics>,
        values: &Value,
    ) -> Result<(), (String, String)> {
        let shells = list(shells, "solid")?;
        if let Some(outer) = shells.first() {
            self.shell(outer, semantics, child(values, 0))?;
            self.cavities += shells.len() as u64 - 1;
        }
        Ok(())
    }

    fn shell(
        &mut self,
        surfaces: &Value,
        semantics: Option<&Semantics>,
        values: &Value,
    ) -> Result<(), (String, String)> {
        for (i, surface) in list(surfaces, "shell")?.iter().enumerate() {
            let label = || format!("surface {i}");
            let mut rings = vec![];
            for ring in list(surface, "surface")? {
                let mut corners = Vec::with_capacity(4);
                for index in list(ring, "ring")? {
                    let count = self.vertices.len();
                    let vertex = index.as_u64().and_then(|k| self.vertices.get(k as usize));
                    corners.push(*vertex.ok_or_else(|| {
                        (label(), format!("vertex index {index}, but there are {count} vertices"))
                    })?);
                }
                rings.push(corners);
            }
            let Some(normal) = rings.first().and_then(|r| normal(r)) else {
                self.flat += 1;
                continue;
            };
            rings.retain(|ring| ring.len() >= 3);
            let stated = match (semantics, child(values, i)) {
                (None, _) | (_, Value::Null) => None,
                (Some(semantics), index) => {
                    let count = semantics.surfaces.len();
                    let surface = index.as_u64().and_then(|k| semantics.surfaces.get(k as usize));
                    let surface = surface.ok_or_else(|| {
                        (label(), format!("semantic surface {index}, but there are {count}"))
                    })?;
                    role(&surface.kind)
                }
            };
            let facing = match normal.y {
                y if y > STEEP => Role::Roof,
                y if y < -STEEP => Role::Ground,
                _ => Role::Wall,
            };
            self.surfaces.push(Surface { rings, role: stated.unwrap_or(facing) });
        }
        Ok(())
    }
}

/// The role that a semantic type names; the rest goes by where it faces.
fn role(kind: &str) -> Option<Role> {
    match kind {
        "GroundSurface" => Some(Role::Ground),
        "WallSurface" => Some(Role::Wall),
        "RoofSurface" => Some(Role::Roof),
        _ => None,
    }
}

fn list<'a>(value: &'a Value, what: &str) -> Result<&'a [Value], (String, String)> {
    match value {
        Value::Array(items) => Ok(items),
        other => {
            let mut text = other.to_string();
            if text.chars().count() > 40 {
                text = text.chars().take(40).chain("...".chars()).collect();
            }
            Err((what.into(), format!("{text} stands where a list is needed")))
        }
    }
}

/// Item `i` of a list of semantics, which may end early or be absent.
fn child(value: &Value, i: usize) -> &Value {
    value.get(i).unwrap_or(&Value::Null)
}

/// Unit normal of a ring by Newell's sum, or none for a ring without area.
fn normal(ring: &[DVec3]) -> Option<DVec3> {
    let first = *ring.first()?;
    let corner = |i: usize| ring[i % ring.len()] - first;
    let sum: DVec3 = (0..ring.len()).map(|i| corner(i).cross(corner(i + 1))).sum();
    // A square of a hundredth of a millimetre.
    (sum.length() > 1e-10).then(|| sum.normalize())
}

impl Surface {
    /// Triangles, turned as the outer ring is.
    pub fn triangles(&self) -> Vec<[DVec3; 3]> {
        let Some(normal) = self.rings.first().and_then(|r| normal(r)) else { return vec![] };
        let corners: Vec<DVec3> = self.rings.iter().flatten().copied().collect();
        if let ([a, b, c], 1) = (&corners[..], self.rings.len()) {
            return vec![[*a, *b, *c]];
        }
        // Seen along the normal: any two directions that span the plane will do.
        let first = corners[0];
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let plan = |p: DVec3| DVec2::new((p - first).dot(u), (p - first).dot(v));
        let mut starts = vec![];
        let mut end = 0;
        for ring in &self.rings[..self.rings.len() - 1] {
            end += ring.len() as u32;
            starts.push(end);
        }
        let mut indices: Vec<u32> = vec![];
        let flat = corners.iter().map(|&p| plan(p).to_array());
        earcut::Earcut::new().earcut(flat, &starts, &mut indices);
        let mut triangles = vec![];
        for t in indices.chunks_exact(3) {
            let mut t = [t[0], t[1], t[2]].map(|i| corners[i as usize]);
            if (t[1] - t[0]).cross(t[2] - t[0]).dot(normal) < 0.0 {
                t.swap(1, 2);
            }
            triangles.push(t);
        }
        triangles
    }
}
