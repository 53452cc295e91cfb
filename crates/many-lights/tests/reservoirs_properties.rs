//! What holds of reservoirs whatever is drawn.

#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod reservoirs_worlds;

use dapple_many_lights::{
    Emission, Eye, Form, Frame, Light, LightTree, Lighting, Point, Reservoirs, Shaded, Technique,
    World, make,
    worlds::{Cloud, cloud, plane},
};
use dapple_scene::{Camera, Projection};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use reservoirs_worlds::{EMISSIONS, bent, mixed, mixed_with_shadows};
use std::sync::Arc;

const BOTH: Reservoirs = Reservoirs {
    candidates: 8,
    temporal: true,
    history: 20,
    neighbours: 3,
    radius_px: 6.0,
    unbiased: true,
};

const PLAIN: Reservoirs = Reservoirs { temporal: false, neighbours: 0, ..BOTH };

const FORMS: [Form; 2] = [Form::Reference, Form::Cpu];

fn made(form: Form, settings: Reservoirs, world: &Arc<World>) -> Box<dyn Lighting + 'static> {
    let tree = Arc::new(LightTree::default());
    make(form, &Technique::Reservoirs(settings), world, &tree, None).unwrap()
}

/// The frames of `order` from a reset; the last one's image.
fn last_of(lighting: &mut dyn Lighting, seed: u32, order: &[usize]) -> Shaded {
    let mut shaded = Shaded::default();
    lighting.reset(seed).unwrap();
    for index in order {
        lighting.shade(*index, true).unwrap();
    }
    lighting.read(&mut shaded).unwrap();
    shaded
}

fn omni(position: DVec3, strength: f64) -> Light {
    let intensity = DVec3::splat(strength);
    Light { position, axis: DVec3::Z, intensity, emission: Emission::Omni }
}

fn truth(world: &World, index: usize) -> Vec<DVec3> {
    let points = &world.frames[index].points;
    points.iter().map(|p| if p.is_there() { world.truth(p) } else { DVec3::ZERO }).collect()
}

#[test]
fn a_lone_light_is_exact_without_reuse() {
    for emission in EMISSIONS {
        let light = Light { emission, axis: DVec3::NEG_Y, ..omni(DVec3::new(0.3, 2.0, 0.1), 5.0) };
        let world = Arc::new(plane(vec![light], 3.0, [9, 7]).world);
        for form in FORMS {
            let shaded = last_of(&mut *made(form, PLAIN, &world), 1, &[0]);
            let truth = truth(&world, 0);
            assert!(truth.iter().any(|rgb| rgb.x > 0.0));
            for (rgb, truth) in shaded.radiance.iter().zip(&truth) {
                let off = (rgb.as_dvec3() - *truth).abs().max_element();
                assert!(off <= 1e-5 * truth.max_element(), "{emission:?} {form:?}: {rgb} {truth}");
            }
        }
    }
}

#[test]
fn nothing_is_lit_by_nothing_by_dark_lights_or_from_behind() {
    let behind = |index: i32| omni(DVec3::new(f64::from(index), -2.0, 0.0), 5.0);
    let dark = |index: i32| omni(DVec3::new(f64::from(index), 2.0, 0.0), 0.0);
    for lights in [vec![], vec![dark(0)], (0..9).map(dark).collect(), (0..9).map(behind).collect()]
    {
        let world = Arc::new(plane(lights, 3.0, [9, 7]).world);
        for form in FORMS {
            let shaded = last_of(&mut *made(form, BOTH, &world), 1, &[0, 0, 0]);
            assert_eq!(shaded.radiance, vec![Vec3::ZERO; 63]);
        }
    }
}

#[test]
fn frames_repeat_for_a_seed_and_do_not_depend_on_counting() {
    for world in [mixed(), mixed_with_shadows()] {
        for form in FORMS {
            let mut lighting = made(form, BOTH, &world);
            let first = last_of(&mut *lighting, 5, &[0, 1, 2]);
            let other = last_of(&mut *lighting, 6, &[0, 1, 2]);
            assert_ne!(first.radiance, other.radiance);
            let again = last_of(&mut *lighting, 5, &[0, 1, 2]);
            assert_eq!((&first.radiance, first.work), (&again.radiance, again.work));
            // Nothing of the history counts after a reset.
            let alone = last_of(&mut *made(form, BOTH, &world), 5, &[2]);
            assert_eq!(last_of(&mut *lighting, 5, &[2]).radiance, alone.radiance);
            lighting.reset(5).unwrap();
            let mut uncounted = Shaded::default();
            for index in 0..3 {
                lighting.shade(index, false).unwrap();
            }
            lighting.read(&mut uncounted).unwrap();
            assert_eq!(uncounted.radiance, first.radiance);
            assert_eq!(uncounted.work, Default::default());
        }
    }
}

