//! Clustered shading: no light within reach of a point is missing from its list.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod lists_support;

use dapple_many_lights::{
    Clustered, Emission, Eye, Form, Frame, Light, Point, Technique, World,
    clustered::{Cell, Grid, Hierarchy, cells, lists, reach_m, window},
    radiance,
    worlds::{Cloud, Facade, WINDOW, cloud, emissions, facade, plane},
};
use glam::{DVec3, Vec3};
use lists_support::{close, extremes, image, sums, work};
use proptest::prelude::*;

const SETTINGS: Clustered = Clustered { cutoff: 1e-3, tile: 16, slices: 12, window: false };

fn settings() -> Vec<Clustered> {
    let of = |cutoff, tile, slices, window| Clustered { cutoff, tile, slices, window };
    vec![
        SETTINGS,
        of(1e-2, 8, 24, true),
        of(0.1, 7, 3, false),
        of(1e-4, 64, 1, true),
        of(3e-2, 1, 5, false),
        of(1e-300, 1000, 1000, false),
        of(f64::INFINITY, 16, 12, true),
    ]
}

/// Brute force over lights that are cut at their reach: written apart from what it judges.
fn cut_sum(world: &World, point: &Point, settings: &Clustered) -> DVec3 {
    let one = |light: &Light| {
        let given = radiance(point, light, world.clamp_m);
        if light.emission == Emission::Directional {
            return given;
        }
        let squared = (light.position - point.position.as_dvec3()).length_squared();
        let reach = reach_m(light, settings.cutoff);
        if reach == 0.0 || squared > reach * reach {
            return DVec3::ZERO;
        }
        given * if settings.window { window(squared, reach * reach) } else { 1.0 }
    };
    world.lights.iter().map(one).sum()
}

/// What f32 may give or not at a light's very reach.
fn at_reach(settings: &Clustered) -> f64 {
    if settings.cutoff.is_finite() { 2.0 * settings.cutoff } else { 0.0 }
}

/// What leaves a light towards a point, over what leaves it along its axis.
fn towards(light: &Light, point: &Point) -> f64 {
    let to_point = (point.position.as_dvec3() - light.position).normalize_or_zero();
    light.emission.falloff(light.axis.dot(to_point).clamp(-1.0, 1.0).acos())
}

/// Lights that reach a point and are not in its cell's list. `listed` has the lights that lists are
/// made of: the world's own, unless something is to be found missing.
fn missing(
    world: &World,
    listed: &World,
    frame: &Frame,
    settings: &Clustered,
    change: impl Fn(&mut Cell),
) -> usize {
    let grid = Grid::of(frame, settings).unwrap();
    let mut cells = cells(&grid, frame);
    cells.iter_mut().for_each(change);
    let lists = lists(listed, &cells, settings.cutoff);
    let hierarchy = Hierarchy::new(&listed.lights, settings.cutoff);
    let mut missing = 0;
    for (pixel, point) in frame.points.iter().enumerate().filter(|(_, p)| p.is_there()) {
        let cell = grid.cell_of(frame, pixel);
        let list = lists.of(cell);
        let mut found = Vec::new();
        hierarchy.list(&cells[cell], &mut found);
        let found: Vec<_> = found.iter().map(|&i| hierarchy.lights[i as usize].light).collect();
        for (index, light) in world.lights.iter().enumerate() {
            let distance = light.position.distance(point.position.as_dvec3());
            let reach = reach_m(light, settings.cutoff);
            let share = towards(light, point);
            if reach > 0.0 && distance <= reach && share > 0.0 {
                missing += usize::from(list.binary_search(&(index as u32)).is_err());
            }
            // f32 decides by its own distance.
            let place = hierarchy.lights.iter().position(|node| node.light == index as u32);
            let in_f32 = place.is_some_and(|place| {
                let squared = (hierarchy.lights[place].position - point.position).length_squared();
                share > 1e-4 && squared <= hierarchy.reaches[place].squared
            });
            missing += usize::from(in_f32 && !found.contains(&(index as u32)));
        }
    }
    missing
}

#[test]
fn no_light_within_reach_is_missing() {
    for emissions in emissions() {
        let world = cloud(&Cloud { lights: 60, emissions, ..Cloud::default() }).world;
        for settings in settings() {
            assert_eq!(
                missing(&world, &world, &world.frames[0], &settings, |_| ()),
                0,
                "{settings:?}"
            );
        }
    }
}

#[test]
fn cones_shorten_lists_and_narrower_ones_miss_lights() {
    let world = cloud(&Cloud { lights: 200, emissions: vec![WINDOW], ..Cloud::default() }).world;
    let with = |emission: Emission| {
        let lights = world.lights.iter().map(|light| Light { emission, ..*light }).collect();
        World { lights, ..world.clone() }
    };
    let (frame, settings) = (&world.frames[0], Clustered { cutoff: 1e-2, ..SETTINGS });
    let entries = |world: &World| {
        let grid = Grid::of(frame, &settings).unwrap();
        lists(world, &cells(&grid, frame), settings.cutoff).lights.len()
    };
    let all_sides = with(Emission::Omni);
    // A cone of 45 degrees to each side is 0.15 of all directions; boxes are not points.
    assert!(2 * entries(&world) < entries(&all_sides), "{}", entries(&all_sides));
    assert_eq!(missing(&world, &all_sides, frame, &settings, |_| ()), 0);
    let narrower = with(Emission::Spot { half_angle_rad: 0.7 });
    assert!(missing(&world, &narrower, frame, &settings, |_| ()) > 10);
}

