//! Random worlds with paths through them, and random settings of techniques.

pub use crate::verify::{default_setting, rng};

use crate::{
    SuiteError,
    case::Case,
    city::Loaded,
    knob,
    problem::{Form, Setting, Technique},
    problems::camera_visibility::{SPEC, case::VisibilityCase},
    verify::anywhere,
};
use dapple_gpu::Gpu;
use dapple_scene::{
    AlphaTest, Camera, CameraPath, Instance, Material, Mesh, Projection, Scene, Texture,
    city::{self, City, Part},
};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;
use serde_json::Value;

/// Columns of the images; 27 rows.
pub const WIDTH: u32 = 48;

/// Frames of a path.
pub const FRAMES: u32 = 8;

/// World `number` of a seed, the same for every gate: a town, a small city, or one that is turned,
/// with a path that walks and jumps.
///
/// # Errors
/// None for these worlds.
pub fn case(seed: u64, number: u32, gpu: Option<&Gpu>) -> Result<VisibilityCase<'_>, SuiteError> {
    let mut rng = rng(seed, "world", number);
    let jumps = [0.7, 0.0, 0.2][number as usize % 3];
    let (scene, parts) = match number % 4 {
        0 | 2 => (town(&mut rng, jumps), None),
        kind => {
            let turn_rad = if kind == 3 { rng.random_range(0.1..1.4) } else { 0.0 };
            let (city, parts, scene) = small_city(&mut rng, turn_rad, jumps)?;
            (scene, Some((city, parts)))
        }
    };
    of(scene, parts, seed, &[], gpu)
}

/// Small city `number` of a seed, every other one turned.
///
/// # Errors
/// None for these worlds.
pub fn city_case(
    seed: u64,
    number: u32,
    gpu: Option<&Gpu>,
) -> Result<VisibilityCase<'_>, SuiteError> {
    case(seed, 2 * number + 1, gpu)
}

/// A town with a path that only walks.
///
/// # Errors
/// None for these worlds.
pub fn walk(seed: u64, number: u32) -> Result<VisibilityCase<'static>, SuiteError> {
    let scene = town(&mut rng(seed, "walk", number), 0.0);
    of(scene, None, seed, &[], None)
}

/// A case of a scene along its first path.
///
/// # Errors
/// A scene that cannot be used.
pub fn of<'g>(
    scene: Scene,
    city: Option<(City, Vec<Part>)>,
    seed: u64,
    parameters: &[(&str, i64)],
    gpu: Option<&'g Gpu>,
) -> Result<VisibilityCase<'g>, SuiteError> {
    let small = [("width", i64::from(WIDTH)), ("frames", i64::from(FRAMES)), ("truth_samples", 1)];
    let given = small.iter().chain(parameters);
    let given = given.map(|(name, value)| ((*name).to_string(), Value::from(*value))).collect();
    let case = Case {
        problem: SPEC.id.into(),
        scene: scene.name.clone(),
        view: String::new(),
        seed,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    };
    let hash = scene.hash();
    VisibilityCase::of(Loaded { scene, city, hash, notes: Vec::new() }, &case, gpu)
}

