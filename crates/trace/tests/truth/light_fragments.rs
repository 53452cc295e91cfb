//! Every fragment of a light's map.

use crate::translucent::sheets;
use dapple_scene::{LightView, Scene};
use dapple_trace::{
    LightFragments, MAX_MAP_SIDE, TraceError, Tracer, light_fragments, light_fragments_by_rays,
};
use glam::DVec3;

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
        let error = fragments(&tracer, &view, 1, MAX_MAP_SIDE + 1).unwrap_err();
        assert!(matches!(error, TraceError::MapSize { height, .. } if height > MAX_MAP_SIDE));
    }
}
