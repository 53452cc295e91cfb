//! Bad and empty input, alpha tests, what a hit lies on.

use crate::shapes::{icosphere, level_patch, mesh, placed, scene};
use dapple_scene::{AlphaTest, Camera, Instance, LightView, Material, Projection, Texture};
use dapple_trace::{Ray, TraceError, Tracer, filtered_visibility, item_buffer, surfaces};
use glam::{DAffine3, DVec3, Vec2, Vec3};

#[test]
fn an_empty_scene_is_missed() {
    let tracer = Tracer::build(&scene(vec![])).unwrap();
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    assert_eq!((tracer.closest(&ray), tracer.any(&ray)), (None, false));
    assert_eq!(tracer.traced_triangles(), 0);
}

#[test]
fn rays_that_are_not_numbers_hit_nothing() {
    let tracer = Tracer::build(&placed(icosphere(2))).unwrap();
    let good = Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z);
    assert!(tracer.any(&good));
    let mut tried = 0;
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..3 {
            let (mut origin, mut direction) = (good.origin, good.direction);
            origin[i] = bad;
            direction[i] = bad;
            for ray in [Ray { origin, ..good }, Ray { direction, ..good }] {
                assert_eq!((tracer.closest(&ray), tracer.any(&ray)), (None, false), "{ray:?}");
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 18);
    for ray in [
        Ray { direction: DVec3::ZERO, ..good },
        Ray { t_min: f64::NAN, ..good },
        Ray { t_max: f64::NAN, ..good },
        Ray { t_min: f64::INFINITY, ..good },
        Ray { t_max: f64::NEG_INFINITY, ..good },
        Ray { origin: DVec3::splat(f64::MAX), ..good },
    ] {
        assert_eq!(tracer.closest(&ray), None, "{ray:?}");
    }
    // Directions whose square is out of range are directions all the same.
    for length in [1e-300, 1e-200, 1e-6, 1e6, 1e200, 1e300] {
        let hit = tracer.closest(&Ray { direction: good.direction * length, ..good }).unwrap();
        let expected = tracer.closest(&good).unwrap().t;
        assert!((hit.t * length / expected - 1.0).abs() < 1e-12, "{length}");
    }
}

#[test]
fn bad_scenes_are_refused_by_element() {
    let good = placed(icosphere(0));
    let build = |scene: &_| Tracer::build(scene).err().unwrap();

    let mut bad = good.clone();
    bad.meshes[0].positions[3].y = f32::NAN;
    assert!(matches!(build(&bad), TraceError::NonFinite { instance: 0, .. }));
    let mut bad = good.clone();
    bad.instances[0].transform.translation.x = f64::INFINITY;
    assert_eq!(build(&bad), TraceError::NonFinite { instance: 0, triangle: 0 });
    let mut bad = good.clone();
    bad.meshes[0].triangles[4][1] = 12;
    let error = TraceError::VertexIndex { mesh: 0, triangle: 4, vertex: 12, vertices: 12 };
    assert_eq!(build(&bad), error);
    assert_eq!(error.to_string(), "mesh 0, triangle 4: vertex 12 of 12");
    let mut bad = good.clone();
    bad.meshes[0].material = 1;
    assert!(matches!(build(&bad), TraceError::MeshMaterial { mesh: 0, material: 1, .. }));
    let mut bad = good.clone();
    bad.meshes[0].uvs = vec![Vec2::ZERO; 3];
    assert!(matches!(build(&bad), TraceError::UvCount { uvs: 3, vertices: 12, .. }));
    let mut bad = good.clone();
    bad.instances[0].mesh = 7;
    assert!(matches!(build(&bad), TraceError::InstanceMesh { mesh: 7, .. }));
    let mut bad = good.clone();
    bad.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
    assert!(matches!(build(&bad), TraceError::AlphaTexture { textures: 0, .. }));
    let mut bad = good.clone();
    bad.textures.push(Texture {
        texels: vec![[0; 4]; 3],
        width: 2,
        height: 2,
        ..Texture::default()
    });
    assert!(matches!(build(&bad), TraceError::TexelCount { texels: 3, .. }));
    let mut bad = good.clone();
    bad.instances[0].transform = DAffine3::from_scale(DVec3::splat(1e301));
    assert!(matches!(build(&bad), TraceError::TooLarge { .. }));
    assert!(Tracer::build(&good).is_ok());
}

#[test]
fn degenerate_triangles_neither_panic_nor_are_hit() {
    let p = vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::splat(3.0)];
    let scene = placed(mesh(p, vec![[0, 0, 0], [0, 1, 2], [3, 3, 1]]));
    let tracer = Tracer::build(&scene).unwrap();
    assert_eq!(tracer.closest(&Ray::new(DVec3::new(0.5, 0.0, 1.0), DVec3::NEG_Z)), None);
    let point = placed(mesh(vec![Vec3::ONE], vec![[0, 0, 0]]));
    assert!(!Tracer::build(&point).unwrap().any(&Ray::new(DVec3::ZERO, DVec3::ONE)));
}