/// The unit cube, a pyramid on it, and an upright square with holes.
fn shapes() -> Vec<Mesh> {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let cube = Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    };
    let base = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z];
    let pyramid = Mesh {
        positions: base.into_iter().chain([Vec3::new(0.5, 1.0, 0.5)]).collect(),
        triangles: vec![[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0], [0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let fence = Mesh {
        positions: square.to_vec(),
        uvs: square.iter().map(|p| 3.0 * Vec2::new(p.x, 1.0 - p.y)).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: 1,
        ..Mesh::default()
    };
    vec![cube, pyramid, fence]
}

/// A scene of cubes, pyramids and fences (0, 1, 2), each placed so.
pub fn scene_of(name: &str, placed: impl IntoIterator<Item = (u32, DAffine3)>) -> Scene {
    let cut = AlphaTest { texture: 0, cutoff: 0.5 };
    Scene {
        name: name.into(),
        meshes: shapes(),
        materials: vec![
            Material::default(),
            Material { alpha_test: Some(cut), albedo_texture: Some(0), ..Material::default() },
        ],
        textures: vec![Texture {
            name: "holes".into(),
            width: 2,
            height: 2,
            texels: [255, 0, 0, 255].map(|a| [200, 200, 200, a]).to_vec(),
        }],
        instances: placed
            .into_iter()
            .map(|(mesh, transform)| Instance { mesh, transform })
            .collect(),
        ..Scene::default()
    }
}

/// A scene of axis-aligned boxes given by lower corner and size.
pub fn boxes(name: &str, boxes: &[(DVec3, DVec3)]) -> Scene {
    scene_of(name, boxes.iter().map(|(at, size)| (0, placed(*at, *size, 0.0))))
}

fn placed(at: DVec3, size: DVec3, turn_rad: f64) -> DAffine3 {
    let matrix3 = DMat3::from_rotation_y(turn_rad) * DMat3::from_diagonal(size);
    DAffine3 { matrix3, translation: at }
}

/// Things of all sizes, 40 m wide: houses of which some are turned, walls, fences with holes, twins
/// in one place and flat ones among them.
fn town(rng: &mut Pcg64, jumps: f64) -> Scene {
    // Something is always seen: the ground, or a tower in the middle.
    let ground = placed(DVec3::new(-30.0, -1.0, -30.0), DVec3::new(60.0, 1.0, 60.0), 0.0);
    let tower = placed(DVec3::new(-1.0, 0.0, -1.0), DVec3::new(2.0, 9.0, 2.0), 0.0);
    let mut things = vec![(0, if rng.random_bool(0.7) { ground } else { tower })];
    for _ in 0..rng.random_range(20..70) {
        let mut between = |a: f64, b: f64| rng.random_range(a..b);
        let at = DVec3::new(between(-20.0, 20.0), between(-0.1, 0.1), between(-20.0, 20.0));
        let kind = between(0.0, 1.0);
        let size = match kind {
            k if k < 0.2 => DVec3::new(between(4.0, 12.0), between(3.0, 8.0), between(0.3, 2.0)),
            k if k < 0.7 => DVec3::new(between(1.0, 4.0), between(1.0, 8.0), between(1.0, 4.0)),
            _ => DVec3::new(between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.0)),
        };
        let turn_rad = if kind < 0.4 { 0.0 } else { between(0.0, 6.3) };
        let mesh = match between(0.0, 1.0) {
            m if m < 0.75 => 0,
            m if m < 0.9 => 1,
            _ => 2,
        };
        let flat = if between(0.0, 1.0) < 0.04 { DVec3::new(1.0, 0.0, 1.0) } else { DVec3::ONE };
        things.push((mesh, placed(at, size * flat, turn_rad)));
        if between(0.0, 1.0) < 0.05 {
            things.extend(things.last().copied());
        }
    }
    let mut scene = scene_of("town", things);
    scene.paths = vec![path(rng, DVec2::splat(22.0), jumps)];
    scene
}

/// A block or two, turned about the vertical: the city, the part of each instance, the scene.
///
/// # Errors
/// None for these knobs.
pub fn small_city(
    rng: &mut Pcg64,
    turn_rad: f64,
    jumps: f64,
) -> Result<(City, Vec<Part>, Scene), SuiteError> {
    let knobs = city::Knobs {
        blocks_x: rng.random_range(1..=2),
        blocks_z: 1,
        shape: match rng.random_bool(0.5) {
            true => city::BlockShape::DoubleRow(rng.random_range(1..=3)),
            false => city::BlockShape::Ring(3),
        },
        heights: city::Heights::Independent { least: 1, most: rng.random_range(1..=4) },
        empty_lots: if rng.random_bool(0.3) { 0.3 } else { 0.0 },
        brick_offset: rng.random_bool(0.5),
        trees_per_block: rng.random_range(0..=4),
        ..city::Knobs::default()
    };
    let mut city = city::generate(&knobs, rng.random())?;
    let made = city.scene();
    let (mut scene, parts) = (made.scene, made.parts);
    let turn = DMat3::from_rotation_y(turn_rad);
    for instance in &mut scene.instances {
        let DAffine3 { matrix3, translation } = instance.transform;
        instance.transform = DAffine3 { matrix3: turn * matrix3, translation: turn * translation };
    }
    for inner in city.buildings.iter_mut().flat_map(|b| &mut b.inner) {
        inner.centre = turn * inner.centre;
        let axis = turn * DVec3::new(inner.axis.x, 0.0, inner.axis.y);
        inner.axis = DVec2::new(axis.x, axis.z);
    }
    let bounds = scene.bounds();
    let size = bounds.max - bounds.min;
    scene.paths = vec![path(rng, 0.4 * DVec2::new(size.x, size.z), jumps)];
    scene.cameras.clear();
    Ok((city, parts, scene))
}

/// Steps of which a share of `jumps` leads anywhere within `half`, to look about at the middle.
fn path(rng: &mut Pcg64, half: DVec2, jumps: f64) -> CameraPath {
    let (mut at, mut heading) = (DVec3::ZERO, 0.0_f64);
    let mut key = |index: u32| {
        if index == 0 || rng.random_bool(jumps) {
            let height = if rng.random_bool(0.6) { 1.7 } else { rng.random_range(0.5..14.0) };
            let mut side = |half: f64| rng.random_range(-half..half);
            at = DVec3::new(side(half.x), height, side(half.y));
            heading = (-at.z).atan2(-at.x) + rng.random_range(-0.4..0.4);
        } else {
            at += DVec3::new(heading.cos(), 0.0, heading.sin()) * rng.random_range(0.1..0.6);
            heading += rng.random_range(-0.05..0.05);
        }
        let pitch = if at.y > 3.0 { -0.4 } else { 0.02 };
        let ahead = DVec3::new(heading.cos(), pitch, heading.sin());
        camera(at, at + ahead)
    };
    CameraPath { name: "path".into(), keys: (0..FRAMES).map(&mut key).collect(), frames: FRAMES }
}

/// A camera of an opening of 1 radian.
pub fn camera(position: DVec3, target: DVec3) -> Camera {
    Camera {
        name: "path".into(),
        position,
        target,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 1.0 },
    }
}

