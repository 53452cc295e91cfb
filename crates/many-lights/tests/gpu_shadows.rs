//! Shadow rays on a device against those in f64, and against what is plain to see.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod shadow_rays_support;

use dapple_gpu::{Gpu, testing::test_gpu};
use dapple_many_lights::{
    Absolute, BoundForm, Capped, Clustered, Emission, Form, Light, LightBvh, LightTree, Lightcuts,
    Per, Point, Relative, Reservoirs, Selection, Shaded, StochasticLightcuts, Technique, World,
    gpu::{LIFT, Occluders, Scene},
    make,
    tree::{Build, Representative},
    worlds::{self, Cloud, Rectangle, cloud, plane},
};
use dapple_scene::{Camera, Instance, Material, Mesh, Projection, city, generate};
use dapple_trace::Tracer;
use glam::{DAffine3, DVec3, Vec3};
use shadow_rays_support::{
    Differences, EDGE_SLACK, RAYS, differences, exact, night, targets, traced,
};
use std::sync::Arc;

const APART: [f64; 2] = [LIFT; 2];

fn compared(gpu: &Gpu, world: &Arc<World>, apart: [f64; 2]) -> Differences {
    let scene = Scene::new(gpu, world).unwrap();
    let targets = targets(world);
    let exact = exact(world, &targets);
    let occluders = Occluders::apart(gpu, world, apart).unwrap();
    let (found, _) = traced(gpu, &scene, &occluders, EDGE_SLACK, &targets);
    differences(&targets, &exact, &found)
}

/// How many of all rays find their way, by the device.
fn seen(gpu: &Gpu, world: World, apart: [f64; 2], edge_slack: f64) -> (usize, usize) {
    let world = Arc::new(world);
    let scene = Scene::new(gpu, &world).unwrap();
    let targets = targets(&world);
    let occluders = Occluders::apart(gpu, &world, apart).unwrap();
    let (found, _) = traced(gpu, &scene, &occluders, edge_slack, &targets);
    (found.iter().filter(|seen| **seen).count(), targets.iter().flatten().count())
}

// 3 of 858,059 rays differed in the largest image looked at, all at silhouettes.
#[test]
fn a_city_casts_the_same_shadows_but_at_silhouettes() {
    let Some(gpu) = test_gpu() else { return };
    let city = city::generate(&generate::city_knobs("city_small").unwrap(), 1).unwrap();
    let camera = city.scene().scene.paths[0].camera(0).unwrap();
    let world = Arc::new(night(&city, &camera, [93, 51]));
    let most = |rays: usize| rays / 50_000;
    let found = compared(gpu, &world, APART);
    assert!(found.rays > 50_000, "{}", found.rays);
    let differing = found.darker.len() + found.brighter.len();
    assert!(differing <= most(found.rays), "{differing} of {}", found.rays);
    // Rays that start on the surface itself meet it.
    let without = compared(gpu, &world, [0.0, LIFT]);
    assert!(without.darker.len() > 100 * most(found.rays), "{}", without.darker.len());
}

#[test]
fn clouds_cast_the_same_shadows_wherever_they_lie() {
    let Some(gpu) = test_gpu() else { return };
    for origin in [DVec3::ZERO, DVec3::new(-1e6, 3e5, 7e6)] {
        let all = Cloud {
            lights: 500,
            emissions: vec![Emission::Omni, worlds::WINDOW, Emission::Directional],
            origin,
            size: [61, 43],
            ..Cloud::default()
        };
        let world = Arc::new(cloud(&all).with_shadows().unwrap());
        let found = compared(gpu, &world, APART);
        let differing = found.darker.len() + found.brighter.len();
        assert!(found.rays > 10_000, "{}", found.rays);
        assert!(differing <= found.rays / 5_000, "{differing} of {}", found.rays);
    }
}

fn omni(position: DVec3) -> Light {
    Light { position, axis: DVec3::NEG_Y, intensity: DVec3::ONE, emission: Emission::Omni }
}

