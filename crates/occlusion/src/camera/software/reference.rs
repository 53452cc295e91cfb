//! The renderer that the others are judged by: scalar f64, pixel by pixel.
//!
//! Edge functions are taken from corners relative to the pixel's centre, so that the two triangles
//! of an edge compute exactly opposite ones: nothing slips between them and nothing is hit twice.

use super::super::{Bounds, Image, Mask, Objects, Query, Readiness, Renderer, View};
use super::answers::Answers;
use super::check;
use super::project::{Corner, OnScreen, Polygon, Projection};
use crate::OcclusionError;
use glam::{DVec2, Vec2};
use std::sync::Arc;

/// Clear to read rather than fast.
#[derive(Clone, Debug)]
pub struct Reference {
    objects: Arc<Objects>,
    answers: Answers,
    frame: Option<(View, Projection)>,
    image: Image,
}

impl Reference {
    /// # Errors
    /// Objects with coordinates that are not finite or indices out of range, or answers polled.
    pub fn new(objects: Arc<Objects>, readiness: Readiness) -> Result<Self, OcclusionError> {
        check::objects(&objects)?;
        let answers = Answers::new(readiness)?;
        Ok(Self { objects, answers, frame: None, image: Image::default() })
    }

    /// What has been drawn since the frame began.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// How many samples of the grown box would pass the depth test now: the box test at full
    /// resolution. Every pixel of the image for a box that cannot be asked about, 0 before the first
    /// frame.
    pub fn would_show(&self, bounds: &Bounds) -> u32 {
        match &self.frame {
            None => 0,
            Some((view, _)) if view.touches(bounds) => view.width * view.height,
            Some((view, projection)) => {
                passing(projection, &view.guarded(bounds), &self.image.depth)
            }
        }
    }

    fn frame(&self) -> Result<(&View, &Projection), OcclusionError> {
        match &self.frame {
            Some((view, projection)) => Ok((view, projection)),
            None => Err(OcclusionError::value("drawing", "begins with a frame")),
        }
    }
}

impl Renderer for Reference {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        check::view(view)?;
        self.image.clear(view.width, view.height);
        self.frame = Some((view.clone(), Projection::new(view)));
        Ok(())
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        check::drawn(objects, self.objects.objects.len())?;
        let projection = *self.frame()?.1;
        for &index in objects {
            let object = &self.objects.objects[index as usize];
            let template = &self.objects.templates[object.template as usize];
            let mask = template.mask.map(|m| &self.objects.masks[m as usize]);
            for triangle in 0..template.triangles.len() {
                let corners = projection.triangle(object, template, triangle);
                draw(&projection, &corners, mask, [index + 1, triangle as u32], &mut self.image);
            }
        }
        self.answers.drew(objects.len());
        Ok(())
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        check::asked(boxes, queries)?;
        let (view, projection) = self.frame()?;
        let count = |query: &Query| {
            boxes[query.boxes.start as usize..query.boxes.end as usize]
                .iter()
                .map(|b| passing(projection, &view.guarded(b), &self.image.depth))
                .fold(0, u32::saturating_add)
        };
        let counts: Vec<u32> = queries.iter().map(count).collect();
        self.answers.asked(boxes.len(), &counts);
        Ok(())
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        Ok(self.answers.ready())
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        self.answers.collect(counts)
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        Ok(())
    }
}

/// Draws one triangle: the nearest wins, of equally near ones the first.
fn draw(
    projection: &Projection,
    corners: &[Corner; 3],
    mask: Option<&Mask>,
    id: [u32; 2],
    image: &mut Image,
) {
    samples(projection, corners, |pixel, depth, uv| {
        if depth > image.depth[pixel] && mask.is_none_or(|mask| mask.at(uv)) {
            image.depth[pixel] = depth;
            image.ids[pixel] = id;
        }
    });
}

/// Samples of a box that are at least as near as what is drawn; every face counts.
pub(super) fn passing(projection: &Projection, bounds: &Bounds, drawn: &[f32]) -> u32 {
    let mut count = 0_u32;
    for triangle in &projection.triangles_of(bounds) {
        samples(projection, triangle, |pixel, depth, _| {
            count = count.saturating_add(u32::from(depth >= drawn[pixel]));
        });
    }
    count
}

/// Every pixel whose centre a triangle covers: its index, depth and texture coordinates.
pub(super) fn samples(
    projection: &Projection,
    corners: &[Corner; 3],
    mut sample: impl FnMut(usize, f32, Vec2),
) {
    for part in Polygon::clipped(corners).triangles() {
        let screen = part.map(|c| projection.screen(c.clip));
        let columns = covered(screen.map(|c| c.x), projection.width);
        for y in covered(screen.map(|c| c.y), projection.height) {
            for x in columns.clone() {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                if let Some(weights) = weigh(&screen, centre) {
                    let pixel = y as usize * projection.width as usize + x as usize;
                    sample(pixel, depth(&screen, weights) as f32, uv(&part, weights));
                }
            }
        }
    }
}

/// Pixels of one direction whose centres lie between the least and the greatest coordinate.
fn covered(t: [f64; 3], pixels: u32) -> std::ops::Range<u32> {
    let least = t[0].min(t[1]).min(t[2]);
    let greatest = t[0].max(t[1]).max(t[2]);
    let first = (least - 0.5).ceil().max(0.0) as u32;
    let last = ((greatest - 0.5).floor() + 1.0).clamp(0.0, f64::from(pixels)) as u32;
    first..last
}

/// The share of each corner at `centre`, `None` outside. A centre on an edge belongs to the triangle
/// of which it is a left or a top edge.
fn weigh(corners: &[OnScreen; 3], centre: DVec2) -> Option<[f64; 3]> {
    let [a, b, c] = corners.map(|c| DVec2::new(c.x, c.y) - centre);
    // Exact negatives need unfused multiplications: no mul_add.
    let weights = [b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x];
    let area = weights[0] + weights[1] + weights[2];
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    for (weight, from, to) in [(weights[0], b, c), (weights[1], c, a), (weights[2], a, b)] {
        let along = to - from;
        let left_or_top = along.y < 0.0 || (along.y == 0.0 && along.x > 0.0);
        let owned = left_or_top == (area > 0.0);
        if weight * area.signum() < 0.0 || (weight == 0.0 && !owned) {
            return None;
        }
    }
    Some(weights.map(|w| w / area))
}

// Depth is linear on the screen. Rounding never takes it out of its corners' range.
fn depth(corners: &[OnScreen; 3], weights: [f64; 3]) -> f64 {
    let d = corners.map(|c| c.depth);
    let least = d[0].min(d[1]).min(d[2]);
    let greatest = d[0].max(d[1]).max(d[2]);
    (weights[0] * d[0] + weights[1] * d[1] + weights[2] * d[2]).max(least).min(greatest)
}

fn uv(corners: &[Corner; 3], weights: [f64; 3]) -> Vec2 {
    let shares: [f64; 3] = std::array::from_fn(|i| weights[i] / corners[i].clip.w);
    let sum = shares[0] + shares[1] + shares[2];
    let uv = corners[0].uv * shares[0] + corners[1].uv * shares[1] + corners[2].uv * shares[2];
    (uv / sum).as_vec2()
}
