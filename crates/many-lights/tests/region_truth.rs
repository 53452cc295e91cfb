//! What is called seen is seen, and nothing that is easily seen is overlooked.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_rivals_support;

use dapple_many_lights::region::truth::{
    Agreement, Gap, Obstacles, Sight, false_culls, gaps, kept, seen,
};
use dapple_many_lights::region::{Cuboid, Direction};
use dapple_many_lights::sample::Random;
use glam::DVec3;
use proptest::prelude::*;
use region_rivals_support::{
    Street, between, cell, lamp, rows, solids, street, upright, with_triangles,
};

fn boxes_only(street: &Street) -> Sight<'_> {
    let solids = solids(&street.boxes);
    Sight::new(&street.world, &street.cell, street.direction, &solids, Obstacles::Boxes).unwrap()
}

fn everything(street: &Street) -> Vec<u32> {
    (0..street.world.lights.len() as u32).collect()
}

/// Whether a segment passes through a box: it is cut down to what lies between each pair of sides.
fn crosses(mut from: DVec3, mut to: DVec3, min: DVec3, max: DVec3) -> bool {
    for axis in 0..3 {
        for (side, sign) in [(min[axis], 1.0), (max[axis], -1.0)] {
            let (a, b) = (sign * (from[axis] - side), sign * (to[axis] - side));
            if a < 0.0 && b < 0.0 {
                return false;
            }
            let mut on_side = from.lerp(to, a / (a - b));
            on_side[axis] = side;
            if a < 0.0 {
                from = on_side;
            } else if b < 0.0 {
                to = on_side;
            }
        }
    }
    true
}

#[test]
fn what_is_said_to_see_a_light_sees_it() {
    let street = rows(3, 0.0);
    let found = seen(&boxes_only(&street), &everything(&street), 20, 1);
    let sightings: Vec<_> = found.sightings.iter().flatten().collect();
    assert!(sightings.len() > 50 && sightings.len() < street.world.lights.len() - 50);
    for sighting in sightings.iter().step_by(3) {
        let light = street.world.lights[sighting.light as usize].position;
        for b in solids(&street.boxes) {
            assert!(!crosses(sighting.from, light, b.min, b.max), "{sighting:?} {b:?}");
        }
    }
}

#[test]
fn a_search_by_gaps_finds_all_that_many_more_random_points_find() {
    for (seed, depth_m) in [(1, 0.0), (2, 0.0), (3, 4.0), (4, 4.0)] {
        let street = rows(seed, depth_m);
        let lights = everything(&street);
        let few = seen(&boxes_only(&street), &lights, 4, 1);
        let many = seen(&boxes_only(&street), &lights, 2_000, 9);
        assert!(many.rays > 5 * few.rays);
        let count =
            |f: &dapple_many_lights::region::truth::Seen| f.sightings.iter().flatten().count();
        let overlooked = count(&many) - count(&few);
        if depth_m == 0.0 {
            // Exact: the highest line of a face without depth sees whatever any point sees.
            assert_eq!(overlooked, 0, "seed {seed}");
        } else {
            assert!(overlooked * 100 <= lights.len(), "seed {seed}: {overlooked}");
        }
        assert!(count(&few) < lights.len(), "something is hidden");
    }
}

#[test]
fn a_light_through_a_crack_is_found_and_none_through_touching_walls() {
    let wall =
        |left: f64, right: f64| upright(DVec3::new(10.0, 0.0, left), DVec3::new(11.0, 30.0, right));
    let face = || cell(DVec3::new(0.0, 0.0, -5.0), DVec3::new(0.0, 3.0, 5.0), Direction::PlusX);
    let count = |crack: f64| {
        let boxes = vec![wall(-100.0, 0.0), wall(crack, 100.0)];
        let lights = vec![lamp(DVec3::new(40.0, 2.0, 0.5 * crack))];
        let street = street(lights, boxes, face(), Direction::PlusX);
        seen(&boxes_only(&street), &[0], 100, 1).sightings.iter().flatten().count()
    };
    assert_eq!(count(1e-6), 1);
    assert_eq!(count(0.0), 0);
}

#[test]
fn every_seen_light_left_out_is_a_false_cull_and_none_else() {
    let street = rows(7, 0.0);
    let sight = boxes_only(&street);
    let lights = everything(&street);
    let sightings = seen(&sight, &lights, 10, 1).sightings;
    let leaf = |l: &u32| street.tree.leaves[*l as usize];
    let mut honest: Vec<u32> =
        lights.iter().filter(|l| sightings[**l as usize].is_some()).map(leaf).collect();
    honest.sort_unstable();
    let honest_culls = false_culls(&sight, &street.tree, &honest, 0.0, (10, 77));
    assert_eq!(honest_culls.found, []);
    assert!(honest_culls.culled > 50 && honest_culls.rays > 500);
    // Each light that is left out besides is found out.
    let dropped: Vec<u32> = honest.iter().copied().step_by(7).collect();
    let faulty: Vec<u32> = honest.iter().copied().filter(|n| !dropped.contains(n)).collect();
    let found = false_culls(&sight, &street.tree, &faulty, 0.0, (10, 77)).found;
    let mut of: Vec<u32> = found.iter().map(|s| leaf(&s.light)).collect();
    of.sort_unstable();
    assert_eq!(of, dropped);
    // Not where they are too weak to count.
    assert_eq!(false_culls(&sight, &street.tree, &faulty, 1e6, (10, 77)).found, []);
    let agreement =
        Agreement::of(sightings.iter().map(Option::is_some).zip(kept(&street.tree, &faulty)));
    assert_eq!(agreement.seen_culled, dropped.len() as u64);
    assert_eq!(agreement.hidden_kept, 0);
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let street = rows(11, 2.0);
    let find = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| seen(&boxes_only(&street), &everything(&street), 8, 5))
    };
    let one = find(1);
    assert_eq!(one, find(3));
    assert!(one.sightings.iter().flatten().count() > 10);
}

