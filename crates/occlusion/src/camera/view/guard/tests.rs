//! Boxes and what they hold, drawn as forms in f32 with snapped corners draw them.

use super::*;
use crate::camera::view::tests::{SIZE, camera, perspective};
use crate::camera::{Object, Objects};
use dapple_scene::Projection;
use glam::{DMat3, DQuat, Mat3, Vec3, Vec4};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

/// A corner as a rasteriser has it: pixels on a grid of 1/256, and reversed depth.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec2,
    depth: f64,
}

/// Division and viewport in f32, then snapped down or to the nearest.
fn corner(view: &View, clip: Vec4, down: bool) -> Corner {
    let (x, y, z) = (clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    let half = Vec3::new(view.width as f32, view.height as f32, 0.0) * 0.5;
    let pixel =
        DVec2::new(f64::from(x.mul_add(half.x, half.x)), f64::from((-y).mul_add(half.y, half.y)));
    let snapped = pixel * 256.0;
    let snapped = if down { snapped.floor() } else { snapped.round() };
    Corner { at: snapped / 256.0, depth: f64::from(z) }
}

/// What is left of a triangle behind the near plane, as a fan, all in f32.
fn raster(view: &View, triangle: &[Vec3; 3], down: bool) -> Vec<[Corner; 3]> {
    let clip = triangle.map(|p| view.to_clip_f32(p));
    let mut kept: Vec<Vec4> = Vec::new();
    for i in 0..3 {
        let (a, b) = (clip[i], clip[(i + 1) % 3]);
        let (inside_a, inside_b) = (a.w - a.z, b.w - b.z);
        if inside_a >= 0.0 {
            kept.push(a);
        }
        if (inside_a < 0.0) != (inside_b < 0.0) {
            // From the inside out, so that faces which share an edge share its cut.
            let (from, to, share) = if inside_a < 0.0 {
                (b, a, inside_b / (inside_b - inside_a))
            } else {
                (a, b, inside_a / (inside_a - inside_b))
            };
            let mut cut = from + (to - from) * share;
            cut.w = cut.z;
            kept.push(cut);
        }
    }
    let corners: Vec<Corner> = kept.into_iter().map(|c| corner(view, c, down)).collect();
    (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]).collect()
}

/// Depth at a pixel's centre, if the triangle covers it; borders count. `error` is added, in units
/// of the rounding that an interpolation of depth is allowed.
fn depth_at(triangle: [Corner; 3], centre: DVec2, error: f64) -> Option<f64> {
    let [a, b, c] = triangle;
    let area = (b.at - a.at).perp_dot(c.at - a.at);
    if area == 0.0 {
        return None;
    }
    let share = |p: Corner, q: Corner| (q.at - p.at).perp_dot(centre - p.at) / area;
    let shares = [share(b, c), share(c, a), share(a, b)];
    if shares.iter().any(|&s| s < 0.0) {
        return None;
    }
    let greatest = a.depth.max(b.depth).max(c.depth);
    let depth = shares[0] * a.depth + shares[1] * b.depth + shares[2] * c.depth;
    Some(depth + error * 2.0_f64.powi(-24) * greatest)
}

/// The two triangles of each face.
fn faces(bounds: &Bounds) -> Vec<[Vec3; 3]> {
    let c = bounds.corners();
    let quads =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    quads.iter().flat_map(|q| [[c[q[0]], c[q[1]], c[q[2]]], [c[q[0]], c[q[2]], c[q[3]]]]).collect()
}

/// Pixels that `triangles` show, and how many of these a box drawn as `drawn` does not cover as
/// near.
fn escaped(view: &View, triangles: &[[Vec3; 3]], drawn: &Bounds, down: bool) -> (u32, u32) {
    let boxes: Vec<_> = faces(drawn).iter().flat_map(|t| raster(view, t, down)).collect();
    let size = DVec2::new(f64::from(view.width), f64::from(view.height));
    let (mut shown, mut lost) = (0, 0);
    for t in triangles.iter().flat_map(|t| raster(view, t, down)) {
        let low = t[0].at.min(t[1].at).min(t[2].at).floor().clamp(DVec2::ZERO, size);
        let high = t[0].at.max(t[1].at).max(t[2].at).ceil().clamp(DVec2::ZERO, size);
        for y in low.y as u32..high.y as u32 {
            for x in low.x as u32..high.x as u32 {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(depth) = depth_at(t, centre, 8.0) else { continue };
                shown += 1;
                let cover = boxes.iter().filter_map(|b| depth_at(*b, centre, -8.0));
                let nearest = cover.fold(f64::NEG_INFINITY, f64::max);
                lost += u32::from(nearest < depth);
            }
        }
    }
    (shown, lost)
}

struct Case {
    view: View,
    bounds: Bounds,
    triangles: Vec<[Vec3; 3]>,
}