#[test]
fn cells_drawn_in_miss_lights() {
    let emissions = vec![Emission::Omni];
    let world = cloud(&Cloud { lights: 100, emissions, ..Cloud::default() }).world;
    let settings = Clustered { cutoff: 0.1, ..SETTINGS };
    let near_end_only = |cell: &mut Cell| {
        // Depth runs along -z: as if points lay no deeper than their cell's middle.
        cell.min.z = 0.5 * (cell.min.z + cell.max.z);
    };
    assert!(missing(&world, &world, &world.frames[0], &settings, near_end_only) > 10);
    let shrunk = |cell: &mut Cell| {
        let middle = 0.5 * (cell.min + cell.max);
        cell.min = cell.min.lerp(middle, 0.1);
        cell.max = cell.max.lerp(middle, 0.1);
    };
    assert!(missing(&world, &world, &world.frames[0], &settings, shrunk) > 0);
    // A reach taken without 1 / π is too long for a cutoff, and harmless; with π twice too short.
    let light = world.lights[0];
    let at_reach = Light { position: DVec3::Y * reach_m(&light, 0.1), ..light };
    let white = Point { normal: Vec3::Y, albedo: Vec3::ONE, ..Point::default() };
    let given = radiance(&white, &at_reach, 0.1).max_element();
    assert!((given / 0.1 - 1.0).abs() < 1e-12, "{given}");
}

#[test]
fn images_are_brute_force_over_lights_cut_at_their_reach() {
    for emissions in emissions() {
        let world = cloud(&Cloud { lights: 50, emissions, frames: 2, ..Cloud::default() }).world;
        for settings in settings() {
            let technique = Technique::Clustered(settings);
            for frame in 0..2 {
                let expected = sums(&world, frame, |p| cut_sum(&world, p, &settings));
                let found = image(Form::Reference, &technique, &world, frame);
                assert_eq!(found, expected, "{settings:?}");
                // At a light's very reach f32 may decide the other way, about the cutoff.
                let lost = at_reach(&settings);
                let f32s = image(Form::Cpu, &technique, &world, frame);
                let away = close(&f32s, &expected, 2e-5, 1e-6);
                assert!(away.len() <= 1, "{settings:?}: {away:?}");
                assert!(close(&f32s, &expected, 2e-5, 1e-6 + lost).is_empty(), "{settings:?}");
            }
        }
    }
}

#[test]
fn fading_only_takes_and_cutting_only_takes() {
    let emissions = vec![Emission::Omni, WINDOW, Emission::Directional];
    let world = cloud(&Cloud { lights: 80, emissions, ..Cloud::default() }).world;
    let truth = sums(&world, 0, |p| world.truth(p));
    let mut last = f32::INFINITY;
    for cutoff in [1.0, 0.1, 1e-2, 1e-3, 1e-5, 1e-9] {
        let of = |window| {
            let technique = Technique::Clustered(Clustered { cutoff, window, ..SETTINGS });
            image(Form::Reference, &technique, &world, 0)
        };
        let (hard, faded) = (of(false), of(true));
        for ((faded, hard), truth) in faded.iter().zip(&hard).zip(&truth) {
            assert!(faded.cmple(*hard).all() && hard.cmple(*truth * 1.000001).all());
        }
        let error = hard.iter().zip(&truth).map(|(a, b)| (*b - *a).max_element());
        let error = error.fold(0.0, f32::max);
        // What is left out gives less than the cutoff each.
        assert!(error <= 80.0 * cutoff as f32 && error <= last, "{error} at {cutoff}");
        last = error;
        if cutoff == 1e-9 {
            assert!(close(&faded, &truth, 1e-5, 1e-6).is_empty());
        }
    }
    assert!(last == 0.0, "{last}");
}

#[test]
fn counters_count_lists_and_all_forms_agree() {
    let (made, _) = facade(&Facade { size: [40, 24], ..Facade::default() });
    let walls = cloud(&Cloud { lights: 300, ..Cloud::default() }).world;
    for world in [made.world, walls] {
        for settings in settings() {
            let frame = &world.frames[0];
            let grid = Grid::of(frame, &settings).unwrap();
            let lists = lists(&world, &cells(&grid, frame), settings.cutoff);
            let there = || (0..frame.points.len()).filter(|&i| frame.points[i].is_there());
            let looked: usize = there().map(|i| lists.of(grid.cell_of(frame, i)).len()).sum();
            let technique = Technique::Clustered(settings);
            let reference = work(Form::Reference, &technique, &world, 0);
            assert_eq!(reference.pixels, there().count() as u64);
            assert_eq!(reference.lights, looked as u64);
            assert_eq!(reference.entries, lists.lights.len() as u64);
            assert_eq!(work(Form::Cpu, &technique, &world, 0), reference, "{settings:?}");
        }
    }
}

