use super::*;
use crate::camera::{Tree, View};
use dapple_scene::{AlphaTest, Camera, Instance, Material, Mesh, Projection, Scene, Texture};
use glam::{DAffine3, DMat3, DQuat};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

fn soup(triangles: usize, seed: u64, offset: f32) -> Mesh {
    let mut rng = Pcg32::seed_from_u64(seed);
    let vertices = (triangles / 2).max(3) as u32;
    let positions = (0..vertices)
        .map(|_| Vec3::new(rng.random(), rng.random(), rng.random()) + offset)
        .collect();
    let mut corner = || rng.random_range(0..vertices);
    let triangles = (0..triangles).map(|_| [corner(), corner(), corner()]).collect();
    Mesh { name: "soup".into(), positions, triangles, ..Mesh::default() }
}

fn scene_of(meshes: Vec<Mesh>, instances: Vec<(u32, DAffine3)>) -> Scene {
    let instances = instances.into_iter().map(|(mesh, transform)| Instance { mesh, transform });
    Scene {
        name: "test".into(),
        meshes,
        materials: vec![Material::default()],
        instances: instances.collect(),
        ..Scene::default()
    }
}

fn two_soups(seed: u64, scale: f64, offset: f64) -> Scene {
    let mut rng = Pcg32::seed_from_u64(seed);
    let mut place = |mesh: u32| {
        let mut vector = || DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
        let turn = DQuat::from_axis_angle(vector().normalize_or(DVec3::X), 3.0 * vector().x);
        let linear = DMat3::from_quat(turn) * DMat3::from_diagonal(vector().abs() + 0.1) * scale;
        let at = (vector() * 10.0 + DVec3::ONE * offset) * scale;
        (mesh, DAffine3 { matrix3: linear, translation: at })
    };
    let instances = vec![place(0), place(1), place(0), place(1)];
    scene_of(vec![soup(40, seed, 0.0), soup(7, seed + 1, 3.0)], instances)
}

fn check_against(scene: &Scene, most: u32, relative: f64) {
    let (objects, homes) = Objects::from_scene(scene, most).unwrap();
    assert_eq!(homes.len(), scene.triangle_count());
    let mut counts = vec![0_u32; objects.objects.len()];
    let bounds = scene.bounds();
    assert!((objects.origin - bounds.centre()).length() <= 1e-12 * bounds.centre().length());
    for (&[object, index], (_, world)) in homes.iter().zip(scene.world_triangles()) {
        counts[object as usize] += 1;
        let placed = objects.triangles(object).nth(index as usize).unwrap();
        let holds = objects.objects[object as usize].bounds;
        for (p, w) in placed.into_iter().zip(world) {
            let local = w - objects.origin;
            assert!((p.as_dvec3() - local).length() <= relative * bounds.radius(), "{p} {local}");
            assert!(holds.contains(p), "{p} {holds:?}");
            assert!(local.cmpge(holds.min.as_dvec3()).all(), "{local} {holds:?}");
            assert!(local.cmple(holds.max.as_dvec3()).all(), "{local} {holds:?}");
        }
    }
    for (object, count) in counts.into_iter().enumerate() {
        assert_eq!(count, objects.triangle_count(object as u32));
        assert!(count <= most);
    }
    // Devices may fuse and reorder.
    for o in &objects.objects {
        for p in &objects.templates[o.template as usize].positions {
            let [x, y, z] = [o.linear.x_axis, o.linear.y_axis, o.linear.z_axis];
            let fused = x.mul_add(Vec3::splat(p.x), o.translation);
            let fused = y.mul_add(Vec3::splat(p.y), fused);
            assert!(o.bounds.contains(z.mul_add(Vec3::splat(p.z), fused)));
            assert!(o.bounds.contains((o.translation + z * p.z) + y * p.y + x * p.x));
        }
    }
    let all: std::collections::BTreeSet<_> = homes.iter().collect();
    assert_eq!(all.len(), homes.len(), "no two triangles have one home");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn triangles_are_where_the_scene_has_them(
        seed: u64, most in prop::sample::select(vec![1_u32, 2, 7, 39, 40, 1000]),
        scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
        offset in prop::sample::select(vec![0.0, 1e3, 1e8]),
    ) {
        // World coordinates themselves have but 16 digits.
        check_against(&two_soups(seed, scale, offset), most, 1e-6 + 1e-15 * offset);
    }
}

#[test]
fn a_far_mesh_brought_back_keeps_its_detail() {
    // The corners are exact in f32; a placement that added a large translation would lose them.
    let mut mesh = soup(30, 4, 0.0);
    for p in &mut mesh.positions {
        *p = (*p * 1024.0).floor() / 1024.0 + Vec3::splat(4096.0);
    }
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0));
    let home = -(turn * DVec3::splat(4096.0));
    let scene = scene_of(vec![mesh], vec![(0, DAffine3 { matrix3: turn, translation: home })]);
    check_against(&scene, 5, 3e-7);
}

