//! What a camera sees through translucent surfaces.

use crate::translucent::sheets;
use dapple_scene::{Camera, Projection, Scene};
use dapple_trace::{
    MAX_IMAGE_SIDE, MAX_LAYERS, Opacities, TraceError, Tracer, camera_layers, item_buffer, surfaces,
};
use glam::DVec3;

fn from_above(height_m: f64) -> Camera {
    Camera {
        name: String::new(),
        position: DVec3::Y * 100.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m },
    }
}

fn heights_seen(sheets_drawn: &[(f64, f32)]) -> Vec<f64> {
    let scene = sheets(sheets_drawn);
    let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
    // Wholly on the sheets, with centres on their diagonals.
    let layers = camera_layers(&tracer, &opacities, &from_above(1.0), 4, 4).unwrap();
    let first: Vec<f64> = layers.surfaces[layers.range(0)].iter().map(|s| s.position.y).collect();
    for pixel in 0..layers.pixels() {
        let range = layers.range(pixel);
        let same: Vec<f64> = layers.surfaces[range.clone()].iter().map(|s| s.position.y).collect();
        assert_eq!(same, first);
        for (surface, &alpha) in layers.surfaces[range.clone()].iter().zip(&layers.alpha[range]) {
            assert_eq!(alpha, opacities.alpha(surface.triangle));
            assert_eq!(alpha, sheets_drawn[surface.material as usize].1);
            assert!((surface.normal - DVec3::Y).length() < 1e-12, "towards the camera");
        }
    }
    first
}

#[test]
fn layers_go_from_front_to_back_and_end_with_the_first_opaque_one() {
    let drawn = [(0.5, 0.3), (2.0, 0.4), (1.0, 1.0), (-0.5, 0.5)];
    assert_eq!(heights_seen(&drawn), [2.0, 1.0]);
    let clear = [(0.5, 0.3), (2.0, 0.4), (1.0, 0.9), (-0.5, 0.5)];
    assert_eq!(heights_seen(&clear), [2.0, 1.0, 0.5, -0.5]);
}

#[test]
fn layers_end_where_nothing_behind_shows() {
    let stack = |count: usize, alpha: f32| -> usize {
        let drawn: Vec<_> = (0..count).map(|i| (-0.1 * i as f64, alpha)).collect();
        heights_seen(&drawn).len()
    };
    // 0.25^4 = 1/256 is the first power under 1/255.
    assert_eq!(stack(10, 0.75), 4);
    assert_eq!(stack(3, 0.75), 3);
    assert_eq!(stack(80, 0.01), MAX_LAYERS);
}

#[test]
fn the_first_layer_is_the_item_buffer() {
    let scene = sheets(&[(0.0, 0.5), (1.0, 0.25)]);
    let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
    let camera = Camera {
        position: DVec3::new(3.0, 4.0, 2.0),
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 0.6 },
        ..from_above(1.0)
    };
    let (width, height) = (31, 17);
    let layers = camera_layers(&tracer, &opacities, &camera, width, height).unwrap();
    let first = surfaces(&tracer, &item_buffer(&tracer, &camera, width, height));
    let mut seen = 0;
    for (pixel, expected) in first.iter().enumerate() {
        assert_eq!(layers.surfaces[layers.range(pixel)].first(), expected.as_ref());
        seen += usize::from(expected.is_some());
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn empty_scenes_and_images_are_fine_and_huge_ones_refused() {
    let scene = Scene::default();
    let (tracer, opacities) = (Tracer::build(&scene).unwrap(), Opacities::of(&scene).unwrap());
    let layers = camera_layers(&tracer, &opacities, &from_above(1.0), 3, 2).unwrap();
    assert_eq!((layers.starts, layers.surfaces.len()), (vec![0; 7], 0));
    let none = camera_layers(&tracer, &opacities, &from_above(1.0), 0, 2).unwrap();
    assert_eq!((none.starts.as_slice(), none.range(0)), ([0].as_slice(), 0..0));
    let error = camera_layers(&tracer, &opacities, &from_above(1.0), MAX_IMAGE_SIDE + 1, 1);
    assert!(matches!(error, Err(TraceError::MapSize { .. })));
}
