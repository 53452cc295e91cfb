use super::*;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

pub(super) const SIZE: u32 = 48;

pub(super) fn camera(position: DVec3, target: DVec3, projection: Projection) -> Camera {
    Camera { name: "test".into(), position, target, up: DVec3::Y, projection }
}

pub(super) fn perspective(fov_y_rad: f64) -> Projection {
    Projection::Perspective { fov_y_rad }
}

fn view(projection: Projection, near_m: f64) -> View {
    let camera = camera(DVec3::ZERO, DVec3::NEG_Z, projection);
    View::new(&camera, &Objects::default(), SIZE, SIZE, near_m).unwrap()
}

fn bounds(min: [f32; 3], max: [f32; 3]) -> Bounds {
    Bounds { min: Vec3::from_array(min), max: Vec3::from_array(max) }
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
