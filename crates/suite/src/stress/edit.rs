//! Scenes pushed to an extreme: moved, scaled, damaged, lit from elsewhere.

use dapple_scene::{Camera, Instance, Light, Material, Mesh, Projection, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Where [`Scene`]s are moved to: no axis of the world, so that every coordinate grows.
const AWAY: DVec3 = DVec3::new(0.8, 0.5, -0.331_662_479_035_54);

/// All lengths and positions times `scale`, in the `f64` of the placements.
pub fn scaled(mut scene: Scene, scale: f64) -> Scene {
    transform(&mut scene, DAffine3::from_scale(DVec3::splat(scale)));
    for camera in cameras(&mut scene) {
        if let Projection::Orthographic { height_m } = &mut camera.projection {
            *height_m *= scale;
        }
    }
    scene
}

/// Everything moved by `radii` of the scene (half the diagonal of its bounds), in the `f64` of
/// the placements: vertices keep their bits.
pub fn moved(scene: Scene, radii: f64) -> Scene {
    let offset = away(&scene, radii);
    moved_by(scene, offset)
}

/// Where [`moved`] moves a scene.
pub fn away(scene: &Scene, radii: f64) -> DVec3 {
    AWAY * (radii * scene.bounds().radius())
}

/// Everything moved by `offset`, metres.
pub fn moved_by(mut scene: Scene, offset: DVec3) -> Scene {
    transform(&mut scene, DAffine3::from_translation(offset));
    scene
}

fn cameras(scene: &mut Scene) -> impl Iterator<Item = &mut Camera> {
    scene.cameras.iter_mut().chain(scene.paths.iter_mut().flat_map(|path| &mut path.keys))
}

/// Scaling and translation only: directions stay.
fn transform(scene: &mut Scene, by: DAffine3) {
    for instance in &mut scene.instances {
        instance.transform = by * instance.transform;
    }
    for camera in cameras(scene) {
        camera.position = by.transform_point3(camera.position);
        camera.target = by.transform_point3(camera.target);
    }
    for light in &mut scene.lights {
        match light {
            Light::Directional { .. } => {}
            Light::Spot { position, .. } => *position = by.transform_point3(*position),
            Light::Area { centre, half_u, half_v } => {
                *centre = by.transform_point3(*centre);
                *half_u = by.transform_vector3(*half_u);
                *half_v = by.transform_vector3(*half_v);
            }
        }
    }
}

/// The same triangles with every corner rounded to `f32` in world space, as a renderer keeps them
/// that has no placements in `f64`.
pub fn in_single_precision(mut scene: Scene) -> Scene {
    let bake = |instance: &Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let world = |p: &Vec3| instance.transform.transform_point3(p.as_dvec3()).as_vec3();
        Mesh { positions: mesh.positions.iter().map(world).collect(), ..mesh.clone() }
    };
    scene.meshes = scene.instances.iter().map(bake).collect();
    let placed = |mesh| Instance { mesh, transform: DAffine3::IDENTITY };
    scene.instances = (0..scene.meshes.len() as u32).map(placed).collect();
    scene
}

/// The first light turned about the middle of the scene, so that it falls at `degrees` from the
/// vertical; its azimuth stays, and is along x for a light from straight above.
pub fn lit_at(mut scene: Scene, degrees: f64) -> Scene {
    let centre = scene.bounds().centre();
    if let Some(light) = scene.lights.first_mut() {
        let (Light::Directional { direction } | Light::Spot { direction, .. }) = light else {
            return scene;
        };
        let level = DVec3::new(direction.x, 0.0, direction.z);
        let azimuth = level.try_normalize().unwrap_or(DVec3::X);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let wanted = azimuth * sin - DVec3::Y * cos;
        let turn = DQuat::from_rotation_arc(direction.normalize_or(DVec3::NEG_Y), wanted);
        *direction = wanted;
        if let Light::Spot { position, .. } = light {
            *position = centre + turn * (*position - centre);
        }
    }
    scene
}

/// `count` triangles without area added to the mesh of most triangles: in turn one
/// corner three times, one corner twice beside a corner of another triangle, and three corners on
/// a line along x through the mesh.
pub fn with_degenerate_triangles(mut scene: Scene, count: u32, seed: u64) -> Scene {
    let Some(mesh) = scene.meshes.iter_mut().max_by_key(|mesh| mesh.triangles.len()) else {
        return scene;
    };
    if mesh.triangles.is_empty() {
        return scene;
    }
    let mut rng = Pcg64::seed_from_u64(seed);
    let old = mesh.triangles.clone();
    for i in 0..count {
        let mut corner = || {
            let triangle = old[rng.random_range(0..old.len())];
            triangle[rng.random_range(0..3)]
        };
        let (a, b) = (corner(), corner());
        let corners = match i % 3 {
            0 => [a, a, a],
            1 => [a, a, b],
            _ => {
                // Equal y and z: on a line exactly, wherever x is rounded to.
                let (from, to) = (mesh.positions[a as usize], mesh.positions[b as usize]);
                let middle = Vec3 { x: 0.5 * (from.x + to.x), ..from };
                let end = Vec3 { x: to.x, ..from };
                [a, like(mesh, a, middle), like(mesh, a, end)]
            }
        };
        mesh.triangles.push(corners);
    }
    scene
}

