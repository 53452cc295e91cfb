//! Objects on the device, uploaded once.
//!
//! Six storage buffers, group 0 of every shader that imports `common/occlusion_scene.wgsl`:
//!
//! | binding | holds | bytes |
//! |---|---|---|
//! | 0 | positions of the templates' corners | 12 a corner |
//! | 1 | texture coordinates, of templates with a mask | 8 a corner |
//! | 2 | triangles: three indices into binding 0 | 12 a triangle |
//! | 3 | templates: where their parts begin, mask, albedo | 40 a template |
//! | 4 | objects: placement, template, box | 76 an object |
//! | 5 | words of the masks | 4 a word |

use crate::OcclusionError;
use crate::camera::Objects;
use crate::camera::software::check;
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout_of, whole};
use dapple_gpu::{Gpu, GpuError, wgpu};
use glam::{Vec2, Vec3};

/// Mirrors `Shape` of `common/occlusion_scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Shape {
    first_triangle: u32,
    triangles: u32,
    first_corner: u32,
    first_uv: u32,
    first_word: u32,
    mask_width: u32,
    mask_height: u32,
    albedo: [f32; 3],
}

/// Mirrors `Object` of `common/occlusion_scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Placed {
    linear: [f32; 9],
    translation: [f32; 3],
    shape: u32,
    low: [f32; 3],
    high: [f32; 3],
}

/// What the host has to know of an object to draw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Drawn {
    /// Its template.
    pub template: u32,
    /// Triangles of the template.
    pub triangles: u32,
    /// Whether the template is alpha-tested.
    pub masked: bool,
}

/// Objects on the device. Clones share the buffers.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Layout of group 0.
    pub(crate) layout: wgpu::BindGroupLayout,
    /// Group 0.
    pub(crate) group: wgpu::BindGroup,
    /// Template and draw size of every object.
    objects: std::sync::Arc<[Drawn]>,
    triangles: u64,
    stored_triangles: u64,
    bytes: u64,
    object_bytes: u64,
}

impl Scene {
    /// Uploads `objects`.
    ///
    /// # Errors
    /// An index that points nowhere, a number that is not finite, a mask without texels, more than
    /// 2^32 / 3 corners or triangles, or a buffer over a limit of the device, each by name.
    pub fn new(gpu: &Gpu, objects: &Objects) -> Result<Self, OcclusionError> {
        check::objects(objects)?;
        index("objects", objects.objects.len())?;
        let drawn = drawn(objects);
        let mut parts = Parts::default();
        let mask_starts = parts.add_masks(objects);
        for template in &objects.templates {
            parts.add(template, objects, &mask_starts)?;
        }
        let placed: Vec<Placed> = objects.objects.iter().map(placed).collect();
        let buffers = [
            upload(gpu, "positions", &parts.positions)?,
            upload(gpu, "texture coordinates", &parts.uvs)?,
            upload(gpu, "triangles", &parts.triangles)?,
            upload(gpu, "templates", &parts.shapes)?,
            upload(gpu, "objects", &placed)?,
            upload(gpu, "masks", &parts.words)?,
        ];
        let stages = wgpu::ShaderStages::all();
        let layout = layout_of(gpu, "occlusion scene", &[(stages, Slot::Read); 6]);
        let group = bind(gpu, &layout, &buffers.each_ref().map(whole));
        gpu.check()?;
        Ok(Self {
            layout,
            group,
            triangles: drawn.iter().map(|d| u64::from(d.triangles)).sum(),
            stored_triangles: parts.triangles.len() as u64,
            objects: drawn.into(),
            bytes: buffers.iter().map(wgpu::Buffer::size).sum(),
            object_bytes: size_of_val(&placed[..]) as u64,
        })
    }

    /// Objects.
    #[must_use]
    pub fn objects(&self) -> u32 {
        self.objects.len() as u32
    }

    /// Template and draw size of every object.
    pub(crate) fn drawn(&self) -> &[Drawn] {
        &self.objects
    }