#[test]
fn images_do_not_depend_on_the_number_of_threads() {
    for (world, frames) in [(mixed_with_shadows(), 3), (bent(), 2)] {
        let order: Vec<_> = (0..frames).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let shaded = pool.install(|| last_of(&mut *made(Form::Cpu, BOTH, &world), 5, &order));
            (shaded.radiance, shaded.work)
        };
        assert_eq!(on(1), on(3));
    }
}

#[test]
fn work_is_counted() {
    let world = mixed();
    let pixels = world.frames[2].points.iter().filter(|p| p.is_there()).count() as u64;
    for form in FORMS {
        let alone = last_of(&mut *made(form, PLAIN, &world), 5, &[0, 1, 2]).work;
        assert_eq!((alone.pixels, alone.samples), (pixels, 8 * pixels));
        assert_eq!((alone.lights, alone.reused, alone.rays), (8 * pixels, 0, 0));
        let still = Reservoirs { temporal: true, ..PLAIN };
        let still = last_of(&mut *made(form, still, &world), 5, &[2, 2]).work;
        // Every pixel finds itself again.
        assert_eq!((still.reused, still.samples), (pixels, 8 * pixels));
        assert!(still.lights > alone.lights);
        let near = Reservoirs { neighbours: 3, ..PLAIN };
        // A roof all of whose pixels are alike: only those outside of the image are left out.
        let near = last_of(&mut *made(form, near, &bent()), 5, &[1]).work;
        assert!(near.reused > near.pixels && near.reused < 3 * near.pixels, "{near:?}");
        let shadows = mixed_with_shadows();
        let rays = last_of(&mut *made(form, PLAIN, &shadows), 5, &[0]).work.rays;
        assert!(rays > 0 && rays <= pixels);
    }
}

/// Ground that two eyes look at from above, and a wall that a third one looks at.
fn jumping(size: [u32; 2]) -> Arc<World> {
    let lights = (0..20).map(|i| omni(DVec3::new(f64::from(i) - 10.0, 3.0, 1.0), 2.0)).collect();
    let mut world = plane(lights, 10.0, size).world;
    let camera = |position: DVec3, target: DVec3| Camera {
        name: "eye".into(),
        position,
        target,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y_rad: 0.8 },
    };
    let ground = |x: f64| {
        let position = DVec3::new(x, 8.0, 0.1);
        let eye = camera(position, DVec3::new(x, 0.0, 0.0));
        (eye, move |column: f64, row: f64| Point {
            position: DVec3::new(x + 3.0 * column, 0.0, 3.0 * row).as_vec3(),
            object: 0,
            normal: Vec3::Y,
            albedo: Vec3::splat(0.5),
            ..Point::default()
        })
    };
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let frame = |camera: &Camera, point: &dyn Fn(f64, f64) -> Point| {
        let places = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (column, row)));
        let centred = |at: u32, of: u32| 2.0 * (f64::from(at) + 0.5) / f64::from(of) - 1.0;
        let points = places.map(|(c, r)| point(centred(c, size[0]), centred(r, size[1])));
        Frame {
            width: size[0],
            height: size[1],
            eye: Eye::new(camera, DVec3::ZERO, aspect),
            points: points.collect(),
        }
    };
    let (here, point_here) = ground(-7.0);
    let (there, point_there) = ground(7.0);
    let wall = camera(DVec3::new(-7.0, 1.0, 8.0), DVec3::new(-7.0, 1.0, 0.0));
    let on_wall = |column: f64, row: f64| Point {
        position: DVec3::new(-7.0 + 3.0 * column, 1.0 - 3.0 * row, 0.0).as_vec3(),
        object: 1,
        normal: Vec3::Z,
        albedo: Vec3::splat(0.5),
        ..Point::default()
    };
    world.frames =
        vec![frame(&here, &point_here), frame(&there, &point_there), frame(&wall, &on_wall)];
    world.check().unwrap();
    Arc::new(world)
}

#[test]
fn history_is_dropped_where_the_eye_jumps() {
    let world = jumping([12, 9]);
    let temporal = Reservoirs { neighbours: 0, ..BOTH };
    for form in FORMS {
        for jump in [[0, 1], [1, 2], [0, 2], [2, 0]] {
            let mut lighting = made(form, temporal, &world);
            let jumped = last_of(&mut *lighting, 9, &jump);
            let alone = last_of(&mut *lighting, 9, &jump[1..]);
            assert_eq!(jumped.work.reused, 0, "{form:?} {jump:?}");
            assert_eq!(jumped.radiance, alone.radiance, "{form:?} {jump:?}");
        }
        // The control: an eye that stays keeps it.
        let stayed = last_of(&mut *made(form, temporal, &world), 9, &[1, 1]);
        assert!(stayed.work.reused > 100, "{form:?}: {}", stayed.work.reused);
    }
}