#[test]
fn shadow_rays_are_cast_for_what_gives_light() {
    let made = cloud(&Cloud { lights: 40, emissions: vec![Emission::Omni], ..Cloud::default() });
    let open = made.world.clone();
    let world = made.with_shadows().unwrap();
    let technique = Technique::Clustered(Clustered { cutoff: 1e-9, ..SETTINGS });
    let truth = sums(&world, 0, |p| world.truth(p));
    let dark = image(Form::Reference, &technique, &world, 0);
    assert_eq!(dark, truth);
    assert!(close(&image(Form::Cpu, &technique, &world, 0), &truth, 2e-5, 1e-6).len() <= 2);
    assert_ne!(image(Form::Reference, &technique, &open, 0), dark);
    let counted = work(Form::Reference, &technique, &world, 0);
    assert!(counted.rays > 0 && counted.rays <= counted.lights);
    assert_eq!(work(Form::Reference, &technique, &open, 0).rays, 0);
}

#[test]
fn extremes_are_survived() {
    for (name, world) in extremes() {
        world.check().unwrap();
        for settings in settings() {
            let technique = Technique::Clustered(settings);
            for frame in 0..world.frames.len() {
                let expected = sums(&world, frame, |p| cut_sum(&world, p, &settings));
                assert_eq!(image(Form::Reference, &technique, &world, frame), expected, "{name}");
                let found = image(Form::Cpu, &technique, &world, frame);
                assert!(found.iter().all(|rgb| rgb.is_finite()), "{name}");
                let lost = at_reach(&settings);
                let away = close(&found, &expected, 1e-3, 1e-5 + lost);
                assert!(away.is_empty(), "{name} {settings:?}: {away:?}");
            }
        }
    }
}

#[test]
fn too_many_cells_are_refused_by_name() {
    let world = plane(vec![], 1.0, [64, 64]).world;
    let settings = Clustered { tile: 1, slices: 1 << 20, ..SETTINGS };
    let refused = Grid::of(&world.frames[0], &settings).unwrap_err().to_string();
    assert!(refused.contains("slices") && refused.contains("16777216"), "{refused}");
}

#[test]
fn slices_grow_by_a_constant_factor() {
    let eye = Eye {
        position: DVec3::ZERO,
        forward: DVec3::Z,
        right: DVec3::X,
        up: DVec3::Y,
        perspective: true,
    };
    let depths = [1.0, 1.9, 2.1, 3.9, 4.1, 7.9, 8.1, 16.0];
    let at = |z: f32| Point { position: Vec3::Z * z, normal: Vec3::Y, ..Point::default() };
    let points = depths.map(at).to_vec();
    let frame = Frame { width: 8, height: 1, eye, points };
    let settings = Clustered { slices: 4, ..SETTINGS };
    let of = |frame: &Frame| {
        let grid = Grid::of(frame, &settings).unwrap();
        depths.map(|z| grid.slice_of(frame, &at(z)))
    };
    assert_eq!(of(&frame), [0, 0, 1, 1, 2, 2, 3, 3]);
    let parallel = Frame { eye: Eye { perspective: false, ..eye }, ..frame.clone() };
    assert_eq!(of(&parallel), [0, 0, 0, 0, 0, 1, 1, 3]);
    let grid = Grid::of(&frame, &settings).unwrap();
    assert_eq!(grid.slice_of(&frame, &at(-5.0)), 0);
    assert_eq!(grid.slice_of(&frame, &at(1e6)), 3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nothing_is_missing_at_any_scale(
        lights in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, 0.0..4.0f64), 0..40),
        points in prop::collection::vec((-1.0..1.0f32, -1.0..1.0f32, -1.0..1.0f32), 24),
        exponent in -4i32..=6,
        cutoff in 1e-3..1.0f64,
        tile in 1u32..9,
        slices in 1u32..9,
    ) {
        let scale = 10.0_f64.powi(exponent);
        let light = |&(x, y, z, i): &(f64, f64, f64, f64)| Light {
            position: DVec3::new(x, y, z) * scale,
            axis: DVec3::Z,
            intensity: DVec3::splat(i * scale * scale),
            emission: Emission::Omni,
        };
        let point = |&(x, y, z): &(f32, f32, f32)| Point {
            position: Vec3::new(x, y, z) * scale as f32,
            normal: Vec3::Y,
            albedo: Vec3::ONE,
            ..Point::default()
        };
        let mut world = plane(lights.iter().map(light).collect(), scale, [6, 4]).world;
        world.frames[0].points = points.iter().map(point).collect();
        let settings = Clustered { cutoff, tile, slices, window: false };
        prop_assert_eq!(missing(&world, &world, &world.frames[0], &settings, |_| ()), 0);
    }
}