/// A setting of `technique`: any variant, every knob anywhere in its useful range. An `exact`
/// one leaves out what is approximate.
pub fn setting(
    rng: &mut Pcg64,
    technique: &Technique,
    form: Form,
    case: &VisibilityCase<'_>,
    exact: bool,
) -> Setting {
    let no_city = case.inner().is_none();
    // Worlds that are no cities have no boxes inside of anything, and no city's hierarchy.
    let there = |id: &str| {
        technique.has(id, form) && !(no_city && id == "boxes") && !(exact && id == "next-frame")
    };
    let variants: Vec<_> = technique.variants.iter().filter(|v| there(v.id)).collect();
    let variant = variants[rng.random_range(0..variants.len())].id;
    let knobs = technique.knobs.iter().map(|knob| {
        let value = match knob.name {
            "tau" if exact || rng.random_bool(0.5) => 0.into(),
            "readiness" if form != Form::Gpu => "modelled".into(),
            "traversal" if form == Form::Gpu => "flat".into(),
            // Several times the image's columns: the reference fills every pixel by itself.
            "buffer" => anywhere(rng, knob).as_i64().unwrap_or(0).min(5 * i64::from(WIDTH)).into(),
            // What the device does is asked elsewhere.
            "counting" => "auto".into(),
            _ => anywhere(rng, knob),
        };
        let refused = no_city && knob.name == "tree" && value == "city";
        (knob.name.to_string(), if refused { "auto".into() } else { value })
    });
    Setting {
        technique: technique.id.into(),
        variant: variant.into(),
        form,
        knobs: knobs.collect(),
    }
}