    /// Triangles of all objects.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Triangles that are stored: those of templates, which objects share.
    #[must_use]
    pub fn stored_triangles(&self) -> u64 {
        self.stored_triangles
    }

    /// Bytes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Bytes of those that objects take, 76 each; the rest are templates and masks.
    #[must_use]
    pub fn object_bytes(&self) -> u64 {
        self.object_bytes
    }
}

/// The templates' parts, one after the other.
#[derive(Default)]
struct Parts {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    shapes: Vec<Shape>,
    words: Vec<u32>,
}

impl Parts {
    /// The first word of each mask.
    fn add_masks(&mut self, objects: &Objects) -> Vec<u32> {
        let add = |mask: &crate::camera::Mask| {
            let first = self.words.len() as u32;
            self.words.extend(&mask.words);
            first
        };
        objects.masks.iter().map(add).collect()
    }

    fn add(
        &mut self,
        template: &crate::camera::Template,
        objects: &Objects,
        mask_starts: &[u32],
    ) -> Result<(), OcclusionError> {
        index("corners", self.positions.len() + template.positions.len())?;
        let first_corner = self.positions.len() as u32;
        let mut shape = Shape {
            first_triangle: index("triangles", self.triangles.len())?,
            triangles: index("triangles of a template", template.triangles.len())?,
            first_corner,
            first_uv: self.uvs.len() as u32,
            albedo: template.albedo.into(),
            ..Shape::default()
        };
        if let Some(mask) = template.mask {
            let texels = &objects.masks[mask as usize];
            shape.first_word = mask_starts[mask as usize];
            (shape.mask_width, shape.mask_height) = (texels.width, texels.height);
            self.uvs.extend(&template.uvs);
        }
        self.shapes.push(shape);
        self.positions.extend(&template.positions);
        let corners = template.triangles.iter().map(|t| t.map(|c| first_corner + c));
        self.triangles.extend(corners);
        Ok(())
    }
}

fn placed(object: &crate::camera::Object) -> Placed {
    Placed {
        linear: object.linear.to_cols_array(),
        translation: object.translation.into(),
        shape: object.template,
        low: object.bounds.min.into(),
        high: object.bounds.max.into(),
    }
}

/// A buffer that holds `data`, or one zero: a binding of no elements is refused.
pub(crate) fn upload<T: Pod>(gpu: &Gpu, label: &str, data: &[T]) -> Result<wgpu::Buffer, GpuError> {
    if data.is_empty() { gpu.upload(label, &[T::zeroed()]) } else { gpu.upload(label, data) }
}

/// The shaders compute with 32-bit indices, of three numbers a corner.
fn index(what: &str, count: usize) -> Result<u32, OcclusionError> {
    const MOST: usize = (u32::MAX / 3) as usize;
    if count > MOST {
        return Err(OcclusionError::value(what, format!("{count}, at most {MOST}")));
    }
    Ok(count as u32)
}

/// What the host has to know of each object, all of whose indices were checked.
fn drawn(objects: &Objects) -> Vec<Drawn> {
    let drawn = |object: &crate::camera::Object| {
        let template = &objects.templates[object.template as usize];
        Drawn {
            template: object.template,
            triangles: template.triangles.len() as u32,
            masked: template.mask.is_some(),
        }
    };
    objects.objects.iter().map(drawn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::gpu::mirror;

    const DRAW: &str = "occlusion/draw.wgsl";

    #[test]
    fn structs_have_the_layout_of_the_shader() {
        let shape = [
            ("first_triangle", 0),
            ("triangles", 4),
            ("first_corner", 8),
            ("first_uv", 12),
            ("first_word", 16),
            ("mask_width", 20),
            ("mask_height", 24),
            ("albedo", 28),
        ];
        mirror::<Shape>(DRAW, "Shape", &shape);
        let object = [("linear", 0), ("translation", 36), ("shape", 48), ("low", 52), ("high", 64)];
        mirror::<Placed>(DRAW, "Object", &object);
    }
}
