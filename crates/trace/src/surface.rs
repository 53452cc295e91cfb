//! What a hit lies on.

use crate::tracer::{Hit, Ray, Tracer, UNTRACED};
use glam::{DVec3, Vec2};

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// World space, metres.
    pub position: DVec3,
    /// Of the triangle's plane, unit length, on the side the ray came from.
    pub normal: DVec3,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in the instance's mesh.
    pub triangle_in_mesh: u32,
    /// Index of the placed triangle, as in [`Hit::triangle`].
    pub triangle: u32,
    /// Index of the material.
    pub material: u32,
    /// Interpolated texture coordinates; 0 for a mesh without.
    pub uv: Vec2,
}

impl Tracer {
    /// The unit normal of a traced triangle's plane, on the side its winding turns it to.
    pub(crate) fn normal(&self, triangle: u32) -> Option<DVec3> {
        let slot = *self.slot_of_triangle.get(triangle as usize)?;
        let [a, b, c] = self.leaves.get(slot as usize)?.corners.map(DVec3::from_array);
        Some((b - a).cross(c - a).normalize_or_zero())
    }

    /// The surface at a hit of this tracer. A hit of another scene, on a triangle that is not here,
    /// gives a position and a normal that are not numbers.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let nowhere = Surface {
            position: DVec3::NAN,
            normal: DVec3::NAN,
            instance: u32::MAX,
            triangle_in_mesh: u32::MAX,
            triangle: hit.triangle,
            material: u32::MAX,
            uv: Vec2::ZERO,
        };
        let slot = self.slot_of_triangle.get(hit.triangle as usize).copied().unwrap_or(UNTRACED);
        let Some(leaf) = self.leaves.get(slot as usize) else {
            return nowhere;
        };
        // The last instance that starts at or before the triangle; those without triangles share
        // their start with the next one.
        let instance = self.instance_starts.partition_point(|&s| s <= hit.triangle) - 1;
        let triangle_in_mesh = hit.triangle - self.instance_starts[instance];
        let mesh = &self.mesh_uvs[self.instance_meshes[instance] as usize];
        let uv = mesh.triangles.get(triangle_in_mesh as usize).map_or(Vec2::ZERO, |corners| {
            let [a, b, c] = corners.map(|v| mesh.uvs[v as usize].as_dvec2());
            (a + (b - a) * hit.u + (c - a) * hit.v).as_vec2()
        });
        let [a, b, c] = leaf.corners.map(DVec3::from_array);
        let normal = self.normal(hit.triangle).unwrap_or(DVec3::NAN);
        let away = normal.dot(ray.direction) > 0.0;
        Surface {
            position: self.space.leave(a + (b - a) * hit.u + (c - a) * hit.v),
            normal: if away { -normal } else { normal },
            instance: instance as u32,
            triangle_in_mesh,
            triangle: hit.triangle,
            material: mesh.material,
            uv,
        }
    }
}
