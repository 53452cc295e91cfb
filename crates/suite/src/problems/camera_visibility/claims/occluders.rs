//! What masked buffers cull of what a depth for each pixel culls, with the same occluders.

use super::{
    support::{LATENCY, Path, Shown, Way, path_of, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{
    Bounds, Object, Objects, Renderer, Template, View, masked, software::Fast,
};
use glam::{DVec3, Mat3, Vec3};
use std::sync::Arc;

/// Share of what is hidden that has to be culled.
const SHARE: f64 = 0.98;

/// The sides of a box, corners as [`Bounds::corners`] has them.
const SIDES: [[u32; 4]; 6] =
    [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "hasselgren-3",
        statement: "Masked buffers cull 98 % of what a depth for each pixel culls with the same \
                    occluders, and nothing that it does not",
        place: "Hasselgren et al. 2016, section 5; the share is a goal of this project",
        method: "the boxes inscribed in the generated city's buildings, all of them, drawn by the \
                 fast renderer and by masked buffers of the image's size, 1920 x 1080: three still \
                 views and six frames of the tour. An object is hidden if every pixel of its \
                 box's rectangle has a nearer depth. Culled of the hidden, and culled of those that \
                 are not, in each view",
        judge: Box::new(share),
    }]
}

/// Boxes as objects that can be drawn.
fn drawn_boxes(origin: DVec3, boxes: &[masked::InnerBox]) -> Objects {
    let mut objects = Objects { origin, ..Objects::default() };
    for (index, masked::InnerBox { corners, .. }) in boxes.iter().enumerate() {
        let of = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        objects.templates.push(Template {
            positions: corners.to_vec(),
            triangles: SIDES.iter().flat_map(|side| of(*side)).collect(),
            ..Template::default()
        });
        let bounds =
            corners.iter().fold(Bounds::EMPTY, |all, &p| all.union(Bounds { min: p, max: p }));
        let (linear, translation) = (Mat3::IDENTITY, Vec3::ZERO);
        objects.objects.push(Object { template: index as u32, linear, translation, bounds });
    }
    objects
}

/// The pixels whose centres lie between two coordinates.
fn centres(low: f32, high: f32, pixels: u32) -> std::ops::Range<usize> {
    let within = |x: f64| x.clamp(0.0, f64::from(pixels)) as usize;
    let first = within((f64::from(low) - 0.5).ceil());
    first..within((f64::from(high) - 0.5).floor() + 1.0).max(first)
}

/// Whether every pixel of a box's rectangle is nearer than it; none where it cannot be asked, is
/// not in sight or has no pixel.
fn hidden(view: &View, bounds: &Bounds, depth: &[f32]) -> Option<bool> {
    if !view.sees(bounds) || view.touches(bounds) {
        return None;
    }
    let ([left, top, right, bottom], nearest) = view.screen_rect(bounds)?;
    let (columns, rows) = (centres(left, right, view.width), centres(top, bottom, view.height));
    if columns.is_empty() || rows.is_empty() {
        return None;
    }
    let row = |y: usize| y * view.width as usize;
    Some(
        rows.into_iter().all(|y| {
            depth[row(y) + columns.start..row(y) + columns.end].iter().all(|d| *d > nearest)
        }),
    )
}

/// Objects hidden by a depth for each pixel, those culled of them, and those culled of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Culled {
    hidden: u64,
    culled: u64,
    wrongly: u64,
}

fn of_a_frame(
    path: &Path,
    index: usize,
    shown: &Shown,
    boxes: &mut Fast,
) -> Result<Culled, SuiteError> {
    let view = &path.views[index];
    let all: Vec<u32> = (0..path.town.inner.len() as u32).collect();
    boxes.begin(view)?;
    boxes.draw(&all)?;
    boxes.end()?;
    let depth = &boxes.image().depth;
    let mut drawn = vec![false; path.town.objects.objects.len()];
    for object in &shown.drawn {
        drawn[*object as usize] = true;
    }
    let mut sums = Culled::default();
    for (object, drawn) in path.town.objects.objects.iter().zip(drawn) {
        match hidden(view, &object.bounds, depth) {
            Some(true) => {
                sums.hidden += 1;
                sums.culled += u64::from(!drawn);
            }
            Some(false) => sums.wrongly += u64::from(!drawn),
            None => {}
        }
    }
    Ok(sums)
}

