//! What from-region visibility is compared with: rays, and extended projections on a raster.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_rivals_support;

use dapple_many_lights::region::extended_projection::{ExtendedProjection, MOST_TEXELS};
use dapple_many_lights::region::sampled::Rays;
use dapple_many_lights::region::truth::{Agreement, Obstacles, Sight, false_culls, kept, seen};
use dapple_many_lights::region::{
    Direction, FacadeCluster, Occluders, Precuts, RegionTechnique, Sampled, make,
};
use dapple_many_lights::{Emission, Light, LightTree, worlds};
use glam::DVec3;
use region_rivals_support::{Street, cell, lamp, rows, solids, street, upright, with_triangles};
use std::sync::Arc;

fn precut(technique: &mut impl Precuts, street: &Street) -> Vec<u32> {
    let mut nodes = vec![7];
    technique.precut(&street.cell, street.direction, &mut nodes);
    nodes
}

fn raster(street: &Street, texels: u32) -> ExtendedProjection {
    let (tree, occluders) = (Arc::clone(&street.tree), Arc::clone(&street.occluders));
    ExtendedProjection::new(tree, occluders, 0.1, texels).unwrap()
}

fn rays(street: &Street, settings: Sampled) -> Rays {
    Rays::new(Arc::clone(&street.tree), Arc::new(with_triangles(street)), settings)
}

/// By boxes: the truth of the occluders themselves.
fn agreement(street: &Street, nodes: &[u32]) -> Agreement {
    let solids = solids(&street.boxes);
    let sight =
        Sight::new(&street.world, &street.cell, street.direction, &solids, Obstacles::Boxes);
    let sight = sight.unwrap();
    let lights: Vec<u32> = (0..street.world.lights.len() as u32).collect();
    let found = seen(&sight, &lights, 30, 4).sightings;
    Agreement::of(found.iter().map(Option::is_some).zip(kept(&street.tree, nodes)))
}

/// Increasing, and none inside another.
fn is_antichain(tree: &LightTree, nodes: &[u32]) -> bool {
    nodes.windows(2).all(|pair| pair[0] + tree.nodes[pair[0] as usize].size <= pair[1])
}

#[test]
fn a_raster_culls_nothing_that_is_seen_at_any_resolution() {
    let (mut rays, mut culled) = (0, 0);
    for (seed, depth_m) in [(1, 0.0), (2, 0.0), (3, 3.0), (4, 0.0), (5, 1.0)] {
        let street = rows(seed, depth_m);
        let solids = solids(&street.boxes);
        let sight =
            Sight::new(&street.world, &street.cell, street.direction, &solids, Obstacles::Boxes);
        let sight = sight.unwrap();
        for texels in [1, 2, 7, 32, 100, 256] {
            let mut technique = raster(&street, texels);
            let nodes = precut(&mut technique, &street);
            assert!(is_antichain(&street.tree, &nodes));
            let found = false_culls(&sight, &street.tree, &nodes, 0.0, (40, seed));
            assert_eq!(found.found, [], "seed {seed}, {texels} texels");
            (rays, culled) = (rays + found.rays, culled + found.culled);
            let steps = technique.steps();
            assert!(steps.is_consistent() && steps.evaluations == 1);
            assert_eq!(steps.output, nodes.len() as u64);
        }
    }
    assert!(rays > 100_000 && culled > 1_000, "{rays} rays, {culled} culled");
}

/// Negative control of the search and of the occluders it believes in.
#[test]
fn a_raster_of_houses_that_are_too_large_culls_what_is_seen() {
    let mut street = rows(2, 0.0);
    let grow = |b: &dapple_scene::city::OrientedBox| dapple_scene::city::OrientedBox {
        half: b.half + DVec3::new(0.0, 1.0, 1.0),
        ..*b
    };
    street.occluders = Arc::new(Occluders::of_boxes(street.boxes.iter().map(grow).collect()));
    let nodes = precut(&mut raster(&street, 256), &street);
    let solids = solids(&street.boxes);
    let sight =
        Sight::new(&street.world, &street.cell, street.direction, &solids, Obstacles::Boxes);
    let found = false_culls(&sight.unwrap(), &street.tree, &nodes, 0.0, (10, 1));
    assert!(found.found.len() >= 5, "{}", found.found.len());
}

#[test]
fn finer_texels_lose_less_and_come_close_to_what_is_hidden() {
    let tightness = [16, 64, 256, 1024].map(|texels| {
        let mut all = Agreement::default();
        for seed in 1..=4 {
            let street = rows(seed, 0.0);
            all += agreement(&street, &precut(&mut raster(&street, texels), &street));
        }
        assert_eq!(all.seen_culled, 0);
        assert!(all.hidden_culled + all.hidden_kept > 300);
        all.tightness()
    });
    eprintln!("tightness at 16, 64, 256, 1024 texels: {tightness:.3?}");
    assert!(tightness.is_sorted(), "{tightness:?}");
    assert!(tightness[0] < tightness[3] - 0.1, "{tightness:?}");
}