/// Lights at one height above a plane that is lit, all in a square of 8 m.
fn above(height_m: f64) -> Vec<Light> {
    let at = |i: u32| DVec3::new(f64::from(i % 8) * 1.01 - 3.6, height_m, f64::from(i / 8) - 3.7);
    (0..64).map(|i| omni(at(i))).collect()
}

#[test]
fn nothing_is_dark_in_the_open() {
    let Some(gpu) = test_gpu() else { return };
    // Among them lights so low that rays all but graze the ground.
    for height_m in [0.05, 3.0, 500.0] {
        let open = || plane(above(height_m), 10.1, [33, 27]).with_shadows().unwrap();
        let (found, rays) = seen(gpu, open(), APART, EDGE_SLACK);
        assert!(rays > 10_000, "{rays}");
        assert_eq!(found, rays, "{height_m} m");
        let (without, _) = seen(gpu, open(), [0.0, LIFT], EDGE_SLACK);
        assert!(without < rays / 2, "{height_m} m: {without} of {rays}");
    }
}

// Points are in f32 and so lie below what they show by more than the tracer's own rounding: of these
// rays some met the surface they start on, before they started above that too.
#[test]
fn a_slope_does_not_shade_itself_in_f64_either() {
    let slope = Rectangle {
        corner: DVec3::new(-10.1, -2.3, 10.1),
        along: DVec3::new(20.2, 4.7, 0.0),
        up: DVec3::new(0.0, 3.1, -20.2),
        albedo: Vec3::ONE,
    };
    let camera = Camera {
        name: "above".into(),
        position: DVec3::Y * 30.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: 18.0 },
    };
    let made = worlds::made(above(9.0), &[slope], &[camera], [31, 33], DVec3::ZERO);
    let world = made.with_shadows().unwrap();
    let targets = targets(&world);
    let seen = exact(&world, &targets);
    let dark = targets.iter().zip(seen).filter(|(target, seen)| target.is_some() && !seen);
    assert_eq!(dark.count(), 0);
}

/// A ground with a sheet above that is as large.
fn covered(lights: Vec<Light>, sheet_m: f64) -> World {
    let of = |height_m: f64| Rectangle {
        corner: DVec3::new(-10.1, height_m, 10.1),
        along: DVec3::X * 20.2,
        up: DVec3::NEG_Z * 20.2,
        albedo: Vec3::ONE,
    };
    let camera = Camera {
        name: "between".into(),
        position: DVec3::Y * (0.5 * sheet_m),
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: 20.2 },
    };
    let sheets = [of(0.0), of(sheet_m)];
    worlds::made(lights, &sheets, &[camera], [29, 31], DVec3::ZERO).with_shadows().unwrap()
}

#[test]
fn everything_is_dark_behind_a_wall() {
    let Some(gpu) = test_gpu() else { return };
    let (found, rays) = seen(gpu, covered(above(2.0), 1.0), APART, EDGE_SLACK);
    assert_eq!((found, rays), (0, 29 * 31 * RAYS));
}

// The ground below sees lights that lie in the very sheet above, as in f64; rays all the way up to
// them would meet it.
#[test]
fn rays_end_before_the_light() {
    let Some(gpu) = test_gpu() else { return };
    let inside = || covered(above(1.1), 1.1);
    let (found, rays) = seen(gpu, inside(), APART, EDGE_SLACK);
    assert_eq!(found, rays);
    let (too_far, _) = seen(gpu, inside(), [LIFT, 0.0], EDGE_SLACK);
    assert!(too_far < rays * 9 / 10, "{too_far} of {rays}");
}