#[test]
fn placements_share_templates_and_clusters_share_corners() {
    let scene = two_soups(3, 1.0, 0.0);
    let (objects, _) = Objects::from_scene(&scene, 100).unwrap();
    assert_eq!(objects.templates.len(), 2);
    let templates: Vec<u32> = objects.objects.iter().map(|o| o.template).collect();
    assert_eq!(templates, [0, 1, 0, 1], "one object an instance, in order");

    let (cut, homes) = Objects::from_scene(&scene, 10).unwrap();
    // 40 triangles in four clusters, 7 in one; each placed twice.
    assert_eq!((cut.templates.len(), cut.objects.len()), (5, 10));
    let templates: Vec<u32> = cut.objects.iter().map(|o| o.template).collect();
    assert_eq!(templates, [0, 1, 2, 3, 4, 0, 1, 2, 3, 4]);
    // Equal corners of one instance are equal bit by bit, in whatever cluster.
    let mesh = &scene.meshes[0];
    let mut known: std::collections::BTreeMap<u32, Vec3> = Default::default();
    for (corners, &[object, index]) in mesh.triangles.iter().zip(&homes) {
        let placed = cut.triangles(object).nth(index as usize).unwrap();
        for (c, p) in corners.iter().zip(placed) {
            assert_eq!(*known.entry(*c).or_insert(p), p);
        }
    }
    assert_eq!(Objects::from_scene(&scene, 10).unwrap().1, homes);
}

#[test]
fn clusters_are_halves_along_the_longest_side() {
    let mut mesh = Mesh { name: "row".into(), ..Mesh::default() };
    for i in [5, 2, 7, 0, 3, 6, 1, 4] {
        let first = mesh.positions.len() as u32;
        let at = Vec3::new(0.0, 0.0, i as f32 * 10.0);
        mesh.positions.extend([at, at + Vec3::X, at + Vec3::Y]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let scene = scene_of(vec![mesh], vec![(0, DAffine3::IDENTITY)]);
    let (objects, homes) = Objects::from_scene(&scene, 3).unwrap();
    assert_eq!(objects.objects.len(), 4);
    // By place in the row: 5 2 7 0 3 6 1 4.
    let clusters: Vec<u32> = homes.iter().map(|h| h[0]).collect();
    assert_eq!(clusters, [2, 1, 3, 0, 1, 3, 0, 2]);
}

fn leaf_scene(alpha: Vec<u8>, width: u32, height: u32, cutoff: f32) -> Scene {
    let mut mesh = soup(4, 1, 0.0);
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x, p.y) * 3.0 - 1.0).collect();
    let mut scene = scene_of(vec![mesh], vec![(0, DAffine3::IDENTITY)]);
    let texels = alpha.into_iter().map(|a| [9, 9, 9, a]).collect();
    scene.textures.push(Texture { name: "leaf".into(), width, height, texels });
    scene.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff });
    scene
}

#[test]
fn masks_are_the_alpha_test() {
    let mut rng = Pcg32::seed_from_u64(8);
    let (width, height) = (13, 7);
    let alpha = (0..width * height).map(|_| rng.random()).collect();
    let scene = leaf_scene(alpha, width, height, 0.4);
    let (objects, _) = Objects::from_scene(&scene, 100).unwrap();
    assert_eq!(objects.templates[0].mask, Some(0));
    assert!(!objects.occludes(0));
    let mask = &objects.masks[0];
    let mut there = 0;
    for _ in 0..5000 {
        let uv = Vec2::new(rng.random(), rng.random()) * 8.0 - 4.0;
        let expected = scene.textures[0].alpha_nearest(uv) >= 0.4;
        assert_eq!(mask.at(uv), expected);
        there += u32::from(expected);
    }
    assert!((500..4500).contains(&there));
    let template = &objects.templates[0];
    assert_eq!(template.uvs.len(), template.positions.len());
    let (home, original) = (template.triangles[0], scene.meshes[0].triangles[0]);
    for (c, o) in home.into_iter().zip(original) {
        assert_eq!(template.uvs[c as usize], scene.meshes[0].uvs[o as usize]);
    }
}

