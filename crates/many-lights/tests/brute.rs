//! R0 in f32 against f64, its counters, and its rays.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Eye, Form, Frame, Light, LightTree, Point, Shaded, Technique, World, make,
};
use dapple_scene::{Instance, Material, Scene, generate::mesh::quad};
use dapple_trace::Tracer;
use glam::{DAffine3, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::{f64::consts::PI, sync::Arc};

fn vector(random: &mut Pcg32, half: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.random_range(-half..half)))
}

fn unit(random: &mut Pcg32) -> DVec3 {
    vector(random, 1.0).normalize_or(DVec3::Y)
}

/// Lights of all kinds at random in a box of 40 m, over points on its floor, some of them nowhere.
fn world(lights: usize, width: u32, height: u32) -> World {
    let mut random = Pcg32::seed_from_u64(11);
    let lights = (0..lights)
        .map(|index| Light {
            position: vector(&mut random, 20.0) + 20.0 * DVec3::Y,
            axis: unit(&mut random),
            intensity: vector(&mut random, 1.0).abs(),
            emission: Emission::of(index as u32 % 4, random.random_range(0.2..PI)),
        })
        .collect();
    let points = (0..width * height)
        .map(|pixel| {
            if pixel % 7 == 3 {
                return Point::nothing();
            }
            let position = vector(&mut random, 20.0) * DVec3::new(1.0, 0.0, 1.0);
            Point {
                position: position.as_vec3(),
                normal: (DVec3::Y + 0.5 * unit(&mut random)).as_vec3().normalize(),
                albedo: Vec3::new(0.2, 0.5, 0.9),
                ..Point::default()
            }
        })
        .collect();
    let eye = Eye {
        position: DVec3::Y,
        forward: DVec3::X,
        right: DVec3::Z,
        up: DVec3::Y,
        perspective: true,
    };
    World {
        origin: DVec3::new(5e5, -3.0, 2e6),
        lights,
        frames: vec![Frame { width, height, eye, points }],
        clamp_m: 0.1,
        occluders: None,
    }
}

fn shaded(form: Form, world: &Arc<World>) -> Shaded {
    let tree = Arc::new(LightTree::default());
    let mut lighting = make(form, &Technique::BruteForce, world, &tree, None).unwrap();
    lighting.reset(1).unwrap();
    lighting.shade(0, true).unwrap();
    let mut shaded = Shaded::default();
    lighting.read(&mut shaded).unwrap();
    assert!(lighting.shade(1, false).is_err(), "there is one frame alone");
    shaded
}

/// The greatest difference over the greatest radiance of the pixel, or 1e-3.
fn difference(a: &Shaded, b: &Shaded) -> f32 {
    assert_eq!(a.radiance.len(), b.radiance.len());
    let pairs = a.radiance.iter().zip(&b.radiance);
    pairs.map(|(a, b)| (a - b).abs().max_element() / b.max_element().max(1e-3)).fold(0.0, f32::max)
}

#[test]
fn f32_gives_what_f64_gives_and_counts_the_same() {
    for (lights, width, height) in
        [(0, 5, 3), (1, 8, 8), (2, 9, 7), (15, 1, 1), (1000, 17, 24), (4099, 10, 9), (3, 0, 0)]
    {
        let world = Arc::new(world(lights, width, height));
        world.check().unwrap();
        let (reference, cpu) = (shaded(Form::Reference, &world), shaded(Form::Cpu, &world));
        let there = world.frames[0].points.iter().filter(|p| p.is_there()).count() as u64;
        assert_eq!(reference.work.lights, there * lights as u64);
        assert_eq!(reference.work, cpu.work);
        assert_eq!(reference.work.rays, 0);
        let off = difference(&cpu, &reference);
        assert!(off < 1e-5, "{lights} lights, {width} x {height}: {off}");
        for (radiance, point) in cpu.radiance.iter().zip(&world.frames[0].points) {
            assert!(point.is_there() || *radiance == Vec3::ZERO);
        }
        if lights >= 1000 {
            assert!(cpu.radiance.iter().filter(|r| r.max_element() > 0.0).count() > 50);
        }
    }
}

#[test]
fn a_light_too_few_is_seen() {
    let whole = Arc::new(world(1000, 9, 7));
    let mut few = (*whole).clone();
    few.lights.pop();
    let few = Arc::new(few);
    assert!(difference(&shaded(Form::Cpu, &few), &shaded(Form::Reference, &whole)) > 1e-5);
}

#[test]
fn threads_do_not_change_a_bit() {
    let world = Arc::new(world(500, 33, 20));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shaded(Form::Cpu, &world).radiance)
    };
    assert_eq!(with(1), with(5));
}

/// A million equal lights: one running f32 would be off by a share of 1e-3 and more.
#[test]
fn a_million_lights_sum_up() {
    let mut one = world(1, 1, 1);
    one.frames[0].points[0] = Point { normal: Vec3::Y, albedo: Vec3::ONE, ..Point::default() };
    let position = DVec3::new(0.0, 3.0, 0.0);
    let lamp = Light { position, emission: Emission::Omni, ..one.lights[0] };
    one.lights = vec![Light { intensity: DVec3::splat(0.1), ..lamp }; 1_000_000];
    let world = Arc::new(one);
    let (reference, cpu) = (shaded(Form::Reference, &world), shaded(Form::Cpu, &world));
    let expected = 1e5 / (9.0 * std::f32::consts::PI);
    assert!((reference.radiance[0].x / expected - 1.0).abs() < 1e-6);
    assert!(difference(&cpu, &reference) < 1e-6);
}

/// A roof at 10 m over one half of the floor.
fn roofed() -> (World, World) {
    let open = world(300, 17, 12);
    let roof = quad(Vec3::new(10.0, 10.0, 0.0), 10.0 * Vec3::X, 20.0 * Vec3::Z);
    let transform = DAffine3::from_translation(open.origin);
    let scene = Scene {
        materials: vec![Material::default()],
        instances: vec![Instance { mesh: 0, transform }],
        meshes: vec![roof],
        ..Scene::default()
    };
    let occluders = Some(Arc::new(Tracer::build(&scene).unwrap()));
    (World { occluders, ..open.clone() }, open)
}

#[test]
fn shadow_rays_only_take_away_and_both_forms_agree() {
    let (roofed, open) = roofed();
    let (roofed, open) = (Arc::new(roofed), Arc::new(open));
    let [reference, cpu] = [Form::Reference, Form::Cpu].map(|form| shaded(form, &roofed));
    let whole = shaded(Form::Reference, &open);
    let darker = reference.radiance.iter().zip(&whole.radiance).filter(|(a, b)| {
        assert!(a.cmple(**b).all(), "{a} {b}");
        a.max_element() < 0.9 * b.max_element()
    });
    assert!(darker.count() > 50);
    let off = difference(&cpu, &reference);
    assert!(off < 1e-5, "{off}");
    // A ray to every light that gives anything; f32 may tell a grazing one otherwise.
    let lit = reference.work.rays;
    assert!(lit > 0 && lit < reference.work.lights && whole.work.rays == 0);
    assert!(cpu.work.rays.abs_diff(lit) * 1000 <= lit, "{} {lit}", cpu.work.rays);
}