/// A bent sheet of many triangles, points on one side, and for each of its corners and edges' middles
/// a light right behind it.
fn sheet() -> World {
    let side = 24;
    let at = |x: u32, z: u32| {
        let (x, z) = (f64::from(x) / 7.3, f64::from(z) / 6.1);
        DVec3::new(x + 0.1 * (3.0 * z).sin(), 0.3 * (2.0 * x).sin() * z.cos() + 5.0, z)
    };
    let index = |x: u32, z: u32| z * (side + 1) + x;
    let corners = (0..=side).flat_map(|z| (0..=side).map(move |x| (x, z)));
    let positions = corners.map(|(x, z)| at(x, z).as_vec3()).collect::<Vec<_>>();
    let cells = (0..side).flat_map(|z| (0..side).map(move |x| (x, z)));
    let triangles = cells.flat_map(|(x, z)| {
        let [a, b] = [index(x, z), index(x + 1, z)];
        let [c, d] = [index(x, z + 1), index(x + 1, z + 1)];
        [[a, b, d], [a, d, c]]
    });
    let mesh = Mesh { positions, triangles: triangles.collect(), ..Mesh::default() };
    let scene = dapple_scene::Scene {
        materials: vec![Material::default()],
        instances: vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }],
        meshes: vec![mesh],
        ..dapple_scene::Scene::default()
    };
    let tracer = Tracer::build(&scene).unwrap();
    // One point below for each light.
    let [width, height] = [2 * (side - 1), side - 1];
    let mut made = plane(Vec::new(), 1.0, [width, height]).world;
    for (i, point) in made.frames[0].points.iter_mut().enumerate() {
        let (x, z) = (i as u32 % width, i as u32 / width);
        let aim = if x % 2 == 0 {
            at(x / 2 + 1, z + 1)
        } else {
            0.5 * (at(x / 2 + 1, z + 1) + at(x / 2 + 2, z + 1))
        };
        let position = Vec3::new(1.0 + 0.013 * x as f32, 0.0, 1.7 + 0.029 * z as f32);
        *point = Point { position, object: 0, normal: Vec3::Y, albedo: Vec3::ONE, ..*point };
        // Where the ray starts is lifted: what is aimed at is hit to some rounding, on either side.
        let from = position.as_dvec3();
        made.lights.push(omni(from + 2.0 * (aim - from)));
    }
    World { occluders: Some(Arc::new(tracer)), ..made }
}

#[test]
fn nothing_slips_between_triangles() {
    let Some(gpu) = test_gpu() else { return };
    let world = Arc::new(sheet());
    let scene = Scene::new(gpu, &world).unwrap();
    let own = |i: usize| i.is_multiple_of(RAYS).then_some((i / RAYS) as u32);
    let targets: Vec<_> = (0..world.lights.len() * RAYS).map(own).collect();
    // Rays start right at the points, and so go right through what they aim at.
    let occluders = Occluders::apart(gpu, &world, [0.0, LIFT]).unwrap();
    let leaks = |edge_slack: f64| {
        let (found, _) = traced(gpu, &scene, &occluders, edge_slack, &targets);
        found.iter().filter(|seen| **seen).count()
    };
    assert_eq!(leaks(EDGE_SLACK), 0);
    // With edges that are narrower than they are, they do.
    assert!(leaks(-EDGE_SLACK) > 20, "{}", leaks(-EDGE_SLACK));
}

#[test]
fn alpha_tests_are_refused_by_name() {
    let Some(gpu) = test_gpu() else { return };
    let mut made = plane(above(2.0), 10.0, [8, 8]);
    made.scene.textures.push(dapple_scene::Texture::default());
    for material in &mut made.scene.materials {
        material.alpha_test = Some(dapple_scene::AlphaTest { texture: 0, cutoff: 0.5 });
    }
    let world = Arc::new(made.with_shadows().unwrap());
    let refused = Scene::new(gpu, &world).err().map(|error| error.to_string());
    let refused = refused.expect("is not traced");
    assert!(refused.contains("alpha-tested surfaces (2 triangles)"), "{refused}");
}