#[test]
fn masks_that_cut_nothing_away_are_none() {
    for scene in [leaf_scene(vec![255; 6], 3, 2, 0.5), leaf_scene(vec![], 0, 0, 0.5)] {
        let (objects, _) = Objects::from_scene(&scene, 100).unwrap();
        assert!(objects.masks.is_empty() && objects.occludes(0));
        assert!(objects.templates[0].uvs.is_empty());
    }
    // No texture coordinates: everywhere the first texel, as elsewhere in the project.
    let mut scene = leaf_scene(vec![0, 255], 2, 1, 0.5);
    scene.meshes[0].uvs.clear();
    let (objects, _) = Objects::from_scene(&scene, 100).unwrap();
    assert_eq!(objects.templates[0].uvs.len(), objects.templates[0].positions.len());
    assert!(!objects.masks[0].at(objects.templates[0].uvs[0]));
    // Two meshes of one texture and cut-off share a mask.
    let mut scene = leaf_scene(vec![0, 255], 2, 1, 0.5);
    scene.meshes.push(scene.meshes[0].clone());
    scene.instances.push(Instance { mesh: 1, transform: DAffine3::IDENTITY });
    assert_eq!(Objects::from_scene(&scene, 100).unwrap().0.masks.len(), 1);
}

#[test]
fn invisible_and_empty_instances_stay_in_their_places() {
    let mut scene = two_soups(3, 1.0, 0.0);
    scene.materials.push(Material { opacity: 0.0, ..Material::default() });
    scene.meshes[0].material = 1;
    scene.meshes.push(Mesh { name: "empty".into(), ..Mesh::default() });
    scene.instances.push(Instance { mesh: 2, transform: DAffine3::IDENTITY });
    let (objects, homes) = Objects::from_scene(&scene, 10).unwrap();
    let counts: Vec<u32> = (0..5).map(|i| objects.triangle_count(i)).collect();
    assert_eq!(counts, [0, 7, 0, 7, 0]);
    assert!(homes[..40].iter().all(|&h| h == NOT_DRAWN));
    assert_eq!(homes[40], [1, 0]);
    assert!(objects.objects.iter().all(|o| o.bounds.min.is_finite() && !o.bounds.is_empty()));
}

#[test]
fn bad_scenes_are_refused_by_name() {
    let refused = |spoil: &dyn Fn(&mut Scene)| {
        let mut scene = leaf_scene(vec![0, 255], 2, 1, 0.5);
        spoil(&mut scene);
        Objects::from_scene(&scene, 10).unwrap_err().to_string()
    };
    let scene = leaf_scene(vec![0, 255], 2, 1, 0.5);
    assert!(Objects::from_scene(&scene, 10).is_ok());
    assert!(
        Objects::from_scene(&scene, 0).unwrap_err().to_string().contains("triangles an object")
    );
    assert!(refused(&|s| s.instances.clear()).contains("no triangle is placed"));
    assert!(refused(&|s| s.instances[0].mesh = 1).contains("instance 0: mesh 1 of 1"));
    assert!(refused(&|s| s.meshes[0].material = 7).contains("mesh 0 \"soup\": material 7 of 1"));
    assert!(refused(&|s| s.meshes[0].triangles[2][1] = 99).contains("triangle 2"));
    assert!(refused(&|s| s.meshes[0].positions[1].x = f32::NAN).contains("vertex 1"));
    assert!(refused(&|s| s.meshes[0].uvs[1].x = f32::INFINITY).contains("vertex 1"));
    assert!(refused(&|s| s.meshes[0].uvs.truncate(1)).contains("1 uvs"));
    assert!(refused(&|s| s.instances[0].transform.translation.y = f64::NAN).contains("instance 0"));
    assert!(refused(&|s| s.textures.clear()).contains("texture 0 of 0"));
    assert!(refused(&|s| s.textures[0].width = 3).contains("\"leaf\" has 2 texels for 3 x 1"));
    assert!(refused(&|s| s.materials[0].opacity = f32::NAN).contains("material 0"));
    assert!(
        refused(&|s| s.materials[0].alpha_test = Some(AlphaTest { texture: 0, cutoff: f32::NAN }))
            .contains("cutoff")
    );
    let far = |s: &mut Scene| {
        let transform = DAffine3::from_translation(DVec3::new(4e12, 0.0, 0.0));
        s.instances.push(Instance { mesh: 0, transform });
    };
    assert!(refused(&far).contains("1e12 m"));
    let huge = |s: &mut Scene| s.instances[0].transform.matrix3 *= 1e300;
    assert!(refused(&huge).contains("1e12 m"));
}

#[test]
fn bytes_grow_with_templates_not_with_triangles_placed() {
    let mut scene = two_soups(3, 1.0, 0.0);
    let before = Objects::from_scene(&scene, 100).unwrap().0.bytes();
    scene.instances.push(scene.instances[0]);
    let after = Objects::from_scene(&scene, 100).unwrap().0.bytes();
    assert_eq!(after - before, size_of::<Object>() as u64);
    assert!(size_of::<Object>() <= 80);
}

