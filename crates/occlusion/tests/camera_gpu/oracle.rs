//! What a pixel may show, in f64 and by looking at every triangle: nothing is clipped, edges are
//! functions in homogeneous pixel coordinates.
//!
//! Corners may be off by 1/128 of a pixel, as rasterisers snap them. A triangle *must* cover a
//! centre that lies deeper inside than that, and *may* cover one that lies no farther outside.

use dapple_occlusion::camera::{Bounds, Image, Mask, Objects, View};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// How far edges may be off, pixels.
const OFF: f64 = 1.0 / 128.0;

/// One triangle on the screen.
struct OnScreen<'a> {
    id: [u32; 2],
    /// Signed distance to each edge's line, and inside positive: `xyz . (x, y, 1)`.
    edges: [DVec3; 3],
    /// Weight of each corner, of `1 / w`.
    weights: [DVec3; 3],
    /// Reversed depth.
    depth: DVec3,
    mask: Option<(&'a Mask, [Vec2; 3])>,
}

/// What a triangle does at a pixel.
struct Cover {
    must: bool,
    depth: f64,
    tolerance: f64,
}

impl<'a> OnScreen<'a> {
    /// None without area.
    fn new(view: &View, id: [u32; 2], corners: [Vec3; 3]) -> Option<Self> {
        let clip = corners.map(|p| view.clip * p.as_dvec3().extend(1.0));
        let size = DVec2::new(f64::from(view.width), f64::from(view.height));
        let pixel =
            clip.map(|c| DVec3::new((c.x + c.w) * 0.5 * size.x, (c.w - c.y) * 0.5 * size.y, c.w));
        let lines: [DVec3; 3] =
            std::array::from_fn(|i| pixel[(i + 1) % 3].cross(pixel[(i + 2) % 3]));
        let volume = pixel[0].dot(lines[0]);
        if volume == 0.0 {
            return None;
        }
        let weights = lines.map(|line| line / volume);
        Some(Self {
            id,
            edges: lines.map(|l| l * volume.signum() / l.truncate().length()),
            weights,
            depth: (0..3).map(|i| weights[i] * clip[i].z).sum(),
            mask: None,
        })
    }

    /// Triangle `index` of `object`.
    fn of(view: &View, objects: &'a Objects, [object, index]: [u32; 2]) -> Option<Self> {
        let placed = &objects.objects[object as usize];
        let template = &objects.templates[placed.template as usize];
        let triangle = template.triangles[index as usize];
        let corners = triangle.map(|c| placed.place(template.positions[c as usize]));
        let mut on_screen = Self::new(view, [object + 1, index], corners)?;
        on_screen.mask = template.mask.map(|mask| {
            (&objects.masks[mask as usize], triangle.map(|c| template.uvs[c as usize]))
        });
        Some(on_screen)
    }

    fn at(&self, x: u32, y: u32) -> Option<Cover> {
        let p = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
        let inside = self.edges.iter().map(|e| e.dot(p)).fold(f64::INFINITY, f64::min);
        let depth = self.depth.dot(p);
        let tolerance = 2.0 * OFF * self.depth.truncate().length() + 1e-5 * depth.abs() + 1e-7;
        let ahead = self.weights.iter().map(|w| w.dot(p)).sum::<f64>() > 0.0;
        if !ahead || inside < -OFF || depth > 1.0 + tolerance || depth < -tolerance {
            return None;
        }
        let near = depth > 1.0 - tolerance;
        let (all, any) = self.texels(p);
        any.then_some(Cover { must: inside > OFF && all && !near, depth, tolerance })
    }

    /// Whether all, and whether any, texels about `p` are there.
    fn texels(&self, p: DVec3) -> (bool, bool) {
        let Some((mask, uvs)) = self.mask else { return (true, true) };
        let (mut all, mut any) = (true, false);
        for (dx, dy) in [(0, 0), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let p = p + DVec3::new(f64::from(dx), f64::from(dy), 0.0) * (3.0 * OFF);
            let weights = self.weights.map(|w| w.dot(p));
            let sum: f64 = weights.iter().sum();
            let uv: DVec2 = (0..3).map(|i| uvs[i].as_dvec2() * (weights[i] / sum)).sum();
            let there = mask.at(uv.as_vec2());
            all &= there;
            any |= there;
        }
        (all, any)
    }
}

/// Why an image cannot be, pixel by pixel; and of how many pixels only one answer is right.
pub fn faults(view: &View, objects: &Objects, image: &Image) -> (Vec<String>, usize) {
    let mut triangles = Vec::new();
    for object in 0..objects.objects.len() as u32 {
        let own = 0..objects.triangle_count(object);
        triangles.extend(own.filter_map(|index| OnScreen::of(view, objects, [object, index])));
    }
    let (mut faults, mut certain) = (Vec::new(), 0);
    for y in 0..image.height {
        for x in 0..image.width {
            let at = (y * image.width + x) as usize;
            let (id, depth) = (image.ids[at], f64::from(image.depth[at]));
            let covers: Vec<_> =
                triangles.iter().filter_map(|t| Some((t.id, t.at(x, y)?))).collect();
            let needed = covers
                .iter()
                .filter(|(_, c)| c.must)
                .map(|(_, c)| c.depth - c.tolerance)
                .fold(f64::NEG_INFINITY, f64::max);
            let possible = covers.iter().filter(|(_, c)| c.depth + c.tolerance >= needed);
            let nothing = needed == f64::NEG_INFINITY;
            certain += usize::from(possible.clone().count() + usize::from(nothing) == 1);
            let right = if id == [0, 0] {
                nothing && depth == 0.0
            } else {
                possible
                    .filter(|(i, _)| *i == id)
                    .any(|(_, c)| (c.depth - depth).abs() <= c.tolerance)
            };
            if !right {
                faults.push(format!("({x}, {y}): {id:?} at {depth}, needed {needed}"));
            }
        }
    }
    (faults, certain)
}

/// Least and most samples of a box, grown as queries grow it, that may pass before what was drawn.
pub fn count_range(view: &View, bounds: &Bounds, drawn: &Image) -> [u32; 2] {
    let corners = view.guarded(bounds).corners();
    let (mut least, mut most) = (0, 0);
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for first in [0, 1 << axis] {
            for face in [[0, u, v], [v, u, u + v]] {
                let triangle = face.map(|corner| corners[first + corner]);
                let Some(triangle) = OnScreen::new(view, [0; 2], triangle) else { continue };
                for (pixel, depth) in (0..).zip(&drawn.depth) {
                    let depth = f64::from(*depth);
                    let cover = triangle.at(pixel % drawn.width, pixel / drawn.width);
                    let Some(cover) = cover else { continue };
                    most += u32::from(cover.depth + cover.tolerance >= depth);
                    least += u32::from(cover.must && cover.depth - cover.tolerance >= depth);
                }
            }
        }
    }
    [least, most]
}
