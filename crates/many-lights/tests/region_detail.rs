//! Bounds of all the light that a face may get, and cones of what it may mirror: nothing that any of
//! its points gets, or mirrors, is ever above or outside.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Light, LightTree, Point,
    bound::Region,
    cut::children,
    radiance,
    region::{
        levels_of_detail::{Levels, brightest},
        specular::Mirror,
    },
    worlds::{CLAMP_M, WINDOW},
};
use glam::{DVec3, Vec3};
use proptest::{
    prelude::*,
    test_runner::{Config, RngSeed, TestRunner},
};
use std::cell::{Cell, RefCell};

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    let side = move || -reach..=reach;
    (side(), side(), side()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn direction() -> impl Strategy<Value = DVec3> {
    vector(1.0).prop_map(|v| v.try_normalize().unwrap_or(DVec3::Y))
}

fn emission() -> impl Strategy<Value = Emission> {
    prop_oneof![
        Just(Emission::Omni),
        Just(Emission::Oriented),
        Just(WINDOW),
        Just(Emission::Directional)
    ]
}

fn lights(most: usize) -> impl Strategy<Value = Vec<Light>> {
    let one = (vector(40.0), direction(), vector(20.0), emission()).prop_map(
        |(position, axis, intensity, emission)| Light {
            position,
            axis,
            intensity: intensity.abs(),
            emission,
        },
    );
    prop::collection::vec(one, 0..most)
}

/// A face: flat along one of the axes, or not.
fn region() -> impl Strategy<Value = Region> {
    let spread = prop_oneof![Just(0.0), 0.0..0.5_f64];
    (vector(30.0), vector(8.0), direction(), spread, 0..4_usize).prop_map(
        |(corner, size, normal_axis, normal_spread_rad, flat)| {
            let mut size = size.abs();
            if flat < 3 {
                size[flat] = 0.0;
            }
            let (min, max) = (corner, corner + size);
            Region { min, max, normal_axis, normal_spread_rad, albedo: DVec3::splat(0.5) }
        },
    )
}

/// A place in a unit cube, and a lean: how far of what is allowed, and to which side.
type Draw = (f64, f64, f64, f64, f64);

fn draws(number: usize) -> impl Strategy<Value = Vec<Draw>> {
    let one = || prop_oneof![0.0..=1.0_f64, Just(0.0), Just(1.0)];
    prop::collection::vec((one(), one(), one(), one(), 0.0..std::f64::consts::TAU), number)
}

/// A direction that leans by an angle, to a side.
fn leant(axis: DVec3, angle_rad: f64, side_rad: f64) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    let across = u * side_rad.cos() + v * side_rad.sin();
    (axis * angle_rad.cos() + across * angle_rad.sin()).normalize()
}

/// A point of a region, and its normal.
fn drawn(region: &Region, &(x, y, z, lean, side): &Draw) -> (DVec3, DVec3) {
    let place = region.min + (region.max - region.min) * DVec3::new(x, y, z);
    let place = place.clamp(region.min, region.max);
    (place, leant(region.normal_axis, lean * region.normal_spread_rad, side))
}

/// What all lights give a white surface there, largest channel.
fn measured(lights: &[Light], place: DVec3, normal: DVec3) -> f64 {
    let point = Point {
        position: place.as_vec3(),
        normal: normal.as_vec3(),
        albedo: Vec3::ONE,
        ..Point::default()
    };
    lights.iter().map(|light| radiance(&point, light, CLAMP_M)).sum::<DVec3>().max_element()
}

/// The region, large enough for points in f32.
fn grown(region: &Region) -> Region {
    let by = region.min.abs().max(region.max.abs()).max_element() * 1e-6;
    Region { min: region.min - by, max: region.max + by, ..*region }
}

/// Children of the roots, or the roots where these are lights.
fn below_roots(tree: &LightTree) -> Vec<u32> {
    let size = |node: u32| tree.nodes[node as usize].size;
    let of = |&root: &u32| match size(root) {
        1 => vec![root],
        _ => children(root, size).collect(),
    };
    tree.roots.iter().flat_map(of).collect()
}

