//! Edges, clipping, degenerate triangles, masks, ties.

use super::super::project::{Corner, Projection};
use super::super::reference::samples;
use super::*;
use crate::camera::Query;
use proptest::prelude::*;

type Draw = fn(&Arc<Objects>, &View) -> Image;
const FORMS: [Draw; 2] =
    [|o, v| reference(o, v).image().clone(), |o, v| fast(o, v).image().clone()];

/// How often each pixel is covered, by the form under test: one triangle an image.
fn times(form: Draw, triangles: &[[Vec3; 3]], view: &View) -> Vec<u32> {
    let mut times = vec![0; (view.width * view.height) as usize];
    for triangle in triangles {
        let image = form(&objects(&[*triangle], 1), view);
        for (count, id) in times.iter_mut().zip(&image.ids) {
            *count += u32::from(id[0] > 0);
        }
    }
    times
}

/// A fan about a point inside the square from `low` to `high`: every point of it once.
fn fan(low: f32, high: f32, middle: [f32; 2], z: f32) -> Vec<[Vec3; 3]> {
    let corner = |x: f32, y: f32| Vec3::new(x, y, z);
    let ring = [corner(low, low), corner(high, low), corner(high, high), corner(low, high)];
    (0..4).map(|i| [ring[i], ring[(i + 1) % 4], corner(middle[0], middle[1])]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_split_square_covers_every_pixel_once(
        x in 0.0_f32..16.0, y in 0.0_f32..16.0, snapped: bool, depth in -9.0_f32..-1.0,
    ) {
        // Centres of pixels are hit too: they lie on the edges where the middle does.
        let at = |t: f32| if snapped { (2.0 * t).floor() * 0.5 } else { t };
        let triangles = fan(0.0, 16.0, [at(x), at(y)], depth);
        let view = flat(&objects(&triangles, 1), 16, 16);
        for form in FORMS {
            prop_assert!(times(form, &triangles, &view).iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn a_huge_split_square_covers_every_pixel_once(
        far in 1_f32..1e6, x in -3.0_f32..19.0, y in -3.0_f32..19.0,
    ) {
        let triangles = fan(8.0 - 8.0 - far, 16.0 + far, [x, y], -2.0);
        let view = flat(&objects(&triangles, 1), 16, 16);
        for form in FORMS {
            prop_assert!(times(form, &triangles, &view).iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn a_split_floor_through_the_eye_s_plane_has_no_cracks(
        x in -40.0_f32..40.0, z in -40.0_f32..40.0, height in 0.2_f32..2.0, yaw in 0.0_f64..6.0,
    ) {
        let corner = |x: f32, z: f32| Vec3::new(x, -height, z);
        let ring = [corner(-99.0, -99.0), corner(99.0, -99.0), corner(99.0, 99.0), corner(-99.0, 99.0)];
        let triangles: Vec<_> =
            (0..4).map(|i| [ring[i], ring[(i + 1) % 4], corner(x, z)]).collect();
        let whole = [[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]];
        let down = DVec3::new(yaw.cos(), -0.9, yaw.sin());
        let view = view(&objects(&triangles, 1), &camera(DVec3::ZERO, down), 24, 17);
        for form in FORMS {
            prop_assert_eq!(times(form, &triangles, &view), times(form, &whole, &view));
            prop_assert!(times(form, &triangles, &view).iter().all(|&n| n <= 1));
        }
    }

    #[test]
    fn the_order_of_drawing_changes_no_depth(seed in 0_u64..1000) {
        let triangles = soup(seed, 60, 4);
        let objects = objects(&triangles, 1);
        let view = view(&objects, &camera(DVec3::new(0.0, 1.0, 7.0), DVec3::ZERO), 31, 22);
        let backwards: Vec<u32> = all(&objects).into_iter().rev().collect();
        let mut reference = reference(&objects, &view);
        let mut fast = fast(&objects, &view);
        let depth = reference.image().depth.clone();
        let depth_of_fast = fast.image().depth.clone();
        for renderer in [&mut reference as &mut dyn Renderer, &mut fast] {
            renderer.begin(&view).unwrap();
            renderer.draw(&backwards).unwrap();
        }
        prop_assert_eq!(&reference.image().depth, &depth);
        prop_assert_eq!(&fast.image().depth, &depth_of_fast);
    }
}

#[test]
fn the_first_of_equal_depths_wins() {
    let triangles = [fan(0.0, 8.0, [3.0, 3.0], -2.0), fan(0.0, 8.0, [5.0, 4.0], -2.0)].concat();
    let objects = objects(&triangles, 4);
    let view = flat(&objects, 8, 8);
    for form in FORMS {
        let image = form(&objects, &view);
        assert!(image.ids.iter().all(|id| id[0] == 1), "{:?}", image.ids);
    }
    let mut fast = fast(&objects, &view);
    fast.begin(&view).unwrap();
    fast.draw(&[1, 0]).unwrap();
    assert!(fast.image().ids.iter().all(|id| id[0] == 2));
}

#[test]
fn an_image_of_one_pixel_is_drawn() {
    let triangles = fan(-9.0, 9.0, [0.5, 0.5], -4.0);
    let objects = objects(&triangles, 4);
    for form in FORMS {
        let image = form(&objects, &straight(&objects, 1, 1));
        assert_eq!(drawn(&image), 1);
        assert!((image.depth[0] - 0.1 / 4.0).abs() < 1e-7);
    }
}

#[test]
fn degenerate_triangles_draw_nothing() {
    let [a, b] = [Vec3::new(-1.0, 0.25, -3.0), Vec3::new(2.0, -0.5, -4.0)];
    let triangles = [[a, a, a], [a, b, a], [a, b, 0.5 * (a + b)], [a, b, b]];
    let objects = objects(&triangles, 4);
    for form in FORMS {
        assert_eq!(drawn(&form(&objects, &straight(&objects, 64, 64))), 0);
    }
}

#[test]
fn nothing_before_the_near_plane_is_drawn() {
    let near = NEAR as f32;
    let at = |z: f32| [Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, -9.0, z), Vec3::new(0.0, 9.0, z)];
    for (z, seen) in [(-0.5 * near, false), (3.0, false), (-1.01 * near, true), (-3.0, true)] {
        let objects = objects(&[at(z)], 1);
        for form in FORMS {
            let image = form(&objects, &straight(&objects, 9, 9));
            assert_eq!(drawn(&image) > 0, seen, "{z}");
        }
    }
}

#[test]
fn masks_leave_their_holes() {
    let mut world = Objects { masks: vec![checkerboard(4)], ..Objects::default() };
    let corner = |x: f32, y: f32| Vec3::new(8.0 * x, 8.0 * y, -2.0);
    let uvs = vec![Vec2::new(0.0, 2.0), Vec2::new(2.0, 2.0), Vec2::new(2.0, 0.0), Vec2::ZERO];
    let positions = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    let bounds = bounds_of(positions.iter().copied());
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let template = Template { positions, uvs, triangles, mask: Some(0), ..Template::default() };
    add(&mut world, template, bounds);
    let world = Arc::new(world);
    // Eight texels along eight pixels.
    for form in FORMS {
        let image = form(&world, &flat(&world, 8, 8));
        for (i, id) in image.ids.iter().enumerate() {
            assert_eq!(id[0] == 1, (i % 8 + i / 8) % 2 == 0, "pixel {i}");
            assert_eq!(image.depth[i] > 0.0, id[0] == 1);
        }
    }
}

#[test]
fn masks_are_foreshortened() {
    // A floor of one repetition a metre: texels of half a metre, found again by casting the ray.
    let mut world = Objects { masks: vec![checkerboard(2)], ..Objects::default() };
    let ring = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]];
    let positions = ring.map(|[x, z]| Vec3::new(x, -1.0, z)).to_vec();
    let uvs = ring.map(|[x, z]| Vec2::new(x, z)).to_vec();
    let bounds = bounds_of(positions.iter().copied());
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    add(
        &mut world,
        Template { positions, uvs, triangles, mask: Some(0), ..Template::default() },
        bounds,
    );
    let world = Arc::new(world);
    let camera = camera(DVec3::ZERO, DVec3::new(0.3, -0.8, -1.0));
    let view = view(&world, &camera, 64, 48);
    for form in FORMS {
        let image = form(&world, &view);
        let mut checked = [0, 0];
        for (i, id) in image.ids.iter().enumerate() {
            let x = (f64::from(i as u32 % 64) + 0.5) / 64.0;
            let y = (f64::from(i as u32 / 64) + 0.5) / 48.0;
            let (_, d) = camera.ray(x, y, 64.0 / 48.0);
            let (u, v) = (-d.x / d.y, -d.z / d.y);
            let border = |t: f64| (2.0 * t - (2.0 * t).round()).abs() < 1e-4;
            if d.y > -0.1 || border(u) || border(v) {
                continue;
            }
            let there = ((2.0 * u).floor() + (2.0 * v).floor()).rem_euclid(2.0) == 0.0;
            assert_eq!(id[0] == 1, there, "pixel {i}");
            checked[usize::from(there)] += 1;
        }
        assert!(checked.iter().all(|&n| n > 300), "{checked:?}");
    }
}

#[test]
fn a_second_frame_forgets_the_first() {
    let triangles = soup(5, 50, 4);
    let objects = objects(&triangles, 5);
    let from = |z: f64| view(&objects, &camera(DVec3::new(0.0, 0.0, z), DVec3::ZERO), 20, 15);
    let mut used = fast(&objects, &from(9.0));
    for side in [40, 20] {
        let view = view(&objects, &camera(DVec3::new(5.0, 0.0, 5.0), DVec3::ZERO), side, 15);
        used.begin(&view).unwrap();
        used.draw(&all(&objects)).unwrap();
        assert_eq!(used.image(), fast(&objects, &view).image());
    }
}

#[test]
fn an_empty_world_draws_nothing() {
    let objects = Arc::new(Objects::default());
    let view = straight(&objects, 4, 3);
    for form in FORMS {
        assert_eq!(drawn(&form(&objects, &view)), 0);
    }
    let mut fast = fast(&objects, &view);
    fast.ask(&[], &[Query { boxes: 0..0 }]).unwrap();
    let mut counts = Vec::new();
    fast.collect(&mut counts).unwrap();
    assert_eq!(counts, [0]);
}

#[test]
fn samples_lie_between_their_corners() {
    let triangles = soup(77, 400, 4);
    let objects = objects(&triangles, 1);
    let view = view(&objects, &camera(DVec3::new(0.0, 0.0, 9.0), DVec3::ZERO), 40, 40);
    let projection = Projection::new(&view);
    let mut checked = 0;
    for triangle in &triangles {
        let corners = triangle.map(|p| Corner { clip: projection.clip(p), uv: glam::DVec2::ZERO });
        let depths =
            triangle.map(|p| view.depth((p.as_dvec3() - view.eye).dot(view.forward)) as f32);
        if depths.iter().any(|d| !(0.0..=1.0).contains(d)) {
            continue;
        }
        let range = depths[0].min(depths[1]).min(depths[2]) * 0.999_999
            ..=depths[0].max(depths[1]).max(depths[2]) * 1.000_001;
        samples(&projection, &corners, |_, depth, _| {
            assert!(range.contains(&depth));
            checked += 1;
        });
    }
    assert!(checked > 1000);
}