#[test]
fn reuse_takes_noise_away() {
    // Ground whose pixels have much the same lights, lamps above it in a spiral.
    let lamp = |i: u32| {
        let (turn, out) = (2.4 * f64::from(i), 0.3 * f64::from(i).sqrt());
        omni(DVec3::new(out * turn.cos(), 2.0, out * turn.sin()), 0.1 + f64::from(i % 7))
    };
    let world = plane((0..300).map(lamp).collect(), 5.0, [40, 30]).world;
    let still = Arc::new(World { frames: vec![world.frames[0].clone(); 6], ..world });
    let truth = truth(&still, 5);
    let error = |settings| {
        let mut lighting = made(Form::Cpu, settings, &still);
        let squared = |seed| {
            let shaded = last_of(&mut *lighting, seed, &[0, 1, 2, 3, 4, 5]);
            let off = shaded.radiance.iter().zip(&truth);
            off.map(|(rgb, truth)| (rgb.as_dvec3() - *truth).length_squared()).sum::<f64>()
        };
        (0..40).map(squared).sum::<f64>()
    };
    let alone = error(PLAIN);
    let temporal = error(Reservoirs { neighbours: 0, ..BOTH });
    let spatial = error(Reservoirs { temporal: false, ..BOTH });
    let both = error(BOTH);
    assert!(temporal < 0.5 * alone && spatial < 0.6 * alone && both < 0.95 * temporal);
}

#[test]
fn a_frame_that_there_is_not_and_settings_beyond_limits_are_refused() {
    let world = mixed();
    for form in FORMS {
        assert!(made(form, BOTH, &world).shade(3, false).is_err());
        let tree = Arc::new(LightTree::default());
        for settings in [
            Reservoirs { candidates: 0, ..BOTH },
            Reservoirs { candidates: u32::MAX, history: u32::MAX, ..BOTH },
            Reservoirs { radius_px: f64::NAN, ..BOTH },
        ] {
            assert!(make(form, &Technique::Reservoirs(settings), &world, &tree, None).is_err());
        }
    }
}

#[test]
fn a_million_lights_are_drawn_from() {
    let world = cloud(&Cloud {
        lights: 1_000_000,
        emissions: EMISSIONS.to_vec(),
        size: [12, 9],
        frames: 2,
        ..Cloud::default()
    });
    let world = Arc::new(world.world);
    let shaded = last_of(&mut *made(Form::Cpu, BOTH, &world), 2, &[0, 1]);
    assert!(shaded.radiance.iter().all(|rgb| rgb.is_finite()));
    assert!(shaded.radiance.iter().filter(|rgb| rgb.x > 0.0).count() > 40);
}

/// Lights and points of any scale, on top of each other, behind, dark.
fn extreme() -> impl Strategy<Value = (Vec<Light>, Vec<Point>, f64)> {
    let unit = || prop_oneof![Just(DVec3::X), Just(DVec3::NEG_Y), Just(DVec3::new(0.6, 0.0, -0.8))];
    let place = || prop::array::uniform3(-2i32..3).prop_map(|p| DVec3::from(p.map(f64::from)));
    let light =
        (place(), unit(), 0usize..4, prop_oneof![Just(0.0), Just(1e-6), 0.5..2.0, Just(1e6)]);
    let light = light.prop_map(|(position, axis, kind, strength)| Light {
        position,
        axis,
        intensity: DVec3::new(strength, 0.0, 0.5 * strength),
        emission: EMISSIONS[kind],
    });
    let point = (place(), unit(), 0u32..4).prop_map(|(position, normal, object)| Point {
        position: position.as_vec3(),
        object: if object == 0 { u32::MAX } else { object },
        normal: normal.as_vec3(),
        albedo: Vec3::new(1.0, 0.5, 0.0),
        ..Point::default()
    });
    let scale = prop_oneof![Just(1e-4), Just(1.0), Just(1e3), Just(1e6)];
    (prop::collection::vec(light, 0..8), prop::collection::vec(point, 12), scale)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn radiance_is_a_number_and_only_where_there_is_light(
        (lights, points, scale) in extreme(), unbiased: bool, seed: u32
    ) {
        let mut world = plane(lights, 1.0, [4, 3]).world;
        for light in &mut world.lights {
            light.position *= scale;
        }
        world.frames[0].points = points;
        for point in &mut world.frames[0].points {
            point.position *= scale as f32;
        }
        // An eye far enough away for all depths to be alike.
        world.frames[0].eye.position = DVec3::Y * (1e3 * scale);
        world.clamp_m = 0.1 * scale;
        world.check().unwrap();
        let world = Arc::new(world);
        let truth = truth(&world, 0);
        for form in FORMS {
            let settings = Reservoirs { unbiased, ..BOTH };
            let shaded = last_of(&mut *made(form, settings, &world), seed, &[0, 0]);
            for (rgb, truth) in shaded.radiance.iter().zip(&truth) {
                prop_assert!(rgb.is_finite() && rgb.min_element() >= 0.0);
                prop_assert!(form == Form::Cpu || *truth != DVec3::ZERO || *rgb == Vec3::ZERO);
            }
        }
    }
}
