//! Opacities follow materials, triangle by triangle.

use crate::shapes::level_patch;
use crate::translucent::{layered, sheets};
use dapple_scene::{Instance, Scene};
use dapple_trace::{Opacities, TraceError};
use glam::DAffine3;

#[test]
fn each_placed_triangle_has_its_materials_opacity() {
    let patch = |n| level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], n);
    let mut scene = layered(vec![(patch(1), 0.25), (patch(2), 1.0)]);
    scene.instances.insert(0, Instance { mesh: 1, transform: DAffine3::IDENTITY });
    let opacities = Opacities::of(&scene).unwrap();
    assert_eq!(opacities.triangles(), 18);
    for triangle in 0..18 {
        let translucent = (8..10).contains(&triangle);
        assert_eq!(opacities.alpha(triangle), if translucent { 0.25 } else { 1.0 });
        assert_eq!(opacities.is_opaque(triangle), !translucent);
    }
    assert_eq!((opacities.alpha(18), opacities.is_opaque(18)), (0.0, false));
    assert_eq!(Opacities::of(&Scene::default()).unwrap().triangles(), 0);
}

#[test]
fn what_is_no_opacity_is_refused_by_its_material() {
    for bad in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
        let error = Opacities::of(&sheets(&[(0.0, 0.5), (1.0, bad)])).unwrap_err();
        assert!(matches!(error, TraceError::Opacity { material: 1, .. }), "{error}");
        assert!(error.to_string().contains("material 1"), "{error}");
    }
    let mut lost = sheets(&[(0.0, 0.5)]);
    lost.meshes[0].material = 7;
    assert!(matches!(Opacities::of(&lost), Err(TraceError::MeshMaterial { .. })));
}
