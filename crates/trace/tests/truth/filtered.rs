//! The box-filtered shadow against its formulas.

use crate::shapes::{icosphere, level_patch, patch, placed, scene};
use dapple_scene::{LightView, Mesh, Scene};
use dapple_trace::{Ray, Surface, Tracer, filtered_visibility, filtered_visibility_all, receiver};
use glam::{DAffine3, DQuat, DVec3};

fn surface_below(tracer: &Tracer, view: &LightView, u: f64, v: f64) -> Surface {
    let (origin, direction) = view.ray(u, v);
    let ray = Ray { origin, direction, t_min: 0.0, t_max: 2.0 };
    tracer.surface(&ray, &tracer.closest(&ray).unwrap())
}

/// y = slope * x over x in -1..1, z in -1..1, in n × n cells.
fn slanted(slope: f64, n: u32) -> Mesh {
    let corner = |x: f64, z: f64| DVec3::new(x, slope * x, z);
    patch([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], n)
}

fn placed_with_roof(slope: f64) -> Scene {
    // The roof's edge lies over x = 0.1, above all of the slope.
    let roof = level_patch([-1.0, 0.1], 3.0, [-1.0, 1.0], 1);
    scene(vec![(slanted(slope, 9), DAffine3::IDENTITY), (roof, DAffine3::IDENTITY)])
}

#[test]
fn a_half_plane_gives_the_linear_ramp_of_a_box_on_any_slope() {
    let mut partial = 0;
    for slope in [0.0, 1.0, -2.0] {
        let scene = placed_with_roof(slope);
        let tracer = Tracer::build(&scene).unwrap();
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        let width_m = 0.4;
        let width_uv = width_m / view.side_m();
        for i in -8..=8 {
            let x = 0.1 + 0.05 * f64::from(i);
            let ray = Ray::new(DVec3::new(x, 2.9, 0.03), DVec3::NEG_Y);
            let surface = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
            let got = filtered_visibility(&tracer, &view, &surface, width_uv, 32, 9);
            let expected = (0.5 + (x - 0.1) / width_m).clamp(0.0, 1.0);
            // One column of 32 samples straddles the edge: 4 sigma.
            assert!((got - expected).abs() < 0.0111, "slope {slope}, x {x}: {got} {expected}");
            partial += i32::from(expected > 0.0 && expected < 1.0);
        }
    }
    assert_eq!(partial, 3 * 7);
}

#[test]
fn an_edge_turned_against_the_map_gives_the_area_it_cuts_off() {
    // The roof's edge is the diagonal x = z: a window shifted by s along x is cut in a trapezoid.
    let corner = |x: f64, z: f64| DVec3::new(x, 1.0, z);
    let roof =
        patch([corner(-2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0), corner(-2.0, 0.0)], 1);
    let floor = level_patch([-2.0, 2.0], 0.0, [-2.0, 2.0], 1);
    let scene = scene(vec![(floor, DAffine3::IDENTITY), (roof, DAffine3::IDENTITY)]);
    let tracer = Tracer::build(&scene).unwrap();
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    let width = 0.5;
    for i in -5..=5 {
        let s = 0.1 * f64::from(i);
        let ray = Ray::new(DVec3::new(s, 0.5, 0.0), DVec3::NEG_Y);
        let surface = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
        let got = filtered_visibility(&tracer, &view, &surface, width / view.side_m(), 64, 2);
        // x > z is lit; the lesser part is a right isosceles triangle of legs width - |s|.
        let lesser = 0.5 * (1.0 - s.abs() / width).max(0.0).powi(2);
        let expected = if s > 0.0 { 1.0 - lesser } else { lesser };
        assert!((got - expected).abs() < 0.006, "{s}: {got} {expected}");
    }
}

/// y = x² over x in -1..1, as fine as f32 allows the tangent plane to be far from it.
fn valley() -> Mesh {
    let mut valley = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 200);
    for p in &mut valley.positions {
        p.y = p.x * p.x;
    }
    valley
}