#[test]
fn no_point_of_a_face_gets_more_light_than_its_bound() {
    // Points compared, those that get any light, and those that get more than half of a precut may give.
    let [compared, lit, beyond] = [0, 1, 2].map(|_| Cell::new(0));
    let least_share = Cell::new(f64::INFINITY);
    let add = |sum: &Cell<u32>, one: bool| sum.set(sum.get() + u32::from(one));
    let mut runner = TestRunner::new(Config {
        cases: 400,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(31),
        ..Config::default()
    });
    let cases = (lights(40), region(), draws(24));
    runner
        .run(&cases, |(lights, region, draws)| {
            let tree = LightTree::median(&lights).unwrap();
            let face = grown(&region);
            let precut = below_roots(&tree);
            let bounds = [f64::INFINITY, 1e-1, 1e-3, 0.0].map(|threshold| {
                let found = brightest(&tree, &precut, &face, CLAMP_M, threshold);
                prop_assert_eq!(found.irradiance(), std::f64::consts::PI * found.radiance);
                prop_assert!(found.bounds as usize >= precut.len());
                Ok(found.radiance)
            });
            for draw in &draws {
                let (place, normal) = drawn(&region, draw);
                let given = measured(&lights, place, normal);
                for bound in &bounds {
                    let bound = *bound.as_ref().map_err(Clone::clone)?;
                    prop_assert!(given <= bound, "{given} of {bound}");
                    add(&compared, true);
                }
                add(&lit, given > 0.0);
                let finest = *bounds[3].as_ref().map_err(Clone::clone)?;
                let share = finest / given.max(f64::MIN_POSITIVE);
                least_share.set(least_share.get().min(share));
                // Negative control: half of the precut does not bound all of it.
                let half = &precut[..precut.len() / 2];
                let half = brightest(&tree, half, &face, CLAMP_M, 0.0).radiance;
                add(&beyond, given > half);
            }
            Ok(())
        })
        .unwrap();
    let [compared, lit, beyond] = [compared, lit, beyond].map(Cell::into_inner);
    let least_share = least_share.into_inner();
    assert!(compared > 30_000 && lit > 5000, "{compared} compared, {lit} lit");
    assert!(beyond > 1000, "{beyond}");
    // It is no bound of anything: somewhere a point gets nearly as much.
    assert!(least_share < 1.01, "{least_share}");
}

#[test]
fn dark_alleys_get_coarse_levels_and_lit_fronts_fine_ones() {
    let face = |x: f64| Region {
        min: DVec3::new(x, 0.0, 0.0),
        max: DVec3::new(x + 5.0, 6.0, 0.0),
        normal_axis: DVec3::Z,
        normal_spread_rad: 0.0,
        albedo: DVec3::ONE,
    };
    let window = |x: f64| Light {
        position: DVec3::new(x, 3.0, 12.0),
        axis: DVec3::NEG_Z,
        intensity: DVec3::splat(20.0),
        emission: WINDOW,
    };
    let lights: Vec<Light> = (0..20).map(|i| window(f64::from(i) * 0.5)).collect();
    let tree = LightTree::median(&lights).unwrap();
    let levels = Levels::new(0.25, 6).unwrap();
    let level = |x: f64| {
        let found = brightest(&tree, &tree.roots, &face(x), CLAMP_M, 1e-3);
        levels.level(found.radiance)
    };
    let along = [0.0, 10.0, 14.0, 17.0, 40.0].map(level);
    assert!(along.is_sorted(), "{along:?}");
    assert_eq!((along[0], along[4]), (0, 6), "{along:?}");
    // A precut of nothing is darkness.
    assert_eq!(levels.level(brightest(&tree, &[], &face(0.0), CLAMP_M, 0.0).radiance), 6);
}

/// Where a surface mirrors what comes from the eye to.
fn mirror_direction(place: DVec3, normal: DVec3, eye: DVec3) -> DVec3 {
    let to_eye = (eye - place).normalize();
    2.0 * normal.dot(to_eye) * normal - to_eye
}

/// How many lights are mirrored to the eye from drawn points, how many of those a cone leaves out, and
/// how many it leaves out of all.
#[derive(Debug, Default)]
struct Kept {
    mirrored: usize,
    lost: usize,
    culled: usize,
    lights: usize,
}