#[test]
fn boxes_in_f32_hold_boxes_in_f64() {
    let third = DVec3::splat(1.0 / 3.0);
    let b = Bounds::around(-third, third);
    assert!(f64::from(b.max.x) >= third.x && f64::from(b.min.x) <= -third.x);
    assert!(f64::from(b.max.x.next_down()) < third.x);
    let one = Bounds::around(DVec3::ONE, DVec3::ONE);
    assert_eq!(one, Bounds { min: Vec3::ONE, max: Vec3::ONE });
    assert!(!one.is_empty() && Bounds::EMPTY.is_empty());
    assert_eq!(one.grown(0.5), Bounds { min: Vec3::splat(0.5), max: Vec3::splat(1.5) });
}

#[test]
fn objects_of_no_size_have_boxes() {
    // All corners in one point; triangles without area; a flat placement.
    let mut scene = two_soups(1, 1.0, 0.0);
    scene.meshes[0].positions.fill(Vec3::ONE);
    scene.instances[1].transform.matrix3.y_axis = DVec3::ZERO;
    let (objects, _) = Objects::from_scene(&scene, 10).unwrap();
    let tree = Tree::bottom_up(&objects).unwrap();
    tree.validate(&objects).unwrap();
    for object in &objects.objects {
        assert!(!object.bounds.is_empty());
    }
    let mut one = scene_of(vec![soup(1, 1, 0.0)], vec![(0, DAffine3::IDENTITY)]);
    one.meshes[0].triangles = vec![[1, 1, 1]];
    let (objects, homes) = Objects::from_scene(&one, 10).unwrap();
    assert_eq!((objects.objects.len(), homes), (1, vec![[0, 0]]));
    let extent = objects.objects[0].bounds.max - objects.objects[0].bounds.min;
    assert!(extent.max_element() < 1e-5);
}

/// What a camera sees and touches, and the middles of boxes on the screen.
fn seen(scene: &Scene, camera: &Camera, near_m: f64) -> Vec<(bool, bool, Option<[f32; 4]>)> {
    let (objects, _) = Objects::from_scene(scene, 10).unwrap();
    let view = View::new(camera, &objects, 160, 90, near_m).unwrap();
    let one = |o: &Object| {
        let rect = view.screen_rect(&o.bounds).map(|r| r.0);
        (view.sees(&o.bounds), view.touches(&o.bounds), rect)
    };
    objects.objects.iter().map(one).collect()
}

#[test]
fn scaled_and_far_scenes_are_seen_alike() {
    let mut counts = [0_u32; 4];
    for seed in 0..60 {
        let scene = two_soups(seed, 1.0, 0.0);
        let mut rng = Pcg32::seed_from_u64(seed);
        let mut vector = || DVec3::new(rng.random(), rng.random(), rng.random()) * 16.0 - 8.0;
        let projection = if seed % 4 == 0 {
            Projection::Orthographic { height_m: 10.0 }
        } else {
            Projection::Perspective { fov_y_rad: 1.0 }
        };
        let (position, target) = (vector(), vector());
        let camera = Camera { name: "c".into(), position, target, up: DVec3::Y, projection };
        let here = seen(&scene, &camera, 0.1);
        for (scale, radii) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e7), (1e-6, 1e7), (1e3, 1e7)] {
            let moved = DVec3::new(1.0, -0.3, 0.7) * radii * scene.bounds().radius() * scale;
            let mut far = scene.clone();
            for instance in &mut far.instances {
                instance.transform.matrix3 *= scale;
                instance.transform.translation = instance.transform.translation * scale + moved;
            }
            let mut camera = camera.clone();
            camera.position = camera.position * scale + moved;
            camera.target = camera.target * scale + moved;
            if let Projection::Orthographic { height_m } = &mut camera.projection {
                *height_m *= scale;
            }
            let there = seen(&far, &camera, 0.1 * scale);
            assert_eq!(here.len(), there.len());
            for (a, b) in here.iter().zip(&there) {
                assert_eq!((a.0, a.1, a.2.is_some()), (b.0, b.1, b.2.is_some()), "{scale} {radii}");
                counts[usize::from(a.0) + 2 * usize::from(a.1)] += 1;
                for (p, q) in a.2.into_iter().flatten().zip(b.2.into_iter().flatten()) {
                    assert!((p - q).abs() <= 0.01 + 1e-3 * p.abs(), "{scale} {radii}: {p} {q}");
                }
            }
        }
    }
    assert!(counts[0] > 100 && counts[1] > 100 && counts[3] >= 20, "{counts:?}");
}
