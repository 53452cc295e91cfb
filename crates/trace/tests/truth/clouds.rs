//! Clouds of small quads of known density against the exponential of their optical thickness.

use crate::shapes::{mesh, rng, unit_vector};
use crate::translucent::{layered, sheets};
use dapple_scene::{LightView, Mesh};
use dapple_trace::{
    Law, LightFragments, LightPath, Opacities, Tracer, light_fragments, transmittance_all,
};
use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

/// The deep shadow map's answer: the product over a texel's fragments in front of a depth.
fn product(map: &LightFragments, opacities: &Opacities, texel: usize, depth: f64) -> f64 {
    let range = map.range(texel);
    let in_front = map.depth[range.clone()].iter().zip(&map.triangle[range]);
    in_front
        .filter(|&(&z, _)| f64::from(z) < depth)
        .map(|(_, &triangle)| 1.0 - f64::from(opacities.alpha(triangle)))
        .product()
}

#[test]
fn a_slab_of_n_sheets_is_within_one_nth_of_its_exponential() {
    for n in [1, 4, 16, 64, 256] {
        // Optical thickness 1 over a height of 1, a sheet in the middle of each nth.
        let tau = 1.0 / f64::from(n);
        let alpha = (-(-tau).exp_m1()) as f32;
        let height = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let mut drawn: Vec<_> = (0..n).map(|i| (height(i), alpha)).collect();
        drawn.extend([(-1.0, 0.0), (2.0, 0.0)]);
        let scene = sheets(&drawn);
        let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        let map = light_fragments(&tracer, &view, 3, 3).unwrap();
        let mut most = 0.0_f64;
        for i in 0..=1000 {
            let below_top = f64::from(i) / 1000.0 * 1.2 - 0.1;
            let position = DVec3::new(0.01, 1.0 - below_top, 0.02);
            let expected = (-below_top.clamp(0.0, 1.0)).exp();
            let path = LightPath { position, triangle: u32::MAX, opaque: false };
            let rays =
                transmittance_all(&tracer, &opacities, &view, Law::Product, None, &[path], 1)[0];
            let depth = view.project(position).z;
            let texel = product(&map, &opacities, 4, depth);
            // Within f32 depths' rounding of a sheet the two may differ by it.
            let at_sheet =
                map.depth[map.range(4)].iter().any(|&z| (f64::from(z) - depth).abs() < 1e-6);
            assert!(at_sheet || (rays - texel).abs() < 1e-12, "{n}: {rays} {texel}");
            most = most.max((rays - expected).abs());
        }
        // Half a step at either side of a sheet, and no better than that.
        assert!(most < 0.5 * tau && most > 0.3 * tau, "{n}: {most}");
    }
}

/// Level squares of a side around random centres, as one mesh.
fn squares(count: u32, side: f64, rng: &mut Pcg64, centre: impl Fn(&mut Pcg64) -> DVec3) -> Mesh {
    let (mut positions, mut triangles) = (Vec::<Vec3>::new(), Vec::new());
    for i in 0..count {
        let middle = centre(rng);
        for (x, z) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            positions.push((middle + DVec3::new(x, 0.0, z) * side).as_vec3());
        }
        triangles.extend([[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]);
    }
    mesh(positions, triangles)
}

const SIDE: f64 = 0.02;
const COUNT: u32 = 80_000;
const ALPHA: f32 = 0.2;
const TEXELS: u32 = 64;

/// Difference between rays' mean transmittance and the mean expected, in standard errors; texels
/// lie farther apart than squares are wide, so that rays are all but independent.
fn deviation(
    cloud: Mesh,
    half_extent: f64,
    floor_y: f64,
    optical_thickness: impl Fn(DVec3) -> f64,
) -> (f64, f64) {
    let scene = layered(vec![(cloud, ALPHA)]);
    let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
    let mut view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    view.half_extent = half_extent;
    assert!(2.0 * half_extent / f64::from(TEXELS) > SIDE);
    let map = light_fragments(&tracer, &view, TEXELS, TEXELS).unwrap();
    let mut paths = Vec::new();
    for texel in 0..TEXELS * TEXELS {
        let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(TEXELS);
        let mut position = view.ray(centre(texel % TEXELS), centre(texel / TEXELS)).0;
        position.y = floor_y;
        paths.push(LightPath { position, triangle: u32::MAX, opaque: false });
    }
    let rays = transmittance_all(&tracer, &opacities, &view, Law::Product, None, &paths, 1);
    let (mut sum, mut squares, mut expected_sum) = (0.0, 0.0, 0.0);
    for (texel, (path, &got)) in paths.iter().zip(&rays).enumerate() {
        let stored = product(&map, &opacities, texel, view.project(path.position).z);
        assert!((stored - got).abs() < 1e-9, "texel {texel}: {stored} {got}");
        let expected = (-optical_thickness(path.position)).exp();
        (sum, squares) = (sum + got - expected, squares + (got - expected).powi(2));
        expected_sum += expected;
    }
    let n = rays.len() as f64;
    let error = ((squares - sum * sum / n) / (n - 1.0) / n).sqrt();
    (sum / n / error, expected_sum / n)
}

#[test]
fn a_random_box_of_squares_is_exponential_within_its_sampling_error() {
    let in_box =
        |rng: &mut Pcg64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    // Covered share of one square times its opacity, per metre of height.
    let density = f64::from(COUNT) * SIDE * SIDE / 8.0 * f64::from(ALPHA);
    for floor_y in [0.5, 0.0, -1.0] {
        let cloud = squares(COUNT, SIDE, &mut rng(3), in_box);
        let (sigmas, mean) = deviation(cloud, 0.9, floor_y, |p| density * (1.0 - p.y));
        assert!(sigmas.abs() < 4.0 && mean < 0.7, "{floor_y}: {sigmas} at {mean}");
    }
    // The comparison can fail: a density wrong by five percent does.
    let cloud = squares(COUNT, SIDE, &mut rng(3), in_box);
    let (sigmas, _) = deviation(cloud, 0.9, -1.0, |p| 1.05 * density * (1.0 - p.y));
    assert!(sigmas > 4.0, "{sigmas}");
}

#[test]
fn a_random_ball_of_squares_is_exponential_in_its_chords() {
    let in_ball = |rng: &mut Pcg64| unit_vector(rng) * rng.random::<f64>().cbrt();
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    let density = f64::from(COUNT) * SIDE * SIDE / volume * f64::from(ALPHA);
    let half = |p: DVec3| (1.0 - p.x * p.x - p.z * p.z).max(0.0).sqrt();
    for floor_y in [0.0, -1.5] {
        let cloud = squares(COUNT, SIDE, &mut rng(5), in_ball);
        let thickness = |p: DVec3| density * (half(p) - p.y.clamp(-half(p), half(p)));
        let (sigmas, mean) = deviation(cloud, 0.7, floor_y, thickness);
        assert!(sigmas.abs() < 4.0 && mean < 0.5, "{floor_y}: {sigmas} at {mean}");
    }
}
