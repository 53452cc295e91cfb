//! Every fragment of a light's map.

use crate::shapes::{icosphere, level_patch, mesh, patch, rng, unit_vector};
use crate::translucent::{cut_out, hair, layered, leaves, sheets, transformed};
use dapple_scene::{LightView, Mesh, Scene};
use dapple_trace::{
    LightFragments, MAX_MAP_SIDE, Ray, TraceError, Tracer, light_fragments, light_fragments_by_rays,
};
use glam::{DAffine3, DVec3};
use rand::RngExt;

/// Triangles of all sizes and shapes.
fn soup(count: u32, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let size = 10.0_f64.powf(rng.random_range(-3.0..0.5));
        let centre = unit_vector(&mut rng) * rng.random::<f64>();
        positions.extend((0..3).map(|_| (centre + unit_vector(&mut rng) * size).as_vec3()));
    }
    mesh(positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn both(scene: &Scene, view: &LightView, width: u32, height: u32) -> [LightFragments; 2] {
    let tracer = Tracer::build(scene).unwrap();
    [light_fragments, light_fragments_by_rays]
        .map(|fragments| fragments(&tracer, view, width, height).unwrap())
}

fn check_layout(map: &LightFragments) {
    assert_eq!(map.starts.len(), map.texels() + 1);
    assert_eq!(map.starts[0], 0);
    assert!(map.starts.is_sorted());
    assert_eq!(*map.starts.last().unwrap() as usize, map.depth.len());
    assert_eq!(map.depth.len(), map.triangle.len());
    assert!(map.depth.iter().all(|z| (0.0..=1.0).contains(z)));
    for texel in 0..map.texels() {
        assert!(map.triangle[map.range(texel)].is_sorted(), "draw order");
    }
}

#[test]
fn sheets_are_met_once_a_texel_in_draw_order() {
    // Drawn out of order, two of them at one height; 9 texels a side put centres on diagonals.
    let heights = [(0.5, 0.3), (2.0, 0.4), (0.5, 0.5), (1.0, 1.0), (-0.25, 0.2)];
    let scene = sheets(&heights);
    let bounds = scene.bounds();
    let parallel = LightView::fit_directional(DVec3::NEG_Y, &bounds).unwrap();
    let spot = LightView::fit_spot(DVec3::new(0.0, 9.0, 0.0), DVec3::NEG_Y, 0.08, &bounds).unwrap();
    for (view, [width, height]) in [(parallel, [9, 9]), (parallel, [16, 5]), (spot, [9, 7])] {
        for map in both(&scene, &view, width, height) {
            check_layout(&map);
            for texel in 0..map.texels() {
                let range = map.range(texel);
                let expected: Vec<f32> = heights
                    .iter()
                    .map(|&(y, _)| view.project(DVec3::new(0.0, y, 0.0)).z as f32)
                    .collect();
                assert_eq!(range.len(), heights.len(), "texel {texel}");
                let sheet: Vec<usize> =
                    map.triangle[range.clone()].iter().map(|&t| t as usize / 2).collect();
                assert_eq!(sheet, [0, 1, 2, 3, 4]);
                for (depth, expected) in map.depth[range].iter().zip(&expected) {
                    assert!((depth - expected).abs() < 1e-6, "{depth} {expected}");
                }
            }
        }
    }
}

#[test]
fn only_depths_between_near_and_far_count() {
    let scene = sheets(&[(0.0, 0.5), (1.0, 0.5), (2.0, 0.5)]);
    let mut view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    let depth_of = |y: f64| view.project(DVec3::new(0.0, y, 0.0)).z * (view.far_m - view.near_m);
    let (near, far) = (depth_of(1.5), depth_of(0.5));
    (view.near_m, view.far_m) = (near, far);
    for map in both(&scene, &view, 6, 6) {
        check_layout(&map);
        assert_eq!(map.depth.len(), 36);
        assert!(map.triangle.iter().all(|t| (2..4).contains(t)));
        assert!(map.depth.iter().all(|z| (z - 0.5).abs() < 1e-6));
    }
}

#[test]
fn empty_maps_and_scenes_have_no_fragments_and_huge_maps_are_refused() {
    let scene = sheets(&[(0.0, 0.5)]);
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    for map in both(&Scene::default(), &view, 4, 3) {
        assert_eq!((map.starts, map.depth.len()), (vec![0; 13], 0));
    }
    for [width, height] in [[0, 5], [5, 0], [0, 0]] {
        for map in both(&scene, &view, width, height) {
            assert_eq!((map.starts.as_slice(), map.depth.len()), ([0].as_slice(), 0));
            assert_eq!(map.range(0), 0..0);
        }
    }
    let tracer = Tracer::build(&scene).unwrap();
    for fragments in [light_fragments, light_fragments_by_rays] {
        // Views that are none see nothing, or a line.
        for half_extent in [f64::NAN, f64::INFINITY, 0.0, 1e-320, 1e300] {
            let strange = LightView { half_extent, ..view };
            assert!(fragments(&tracer, &strange, 4, 4).unwrap().depth.len() <= 16);
        }
        let flat = LightView { far_m: view.near_m, ..view };
        assert!(fragments(&tracer, &flat, 4, 4).unwrap().depth.is_empty());
        let error = fragments(&tracer, &view, 1, MAX_MAP_SIDE + 1).unwrap_err();
        assert!(matches!(error, TraceError::MapSize { height, .. } if height > MAX_MAP_SIDE));
    }
}

/// Texels where the two ways differ in triangles; depths must agree wherever triangles do, and the
/// number of fragments everywhere but in `miscounted` texels.
struct Difference {
    fragments: usize,
    other_triangles: usize,
    miscounted: usize,
}

fn difference(scene: &Scene, view: &LightView, size: [u32; 2]) -> Difference {
    let [filled, rays] = both(scene, view, size[0], size[1]);
    check_layout(&filled);
    check_layout(&rays);
    let mut found = Difference { fragments: rays.depth.len(), other_triangles: 0, miscounted: 0 };
    for texel in 0..filled.texels() {
        let (a, b) = (filled.range(texel), rays.range(texel));
        found.miscounted += usize::from(a.len() != b.len());
        if filled.triangle[a.clone()] != rays.triangle[b.clone()] {
            found.other_triangles += 1;
            continue;
        }
        for (a, b) in filled.depth[a].iter().zip(&rays.depth[b]) {
            assert!((a - b).abs() <= f32::EPSILON, "texel {texel}: {a} {b}");
        }
    }
    found
}

#[test]
fn filling_and_rays_agree_on_anything_but_ties() {
    let camera = DVec3::new(0.0, 2.0, 9.0);
    let scenes = [
        // Slivers and triangles larger than the map, foliage, cut-out cards, hair, closed bodies.
        layered(vec![(soup(400, 4), 0.5)]),
        layered(vec![(leaves(1500, 0.1, 1), 0.7), (icosphere(3), 1.0)]),
        cut_out(layered(vec![(leaves(400, 0.4, 2), 0.7)])),
        layered(vec![(hair(2000, 8, 0.01, camera, 3), 0.275)]),
    ];
    let directions =
        [DVec3::NEG_Y, DVec3::new(0.3, -1.0, 0.2), DVec3::X, DVec3::new(1.0, 1e-7, 0.0)];
    for (i, scene) in scenes.iter().enumerate() {
        for direction in directions {
            let view = LightView::fit_directional(direction, &scene.bounds()).unwrap();
            for size in [[97, 61], [128, 128], [1, 1]] {
                let found = difference(scene, &view, size);
                let what = format!("scene {i}, {direction}, {size:?}");
                assert_eq!((found.other_triangles, found.miscounted), (0, 0), "{what}");
                assert!(found.fragments > 3000 || size[0] < 128, "{what}: {}", found.fragments);
            }
        }
    }
}

#[test]
fn filling_and_rays_agree_at_any_scale_and_place() {
    let scene = layered(vec![(leaves(600, 0.2, 1), 0.7), (icosphere(2), 1.0)]);
    for (scale, shift) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e7)] {
        let map = DAffine3::from_translation(DVec3::new(shift, 0.0, -shift))
            * DAffine3::from_scale(DVec3::splat(scale));
        let scene = transformed(scene.clone(), map);
        let direction = DVec3::new(0.3, -1.0, 0.2);
        let view = LightView::fit_directional(direction, &scene.bounds()).unwrap();
        let found = difference(&scene, &view, [128, 128]);
        assert_eq!(found.miscounted, 0, "{scale} {shift}");
        assert!(found.other_triangles <= 1 && found.fragments > 10_000, "{scale} {shift}");
    }
}