fn enough(views: &[Culled]) -> Verdict {
    if views.is_empty() || views.iter().any(|v| v.hidden == 0) {
        Verdict::Open
    } else if views.iter().any(|v| v.wrongly > 0) {
        Verdict::Refuted
    } else {
        let share = |v: &Culled| v.culled as f64 / v.hidden as f64;
        let met: Vec<bool> = views.iter().map(|v| share(v) >= SHARE).collect();
        super::verdict::vote(&met)
    }
}

fn share(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let city = town("city", &[])?;
    let mut boxes = Fast::new(Arc::new(drawn_boxes(city.objects.origin, &city.inner)), LATENCY)?;
    let way = Way::Masked(masked::Settings {
        form: masked::Form::Fast,
        occluders: masked::Occluders::InnerBoxes,
        columns: None,
        most_triangles: u64::MAX,
    });
    let (mut figures, mut views) = (Vec::new(), Vec::new());
    for (name, frames, step) in
        [("close_ended", 1, 1), ("street", 1, 1), ("birds_eye", 1, 1), ("tour", 6, 20)]
    {
        let path = path_of(&city, name, frames, step, [1920, 1080])?;
        let mut sums = Culled::default();
        for (index, shown) in path.shown(&way)?.iter().enumerate() {
            let frame = of_a_frame(&path, index, shown, &mut boxes)?;
            sums.hidden += frame.hidden;
            sums.culled += frame.culled;
            sums.wrongly += frame.wrongly;
        }
        let share = sums.culled as f64 / sums.hidden.max(1) as f64;
        figures.push(figure(format!("{name}: hidden by a depth a pixel"), sums.hidden as f64, ""));
        figures.push(figure(format!("{name}: culled of them"), share * 100.0, "%"));
        figures.push(figure(format!("{name}: culled though not hidden"), sums.wrongly as f64, ""));
        views.push(sums);
    }
    let shares: Vec<f64> =
        views.iter().map(|v| v.culled as f64 / v.hidden.max(1) as f64 * 100.0).collect();
    let because = format!("{shares:.1?} % of the hidden are culled in the four views");
    Ok(judged(enough(&views), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn nearly_all_are_culled_and_nothing_else() {
        let good = Culled { hidden: 100, culled: 99, wrongly: 0 };
        assert_eq!(enough(&[good]), Reproduced);
        assert_eq!(enough(&[good, Culled { culled: 90, ..good }]), Open);
        assert_eq!(enough(&[Culled { culled: 90, ..good }]), Refuted);
        assert_eq!(enough(&[Culled { wrongly: 1, ..good }]), Refuted);
        assert_eq!(enough(&[Culled { hidden: 0, culled: 0, wrongly: 0 }]), Open);
    }

    #[test]
    fn pixels_count_by_their_centres() {
        assert_eq!(centres(0.5, 2.4, 10), 0..2);
        assert_eq!(centres(0.6, 0.9, 10), 1..1);
        assert_eq!(centres(-5.0, 50.0, 10), 0..10);
        assert_eq!(centres(20.0, 50.0, 10), 10..10);
    }

    #[test]
    fn boxes_have_twelve_triangles_around_them() {
        let corners = Bounds { min: Vec3::ZERO, max: Vec3::ONE }.corners();
        let objects =
            drawn_boxes(DVec3::ZERO, &[masked::InnerBox { corners, solid: Bounds::EMPTY }]);
        assert_eq!(objects.templates[0].triangles.len(), 12);
        let area: f32 =
            objects.triangles(0).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        assert!((area - 6.0).abs() < 1e-6, "{area}");
    }
}