/// A camera that looks at a box from outside, and triangles with corners in or on it. Everything
/// scaled by `scale`, and moved by `offset` of the box's distance.
fn case(seed: u64, scale: f64, offset: f64, parallel: bool) -> Option<Case> {
    let mut rng = Pcg32::seed_from_u64(seed);
    let unit = |rng: &mut Pcg32| 2.0 * rng.random::<f64>() - 1.0;
    let vector = |rng: &mut Pcg32| DVec3::new(unit(rng), unit(rng), unit(rng));
    let middle = vector(&mut rng) * offset * scale;
    let half = vector(&mut rng).abs() * DVec3::new(1.0, 0.2, 1.0) * scale;
    // Often flat.
    let half = if rng.random::<f32>() < 0.4 { half * DVec3::new(1.0, 1.0, 0.0) } else { half };
    let bounds = Bounds::around(middle - half, middle + half);
    // Also beside the box, so close that the near plane cuts it.
    let away = 10.0_f64.powf(3.0 * rng.random::<f64>() - 1.3) * scale;
    let eye = middle + vector(&mut rng).normalize_or(DVec3::X) * away;
    let target = middle + vector(&mut rng) * half;
    let projection = if parallel {
        Projection::Orthographic { height_m: 3.0 * scale * rng.random::<f64>() + 0.01 * scale }
    } else {
        perspective(0.05 + 2.6 * rng.random::<f64>())
    };
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::Z, unit(&mut rng)));
    let mut camera = camera(eye, target, projection);
    camera.up = turn * DVec3::Y;
    let objects = Objects {
        objects: vec![Object {
            template: 0,
            linear: Mat3::IDENTITY,
            translation: Vec3::ZERO,
            bounds,
        }],
        ..Objects::default()
    };
    let [width, height] = [[SIZE, SIZE], [1, 1], [3, 90]][rng.random_range(0..3)];
    let view = View::new(&camera, &objects, width, height, 0.01 * scale).unwrap();
    if view.touches(&bounds) {
        return None;
    }
    let point = |rng: &mut Pcg32| {
        let mut t = Vec3::new(rng.random(), rng.random(), rng.random());
        // Often on a face, an edge or a corner.
        for k in 0..3 {
            if rng.random::<f32>() < 0.6 {
                t[k] = t[k].round();
            }
        }
        (bounds.min + (bounds.max - bounds.min) * t).clamp(bounds.min, bounds.max)
    };
    let triangles = (0..6).map(|_| std::array::from_fn(|_| point(&mut rng))).collect();
    Some(Case { view, bounds, triangles })
}

#[test]
fn grown_boxes_cover_what_they_hold() {
    let (mut shown, mut uncovered, mut cut) = (0, 0, 0);
    for seed in 0..8000 {
        let scale = [1.0, 1e-6, 1e6, 300.0][seed as usize % 4];
        let offset = [0.0, 3.0, 1000.0][seed as usize % 3];
        let Some(Case { view, bounds, triangles }) = case(seed, scale, offset, seed % 5 == 0)
        else {
            continue;
        };
        for down in [false, true] {
            let grown = view.guarded(&bounds);
            let (pixels, lost) = escaped(&view, &triangles, &grown, down);
            assert_eq!(lost, 0, "seed {seed}: {lost} of {pixels} pixels, {bounds:?} {grown:?}");
            shown += pixels;
            cut += u32::from(pixels > 0 && view.screen_rect(&bounds).is_none());
            uncovered += escaped(&view, &triangles, &bounds, down).1;
        }
    }
    assert!(shown > 50_000, "{shown}");
    // Some are cut by the near plane beside the image.
    assert!(cut > 50, "{cut}");
    // The same property finds that boxes as they are do not cover what they hold.
    assert!(uncovered > 50, "{uncovered}");
}

#[test]
fn screen_rects_hold_what_is_drawn() {
    let (mut tight, mut cases) = (0, 0);
    for seed in 0..4000 {
        let scale = [1.0, 1e-6, 1e6][seed as usize % 3];
        let Some(Case { view, bounds, triangles }) = case(seed, scale, 5.0, seed % 4 == 0) else {
            continue;
        };
        let Some(([left, top, right, bottom], nearest)) = view.screen_rect(&bounds) else {
            continue;
        };
        cases += 1;
        for p in triangles.iter().flatten() {
            let c = corner(&view, view.to_clip_f32(*p), true);
            assert!(c.at.x >= f64::from(left) && c.at.x <= f64::from(right), "{seed}");
            assert!(c.at.y >= f64::from(top) && c.at.y <= f64::from(bottom), "{seed}");
            assert!(c.depth <= f64::from(nearest), "{seed}");
        }
        // No wider than the corners by more than a fraction of a pixel, unless a corner is close.
        let corners = bounds.corners().map(|p| view.pixel(p.as_dvec3()));
        let low = corners.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
        let (near, far) = (view.distance(&bounds), view.distances(&bounds)[1]);
        let fine = view.pixel_m(1.0) < 0.1 || view.parallel;
        if fine && (view.parallel || far < 3.0 * near) {
            let most = 0.25 + 0.01 * low.x.abs();
            assert!(low.x - f64::from(left) < most, "{seed}: {low} {left}");
            tight += 1;
        }
    }
    assert!(cases > 2000 && tight > 1000, "{cases} {tight}");
}