#[test]
fn at_exact_ties_the_number_of_fragments_is_the_same() {
    // Texel centres on edges, diagonals and vertices of tessellated sheets, two of them continuing
    // each other: always one fragment a sheet.
    let patch = |x: [f64; 2], y| level_patch(x, y, [-1.0, 1.0], 8);
    let scene = layered(vec![
        (patch([-1.0, 0.0], 0.0), 0.5),
        (patch([0.0, 1.0], 0.0), 0.5),
        (patch([-1.0, 1.0], 1.0), 0.5),
    ]);
    let mut view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    view.half_extent = 1.0;
    // Centres at odd multiples of 1/8, 1/16 and 1/32 of the sheets' half sides.
    for n in [8, 16, 32] {
        let found = difference(&scene, &view, [n, n]);
        assert_eq!((found.fragments, found.miscounted), (2 * (n * n) as usize, 0), "{n}");
    }
    // Shifted by half a texel, and with a border around, every centre is a vertex of both sheets.
    view.half_extent = 0.75;
    view.origin += (view.right + view.down) / 8.0;
    let found = difference(&scene, &view, [6, 6]);
    assert_eq!((found.fragments, found.miscounted), (2 * 6 * 6, 0));
    // The sides chosen differ here and there (28 of 36 texels): these are ties indeed.
    assert!(found.other_triangles > 0);
    // The control: counting both sides of an edge would find more.
    let (tracer, mut hits) = (Tracer::build(&scene).unwrap(), Vec::new());
    let (origin, direction) = view.ray(0.25, 0.25);
    tracer.all(&Ray { origin, direction, t_min: 0.0, t_max: 1.0 }, &mut hits);
    assert!(hits.len() > 2, "{}", hits.len());
}