#[test]
fn degenerate_triangles_are_not_traced_and_join_no_surfaces() {
    // A floor, a slat above it, and in the same mesh a triangle without area from one to the
    // other: joined to the floor, the slat would be the floor's own surface and cast no shadow.
    let square = |y: f32, half: f32| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, z)| Vec3::new(x * half, y, z * half))
    };
    let positions = [square(0.0, 2.0), square(0.02, 0.5)].concat();
    let plain = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let joined = [plain.clone(), vec![[0, 0, 4]]].concat();
    let shadow = |triangles: Vec<[u32; 3]>| {
        let scene = placed(mesh(positions.clone(), triangles));
        let tracer = Tracer::build(&scene).unwrap();
        assert_eq!(tracer.traced_triangles(), 4);
        let view = LightView::fit_directional(DVec3::NEG_Y, &scene.bounds()).unwrap();
        let ray = Ray::new(DVec3::new(0.0, 0.01, 0.0), DVec3::NEG_Y);
        let floor = tracer.surface(&ray, &tracer.closest(&ray).unwrap());
        filtered_visibility(&tracer, &view, &floor, 0.1, 4, 1)
    };
    assert_eq!(shadow(plain), 0.0);
    assert_eq!(shadow(joined), 0.0);
}

fn from_above(height_m: f64) -> Camera {
    Camera {
        name: String::new(),
        position: DVec3::Y * 10.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m },
    }
}

#[test]
fn a_checker_texture_cuts_its_pattern_out() {
    let mut scene = placed(level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 3));
    let texel = |i: u32| [0, 0, 0, if (i % 8 + i / 8).is_multiple_of(2) { 255 } else { 100 }];
    scene.textures.push(Texture {
        name: String::new(),
        width: 8,
        height: 8,
        texels: (0..64).map(texel).collect(),
    });
    scene.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.5 });
    let n = 128_u32;
    let cover = |scene: &_| {
        let tracer = Tracer::build(scene).unwrap();
        item_buffer(&tracer, &from_above(2.0), n, n)
    };
    let cut = cover(&scene);
    for (i, item) in (0..).zip(&cut) {
        // The image's x and y run along the patch's u and v.
        let there = ((i % n) / 16 + (i / n) / 16).is_multiple_of(2);
        assert_eq!(item.is_some(), there, "pixel {i}");
    }
    assert_eq!(cut.iter().flatten().count() as u32, n * n / 2);
    // The same test passes everywhere once the cutoff is at most the lower alpha.
    scene.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: 100.0 / 255.0 });
    assert_eq!(cover(&scene).iter().flatten().count() as u32, n * n);
    scene.materials[0].opacity = 0.0;
    assert_eq!(cover(&scene).iter().flatten().count(), 0);
}

#[test]
fn a_surface_names_what_was_hit() {
    let lower = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 1);
    let mut upper = level_patch([-1.0, 1.0], 1.0, [-1.0, 1.0], 4);
    upper.material = 1;
    let none = mesh(vec![], vec![]);
    let shift = DAffine3::from_translation(DVec3::new(1e7, 0.0, 0.0));
    let mut scene = scene(vec![(lower, shift), (none, shift), (upper, shift)]);
    scene.materials.push(Material { opacity: 0.0, ..Material::default() });
    scene.materials.push(Material::default());
    let tracer = Tracer::build(&scene).unwrap();
    // Through the invisible upper patch onto the lower one, in the half of triangle 1.
    let ray = Ray::new(DVec3::new(1e7 + 0.5, 5.0, 0.75), DVec3::NEG_Y * 2.0);
    let hit = tracer.closest(&ray).unwrap();
    let s = tracer.surface(&ray, &hit);
    assert_eq!((s.instance, s.triangle_in_mesh, s.triangle, s.material), (0, 1, 1, 0));
    assert!((s.position - DVec3::new(1e7 + 0.5, 0.0, 0.75)).length() < 1e-8);
    assert!((s.uv - Vec2::new(0.75, 0.875)).length() < 1e-6, "{}", s.uv);
    assert_eq!((s.normal, hit.t), (DVec3::Y, 2.5));
    let from_below = Ray::new(DVec3::new(1e7 + 0.5, -5.0, 0.75), DVec3::Y);
    let hit = tracer.closest(&from_below).unwrap();
    assert_eq!(tracer.surface(&from_below, &hit).normal, DVec3::NEG_Y);

    scene.meshes[2].material = 2;
    scene.instances.push(Instance { mesh: 1, transform: shift });
    let tracer = Tracer::build(&scene).unwrap();
    let items = [tracer.closest(&ray).map(|hit| (ray, hit)), None];
    let found = surfaces(&tracer, &items);
    let s = found[0].unwrap();
    assert_eq!((s.instance, s.triangle - s.triangle_in_mesh, s.material), (2, 2, 2));
    assert_eq!(found[1], None);
    assert!(
        tracer
            .surface(&ray, &dapple_trace::Hit { t: 1.0, triangle: 999, u: 0.0, v: 0.0 })
            .position
            .is_nan()
    );
}