/// What is lost to resolution (H4.7): lights that shadows without texels hide, and the map does not.
#[test]
fn what_the_analytic_form_culls_and_the_raster_keeps_falls_with_the_size_of_texels() {
    let settings = FacadeCluster { threshold: 0.0, ..FacadeCluster::default() };
    let lost = [16, 64, 256, 1024].map(|texels| {
        let (mut lost, mut culled) = (0, 0);
        for seed in 1..=4 {
            let street = rows(seed, 0.0);
            let technique = RegionTechnique::FacadeCluster(settings);
            let world = Arc::new(street.world.clone());
            let made = make(&technique, false, &world, &street.tree, &street.occluders);
            let mut nodes = vec![];
            made.unwrap().precut(&street.cell, street.direction, &mut nodes);
            let analytic = kept(&street.tree, &nodes);
            let on_raster = kept(&street.tree, &precut(&mut raster(&street, texels), &street));
            culled += analytic.iter().filter(|kept| !**kept).count();
            lost += analytic.iter().zip(&on_raster).filter(|(a, r)| !**a && **r).count();
        }
        assert!(culled > 200);
        lost as f64 / culled as f64
    });
    eprintln!("culled without texels, kept with 16, 64, 256, 1024: {lost:.4?}");
    assert!(lost.is_sorted_by(|a, b| a > b) && lost[3] < 0.02, "{lost:?}");
}

#[test]
fn behind_houses_apart_the_raster_converges_to_the_exact_answer() {
    let house = upright(DVec3::new(10.0, 0.0, -15.0), DVec3::new(20.0, 15.0, 12.0));
    let tower = upright(DVec3::new(12.0, 0.0, 24.0), DVec3::new(17.0, 29.0, 37.0));
    let mut random = dapple_many_lights::sample::Random::new(1, 2, 3);
    let mut draw = |low, high| region_rivals_support::between(&mut random, low, high);
    let lights: Vec<_> = (0..3_000)
        .map(|_| lamp(DVec3::new(draw(21.0, 60.0), draw(0.5, 30.0), draw(-40.0, 40.0))))
        .collect();
    let face = cell(DVec3::new(0.0, 0.0, -5.0), DVec3::new(0.0, 6.0, 5.0), Direction::PlusX);
    let street = street(lights, vec![house, tower], face, Direction::PlusX);
    let missed = [16, 64, 256, 1024].map(|texels| {
        let found = agreement(&street, &precut(&mut raster(&street, texels), &street));
        assert_eq!(found.seen_culled, 0);
        found.false_visible()
    });
    eprintln!("share of the hidden kept at 16, 64, 256, 1024 texels: {missed:.4?}");
    assert!(missed[0] > missed[1] && missed[1] > missed[2] && missed[3] < 0.01, "{missed:?}");
}

#[test]
fn touching_houses_hide_together_and_houses_apart_do_not() {
    let lights = vec![lamp(DVec3::new(20.5, 2.0, 0.1)), lamp(DVec3::new(30.0, 4.0, 0.1))];
    for (gap, hidden) in [(0.0, true), (0.01, false)] {
        // No edge of the 100 texels lies where the houses meet.
        let house = |left: f64, right: f64| {
            upright(DVec3::new(10.0, 0.0, left), DVec3::new(20.0, 15.0, right))
        };
        let boxes = vec![house(-31.7, 0.0), house(gap, 28.3)];
        let face = cell(DVec3::new(0.0, 0.0, -5.0), DVec3::new(0.0, 6.0, 5.0), Direction::PlusX);
        let street = street(lights.clone(), boxes, face, Direction::PlusX);
        let nodes = precut(&mut raster(&street, 100), &street);
        assert_eq!(nodes.is_empty(), hidden, "gap {gap}: {nodes:?}");
    }
}