#[test]
fn a_curved_receiver_does_not_shadow_itself_but_what_hangs_over_it_does() {
    let slat = |y: f64| level_patch([-1.0, 0.0], y, [-1.0, 1.0], 1);
    let open = placed(valley());
    let covered = scene(vec![(valley(), DAffine3::IDENTITY), (slat(1.5), DAffine3::IDENTITY)]);
    let width_m = 0.3;
    for (scene, has_slat) in [(open, false), (covered, true)] {
        let tracer = Tracer::build(&scene).unwrap();
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        for x in [-0.7, -0.4, -0.05, 0.0, 0.05, 0.4, 0.7] {
            let ray = Ray::new(DVec3::new(x, 1.2, 0.013), DVec3::NEG_Y);
            let surface = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
            let got = filtered_visibility(&tracer, &view, &surface, width_m / view.side_m(), 32, 4);
            let ramp = (0.5 + x / width_m).clamp(0.0, 1.0);
            let expected = if has_slat { ramp } else { 1.0 };
            assert!((got - expected).abs() < 0.0111, "x {x}, slat {has_slat}: {got} {expected}");
        }
    }
}

#[test]
fn a_slat_within_the_reach_of_the_floor_still_shadows_it() {
    let floor = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 3);
    for height in [1e-3, 0.02, 0.1, 0.14] {
        let slat = level_patch([-1.0, 0.0], height, [-1.0, 1.0], 1);
        let parts = vec![(floor.clone(), DAffine3::IDENTITY), (slat, DAffine3::IDENTITY)];
        let scene = scene(parts);
        let tracer = Tracer::build(&scene).unwrap();
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        // The reach is half of the window's 0.3 m: more than any of these heights.
        let width_m = 0.3;
        for x in [-0.5, -0.1, 0.0, 0.1, 0.5] {
            let ray = Ray::new(DVec3::new(x, 0.5 * height, 0.013), DVec3::NEG_Y);
            let surface = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
            let got = filtered_visibility(&tracer, &view, &surface, width_m / view.side_m(), 32, 4);
            let expected = (0.5 + x / width_m).clamp(0.0, 1.0);
            assert!((got - expected).abs() < 0.0111, "{height}, x {x}: {got} {expected}");
        }
    }
}

/// Leaves side by side at slightly different heights: one is no part of the other.
#[test]
fn a_leaf_within_reach_shadows_its_neighbour() {
    let low = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 1);
    let high = level_patch([0.05, 1.0], 0.02, [-1.0, 1.0], 1);
    let scene = scene(vec![(low, DAffine3::IDENTITY), (high, DAffine3::IDENTITY)]);
    let tracer = Tracer::build(&scene).unwrap();
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    let ray = Ray::new(DVec3::new(0.0, 1.0, 0.013), DVec3::NEG_Y);
    let surface = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
    let got = filtered_visibility(&tracer, &view, &surface, 0.4 / view.side_m(), 32, 4);
    // The window reaches from -0.2 to 0.2; from 0.05 on the other leaf is above.
    assert!((got - 0.625).abs() < 0.0111, "{got}");
}