fn lit(form: Form, technique: &Technique, world: &Arc<World>, tree: &Arc<LightTree>) -> Shaded {
    let scene = Arc::new(Scene::new(test_gpu().unwrap(), world).unwrap());
    let mut lighting = make(form, technique, world, tree, Some(&scene)).unwrap();
    lighting.reset(7).unwrap();
    let mut shaded = Shaded::default();
    lighting.shade(0, true).unwrap();
    lighting.read(&mut shaded).unwrap();
    // Counting changes nothing.
    let mut timed = Shaded::default();
    lighting.reset(7).unwrap();
    lighting.shade(0, false).unwrap();
    lighting.read(&mut timed).unwrap();
    assert_eq!(shaded.radiance, timed.radiance);
    shaded
}

/// Pixels that differ by more than rounding.
fn unlike(a: &Shaded, b: &Shaded) -> usize {
    let differ = |(a, b): &(&Vec3, &Vec3)| {
        (**a - **b).abs().max_element() > 1e-4 * a.max_element().max(b.max_element()) + 1e-9
    };
    a.radiance.iter().zip(&b.radiance).filter(differ).count()
}

fn techniques() -> Vec<Technique> {
    let bound = BoundForm::Cheap;
    let absolute = |per| Technique::Absolute(Absolute { threshold: 1e-3, per, bound });
    let lightcuts = Lightcuts { epsilon: 0.05, most: 200, selection: Selection::Scan, bound };
    let clustered = Clustered { cutoff: 1e-3, tile: 16, slices: 12, window: true };
    let stochastic = |real_time| StochasticLightcuts { cut: 20, real_time };
    vec![
        Technique::BruteForce,
        absolute(Per::Pixel),
        absolute(Per::Tile),
        Technique::Relative(Relative { epsilon: 0.1, bound }),
        Technique::Lightcuts(lightcuts),
        Technique::LightBvh(LightBvh { samples: 8 }),
        Technique::StochasticLightcuts(stochastic(false)),
        Technique::StochasticLightcuts(stochastic(true)),
        Technique::Clustered(clustered),
        Technique::Capped(Capped { most: 40 }),
    ]
}

// Not one of 1127 pixels differed in a larger image, and no count of rays.
#[test]
fn techniques_shadow_as_on_the_processor() {
    if test_gpu().is_none() {
        return;
    }
    let city = city::generate(&generate::city_knobs("city_small").unwrap(), 1).unwrap();
    let camera = city.scene().scene.paths[0].camera(0).unwrap();
    let world = Arc::new(night(&city, &camera, [29, 19]));
    let tree = LightTree::build(&world.lights, Build::Median, Representative::Nearest).unwrap();
    let tree = Arc::new(tree);
    let open = Arc::new(World { occluders: None, ..World::clone(&world) });
    for technique in techniques() {
        let [device, processor] =
            [Form::Gpu, Form::Cpu].map(|form| lit(form, &technique, &world, &tree));
        let there = device.work.pixels as usize;
        let differing = unlike(&device, &processor);
        assert!(differing <= there / 500, "{technique:?}: {differing} of {there} pixels");
        let (rays, of_processor) = (device.work.rays, processor.work.rays);
        assert!(rays > 0 && rays.abs_diff(of_processor) <= rays / 1000, "{rays} {of_processor}");
        let without = unlike(&device, &lit(Form::Cpu, &technique, &open, &tree));
        assert!(without > there / 5, "{technique:?}: {without} of {there} pixels");
    }
}

// Reservoirs ask for rays in every pass.
#[test]
fn a_technique_without_shadow_rays_says_so() {
    let Some(gpu) = test_gpu() else { return };
    let world = Arc::new(cloud(&Cloud::default()).with_shadows().unwrap());
    let scene = Arc::new(Scene::new(gpu, &world).unwrap());
    let settings = Reservoirs {
        candidates: 4,
        temporal: false,
        neighbours: 0,
        radius_px: 1.0,
        history: 1,
        unbiased: true,
    };
    let technique = Technique::Reservoirs(settings);
    let none = Arc::new(LightTree::default());
    let refused = make(Form::Gpu, &technique, &world, &none, Some(&scene)).err();
    assert!(refused.unwrap().to_string().contains("no shadow rays"));
}
