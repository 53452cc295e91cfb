//! The cap: the strongest lights of each tile, exactly, and what leaving out the others costs.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod lists_support;

use dapple_many_lights::{
    BoundForm, Capped, Emission, Form, Frame, LightTree, Point, Technique, World,
    bound::{Region, packed, region},
    capped::{Choice, FAN, Groups, strongest, strongest_of_all},
    cut::tile::{pixels, tiles},
    make, radiance,
    worlds::{Cloud, Facade, cloud, emissions, facade},
};
use glam::Vec3;
use lists_support::{close, extremes, image, sums, work};
use std::sync::Arc;

fn capped(most: u32) -> Technique {
    Technique::Capped(Capped { most })
}

/// The points of each tile of a frame that shows anything.
fn shown(frame: &Frame) -> Vec<Vec<Point>> {
    let (columns, rows) = tiles(frame.width, frame.height);
    let of = |column, row| {
        let points = pixels(frame.width, frame.height, column, row).map(|i| frame.points[i]);
        points.filter(Point::is_there).collect::<Vec<_>>()
    };
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| of(column, row)));
    all.filter(|points| !points.is_empty()).collect()
}

/// Tiles where other lights are found than by a look at all of them, in f32.
fn differing(world: &World, tree: &LightTree, groups: &Groups, most: usize) -> (usize, usize) {
    let (packed_tree, clamp) = (tree.pack(), packed::clamp_squared(world.clamp_m));
    let (mut choice, mut differing, mut checked) = (Choice::default(), 0, 0);
    for points in shown(&world.frames[0]) {
        let over = packed::PackedRegion::of(points.iter()).unwrap();
        strongest(groups, &over, most, clamp, &mut choice);
        let leaves = tree.leaves.iter().map(|&leaf| &packed_tree.nodes[leaf as usize]);
        let bounds = leaves.map(|leaf| packed::region(BoundForm::Walter, leaf, &over, clamp));
        let mut all: Vec<_> = bounds.zip(0_u32..).filter(|(bound, _)| *bound > 0.0).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let ended = all.len() > most;
        all.truncate(most);
        let mut expected: Vec<_> = all.into_iter().map(|(_, light)| light).collect();
        expected.sort_unstable();
        differing += usize::from(expected != choice.lights);
        assert!(choice.ended || !ended);
        checked += 1;
    }
    (differing, checked)
}

#[test]
fn the_strongest_are_found_whatever_is_left_out_early() {
    for emissions in emissions() {
        let world = cloud(&Cloud { lights: 2000, emissions, ..Cloud::default() }).world;
        let tree = LightTree::median(&world.lights).unwrap();
        let groups = Groups::new(&tree.pack());
        for most in [1, 7, 64, 500, 2000] {
            let (differing, checked) = differing(&world, &tree, &groups, most);
            assert!(differing == 0 && checked > 10, "{differing} of {checked} at {most}");
        }
        // Groups whose boxes hold too little are found out.
        let mut wrong = groups.clone();
        wrong.min[1].iter_mut().for_each(|low| *low += 300.0);
        wrong.max[1].iter_mut().for_each(|high| *high += 300.0);
        if world.lights.iter().any(|light| light.emission != Emission::Directional) {
            assert!(differing(&world, &tree, &wrong, 20).0 > 0);
        }
    }
}

