//! Triangles as a light's map sees them: what every rasteriser of such a map takes.

use bytemuck::{Pod, Zeroable};
use thiserror::Error;

/// A corner of a triangle, seen from the light. 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightSpaceVertex {
    /// `[u * w, v * w, w]`: map coordinates (0..=1 inside the map, v down) times `w`. `w` is 1 for
    /// parallel light, and the distance along the light's axis, in any unit, for a perspective
    /// one: affine in world space, negative behind the light.
    pub position: [f32; 3],
    /// Linear depth, 0 at the near plane and 1 at the far plane; fragments outside are dropped.
    pub z: f32,
    /// Texture coordinates for the alpha test.
    pub uv: [f32; 2],
}

/// A cut-out texture, read at the nearest texel and repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaTexture {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` alphas in 0..=1, from v = 0 on.
    pub alpha: Vec<f32>,
}

/// Triangles that share an alpha test and an opacity.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleGroup {
    /// First index of the group.
    pub first: u32,
    /// Number of indices, a multiple of 3.
    pub count: u32,
    /// Index into [`LightSpaceMesh::textures`] and the alpha below which there is a hole.
    pub alpha: Option<(u32, f32)>,
    /// 1 for opaque triangles, below that what they absorb of the light.
    pub opacity: f32,
}

/// What a light sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightSpaceMesh {
    /// Corners.
    pub vertices: Vec<LightSpaceVertex>,
    /// Three a triangle, of either winding.
    pub indices: Vec<u32>,
    /// Ranges of `indices`; those in no group are not drawn.
    pub groups: Vec<TriangleGroup>,
    /// Cut-out textures.
    pub textures: Vec<AlphaTexture>,
}

/// Why a mesh cannot be rasterised.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum LightSpaceError {
    /// A vertex with a NaN or infinite component.
    #[error("vertex {vertex} is not finite")]
    Vertex {
        /// Index into the vertices.
        vertex: usize,
    },
    /// An index beyond the vertices.
    #[error("index {place} is {index}, but there are {vertices} vertices")]
    Index {
        /// Place in the indices.
        place: usize,
        /// What stands there.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A group whose range is not whole triangles of the mesh, or whose texture does not exist.
    #[error("triangle group {group} does not fit the mesh: {why}")]
    Group {
        /// Index into the groups.
        group: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// A texture whose size and alphas disagree, or that is empty.
    #[error(
        "alpha texture {texture} should hold {expected} (and at least 1) alphas and holds {actual}"
    )]
    Texture {
        /// Index into the textures.
        texture: usize,
        /// `width * height`, which must not be 0.
        expected: u64,
        /// Alphas given.
        actual: usize,
    },
}

impl LightSpaceMesh {
    /// Checks every vertex, index, group and texture.
    ///
    /// # Errors
    /// The [`LightSpaceError`] that names the first bad element.
    pub fn check(&self) -> Result<(), LightSpaceError> {
        let finite = |v: &LightSpaceVertex| {
            v.position.iter().chain(&[v.z]).chain(&v.uv).all(|component| component.is_finite())
        };
        if let Some(vertex) = self.vertices.iter().position(|v| !finite(v)) {
            return Err(LightSpaceError::Vertex { vertex });
        }
        let vertices = self.vertices.len();
        if let Some(place) = self.indices.iter().position(|&i| i as usize >= vertices) {
            return Err(LightSpaceError::Index { place, index: self.indices[place], vertices });
        }
        for (texture, t) in self.textures.iter().enumerate() {
            let expected = u64::from(t.width) * u64::from(t.height);
            if expected == 0 || t.alpha.len() as u64 != expected {
                return Err(LightSpaceError::Texture { texture, expected, actual: t.alpha.len() });
            }
        }
        for (group, g) in self.groups.iter().enumerate() {
            let end = u64::from(g.first) + u64::from(g.count);
            let why = if end > self.indices.len() as u64 {
                "it reaches beyond the last index"
            } else if !g.count.is_multiple_of(3) {
                "its indices are no whole triangles"
            } else if g.alpha.is_some_and(|(texture, _)| texture as usize >= self.textures.len()) {
                "its alpha texture does not exist"
            } else if g.alpha.is_some_and(|(_, cutoff)| !cutoff.is_finite()) {
                "its alpha cutoff is not finite"
            } else if !(0.0..=1.0).contains(&g.opacity) {
                "its opacity is not in 0..=1"
            } else {
                continue;
            };
            return Err(LightSpaceError::Group { group, why });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> LightSpaceMesh {
        let corner = LightSpaceVertex { position: [0.5, 0.5, 1.0], z: 0.5, uv: [0.0; 2] };
        LightSpaceMesh {
            vertices: vec![corner; 3],
            indices: vec![0, 1, 2],
            groups: vec![TriangleGroup { first: 0, count: 3, alpha: None, opacity: 1.0 }],
            textures: Vec::new(),
        }
    }

    #[test]
    fn a_vertex_has_24_bytes() {
        assert_eq!(size_of::<LightSpaceVertex>(), 24);
    }

    #[test]
    fn bad_meshes_are_refused_with_the_element() {
        assert_eq!(mesh().check(), Ok(()));
        let mut m = mesh();
        m.vertices[2].z = f32::NAN;
        assert_eq!(m.check(), Err(LightSpaceError::Vertex { vertex: 2 }));
        let mut m = mesh();
        m.indices[1] = 3;
        let error = LightSpaceError::Index { place: 1, index: 3, vertices: 3 };
        assert_eq!(m.check(), Err(error));
        for (first, count, alpha) in
            [(0, 6, None), (1, 3, None), (0, 2, None), (0, 3, Some((0, 0.5))), (u32::MAX, 3, None)]
        {
            let mut m = mesh();
            m.groups.push(TriangleGroup { first, count, alpha, opacity: 1.0 });
            assert!(matches!(m.check(), Err(LightSpaceError::Group { group: 1, .. })));
        }
        for opacity in [-0.1, 1.1, f32::NAN] {
            let mut m = mesh();
            m.groups[0].opacity = opacity;
            assert!(matches!(m.check(), Err(LightSpaceError::Group { group: 0, .. })));
        }
        let mut m = mesh();
        m.textures.push(AlphaTexture { width: 2, height: 2, alpha: vec![1.0; 3] });
        let error = LightSpaceError::Texture { texture: 0, expected: 4, actual: 3 };
        assert_eq!(m.check(), Err(error));
        m.textures[0] = AlphaTexture { width: 0, height: 2, alpha: Vec::new() };
        assert!(matches!(m.check(), Err(LightSpaceError::Texture { .. })));
        m.textures[0] = AlphaTexture { width: 0, height: 2, alpha: vec![1.0] };
        assert!(matches!(m.check(), Err(LightSpaceError::Texture { .. })));
    }
}