#[test]
fn a_slanted_receiver_does_not_shadow_itself() {
    let mut tried = 0;
    for degrees in [0.0_f64, 30.0, 60.0, 80.0, 85.0, -45.0, -85.0] {
        for (cells, offset) in [(1, 0.0), (25, 0.0), (25, 1e7)] {
            let shift = DVec3::new(offset, 0.0, offset);
            let plane = slanted(degrees.to_radians().tan(), cells);
            let scene = scene(vec![(plane, DAffine3::from_translation(shift))]);
            let tracer = Tracer::build(&scene).unwrap();
            let above = shift + DVec3::new(0.0, 40.0, 0.0);
            let views = [
                LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap(),
                LightView::fit_spot(above, DVec3::NEG_Y, 0.06, &scene.bounds()).unwrap(),
            ];
            for view in views {
                for i in 0..25 {
                    let (x, z) = (f64::from(i % 5) * 0.36 - 0.7, f64::from(i / 5) * 0.36 - 0.7);
                    let y = degrees.to_radians().tan() * x;
                    let at = view.project(shift + DVec3::new(x, y, z));
                    let surface = surface_below(&tracer, &view, at.x, at.y);
                    if receiver(&view, &surface).is_none() {
                        // Past 83 degrees a point light may stand behind the plane.
                        assert!(view.perspective && degrees.abs() > 83.0);
                        continue;
                    }
                    let got = filtered_visibility(&tracer, &view, &surface, 0.1, 16, 3);
                    assert_eq!(got, 1.0, "{degrees} degrees, {cells} cells, {offset:e}");
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 900, "{tried}");
}

/// The control: without the plane (a normal towards the light) the same receivers shadow themselves,
/// but for the tenth of the window where the slope of 5 stays within the reach of half a width.
#[test]
fn comparing_with_one_depth_would_shadow_a_slope() {
    let scene = placed(slanted(5.0, 25));
    let tracer = Tracer::build(&scene).unwrap();
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    let at = view.project(DVec3::new(0.1, 0.5, 0.1));
    let surface = surface_below(&tracer, &view, at.x, at.y);
    let flat = Surface { normal: DVec3::Y, ..surface };
    let got = filtered_visibility(&tracer, &view, &flat, 0.1, 16, 3);
    assert!((got - 0.6).abs() < 0.02, "{got}");
}

#[test]
fn facing_away_is_dark_and_no_receiver_is_lit() {
    let scene = placed(level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 1));
    let tracer = Tracer::build(&scene).unwrap();
    let view = LightView::fit_directional(DVec3::new(0.1, -1.0, 0.0), &scene.bounds()).unwrap();
    let surface = surface_below(&tracer, &view, 0.5, 0.5);
    let away = Surface { normal: -surface.normal, ..surface };
    let grazing = Surface { normal: view.right, ..surface };
    let nan = Surface { position: DVec3::NAN, ..surface };
    assert!(receiver(&view, &surface).is_some());
    for bad in [away, grazing, nan] {
        assert_eq!(receiver(&view, &bad), None);
        assert_eq!(filtered_visibility(&tracer, &view, &bad, 0.1, 4, 0), 0.0);
    }
    let all =
        filtered_visibility_all(&tracer, &view, &[Some(surface), Some(away), None], 0.1, 0, 0);
    assert_eq!(all, [1.0, 0.0, 1.0]);
}

#[test]
fn the_receiver_plane_is_what_projection_makes_of_the_tangent_plane() {
    let scene = placed(icosphere(3));
    let tracer = Tracer::build(&scene).unwrap();
    let bounds = scene.bounds();
    let views = [
        LightView::fit_directional(DVec3::new(0.4, -1.0, -0.3), &bounds).unwrap(),
        LightView::fit_spot(DVec3::new(1.0, 4.0, 2.0), DVec3::new(-1.0, -4.0, -2.0), 0.3, &bounds)
            .unwrap(),
    ];
    let mut checked = 0;
    for view in views {
        for i in 0..100 {
            let (u, v) = (0.35 + 0.03 * f64::from(i % 10), 0.35 + 0.03 * f64::from(i / 10));
            let surface = surface_below(&tracer, &view, u, v);
            let plane = receiver(&view, &surface).unwrap();
            let at = view.project(surface.position);
            assert_eq!(DVec3::new(plane.u, plane.v, plane.z), at);
            let tangent = surface.normal.any_orthonormal_vector();
            for along in [tangent, surface.normal.cross(tangent)] {
                // Central differences are exact for parallel light, second order otherwise.
                let h = 1e-4;
                let step = |s: f64| view.project(surface.position + along * s);
                let d = (step(h) - step(-h)) / (2.0 * h);
                let expected = plane.dz_du * d.x + plane.dz_dv * d.y;
                assert!((d.z - expected).abs() < 1e-7, "{} {expected}", d.z);
                checked += 1;
            }
            let to_light = if view.perspective {
                (view.origin - surface.position).normalize()
            } else {
                -view.forward
            };
            assert!((plane.n_dot_l - surface.normal.dot(to_light)).abs() < 1e-12);
        }
    }
    assert_eq!(checked, 400);
}

#[test]
fn results_do_not_depend_on_threads() {
    let scene = placed_with_roof(1.0);
    let tracer = Tracer::build(&scene).unwrap();
    let turn = DQuat::from_rotation_x(0.2) * DVec3::NEG_Y;
    let view = LightView::fit_directional(turn, &scene.bounds()).unwrap();
    let receivers: Vec<_> = (0..200)
        .map(|i| Some(surface_below(&tracer, &view, 0.4 + 0.001 * f64::from(i), 0.5)))
        .collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filtered_visibility_all(&tracer, &view, &receivers, 0.2, 6, 11))
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert!(one.iter().any(|&v| v > 0.0 && v < 1.0));
}