#[test]
fn groups_are_bounded_no_lower_than_their_lights() {
    let mut worlds = extremes();
    for emissions in emissions() {
        let cloud = Cloud { lights: 700, emissions, seed: 9, ..Cloud::default() };
        worlds.push(("cloud", dapple_many_lights::worlds::cloud(&cloud).world));
    }
    let mut compared = 0;
    for (name, world) in worlds {
        let clamp = packed::clamp_squared(world.clamp_m);
        let groups = Groups::new(&LightTree::median(&world.lights).unwrap().pack());
        let mut bounds = Vec::new();
        let tiles = world.frames.iter().flat_map(shown);
        for points in tiles.flat_map(|tile| [tile[..1].to_vec(), tile]) {
            let over = packed::PackedRegion::of(points.iter()).unwrap();
            groups.bound(&over, clamp, &mut bounds);
            for (group, &bound) in (0..).zip(&bounds) {
                let mut lanes = [0.0; FAN];
                groups.bound_lights(group, &over, clamp, &mut lanes);
                for (light, lane) in groups.of(group).iter().zip(lanes) {
                    let own = packed::region(BoundForm::Walter, light, &over, clamp);
                    assert_eq!(own, lane, "{name}: {light:?} in {over:?}");
                    assert!(own <= bound, "{name}: {light:?} in {over:?}: {own} over {bound}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}

#[test]
fn far_fewer_bounds_than_lights_are_looked_at() {
    let world = cloud(&Cloud { lights: 20_000, ..Cloud::default() }).world;
    let tree = LightTree::median(&world.lights).unwrap();
    let technique = capped(64);
    let (world, tree) = (Arc::new(world), Arc::new(tree));
    let mut cpu = make(Form::Cpu, &technique, &world, &tree, None).unwrap();
    cpu.shade(0, true).unwrap();
    let mut shaded = dapple_many_lights::Shaded::default();
    cpu.read(&mut shaded).unwrap();
    let tiles = shown(&world.frames[0]).len() as u64;
    assert_eq!(shaded.work.entries, 64 * tiles);
    assert_eq!(shaded.work.ended, tiles);
    assert!(shaded.work.bounds < tiles * 20_000 / 5, "{} bounds", shaded.work.bounds);
}

#[test]
fn a_cap_over_all_lights_is_brute_force() {
    for emissions in emissions() {
        let world = cloud(&Cloud { lights: 50, emissions, frames: 2, ..Cloud::default() }).world;
        for (frame, most) in [(0, 50), (1, u32::MAX)] {
            let truth = sums(&world, frame, |p| world.truth(p));
            // Bounds of 0 leave out what gives nothing: the same sums, in the same order.
            assert_eq!(image(Form::Reference, &capped(most), &world, frame), truth);
            let away = close(&image(Form::Cpu, &capped(most), &world, frame), &truth, 2e-5, 1e-6);
            assert!(away.is_empty(), "{away:?}");
            assert_eq!(work(Form::Reference, &capped(most), &world, frame).ended, 0);
        }
    }
}

#[test]
fn images_are_sums_over_the_chosen_and_error_falls_with_the_cap() {
    let emissions = vec![Emission::Omni];
    let world = cloud(&Cloud { lights: 400, emissions, ..Cloud::default() }).world;
    let truth = sums(&world, 0, |p| world.truth(p));
    let mut last = f32::INFINITY;
    for most in [1, 4, 16, 64, 256, 400] {
        let found = image(Form::Reference, &capped(most), &world, 0);
        let error = found.iter().zip(&truth).map(|(a, b)| (*b - *a).max_element());
        let error = error.fold(0.0, f32::max);
        assert!(error <= last && (error < last || error == 0.0), "{error} at {most}");
        assert!(found.iter().zip(&truth).all(|(a, b)| a.cmple(*b * 1.000001).all()));
        // Where f64 and f32 choose alike, they give alike; ties near the cap are few.
        let away = close(&image(Form::Cpu, &capped(most), &world, 0), &found, 2e-5, 1e-6);
        assert!(away.len() <= 64, "{} pixels at {most}", away.len());
        last = error;
    }
    assert_eq!(last, 0.0);
}

/// Row 46.
#[test]
fn error_grows_with_lights_beyond_the_cap() {
    let mut last = 0.0;
    for lights in [32, 64, 256, 1024, 4096] {
        let emissions = vec![Emission::Omni];
        let world = cloud(&Cloud { lights, emissions, ..Cloud::default() }).world;
        let found = image(Form::Cpu, &capped(32), &world, 0);
        let truth = sums(&world, 0, |p| world.truth(p));
        let lost: f32 = truth.iter().zip(&found).map(|(b, a)| (*b - *a).element_sum()).sum();
        let share = lost / truth.iter().map(|b| b.element_sum()).sum::<f32>();
        if lights == 32 {
            assert!(share.abs() < 1e-5, "{share}");
        } else {
            assert!(share > last + 0.02, "{share} of the light is lost at {lights}, {last} before");
        }
        last = share;
    }
    assert!(last > 0.5, "{last}");
}

#[test]
fn f64_chooses_by_bounds_over_the_tile_and_counts_what_it_does() {
    let (made, _) = facade(&Facade { size: [20, 13], ..Facade::default() });
    let world = made.world;
    let tree = LightTree::median(&world.lights).unwrap();
    let over = Region::of(world.frames[0].points.iter()).unwrap();
    let bound = |light: u32| {
        let leaf = &tree.nodes[tree.leaves[light as usize] as usize];
        region(BoundForm::Walter, leaf, &over, world.clamp_m)
    };
    let (chosen, ended) = strongest_of_all(&tree, &over, 10, world.clamp_m);
    assert!(ended && chosen.len() == 10);
    let least = chosen.iter().map(|&light| bound(light)).fold(f64::INFINITY, f64::min);
    let others = (0..world.lights.len() as u32).filter(|light| !chosen.contains(light));
    assert!(others.map(bound).all(|other| other <= least));

    let counted = work(Form::Reference, &capped(10), &world, 0);
    let tiles = shown(&world.frames[0]);
    assert_eq!(counted.pixels, 20 * 13);
    assert_eq!(counted.bounds, (tiles.len() * world.lights.len()) as u64);
    assert_eq!((counted.entries, counted.ended), (10 * tiles.len() as u64, tiles.len() as u64));
    assert_eq!(counted.lights, 10 * 20 * 13);
    let in_f32 = work(Form::Cpu, &capped(10), &world, 0);
    assert_eq!((in_f32.pixels, in_f32.entries), (counted.pixels, counted.entries));
    assert_eq!((in_f32.lights, in_f32.ended), (counted.lights, counted.ended));
    assert!(in_f32.bounds < counted.bounds * 2);
}

#[test]
fn shadows_are_traced_to_the_chosen() {
    let made = cloud(&Cloud { lights: 40, emissions: vec![Emission::Omni], ..Cloud::default() });
    let world = made.with_shadows().unwrap();
    let truth = sums(&world, 0, |p| world.truth(p));
    assert_eq!(image(Form::Reference, &capped(40), &world, 0), truth);
    assert!(close(&image(Form::Cpu, &capped(40), &world, 0), &truth, 2e-5, 1e-6).len() <= 2);
    let counted = work(Form::Cpu, &capped(5), &world, 0);
    assert!(counted.rays > 0 && counted.rays <= counted.lights);
}

#[test]
fn extremes_are_survived() {
    for (name, world) in extremes() {
        for most in [1, 2, 1000] {
            for frame in 0..world.frames.len() {
                let found = image(Form::Reference, &capped(most), &world, frame);
                let truth = sums(&world, frame, |p| world.truth(p));
                if most == 1000 {
                    assert_eq!(found, truth, "{name}");
                }
                let in_f32 = image(Form::Cpu, &capped(most), &world, frame);
                assert!(in_f32.iter().all(|rgb| rgb.is_finite()), "{name}");
                if most == 1000 || world.lights.len() < 3 {
                    let away = close(&in_f32, &found, 1e-3, 1e-5);
                    assert!(away.is_empty(), "{name} at {most}: {away:?}");
                }
            }
        }
    }
}

#[test]
fn equally_strong_lights_are_taken_by_lowest_index() {
    let (_, world) = extremes().into_iter().find(|(name, _)| *name == "in one place").unwrap();
    let tree = LightTree::median(&world.lights).unwrap();
    let points = &world.frames[0].points;
    let over = Region::of(points.iter()).unwrap();
    assert_eq!(strongest_of_all(&tree, &over, 3, world.clamp_m).0, [0, 1, 2]);
    let over = packed::PackedRegion::of(points.iter()).unwrap();
    let (groups, mut choice) = (Groups::new(&tree.pack()), Choice::default());
    strongest(&groups, &over, 3, packed::clamp_squared(world.clamp_m), &mut choice);
    assert_eq!(choice.lights, [0, 1, 2]);
    let found = image(Form::Cpu, &capped(3), &world, 0);
    let three = |p: &Point| radiance(p, &world.lights[0], world.clamp_m) * 3.0;
    assert!(close(&found, &sums(&world, 0, three), 2e-5, 1e-6).is_empty());
    assert!(found.iter().all(|rgb| *rgb != Vec3::ZERO));
}

#[test]
fn a_tree_of_other_lights_is_refused_by_name() {
    let world = Arc::new(cloud(&Cloud::default()).world);
    let tree = Arc::new(LightTree::median(&world.lights[1..]).unwrap());
    for form in [Form::Reference, Form::Cpu] {
        let refused = make(form, &capped(5), &world, &tree, None).err().unwrap().to_string();
        assert!(refused.contains("light tree") && refused.contains("99"), "{refused}");
    }
}
