//! What each pixel of an image may show, in f64, by looking at every triangle.
//!
//! Rasterisers move corners by up to 1/128 of a pixel. A triangle *must* cover a centre that lies
//! deeper inside than that, and *may* cover one that lies no farther outside; nothing is clipped,
//! edges are functions in homogeneous pixel coordinates. What has holes may cover, and never must.

use dapple_occlusion::camera::{Image, Objects, View};
use glam::{DVec3, Vec3};

/// How far edges may be off, pixels.
const OFF: f64 = 1.0 / 128.0;

/// A triangle on the screen.
struct OnScreen {
    id: [u32; 2],
    /// Signed distance to each edge's line, inside positive: `edge . (x, y, 1)`.
    edges: [DVec3; 3],
    /// Of the inverse distance, and of reversed depth: both are linear on the image.
    ahead: DVec3,
    depth: DVec3,
    has_holes: bool,
}

/// A triangle at a pixel.
struct Cover {
    must: bool,
    /// Least and greatest reversed depth that a rasteriser may find.
    depth: [f64; 2],
}

impl OnScreen {
    /// None without area.
    fn new(view: &View, id: [u32; 2], corners: [Vec3; 3], has_holes: bool) -> Option<Self> {
        let clip = corners.map(|p| view.clip * p.as_dvec3().extend(1.0));
        let (width, height) = (f64::from(view.width), f64::from(view.height));
        let pixel =
            clip.map(|c| DVec3::new((c.x + c.w) * 0.5 * width, (c.w - c.y) * 0.5 * height, c.w));
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
            ahead: weights.iter().sum(),
            depth: (0..3).map(|i| weights[i] * clip[i].z).sum(),
            has_holes,
        })
    }

    fn at(&self, centre: DVec3) -> Option<Cover> {
        let inside = self.edges.iter().map(|e| e.dot(centre)).fold(f64::INFINITY, f64::min);
        let depth = self.depth.dot(centre);
        let off = 2.0 * OFF * self.depth.truncate().length() + 1e-5 * depth.abs() + 1e-9;
        // An edge without direction tells nothing: NaN is not below.
        let outside = inside < -OFF || self.ahead.dot(centre) <= 0.0;
        if outside || depth > 1.0 + off || depth < -off {
            return None;
        }
        let must = inside > OFF && depth < 1.0 - off && !self.has_holes;
        Some(Cover { must, depth: [depth - off, depth + off] })
    }
}

/// What an image shows that it may not: pixel and clause. Also the number of pixels that must show
/// something.
pub fn faults(view: &View, objects: &Objects, image: &Image) -> (Vec<String>, u64) {
    let mut triangles = Vec::new();
    for (index, object) in (0..).zip(&objects.objects) {
        let has_holes = objects.templates[object.template as usize].mask.is_some();
        let on_screen =
            |(within, corners)| OnScreen::new(view, [index + 1, within], corners, has_holes);
        triangles.extend((0..).zip(objects.triangles(index)).filter_map(on_screen));
    }
    let (mut faults, mut covered) = (Vec::new(), 0);
    for (pixel, (id, depth)) in image.ids.iter().zip(&image.depth).enumerate() {
        let (x, y) = (pixel as u32 % image.width, pixel as u32 / image.width);
        let centre = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
        // Nothing that must be seen lies nearer than what is shown.
        let (mut nearest, mut shown) = (f64::NEG_INFINITY, None);
        for triangle in &triangles {
            let Some(cover) = triangle.at(centre) else { continue };
            if cover.must {
                nearest = nearest.max(cover.depth[0]);
            }
            if triangle.id == *id {
                shown = Some(cover.depth);
            }
        }
        covered += u64::from(nearest > f64::NEG_INFINITY);
        let depth = f64::from(*depth);
        let clause = match shown {
            _ if nearest > depth => "is behind what must cover it",
            None if id[0] > 0 => "shows what does not cover it",
            None if depth != 0.0 => "is empty and has a depth",
            Some([least, greatest]) if !(least..=greatest).contains(&depth) => {
                "has another depth than what it shows"
            }
            _ => continue,
        };
        faults.push(format!("pixel {x}, {y} of {id:?} at {depth:e} {clause}"));
    }
    (faults, covered)
}