/// Holds cones that `made` makes of a face, an eye and a lobe, against what its points mirror.
fn kept(made: impl Fn(&Region, [DVec3; 2], f64) -> Mirror) -> Kept {
    let sum = RefCell::new(Kept::default());
    let mut runner = TestRunner::new(Config {
        cases: 300,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(47),
        ..Config::default()
    });
    let eye = (vector(30.0), prop_oneof![Just(DVec3::ZERO), vector(2.0)]);
    let cases = (region(), eye, 0.0..0.3_f64, lights(30), draws(40), 0.5..40.0_f64, emission());
    runner
        .run(&cases, |(region, (at, moves), lobe, mut lights, draws, far, emission)| {
            let eye = [at, at + moves.abs()];
            let from = |draw: &Draw| {
                let (place, normal) = drawn(&region, draw);
                (place, normal, at + moves.abs() * DVec3::new(draw.3, draw.0, draw.1))
            };
            // Lights that points do mirror, to the very edge of the lobe.
            for draw in &draws {
                let (place, normal, eye) = from(draw);
                let axis = mirror_direction(place, normal, eye);
                let direction = leant(axis, lobe * (1.0 - 1e-9) * draw.0, draw.4);
                lights.push(Light {
                    position: place + direction * far * (0.1 + draw.2),
                    axis: -direction,
                    intensity: DVec3::ONE,
                    emission,
                });
            }
            let tree = LightTree::median(&lights).unwrap();
            let mirror = made(&grown(&region), eye, lobe);
            let mut found = Vec::new();
            let tests = mirror.reflected(&tree, &tree.roots, &mut found);
            prop_assert!(tests >= found.len() as u64);
            prop_assert!(found.is_sorted());
            let is_kept = |light: usize| found.binary_search(&tree.leaves[light]).is_ok();
            for (light, one) in lights.iter().enumerate() {
                let is_mirrored = draws.iter().any(|draw| {
                    let (place, normal, eye) = from(draw);
                    let to_light = match one.emission {
                        Emission::Directional => -one.axis,
                        _ => (one.position - place).normalize(),
                    };
                    let axis = mirror_direction(place, normal, eye);
                    let lean = axis.cross(to_light).length().atan2(axis.dot(to_light));
                    let in_front = normal.dot(eye - place) > 0.0 && normal.dot(to_light) > 0.0;
                    in_front && lean <= lobe
                });
                let mut sum = sum.borrow_mut();
                sum.lights += 1;
                sum.mirrored += usize::from(is_mirrored);
                sum.lost += usize::from(is_mirrored && !is_kept(light));
                sum.culled += usize::from(!is_kept(light));
            }
            Ok(())
        })
        .unwrap();
    sum.into_inner()
}

#[test]
fn every_light_that_a_face_mirrors_is_kept() {
    let mut culled = Vec::new();
    for halvings in [0, 3, 6] {
        let of = kept(|region, eye, lobe| Mirror::new(region, eye, lobe, halvings).unwrap());
        assert_eq!(of.lost, 0, "{halvings}: {of:?}");
        assert!(of.mirrored > 3000 && of.culled > of.lights / 10, "{halvings}: {of:?}");
        culled.push(of.culled);
    }
    // Parts of a face leave out more than the whole of it.
    assert!(culled.is_sorted() && culled[0] < culled[2], "{culled:?}");
}

#[test]
fn a_narrower_lobe_flat_normals_or_the_middle_of_a_face_lose_lights() {
    // Negative controls: each leaves out one thing that opens the cone.
    let half_lobe = kept(|region, eye, lobe| Mirror::new(region, eye, 0.5 * lobe, 6).unwrap());
    let flat = kept(|region, eye, lobe| {
        Mirror::new(&Region { normal_spread_rad: 0.0, ..*region }, eye, lobe, 6).unwrap()
    });
    let middle = kept(|region, eye, lobe| {
        let middle = 0.5 * (region.min + region.max);
        Mirror::new(&Region { min: middle, max: middle, ..*region }, eye, lobe, 0).unwrap()
    });
    let still = kept(|region, [eye, _], lobe| Mirror::new(region, [eye, eye], lobe, 6).unwrap());
    let away = kept(|region, eye, lobe| {
        Mirror::new(&Region { normal_axis: -region.normal_axis, ..*region }, eye, lobe, 6).unwrap()
    });
    for wrong in [half_lobe, flat, middle, still, away] {
        assert!(wrong.lost > 20, "{wrong:?}");
    }
}
