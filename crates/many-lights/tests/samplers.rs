//! Samplers on the processor: bias told from variance, and what no frame may do.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Emission, Form, Frame, LightBvh, LightTree, Lighting, Point, Shaded, StochasticLightcuts,
    Technique, World, make,
    sample::{expected, statistics::Moments},
    tree::{Build, Representative},
    worlds::{Cloud, cloud, plane},
};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

#[path = "samplers_support/mod.rs"]
mod support;
use support::{ALL, every, small, tree_of};

fn light(form: Form, technique: &Technique, world: &Arc<World>) -> Box<dyn Lighting> {
    make(form, technique, world, &tree_of(world), None).unwrap()
}

fn image(lighting: &mut dyn Lighting, seed: u32, frame: usize) -> Shaded {
    let mut shaded = Shaded::default();
    lighting.reset(seed).unwrap();
    lighting.shade(frame, true).unwrap();
    lighting.read(&mut shaded).unwrap();
    shaded
}

fn truth(world: &World) -> Vec<DVec3> {
    let one = |point: &Point| if point.is_there() { world.truth(point) } else { DVec3::ZERO };
    world.frames[0].points.iter().map(one).collect()
}

#[test]
fn enumerated_means_are_the_truth() {
    for emissions in [&ALL[..], &[Emission::Omni]] {
        let made = small(emissions, 50, [19, 13]);
        let shadowed = made.clone().with_shadows().unwrap();
        for world in [Arc::new(made.world), Arc::new(shadowed)] {
            let truth = truth(&world);
            assert!(truth.iter().any(|value| value.max_element() > 0.05));
            for technique in every() {
                for (form, rounding) in [(Form::Reference, 1e-12), (Form::Cpu, 2e-5)] {
                    let found = expected(form, &technique, &world, &tree_of(&world), 0).unwrap();
                    for (mean, truth) in found.mean.iter().zip(&truth) {
                        let off = (*mean - *truth).abs().max_element();
                        assert!(
                            off <= rounding * truth.max_element(),
                            "{technique:?} {mean} {truth}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn images_have_the_enumerated_mean_and_variance() {
    let made = small(&ALL, 30, [11, 9]);
    let shadowed = made.clone().with_shadows().unwrap();
    for world in [Arc::new(made.world), Arc::new(shadowed)] {
        for technique in every() {
            let tree = tree_of(&world);
            let known = expected(Form::Cpu, &technique, &world, &tree, 0).unwrap();
            let mut lighting = light(Form::Cpu, &technique, &world);
            let mut moments = Moments::default();
            for seed in 0..2000 {
                moments.push(&image(&mut *lighting, seed, 0).radiance);
            }
            let test = moments.z_test(&known.mean, &known.variance, 0.001, 1e-5);
            assert!(test.passes() && test.tests == 3 * 99, "{technique:?}: {test:?}");
            // The variances together: single ones scatter by far more than 10 %.
            let sum = |variances: &[DVec3]| variances.iter().map(|v| v.element_sum()).sum::<f64>();
            let (found, exact) = (sum(&moments.variance()), sum(&known.variance));
            assert!((found - exact).abs() <= 0.1 * exact, "{technique:?}: {found} {exact}");
            // Control: a mean that is 5 % off.
            let off: Vec<_> = known.mean.iter().map(|mean| *mean * 1.05).collect();
            assert!(!moments.z_test(&off, &known.variance, 0.001, 1e-5).passes(), "{technique:?}");
        }
    }
}

#[test]
fn more_samples_scatter_less_and_cuts_of_all_lights_not_at_all() {
    let world = Arc::new(small(&ALL, 40, [16, 8]).world);
    let variance = |technique| {
        let found = expected(Form::Reference, &technique, &world, &tree_of(&world), 0).unwrap();
        found.variance.iter().map(|v| v.element_sum()).sum::<f64>()
    };
    let bvh = |samples| variance(Technique::LightBvh(LightBvh { samples }));
    assert!((bvh(1) / bvh(4) - 4.0).abs() < 1e-9);
    for real_time in [false, true] {
        let cut =
            |cut| variance(Technique::StochasticLightcuts(StochasticLightcuts { cut, real_time }));
        assert!(cut(20) < cut(6) && cut(6) < cut(1));
        // Clusters that give nothing where a tile's cut is made are not split.
        assert!(if real_time { cut(40) < cut(20) } else { cut(40) == 0.0 });
    }
    let cuts = [true, false].map(|real_time| {
        variance(Technique::StochasticLightcuts(StochasticLightcuts { cut: 16, real_time }))
    });
    // A cut that was made for another pixel leaves more noise.
    assert!(cuts[0] > cuts[1], "{cuts:?}");
}

#[test]
fn forms_draw_the_same_lights() {
    let world = Arc::new(small(&ALL, 300, [37, 29]).world);
    for technique in every() {
        let reference = image(&mut *light(Form::Reference, &technique, &world), 5, 0);
        let cpu = image(&mut *light(Form::Cpu, &technique, &world), 5, 0);
        let share = support::differing(&reference.radiance, &cpu.radiance);
        assert!(share <= support::DIFFERING, "{technique:?}: {share}");
        // Control: another seed draws other lights.
        let other = image(&mut *light(Form::Cpu, &technique, &world), 6, 0);
        assert!(support::differing(&reference.radiance, &other.radiance) > 0.3);
    }
}

#[test]
fn threads_seeds_and_counting_change_nothing_that_they_should_not() {
    let world = Arc::new(small(&ALL, 100, [37, 29]).world);
    for technique in every() {
        let mut lighting = light(Form::Cpu, &technique, &world);
        let counted = image(&mut *lighting, 3, 0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let alone = pool.install(|| {
            let mut lighting = light(Form::Cpu, &technique, &world);
            let mut shaded = Shaded::default();
            lighting.reset(3).unwrap();
            lighting.shade(0, false).unwrap();
            lighting.read(&mut shaded).unwrap();
            shaded
        });
        assert_eq!(counted.radiance, alone.radiance, "{technique:?}");
        assert!(alone.visits.is_empty() && alone.work == Default::default());
        let work = counted.work;
        let there = world.frames[0].points.iter().filter(|p| p.is_there()).count() as u64;
        assert_eq!(work.pixels, there);
        assert_eq!(work.visits, counted.visits.iter().map(|&v| u64::from(v)).sum::<u64>());
        assert!(work.lane_visits >= work.visits && work.samples <= work.lights);
        assert!(work.samples > 0 && work.rays == 0);
        if let Technique::LightBvh(settings) = technique {
            assert!(work.samples <= there * u64::from(settings.samples));
        } else {
            assert!(work.cut >= work.lights && work.most_cut <= 16, "{work:?}");
        }
        assert!(lighting.bytes() > 0);
        assert!(lighting.shade(1, false).is_err());
    }
}

#[test]
fn a_shadow_ray_is_cast_for_every_light_that_gives_anything() {
    let made = small(&[Emission::Omni], 30, [16, 16]);
    let world = Arc::new(made.with_shadows().unwrap());
    for technique in every() {
        let work = image(&mut *light(Form::Cpu, &technique, &world), 1, 0).work;
        assert!(work.rays > 0 && work.rays <= work.lights, "{technique:?}: {work:?}");
    }
}

/// A frame of the points, in one row.
fn row(world: &World, points: Vec<Point>) -> World {
    let frame = Frame { width: points.len() as u32, height: 1, points, ..world.frames[0].clone() };
    World { frames: vec![frame], ..world.clone() }
}

#[test]
fn extremes_stay_finite_and_exact() {
    let made = small(&ALL, 9, [4, 4]);
    let base = made.world;
    let omni = base.lights.iter().find(|light| light.emission == Emission::Omni).unwrap();
    let at = omni.position.as_vec3();
    let mut worlds = vec![
        // Nothing shows, and no pixels at all.
        row(&base, vec![Point::nothing(); 9]),
        row(&base, Vec::new()),
        // No lights.
        World { lights: Vec::new(), ..base.clone() },
        // One light; one that gives nothing; many in one place.
        World { lights: base.lights[..1].to_vec(), ..base.clone() },
    ];
    let mut dark = base.clone();
    dark.lights.iter_mut().for_each(|light| light.intensity = DVec3::ZERO);
    worlds.push(dark);
    let mut coincident = base.clone();
    coincident.lights = vec![*omni; 33];
    // In the lights' very place too.
    let on = Point { position: at, object: 0, normal: Vec3::Y, ..base.frames[0].points[15] };
    let near = Point { position: at + Vec3::Y * 1e-4, ..on };
    worlds.push(row(&coincident, vec![on, near, Point { albedo: Vec3::ZERO, ..near }]));
    // All lights behind the surface.
    let mut behind = base.clone();
    behind.lights.retain(|light| light.emission == Emission::Omni);
    let under = Point { position: Vec3::Y * -50.0, normal: Vec3::NEG_Y, ..on };
    worlds.push(row(&behind, vec![under; 10]));
    for world in worlds {
        let world = Arc::new(world);
        let truth = truth(&world);
        for technique in every() {
            let known = expected(Form::Reference, &technique, &world, &tree_of(&world), 0).unwrap();
            for form in [Form::Reference, Form::Cpu] {
                let shaded = image(&mut *light(form, &technique, &world), 1, 0);
                assert_eq!(shaded.radiance.len(), truth.len());
                for ((value, truth), variance) in
                    shaded.radiance.iter().zip(&truth).zip(&known.variance)
                {
                    assert!(value.is_finite() && value.min_element() >= 0.0);
                    // Where nothing is left to chance there is no noise.
                    if variance.max_element() <= 1e-12 * truth.max_element().powi(2) {
                        let off = (value.as_dvec3() - *truth).abs().max_element();
                        assert!(off <= 1e-5 * truth.max_element(), "{technique:?} {value} {truth}");
                    }
                }
            }
        }
    }
}

#[test]
fn one_light_above_a_plane_is_drawn_with_certainty() {
    let light = dapple_many_lights::Light {
        position: DVec3::Y * 2.0,
        axis: DVec3::NEG_Y,
        intensity: DVec3::new(3.0, 2.0, 1.0),
        emission: Emission::Spot { half_angle_rad: 0.25 * PI },
    };
    let world = Arc::new(plane(vec![light], 1.0, [9, 9]).world);
    for technique in every() {
        let shaded = image(&mut *self::light(Form::Cpu, &technique, &world), 1, 0);
        // The middle pixel lies below the light: rho I / (pi d^2), the surface being white.
        let middle = shaded.radiance[40].as_dvec3();
        let closed = DVec3::new(3.0, 2.0, 1.0) / (4.0 * PI);
        assert!((middle - closed).abs().max_element() < 1e-5, "{technique:?}: {middle} {closed}");
    }
}

#[test]
fn trees_of_many_children_are_drawn_from_too() {
    let settings = Cloud {
        lights: 60,
        emissions: ALL.to_vec(),
        seed: 11,
        size: [9, 9],
        frames: 1,
        origin: DVec3::ZERO,
    };
    let world = Arc::new(cloud(&settings).world);
    let keys: Vec<_> = (0..60).map(|i| vec![i % 5, i % 7]).collect();
    let tree = LightTree::build(&world.lights, Build::Keys(&keys), Representative::Weighted);
    let tree = Arc::new(tree.unwrap());
    let truth = truth(&world);
    for technique in every() {
        for form in [Form::Reference, Form::Cpu] {
            let known = expected(form, &technique, &world, &tree, 0).unwrap();
            for (mean, truth) in known.mean.iter().zip(&truth) {
                assert!((*mean - *truth).abs().max_element() <= 2e-5 * truth.max_element());
            }
            let mut lighting = make(form, &technique, &world, &tree, None).unwrap();
            let work = image(&mut *lighting, 1, 0).work;
            assert!(work.most_cut <= 16 && work.visits > 0);
        }
    }
}

#[test]
fn a_million_lights_are_drawn_from() {
    let world = Arc::new(small(&ALL, 1_000_000, [6, 4]).world);
    let tree = tree_of(&world);
    let whole: DVec3 = truth(&world).iter().sum();
    for (technique, allowed) in [
        (Technique::LightBvh(LightBvh { samples: 256 }), 0.1),
        (Technique::StochasticLightcuts(StochasticLightcuts { cut: 256, real_time: false }), 0.05),
        (Technique::StochasticLightcuts(StochasticLightcuts { cut: 256, real_time: true }), 0.1),
    ] {
        let mut lighting = make(Form::Cpu, &technique, &world, &tree, None).unwrap();
        let shaded = image(&mut *lighting, 1, 0);
        let found: DVec3 = shaded.radiance.iter().map(|value| value.as_dvec3()).sum();
        let off = (found - whole).abs().max_element() / whole.max_element();
        assert!(off < allowed, "{technique:?}: {found} {whole}");
        // Ways down are as long as the tree is deep: 18 levels of 2 a kind, and its 4 roots.
        let most = shaded.work.pixels * 256 * 40;
        assert!(shaded.work.visits < most, "{technique:?}: {:?}", shaded.work);
    }
}
