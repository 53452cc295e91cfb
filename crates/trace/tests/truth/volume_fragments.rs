//! Balls as volumes and as surfaces in a light's map.

use crate::shapes::{icosphere, rng, unit_vector};
use crate::translucent::layered;
use dapple_scene::{Aabb, LightView, Mesh};
use dapple_trace::{
    Ball, MAX_MAP_SIDE, Opacities, Profile, Ray, TraceError, Tracer, VolumeFragments, Voxels,
    ball_bounds, light_fragments, optical_depth, volume_fragments,
};
use glam::DVec3;
use rand::RngExt;

const SIDE: u32 = 48;

fn cloud(profiles: [Profile; 2]) -> Vec<Ball> {
    let mut rng = rng(8);
    let ball = |i: usize| Ball {
        centre: unit_vector(&mut rng) * rng.random::<f64>(),
        radius: rng.random_range(0.3..0.6),
        extinction: rng.random_range(0.3..1.0),
        profile: profiles[i % 2],
    };
    (0..20).map(ball).collect()
}

fn view_of(bounds: &Aabb) -> LightView {
    LightView::fit_directional(DVec3::new(0.3, -1.0, 0.2), bounds).unwrap()
}

/// The light ray through a texel's centre.
fn texel_ray(view: &LightView, texel: usize) -> Ray {
    let centre = |i: usize| (i as f64 + 0.5) / f64::from(SIDE);
    let (x, y) = (texel % SIDE as usize, texel / SIDE as usize);
    let (origin, direction) = view.ray(centre(x), centre(y));
    Ray { origin, direction, t_min: 0.0, t_max: 1.0 }
}

fn thickness_in_front(map: &VolumeFragments, texel: usize, depth: f64) -> f64 {
    let range = map.range(texel);
    let items = map.depth[range.clone()].iter().zip(&map.thickness[range]);
    items.filter(|f| f64::from(*f.0) < depth).map(|f| f64::from(*f.1)).sum()
}

#[test]
fn slices_add_up_to_the_chord_and_follow_it_within_half_a_slice() {
    let balls = cloud([Profile::Homogeneous, Profile::Soft]);
    let view = view_of(&ball_bounds(&balls).unwrap());
    for slices in [1, 4, 32] {
        let map = volume_fragments(&balls, &view, SIDE, SIDE, slices).unwrap();
        let mut covered = 0;
        for texel in 0..(SIDE * SIDE) as usize {
            let ray = texel_ray(&view, texel);
            let (whole, exact) =
                (thickness_in_front(&map, texel, 2.0), optical_depth(&balls, &ray));
            assert!((whole - exact).abs() < 1e-5, "texel {texel}: {whole} {exact}");
            covered += usize::from(exact > 0.1);
            let thickest = map.thickness[map.range(texel)].iter().fold(0.0, |a: f32, &b| a.max(b));
            for z in [0.3, 0.5, 0.7] {
                let got = thickness_in_front(&map, texel, z);
                let exact = optical_depth(&balls, &Ray { t_max: z, ..ray });
                // Of each ball at most one slice is cut; it counts wholly or not at all.
                let bound = f64::from(thickest) * balls.len() as f64;
                assert!((got - exact).abs() <= bound + 1e-5, "texel {texel}, {z}: {got} {exact}");
            }
        }
        assert!(covered > 600, "{covered}");
    }
}