#[test]
fn a_raster_survives_the_extremes() {
    let house = upright(DVec3::new(10.0, 0.0, -15.0), DVec3::new(20.0, 15.0, 12.0));
    let point = DVec3::new(0.0, 3.0, 0.0);
    let no_lights =
        street(vec![], vec![house], cell(point, point, Direction::PlusX), Direction::PlusX);
    assert!(precut(&mut raster(&no_lights, 8), &no_lights).is_empty());
    let spot = |x: f64| lamp(DVec3::new(x, 3.0, 0.0));
    for scale in [1e-4, 1.0, 1e6] {
        let lights: Vec<_> = [30.0, 5.0, -5.0, 15.0, 10.0, 20.0]
            .map(|x: f64| lamp(DVec3::new(x, 3.0, 0.0) * scale))
            .to_vec();
        let flat =
            upright(DVec3::new(10.0, 0.0, -15.0) * scale, DVec3::new(10.0, 15.0, 12.0) * scale);
        let face = cell(point * scale, point * scale, Direction::PlusX);
        let street = street(lights, vec![flat], face, Direction::PlusX);
        let culled = kept(&street.tree, &precut(&mut raster(&street, 64), &street));
        // Behind the wall nothing is left; what lies on it ties and stays; what lies behind the cell
        // belongs to another direction.
        assert_eq!(culled, [false, true, false, false, true, false], "scale {scale}");
    }
    // A cell that touches, overlaps and lies within what would hide.
    for near in [0.0, -1.0] {
        let around = upright(DVec3::new(near, 0.0, -15.0), DVec3::new(20.0, 15.0, 12.0));
        let face = cell(point - DVec3::Z, point + DVec3::Z, Direction::PlusX);
        let street = street(vec![spot(30.0)], vec![around], face, Direction::PlusX);
        let nodes = precut(&mut raster(&street, 64), &street);
        assert!(nodes.len() <= 1);
    }
    let none =
        street(vec![spot(30.0)], vec![], cell(point, point, Direction::PlusX), Direction::PlusX);
    assert_eq!(precut(&mut raster(&none, 64), &none), [0]);
    let (tree, occluders) = (Arc::clone(&none.tree), Arc::clone(&none.occluders));
    for texels in [0, MOST_TEXELS + 1] {
        let made = ExtendedProjection::new(tree.clone(), occluders.clone(), 0.1, texels);
        assert!(made.err().unwrap().to_string().contains(&texels.to_string()));
    }
}

#[test]
fn parallel_light_always_stays() {
    let mut sun = lamp(DVec3::ZERO);
    sun.emission = Emission::Directional;
    let wall = upright(DVec3::new(10.0, 0.0, -1e3), DVec3::new(20.0, 1e3, 1e3));
    let face = cell(DVec3::ZERO, DVec3::new(0.0, 3.0, 3.0), Direction::PlusX);
    let street =
        street(vec![lamp(DVec3::new(30.0, 1.0, 1.0)), sun], vec![wall], face, Direction::PlusX);
    let sun_node = street.tree.leaves[1];
    assert_eq!(precut(&mut raster(&street, 64), &street), [sun_node]);
    assert_eq!(precut(&mut rays(&street, Sampled { rays: 4, seed: 1 }), &street), [sun_node]);
}

#[test]
fn more_rays_overlook_fewer_lights_and_never_invent_any() {
    let mut shares = vec![];
    for count in [1, 8, 64] {
        let mut all = Agreement::default();
        for seed in 1..=3 {
            let street = rows(seed, 0.0);
            let mut technique = rays(&street, Sampled { rays: count, seed });
            let nodes = precut(&mut technique, &street);
            assert!(is_antichain(&street.tree, &nodes));
            all += agreement(&street, &nodes);
            let lights = street.world.lights.len() as u64;
            let traced = technique.steps().rays;
            assert!(technique.steps().is_consistent());
            assert!(traced >= lights && traced <= lights * u64::from(count));
            // The same again, and other points of another seed.
            assert_eq!(precut(&mut technique, &street), nodes);
        }
        shares.push(all.false_hidden());
        assert_eq!(all.hidden_kept, 0, "what a ray reached is seen");
    }
    eprintln!("falsely hidden with 1, 8, 64 rays: {shares:.3?}");
    assert!(shares[0] > shares[1] && shares[1] > shares[2] && shares[2] > 0.0, "{shares:?}");
}

#[test]
fn no_ray_is_spent_on_a_light_that_shines_away() {
    let face = cell(DVec3::ZERO, DVec3::new(0.0, 3.0, 3.0), Direction::PlusX);
    let window =
        |axis: DVec3| Light { axis, emission: worlds::WINDOW, ..lamp(DVec3::new(30.0, 1.0, 1.0)) };
    let lights = vec![window(DVec3::NEG_X), window(DVec3::X)];
    let street = street(lights, vec![], face, Direction::PlusX);
    let mut technique = rays(&street, Sampled { rays: 5, seed: 1 });
    let nodes = precut(&mut technique, &street);
    assert_eq!(kept(&street.tree, &nodes), [true, false]);
    let steps = technique.steps();
    assert_eq!((steps.rays, steps.potential, steps.potential_culled, steps.last), (1, 2, 1, 1));
}

#[test]
fn the_precut_of_rays_is_the_smallest_that_holds_the_lights_seen() {
    let street = rows(2, 0.0);
    let nodes = precut(&mut rays(&street, Sampled { rays: 16, seed: 3 }), &street);
    let kept = kept(&street.tree, &nodes);
    let all_kept = |node: usize| {
        let below = &street.tree.nodes[node..node + street.tree.nodes[node].size as usize];
        below.iter().filter(|n| n.is_leaf()).all(|n| kept[n.light as usize])
    };
    // The largest nodes whose lights are all kept.
    let mut expected = vec![];
    let mut index = 0;
    while index < street.tree.nodes.len() {
        if all_kept(index) {
            expected.push(index as u32);
            index += street.tree.nodes[index].size as usize;
        } else {
            index += 1;
        }
    }
    assert_eq!(nodes, expected);
    assert!(nodes.len() < kept.iter().filter(|k| **k).count(), "some nodes are put out whole");
}