/// Adds a vertex with the attributes of vertex `of` at another place.
fn like(mesh: &mut Mesh, of: u32, position: Vec3) -> u32 {
    let of = of as usize;
    mesh.positions.push(position);
    if let Some(normal) = mesh.normals.get(of).copied() {
        mesh.normals.push(normal);
    }
    if let Some(uv) = mesh.uvs.get(of).copied() {
        mesh.uvs.push(uv);
    }
    mesh.positions.len() as u32 - 1
}

/// One coordinate of the middle vertex of the first mesh set to `value`.
pub fn with_coordinate(mut scene: Scene, value: f32) -> Scene {
    if let Some(mesh) = scene.meshes.first_mut() {
        let middle = mesh.positions.len() / 2;
        if let Some(position) = mesh.positions.get_mut(middle) {
            position.y = value;
        }
    }
    scene
}

/// One square that faces the first light, and nothing else: every depth is the same, and all of
/// it is lit.
pub fn one_depth(mut scene: Scene) -> Scene {
    let bounds = scene.bounds();
    let travel = match scene.lights.first() {
        Some(Light::Directional { direction }) => *direction,
        Some(Light::Spot { position, .. }) => bounds.centre() - *position,
        Some(Light::Area { .. }) | None => DVec3::NEG_Y,
    };
    let normal = -travel.normalize_or(DVec3::NEG_Y);
    let turn = DQuat::from_rotation_arc(DVec3::Y, normal);
    let half = DVec3::splat(0.7 * bounds.radius());
    scene.meshes.clear();
    scene.instances.clear();
    add_square(&mut scene, DAffine3::from_scale_rotation_translation(half, turn, bounds.centre()));
    for camera in cameras(&mut scene) {
        // From the light's side, aslant: seen whatever way the camera looked before.
        camera.target = bounds.centre();
        let (across, _) = normal.any_orthonormal_pair();
        camera.position = camera.target + (normal + 0.5 * across) * (2.0 * bounds.radius());
        camera.up = across;
    }
    scene
}

/// `count` small squares strewn over the scene's bounds, turned every way: a window holds many
/// depths.
pub fn with_confetti(mut scene: Scene, count: u32, seed: u64) -> Scene {
    let bounds = scene.bounds();
    let half = 0.01 * bounds.radius();
    let mut rng = Pcg64::seed_from_u64(seed);
    let mesh = add_square(&mut scene, DAffine3::IDENTITY);
    scene.instances.pop();
    for _ in 0..count {
        let share = DVec3::new(rng.random(), rng.random(), rng.random());
        let axis = DVec3::new(rng.random::<f64>() - 0.5, 0.5, rng.random::<f64>() - 0.5);
        let turn = DQuat::from_axis_angle(axis.normalize(), rng.random_range(0.0..6.0));
        let place = bounds.min + (bounds.max - bounds.min) * share;
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(half), turn, place);
        scene.instances.push(Instance { mesh, transform });
    }
    scene
}

/// Places a square of half side 1 that faces y, of a new opaque material, and returns its mesh.
pub fn add_square(scene: &mut Scene, transform: DAffine3) -> u32 {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    scene.materials.push(Material { name: "square (added)".into(), ..Material::default() });
    scene.meshes.push(Mesh {
        name: "square (added)".into(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: scene.materials.len() as u32 - 1,
        ..Mesh::default()
    });
    let mesh = scene.meshes.len() as u32 - 1;
    scene.instances.push(Instance { mesh, transform });
    mesh
}

/// Every camera turned to look away from the scene.
pub fn seen_from_behind(mut scene: Scene) -> Scene {
    let (centre, radius) = (scene.bounds().centre(), scene.bounds().radius());
    for camera in cameras(&mut scene) {
        let outwards = (camera.position - centre).normalize_or(DVec3::X);
        camera.position = centre + outwards * (3.0 * radius);
        camera.target = camera.position + outwards * radius;
        camera.up = outwards.any_orthonormal_vector();
    }
    scene
}

/// The last triangle of the first mesh given a vertex that is not there.
pub fn with_missing_vertex(mut scene: Scene) -> Scene {
    if let Some(mesh) = scene.meshes.first_mut() {
        let past = mesh.positions.len() as u32;
        if let Some(triangle) = mesh.triangles.last_mut() {
            triangle[1] = past;
        }
    }
    scene
}

/// Every mesh without its triangles.
pub fn without_triangles(mut scene: Scene) -> Scene {
    for mesh in &mut scene.meshes {
        mesh.triangles.clear();
    }
    scene
}