#[test]
fn triangles_hide_what_the_boxes_they_stand_for_hide() {
    let street = rows(5, 0.0);
    let world = with_triangles(&street);
    let lights = everything(&street);
    let solids = solids(&street.boxes);
    let by_triangles = Obstacles::Triangles(&world);
    let sight = Sight::new(&world, &street.cell, street.direction, &solids, by_triangles).unwrap();
    let triangles = seen(&sight, &lights, 20, 1).sightings;
    let boxes = seen(&boxes_only(&street), &lights, 20, 1).sightings;
    let of = |found: &[Option<_>]| found.iter().map(Option::is_some).collect::<Vec<_>>();
    // Boxes are closed: at most a ray exactly along a wall is told otherwise.
    assert_eq!(of(&triangles), of(&boxes));
    // Without anything in the way, all that lies in front is seen.
    let open = Sight::new(
        &street.world,
        &street.cell,
        street.direction,
        &solids,
        Obstacles::Triangles(&street.world),
    );
    let open = seen(&open.unwrap(), &lights, 0, 1).sightings;
    assert!(open.iter().all(Option::is_some));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn the_segment_from_inside_a_gap_meets_nothing_and_from_beside_it_something(
        corners in prop::collection::vec(
            (prop::array::uniform3(-10.0_f64..10.0), prop::array::uniform3(0.0_f64..8.0), any::<bool>()),
            0..8,
        ),
        (w, h) in (0.0_f64..8.0, -5.0_f64..5.0),
        light in (-15.0_f64..15.0, 8.0_f64..20.0, -5.0_f64..15.0),
        seed in any::<u32>(),
    ) {
        let cuboid = |(c, s, sunk): &([f64; 3], [f64; 3], bool)| Cuboid {
            u: [c[0], c[0] + s[0]],
            w: [c[1], c[1] + s[1]],
            h: [if *sunk { f64::NEG_INFINITY } else { c[2] }, c[2] + s[2]],
        };
        let boxes: Vec<Cuboid> = corners.iter().map(cuboid).collect();
        let (mut hidden, mut found) = (vec![], vec![]);
        let line = [-12.0, 12.0];
        gaps(line, (w, h), [light.0, light.1, light.2], &boxes, &mut hidden, &mut found);
        let mut random = Random::new(seed, 0, 0);
        let to = DVec3::new(light.0, light.1, light.2);
        for _ in 0..20 {
            let u = between(&mut random, line[0], line[1]);
            let from = DVec3::new(u, w, h);
            let inside = found.iter().any(|Gap { from, to }| u > from + 1e-3 && u < to - 1e-3);
            let beside = found.iter().all(|Gap { from, to }| u < from - 1e-3 || u > to + 1e-3);
            let mut grazed = false;
            let blocked = boxes.iter().any(|b| {
                let min = DVec3::new(b.u[0], b.w[0], b.h[0]);
                let max = DVec3::new(b.u[1], b.w[1], b.h[1]);
                let near = crosses(from, to, min - 2e-3, max + 2e-3);
                grazed |= near;
                near && crosses(from, to, min, max)
            });
            if inside {
                prop_assert!(!blocked, "u = {}", u);
            }
            if beside {
                prop_assert!(grazed, "u = {}", u);
            }
        }
    }
}

/// The box of a turned face reaches beyond the box that its surfaces have along the axes: no light is
/// seen from there alone.
#[test]
fn nothing_is_seen_from_where_no_surface_can_be() {
    let light = lamp(DVec3::new(30.0, 1.0, 0.0));
    let face = cell(DVec3::ZERO, DVec3::new(0.0, 2.0, 10.0), Direction::PlusX);
    // Hidden from all but the last metre.
    let wall = upright(DVec3::new(1.0, -1.0, -20.0), DVec3::new(2.0, 50.0, 8.5));
    let mut street = street(vec![light], vec![wall], face, Direction::PlusX);
    let found = |street: &Street| seen(&boxes_only(street), &[0], 50, 1).sightings[0];
    assert!(found(&street).is_some_and(|sighting| sighting.from.z > 8.0));
    for face in street.cell.faces.iter_mut().flatten() {
        face.region.max.z = 8.0;
    }
    assert_eq!(found(&street), None);
}
