use super::*;
use glam::{DMat3, DQuat};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

const SIZE: u32 = 48;

fn camera(position: DVec3, target: DVec3, projection: Projection) -> Camera {
    Camera { name: "test".into(), position, target, up: DVec3::Y, projection }
}

fn perspective(fov_y_rad: f64) -> Projection {
    Projection::Perspective { fov_y_rad }
}

fn view(projection: Projection, near_m: f64) -> View {
    let camera = camera(DVec3::ZERO, DVec3::NEG_Z, projection);
    View::new(&camera, &Objects::default(), SIZE, SIZE, near_m).unwrap()
}

fn bounds(min: [f32; 3], max: [f32; 3]) -> Bounds {
    Bounds { min: Vec3::from_array(min), max: Vec3::from_array(max) }
}

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
    let objects = crate::camera::Objects {
        objects: vec![crate::camera::Object {
            template: 0,
            linear: glam::Mat3::IDENTITY,
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

proptest! {
    #[test]
    fn what_shows_is_seen_and_what_is_seen_of_a_part_is_seen_of_the_whole(
        seed: u64, wider in 0.0_f64..100.0, parallel: bool, scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
    ) {
        let mut rng = Pcg32::seed_from_u64(seed);
        let mut vector = || DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
        let projection = if parallel {
            Projection::Orthographic { height_m: 3.0 * scale }
        } else {
            perspective(1.2)
        };
        let c = camera(vector() * scale, vector() * scale, projection);
        let middle = vector() * 5.0 * scale;
        let half = vector().abs() * scale;
        let inner = Bounds::around(middle - half, middle + half);
        let outer = inner.union(Bounds::around(middle - half * wider, middle + half));
        let mut objects = Objects::default();
        for bounds in [inner, outer] {
            let (linear, translation) = (glam::Mat3::IDENTITY, Vec3::ZERO);
            objects.objects.push(crate::camera::Object { template: 0, linear, translation, bounds });
        }
        let Ok(view) = View::new(&c, &objects, 64, 36, 0.1 * scale) else { return Ok(()) };
        prop_assert!(!view.sees(&inner) || view.sees(&outer));
        prop_assert!(!view.touches(&inner) || view.touches(&outer));
        prop_assert!(view.guard_m(&inner) <= view.guard_m(&outer));
        // Any point of it inside the clip volume: it is seen.
        for _ in 0..50 {
            let p = (middle + vector() * half).as_vec3().clamp(inner.min, inner.max);
            let clip = view.clip * p.as_dvec3().extend(1.0);
            let inside = clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
                && clip.z >= 0.0 && clip.z <= clip.w;
            prop_assert!(!inside || view.sees(&inner));
            let clip_f32 = view.to_clip_f32(p).as_dvec4();
            let size = clip.abs().max_element().max(f64::MIN_POSITIVE);
            let reach = (p.as_dvec3() - view.eye).length() / (0.1 * scale);
            prop_assert!((clip - clip_f32).abs().max_element() <= 1e-5 * size * reach.max(1.0));
        }
    }

    #[test]
    fn clip_space_planes_and_pixels_agree_with_the_cameras_rays(
        seed: u64, x in 0.0_f64..1.0, y in 0.0_f64..1.0, t in 1.0_f64..50.0, parallel: bool,
    ) {
        let mut rng = Pcg32::seed_from_u64(seed);
        let mut vector = || DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
        let projection =
            if parallel { Projection::Orthographic { height_m: 3.0 } } else { perspective(1.0) };
        let c = camera(vector(), vector(), projection);
        let origin = vector() * 10.0;
        let bounds = Bounds::around(DVec3::splat(-99.0), DVec3::splat(99.0));
        let (linear, translation) = (glam::Mat3::IDENTITY, Vec3::ZERO);
        let object = crate::camera::Object { template: 0, linear, translation, bounds };
        let objects = Objects { origin, objects: vec![object], ..Objects::default() };
        let view = View::new(&c, &objects, 200, 100, 0.1).unwrap();
        let (from, direction) = c.ray(x, y, 2.0);
        let p = from + direction * t - origin;
        let clip = view.clip * p.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        prop_assert!((ndc.x - (2.0 * x - 1.0)).abs() < 1e-9);
        prop_assert!((ndc.y - (1.0 - 2.0 * y)).abs() < 1e-9);
        let distance = (p - view.eye).dot(view.forward);
        prop_assert!((ndc.z - view.depth(distance)).abs() < 1e-12);
        prop_assert!(ndc.z > 0.0 && ndc.z <= 1.0);
        let pixel = view.pixel(p);
        prop_assert!((pixel - DVec2::new(200.0 * x, 100.0 * y)).length() < 1e-6);
        for plane in view.planes {
            prop_assert!((plane.truncate().length() - 1.0).abs() < 1e-12);
            prop_assert!(plane.truncate().dot(p) + plane.w >= -1e-9);
        }
        // Left of the image, above it, and before the near plane: outside one plane each.
        let (aside, _) = c.ray(-0.1, y, 2.0);
        let (_, direction) = c.ray(-0.1, y, 2.0);
        let p = aside + direction * t - origin;
        prop_assert!(view.planes[1].truncate().dot(p) + view.planes[1].w < 0.0);
        let p = view.eye + view.forward * (view.near_distance() - 0.01);
        prop_assert!(view.planes[0].truncate().dot(p) + view.planes[0].w < 0.0);
    }
}

#[test]
fn planes_and_boxes_by_hand() {
    let v = view(perspective(std::f64::consts::FRAC_PI_2), 0.5);
    assert_eq!(v.depth(0.5), 1.0);
    assert_eq!(v.depth(5.0), 0.1);
    assert!(v.sees(&bounds([-1.0, -1.0, -3.0], [1.0, 1.0, -2.0])));
    assert!(!v.sees(&bounds([-1.0, -1.0, 2.0], [1.0, 1.0, 3.0])));
    assert!(!v.sees(&bounds([4.0, -1.0, -3.0], [5.0, 1.0, -2.0])));
    assert!(!v.sees(&bounds([-1.0, -9.0, -3.0], [1.0, -4.0, -2.0])));
    assert!(!v.sees(&bounds([-0.1, -0.1, -0.4], [0.1, 0.1, -0.3])));
    assert!(!v.sees(&Bounds::EMPTY) && !v.touches(&Bounds::EMPTY));
    assert_eq!(v.guarded(&Bounds::EMPTY), Bounds::EMPTY);
    assert!(v.screen_rect(&Bounds::EMPTY).is_none());

    // Around the eye; across the near plane in the image; across it beside the image.
    assert!(v.touches(&bounds([-1.0; 3], [1.0; 3])));
    assert!(v.touches(&bounds([-0.1, -0.1, -0.6], [0.1, 0.1, -0.4])));
    let beside = bounds([2.0, -1.0, -9.0], [3.0, 1.0, 1.0]);
    assert!(!v.touches(&beside) && v.sees(&beside));
    assert!(v.screen_rect(&beside).is_none());
    assert!(!v.touches(&bounds([-1.0, -1.0, -3.0], [1.0, 1.0, -0.6])));
    // So near that the guard band reaches it.
    assert!(v.touches(&bounds([-1.0, -1.0, -3.0], [1.0, 1.0, -0.500_001])));

    let (rect, depth) = v.screen_rect(&bounds([-1.0, 0.0, -2.0], [1.0, 1.0, -2.0])).unwrap();
    for (got, exact) in rect.into_iter().zip([12.0_f32, 12.0, 36.0, 24.0]) {
        assert!((got - exact).abs() < 0.05, "{rect:?}");
    }
    assert!(rect[0] < 12.0 && rect[1] < 12.0 && rect[2] > 36.0 && rect[3] > 24.0);
    assert!(depth > 0.25 && depth < 0.2505, "{depth}");
}

#[test]
fn parallel_rays_see_from_the_near_plane_to_behind_all_objects() {
    let mut objects = Objects::default();
    let far = bounds([-1.0, -1.0, -1000.0], [1.0, 1.0, -999.0]);
    let (linear, translation) = (glam::Mat3::IDENTITY, Vec3::ZERO);
    objects.objects.push(crate::camera::Object { template: 0, linear, translation, bounds: far });
    let c = camera(DVec3::ZERO, DVec3::NEG_Z, Projection::Orthographic { height_m: 4.0 });
    let v = View::new(&c, &objects, SIZE, SIZE, 1.0).unwrap();
    assert!(v.sees(&far) && !v.touches(&far));
    let (_, depth) = v.screen_rect(&far).unwrap();
    assert!(depth > 0.0 && depth < 0.2, "{depth}");
    let behind = v.depth(v.distances(&v.guarded(&far))[1]);
    assert!(behind > 0.0, "{behind}");
    assert!(v.touches(&bounds([-1.0, -1.0, -1.5], [1.0, 1.0, -0.5])));
    assert!(!v.touches(&bounds([5.0, -1.0, -1.5], [6.0, 1.0, -0.5])));
}

#[test]
fn boxes_far_abeam_and_behind_are_not_seen_nor_touched() {
    // The guard band grows with distance, not without end.
    for scale in [1e-6_f32, 1.0, 1e6] {
        let v = view(perspective(1.0), f64::from(0.01 * scale));
        for x in [1e2, 1e4, 1e6] {
            let abeam = bounds([x * scale, 0.0, 0.0], [(x + 1.0) * scale, scale, scale]);
            let behind = bounds([0.0, 0.0, x * scale], [scale, scale, (x + 1.0) * scale]);
            for b in [abeam, behind] {
                assert!(!v.sees(&b) && !v.touches(&b), "{scale} {x}");
            }
        }
    }
}

#[test]
fn cameras_that_look_nowhere_are_refused_by_name() {
    let ok = camera(DVec3::ZERO, DVec3::NEG_Z, perspective(1.0));
    let objects = Objects::default();
    let refused = |c: &Camera, w: u32, h: u32, near: f64| {
        View::new(c, &objects, w, h, near).unwrap_err().to_string()
    };
    assert!(refused(&ok, 0, 4, 0.1).contains("0 x 4 pixels"));
    assert!(refused(&ok, 4, 20_000, 0.1).contains("16384"));
    for near in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&ok, 4, 4, near).contains("near plane"));
    }
    for bad in [f64::NAN, f64::INFINITY, 2e12] {
        let mut c = ok.clone();
        c.position.y = bad;
        assert!(refused(&c, 4, 4, 0.1).contains("camera \"test\""));
    }
    let mut c = ok.clone();
    c.target = c.position;
    assert!(refused(&c, 4, 4, 0.1).contains("no direction"));
    c.target = DVec3::Y;
    assert!(refused(&c, 4, 4, 0.1).contains("no direction"));
    c.target = DVec3::new(0.0, f64::NAN, 0.0);
    assert!(refused(&c, 4, 4, 0.1).contains("no direction"));
    for fov in [0.0, std::f64::consts::PI, f64::NAN] {
        assert!(
            refused(&camera(DVec3::ZERO, DVec3::X, perspective(fov)), 4, 4, 0.1)
                .contains("opening")
        );
    }
    let wide = camera(DVec3::ZERO, DVec3::X, perspective(3.13));
    assert!(refused(&wide, 1, 1, 0.1).contains("too wide for 1 rows"));
    View::new(&wide, &objects, 64, 64, 0.1).unwrap();
    for height_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let c = camera(DVec3::ZERO, DVec3::X, Projection::Orthographic { height_m });
        assert!(refused(&c, 4, 4, 0.1).contains("height"));
    }
}