#[test]
fn volumes_match_the_march_and_sphere_surfaces_do_not() {
    let balls = cloud([Profile::Homogeneous; 2]);
    let view = view_of(&ball_bounds(&balls).unwrap());
    let map = volume_fragments(&balls, &view, SIDE, SIDE, 32).unwrap();
    let grid = Voxels::of(&balls, 128).unwrap();

    // Each ball drawn as a sphere, its opacity that of half its middle chord at either side: right
    // through the middle, too dark elsewhere.
    let surface = |ball: &Ball| -> (Mesh, f32) {
        let mut mesh = icosphere(3);
        for p in &mut mesh.positions {
            *p = (ball.centre + p.as_dvec3() * ball.radius).as_vec3();
        }
        (mesh, (-(-ball.radius * ball.extinction).exp_m1()) as f32)
    };
    let scene = layered(balls.iter().map(surface).collect());
    let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
    let surfaces = light_fragments(&tracer, &view, SIDE, SIDE).unwrap();

    let (mut volume_error, mut surface_error, mut counted) = (0.0, 0.0, 0);
    for texel in 0..(SIDE * SIDE) as usize {
        let ray = texel_ray(&view, texel);
        if optical_depth(&balls, &ray) == 0.0 {
            continue;
        }
        for z in [0.4, 0.6, 1.0] {
            let marched = (-grid.optical_depth(&Ray { t_max: z, ..ray })).exp();
            let by_volume = (-thickness_in_front(&map, texel, z)).exp();
            let range = surfaces.range(texel);
            let in_front = surfaces.depth[range.clone()].iter().zip(&surfaces.triangle[range]);
            let by_surface: f64 = in_front
                .filter(|f| f64::from(*f.0) < z)
                .map(|f| 1.0 - f64::from(opacities.alpha(*f.1)))
                .product();
            volume_error += (by_volume - marched).powi(2);
            surface_error += (by_surface - marched).powi(2);
            counted += 1;
        }
    }
    let root = |sum: f64| (sum / f64::from(counted)).sqrt();
    let (volume, surface) = (root(volume_error), root(surface_error));
    assert!(counted > 2000 && volume < 0.01, "{counted}: {volume}");
    assert!(surface > 10.0 * volume, "{volume} {surface}");
}

#[test]
fn only_depths_between_near_and_far_count() {
    let ball =
        Ball { centre: DVec3::ZERO, radius: 1.0, extinction: 1.0, profile: Profile::Homogeneous };
    let view =
        LightView::fit_directional(DVec3::NEG_Y, &Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE })
            .unwrap();
    let whole = volume_fragments(&[ball], &view, 1, 1, 8).unwrap();
    assert!((thickness_in_front(&whole, 0, 2.0) - 2.0).abs() < 1e-6);
    // What lies in front of a depth is off by half a slice at most.
    let slice = 2.0 / 8.0;
    let mut most = 0.0_f64;
    for i in 0..=200 {
        let z = f64::from(i) / 200.0;
        let (origin, direction) = view.ray(0.5, 0.5);
        let exact = ball.optical_depth(&Ray { origin, direction, t_min: 0.0, t_max: z });
        most = most.max((thickness_in_front(&whole, 0, z) - exact).abs());
    }
    assert!(most < 0.5 * slice + 1e-6 && most > 0.4 * slice, "{most}");
    let middle = 0.5 * (view.near_m + view.far_m);
    for half in [LightView { near_m: middle, ..view }, LightView { far_m: middle, ..view }] {
        let map = volume_fragments(&[ball], &half, 1, 1, 8).unwrap();
        assert!((thickness_in_front(&map, 0, 2.0) - 1.0).abs() < 1e-6);
        assert!(map.depth.len() == 8 && map.depth.iter().all(|z| (0.0..=1.0).contains(z)));
    }
}

#[test]
fn nothing_is_fine_and_bad_balls_and_huge_maps_are_refused() {
    let bounds = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
    let view = view_of(&bounds);
    let map = volume_fragments(&[], &view, 3, 2, 4).unwrap();
    assert_eq!((map.starts, map.depth.len()), (vec![0; 7], 0));
    let bad = Ball { radius: -1.0, ..cloud([Profile::Soft; 2])[0] };
    assert!(matches!(
        volume_fragments(&[bad], &view, 3, 2, 4),
        Err(TraceError::Ball { ball: 0, .. })
    ));
    let huge = volume_fragments(&[], &view, MAX_MAP_SIDE + 1, 1, 4);
    assert!(matches!(huge, Err(TraceError::MapSize { .. })));
}
