//! What may be drawn: templates, and objects that place them.

mod build;
mod check;
mod clusters;
#[cfg(test)]
mod tests;

use glam::{DVec3, Mat3, Vec2, Vec3};

pub use build::NOT_DRAWN;

/// Everything that may be drawn.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    /// World-space point that all f32 coordinates are relative to.
    pub origin: DVec3,
    /// Triangles, shared by the objects that place them.
    pub templates: Vec<Template>,
    /// The units of culling.
    pub objects: Vec<Object>,
    /// Which texels of an alpha-tested texture are there.
    pub masks: Vec<Mask>,
}

/// Indexed triangles in a space of their own.
#[derive(Clone, Debug, Default)]
pub struct Template {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Texture coordinates, one a corner where there is a mask; else empty.
    pub uvs: Vec<Vec2>,
    /// Indices of corners; both sides are seen.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Objects::masks`]. Objects of such a template never occlude.
    pub mask: Option<u32>,
    /// Diffuse reflectance, linear RGB.
    pub albedo: Vec3,
}

/// One placement of a template.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// Index into [`Objects::templates`].
    pub template: u32,
    /// Template space to local space: linear part.
    pub linear: Mat3,
    /// Template space to local space: translation.
    pub translation: Vec3,
    /// Holds the placed triangles in whatever order a form rounds, and the scene's own in f64.
    pub bounds: Bounds,
}

/// A texture's texels that pass its alpha test, one bit each, nearest sampling, repeating.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bit `i` of the words is texel `i`, rows top to bottom.
    pub words: Vec<u32>,
}

/// An axis-aligned box in local space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box of nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it is the box of nothing.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The box with all sides moved out by `margin` metres, rounded outwards.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self::around(self.min.as_dvec3() - margin, self.max.as_dvec3() + margin)
    }

    /// The smallest box in f32 that holds the one from `min` to `max`.
    pub fn around(min: DVec3, max: DVec3) -> Self {
        let low = min.to_array().map(round_down);
        let high = max.to_array().map(round_up);
        Self { min: Vec3::from_array(low), max: Vec3::from_array(high) }
    }

    /// Area of the six faces, 0 for the box of nothing.
    pub fn surface_area(&self) -> f32 {
        let d = (self.max - self.min).max(Vec3::ZERO);
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }

    /// Whether `p` is inside or on the border.
    pub fn contains(&self, p: Vec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// Middle of the box.
    pub fn centre(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// The eight corners; bit 0 of the index is x, bit 1 y, bit 2 z.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 0 { lo } else { hi };
            Vec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }
}

/// The greatest f32 that is not above `x`.
pub(crate) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The least f32 that is not below `x`.
pub(crate) fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

impl Mask {
    /// Whether the texel nearest to `uv` is there.
    pub fn at(&self, uv: Vec2) -> bool {
        let wrap = |t: f32, n: u32| (((t - t.floor()) * n as f32) as u32).min(n - 1);
        let texel = wrap(uv.y, self.height) * self.width + wrap(uv.x, self.width);
        self.words[(texel / 32) as usize] >> (texel % 32) & 1 == 1
    }
}

impl Objects {
    /// Triangles of object `index`, local space.
    pub fn triangles(&self, index: u32) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        let object = &self.objects[index as usize];
        let template = &self.templates[object.template as usize];
        template
            .triangles
            .iter()
            .map(move |t| t.map(|c| object.place(template.positions[c as usize])))
    }

    /// Number of triangles of object `index`.
    pub fn triangle_count(&self, index: u32) -> u32 {
        let object = &self.objects[index as usize];
        self.templates[object.template as usize].triangles.len() as u32
    }

    /// Whether object `index` may hide others.
    pub fn occludes(&self, index: u32) -> bool {
        let object = &self.objects[index as usize];
        self.templates[object.template as usize].mask.is_none()
    }

    /// Bytes that the objects, templates and masks take.
    pub fn bytes(&self) -> u64 {
        let template = |t: &Template| {
            (size_of_val(&t.positions[..])
                + size_of_val(&t.uvs[..])
                + size_of_val(&t.triangles[..])) as u64
        };
        size_of_val(&self.objects[..]) as u64
            + self.templates.iter().map(template).sum::<u64>()
            + self.masks.iter().map(|m| size_of_val(&m.words[..]) as u64).sum::<u64>()
    }
}

impl Object {
    /// A point of the template in local space. All forms compute it in this order.
    pub fn place(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation
    }
}