#[test]
fn ribbons_seen_along_their_plane_and_flat_scenes_are_no_exception() {
    // All in the plane that the light travels in; then all at one depth.
    let blade = |z: f64| {
        patch(
            [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z)),
            3,
        )
    };
    let edge_on = layered((0..40).map(|i| (blade(0.0123 * f64::from(i)), 0.5)).collect());
    let view = LightView::fit_directional(DVec3::NEG_Y, &edge_on.bounds()).unwrap();
    assert_eq!(difference(&edge_on, &view, [64, 64]).fragments, 0);
    // All but edge-on: the two must still tell the same.
    let slight = DVec3::new(0.0, -1.0, 1e-9);
    let view = LightView::fit_directional(slight, &edge_on.bounds()).unwrap();
    assert_eq!(difference(&edge_on, &view, [64, 64]).miscounted, 0);

    let flat =
        layered((0..5).map(|_| (level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 3), 0.5)).collect());
    let view = LightView::fit_directional(DVec3::NEG_Y, &flat.bounds()).unwrap();
    let found = difference(&flat, &view, [33, 33]);
    assert_eq!(found.miscounted, 0);
    assert!(found.fragments > 5 * 900, "{}", found.fragments);
}

#[test]
fn sorting_orders_depths_and_keeps_draw_order_at_ties() {
    let scene = sheets(&[(0.5, 0.3), (2.0, 0.4), (0.5, 0.5), (1.0, 1.0), (0.5, 0.2)]);
    let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
    for mut map in both(&scene, &view, 11, 7) {
        let starts = map.starts.clone();
        map.sort_by_depth();
        assert_eq!(map.starts, starts);
        for texel in 0..map.texels() {
            let sheet: Vec<u32> = map.triangle[map.range(texel)].iter().map(|t| t / 2).collect();
            assert_eq!(sheet, [1, 3, 0, 2, 4]);
            assert!(map.depth[map.range(texel)].is_sorted());
        }
    }
    LightFragments::default().sort_by_depth();
}

#[test]
fn thread_counts_do_not_matter() {
    let scene = layered(vec![(leaves(600, 0.2, 1), 0.7)]);
    let view = LightView::fit_directional(DVec3::new(1.0, -2.0, 0.5), &scene.bounds()).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| both(&scene, &view, 61, 147))
    };
    assert_eq!(with(1), with(3));
}
