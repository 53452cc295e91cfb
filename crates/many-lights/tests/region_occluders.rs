//! Occluders of cities: boxes that lie within what hides, in every turn and mode that claims so.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::region::{OccluderMode, Occluders, Solid, Turn};
use dapple_scene::city::{self, City, InnerKnobs, OrientedBox, inner_boxes};
use dapple_scene::{Aabb, generate};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

const SOUND: [OccluderMode; 2] = [OccluderMode::Leaf, OccluderMode::ContiguousMin];

fn generated(name: &str) -> City {
    city::generate(&generate::city_knobs(name).unwrap(), 1).unwrap()
}

/// A small generated city turned about its middle, each building moved by `apart_m` along its row times
/// its number.
fn askew(degrees: f64, apart_m: f64) -> City {
    let knobs = city::Knobs {
        blocks_x: 1,
        blocks_z: 1,
        shape: city::BlockShape::DoubleRow(8),
        ..city::Knobs::default()
    };
    let mut made = city::generate(&knobs, 3).unwrap();
    let axis = DVec2::from_angle(degrees.to_radians());
    for (number, b) in made.buildings.iter_mut().enumerate() {
        let moved = DVec2::new(apart_m * (number % 8) as f64, 0.0);
        b.footprint.outer.iter_mut().for_each(|p| *p = axis.rotate(*p + moved));
        b.inner = inner_boxes(&b.footprint, b.base_m, b.eaves_m, &InnerKnobs::default());
        assert_eq!(b.inner.len(), 1);
    }
    made
}

/// What a city's walls enclose, by looking at every building.
struct Enclosed<'a> {
    city: &'a City,
    lowest: f64,
}

impl<'a> Enclosed<'a> {
    fn of(city: &'a City) -> Self {
        let bases = city.buildings.iter().map(|b| b.base_m);
        Self { city, lowest: bases.fold(f64::INFINITY, f64::min) }
    }

    fn holds(&self, p: DVec3) -> bool {
        let plan = DVec2::new(p.x, p.z);
        self.city
            .buildings
            .iter()
            .any(|b| b.base_m <= p.y && p.y <= b.eaves_m && b.footprint.contains(plan))
    }

    /// Points of the solids that lie in no building: random ones, and such near sides and corners.
    fn outside(&self, solids: &[Solid], turn: Turn, points: u32) -> u64 {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut outside = 0;
        for solid in solids {
            // Nothing is below the lowest base; a solid without a foot stands there.
            let foot = if solid.min.y.is_finite() { solid.min.y } else { self.lowest };
            assert!(foot >= self.lowest - 1e-9, "{solid:?}");
            let (low, high) = (solid.min.with_y(foot), solid.max);
            for _ in 0..points {
                // A nanometre inside at the ends: a point on a wall is on either side of it.
                let share = [(); 3].map(|()| (1.2 * rng.random::<f64>() - 0.1).clamp(0.0, 1.0));
                let kept = DVec3::splat(1e-9).min(0.5 * (high - low));
                let p = low + kept + DVec3::from(share) * (high - low - 2.0 * kept);
                outside += u64::from(!self.holds(turn.from(p)));
            }
        }
        outside
    }
}

/// Pairs that share a side, exactly, along more than a point.
fn touching(solids: &[Solid]) -> usize {
    let side = |s: &Solid, axis: usize| [s.min[axis], s.max[axis]];
    let touch = |a: &Solid, b: &Solid| {
        [0, 2].into_iter().any(|axis| {
            let ([a0, a1], [b0, b1]) = (side(a, axis), side(b, axis));
            let ([c0, c1], [d0, d1]) = (side(a, 2 - axis), side(b, 2 - axis));
            (a1 == b0 || b1 == a0) && c0.max(d0) < c1.min(d1)
        })
    };
    let pairs = (0..solids.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| touch(&solids[i], &solids[j])).count()
}

/// Pairs of buildings with the same wall from both sides.
fn sharing(city: &City) -> usize {
    let key = |a: DVec2, b: DVec2| [a.x, a.y, b.x, b.y].map(f64::to_bits);
    let edges = |i: usize| city.buildings[i].footprint.edges();
    let walls: Vec<BTreeSet<_>> =
        (0..city.buildings.len()).map(|i| edges(i).map(|[a, b]| key(a, b)).collect()).collect();
    let share = |i: usize, j: usize| edges(i).any(|[a, b]| walls[j].contains(&key(b, a)));
    let pairs = (0..walls.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| share(i, j)).count()
}

#[test]
fn generated_buildings_stand_for_themselves_and_neighbours_touch() {
    let city = generated("city_small");
    // An origin whose subtraction rounds.
    for origin in [DVec3::ZERO, DVec3::new(0.1, 0.3, -7.7)] {
        let turned = Occluders::of_city(&city, origin).turned(Turn::NONE, OccluderMode::Leaf);
        assert_eq!((turned.solids.len(), turned.lost), (city.buildings.len(), 0.0));
        for (solid, building) in turned.solids.iter().zip(&city.buildings) {
            let Aabb { min, max } = building.outer;
            assert_eq!(solid.min, (min - origin).with_y(f64::NEG_INFINITY));
            assert_eq!(solid.max, max - origin);
        }
        assert_eq!((touching(&turned.solids), sharing(&city)), (168, 168));
    }
}

/// Of each building the longest gap-free stretch of its row that is at least as high, without looking at
/// the boxes of occluders.
fn stretches(city: &City) -> BTreeSet<[u64; 5]> {
    let mut found = BTreeSet::new();
    let boxes: Vec<Aabb> = city.buildings.iter().map(|b| b.outer).collect();
    for b in &boxes {
        let (mut min, mut max) = (b.min, b.max);
        while let Some(next) = boxes.iter().find(|n| {
            let row = n.min.z == b.min.z && n.max.z == b.max.z && n.max.y >= b.max.y;
            row && (n.min.x == max.x || n.max.x == min.x)
        }) {
            (min.x, max.x) = (min.x.min(next.min.x), max.x.max(next.max.x));
        }
        (min, max) = (min.with_y(0.0), max);
        if max.x - min.x > b.max.x - b.min.x {
            found.insert([min.x, max.x, min.z, max.z, max.y].map(f64::to_bits));
        }
    }
    found
}

#[test]
fn runs_are_the_longest_stretches_of_each_height() {
    let city = generated("city_small");
    let turned =
        Occluders::of_city(&city, DVec3::ZERO).turned(Turn::NONE, OccluderMode::ContiguousMin);
    let (members, runs) = turned.solids.split_at(city.buildings.len());
    let leaf = Occluders::of_city(&city, DVec3::ZERO).turned(Turn::NONE, OccluderMode::Leaf);
    assert_eq!(members, leaf.solids);
    let bits = |s: &Solid| [s.min.x, s.max.x, s.min.z, s.max.z, s.max.y].map(f64::to_bits);
    let found: BTreeSet<_> = runs.iter().map(bits).collect();
    assert_eq!(found.len(), runs.len());
    assert_eq!(found, stretches(&city));
    assert!(runs.len() > 40, "{}", runs.len());
    assert_eq!(Enclosed::of(&city).outside(&turned.solids, Turn::NONE, 64), 0);
}

#[test]
fn boxes_of_a_city_askew_lie_within_and_neighbours_touch() {
    for (degrees, turn) in [(0.3, 0), (12.3, 12), (12.3, 13), (61.0, 61), (88.6, 88), (30.0, 0)] {
        let city = askew(degrees, 0.0);
        let enclosed = Enclosed::of(&city);
        let occluders = Occluders::of_city(&city, DVec3::ZERO);
        let turn = Turn::degrees(turn);
        for mode in SOUND {
            let turned = occluders.turned(turn, mode);
            assert!(turned.solids.len() >= 16);
            assert_eq!(enclosed.outside(&turned.solids, turn, 256), 0, "{degrees} {mode:?}");
        }
        // Nearly parallel to the turn, all neighbours touch again.
        let leaf = occluders.turned(turn, OccluderMode::Leaf);
        let askew = (degrees - turn.axis().to_angle().to_degrees()).abs();
        assert_eq!(sharing(&city), 14);
        if askew < 0.5 {
            assert_eq!(touching(&leaf.solids), 14, "{degrees}");
            assert!(leaf.lost < 0.02, "{}", leaf.lost);
        }
        // A run along the lowest of a row is as long as the row, less what the ends are askew by.
        let runs = occluders.turned(turn, OccluderMode::ContiguousMin);
        let longest = runs.solids.iter().map(|s| (s.max - s.min).with_y(0.0).max_element());
        assert!(askew > 1.0 || longest.fold(0.0, f64::max) > 79.0, "{degrees}");
    }
}

#[test]
fn cracks_are_neither_closed_nor_bridged() {
    for apart_m in [1e-9, 0.02, 0.5] {
        let city = askew(12.3, apart_m);
        let turn = Turn::degrees(12);
        let occluders = Occluders::of_city(&city, DVec3::ZERO);
        let leaf = occluders.turned(turn, OccluderMode::Leaf);
        let runs = occluders.turned(turn, OccluderMode::ContiguousMin);
        assert_eq!((sharing(&city), touching(&leaf.solids)), (0, 0), "{apart_m}");
        assert_eq!(runs.solids, leaf.solids);
    }
}

#[test]
fn boxes_around_clusters_do_not_lie_within() {
    let city = generated("city_small");
    let occluders = Occluders::of_city(&city, DVec3::ZERO);
    let clusters = occluders.turned(Turn::NONE, OccluderMode::BoundingBoxes);
    assert!(clusters.solids.len() < city.buildings.len() / 3, "{}", clusters.solids.len());
    let enclosed = Enclosed::of(&city);
    let outside = enclosed.outside(&clusters.solids, Turn::NONE, 256);
    let share = outside as f64 / (256 * clusters.solids.len()) as f64;
    assert!(share > 0.2, "{share}");
    // Every building lies in one of them.
    for b in &city.buildings {
        let around = |s: &Solid| s.min.cmple(b.outer.min).all() && s.max.cmpge(b.outer.max).all();
        assert!(clusters.solids.iter().any(around), "{}", b.id);
    }
}

#[test]
fn all_objects_are_buildings_and_storeys() {
    let city = generated("city_small");
    let buildings = Occluders::of_city(&city, DVec3::ZERO).turned(Turn::NONE, OccluderMode::Leaf);
    let objects = Occluders::of_objects(&city, DVec3::ZERO).turned(Turn::NONE, OccluderMode::Leaf);
    let storeys: u32 = city.buildings.iter().map(|b| 4 * b.storeys).sum();
    assert_eq!(objects.solids.len(), city.buildings.len() + storeys as usize);
    let (first, walls) = objects.solids.split_at(city.buildings.len());
    assert_eq!(first, buildings.solids);
    assert_eq!(objects.lost, 0.0);
    for wall in walls {
        let sides = wall.max - wall.min;
        assert!(sides.x == 0.0 || sides.z == 0.0);
        let on = |s: &&Solid| s.min.cmple(wall.min).all() && s.max.cmpge(wall.max).all();
        assert!(first.iter().any(|s| on(&s)), "{wall:?}");
    }
    // Storeys that stand on the ground, and those on others.
    let grounded = walls.iter().filter(|w| w.min.y == f64::NEG_INFINITY).count();
    assert_eq!(grounded, 4 * city.buildings.len());
}

#[test]
fn what_stands_above_the_lowest_point_has_a_foot() {
    let mut city = askew(0.0, 0.0);
    city.buildings[3].base_m = 1.5;
    let turned =
        Occluders::of_city(&city, DVec3::new(0.0, 1.0, 0.0)).turned(Turn::NONE, OccluderMode::Leaf);
    let feet: Vec<f64> = turned.solids.iter().map(|s| s.min.y).filter(|y| y.is_finite()).collect();
    assert_eq!(feet, [0.5]);
    // A light below all of them could be seen from below.
    city.lights[0].position.y = -0.5;
    let turned = Occluders::of_city(&city, DVec3::ZERO).turned(Turn::NONE, OccluderMode::Leaf);
    assert!(turned.solids.iter().all(|s| s.min.y.is_finite()));
}

#[test]
fn a_turn_is_made_once_and_the_same_by_any_thread() {
    let city = generated("city_small");
    let occluders = Occluders::of_city(&city, DVec3::ZERO);
    let turns = [0, 17, 45, 80].map(Turn::degrees);
    let ask = || turns.map(|turn| SOUND.map(|mode| occluders.turned(turn, mode)));
    let answers: Vec<_> = std::thread::scope(|scope| {
        let asked: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
        asked.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let before = occluders.bytes();
    for (turned, first) in answers.iter().flatten().zip(answers[0].iter().cycle()) {
        assert!(turned.iter().zip(first).all(|(a, b)| Arc::ptr_eq(a, b)));
    }
    let anew = Occluders::of_city(&city, DVec3::ZERO);
    assert!(anew.bytes() < before);
    for (turn, made) in turns.iter().zip(&answers[0]) {
        for (mode, made) in SOUND.iter().zip(made) {
            assert_eq!(*anew.turned(*turn, *mode), **made);
        }
    }
    assert_eq!(anew.bytes(), before);
}

#[test]
fn boxes_without_size_and_far_away_are_taken_and_others_left_out() {
    let of = |centre: DVec3, half: DVec3| OrientedBox { centre, axis: DVec2::X, half };
    let nan = DVec3::new(f64::NAN, 0.0, 0.0);
    let boxes = vec![
        of(nan, DVec3::ONE),
        of(DVec3::ZERO, DVec3::new(1.0, -1.0, 1.0)),
        of(DVec3::ZERO, DVec3::INFINITY),
        of(DVec3::ZERO, DVec3::ZERO),
        of(DVec3::splat(1e6), DVec3::splat(1e-4)),
        of(DVec3::splat(-1e6), DVec3::splat(1e6)),
        OrientedBox { axis: DVec2::NAN, ..of(DVec3::ZERO, DVec3::ONE) },
    ];
    let occluders = Occluders::of_boxes(boxes);
    assert_eq!(occluders.count(), 3);
    for degrees in 0..90 {
        for mode in [SOUND[0], SOUND[1], OccluderMode::BoundingBoxes] {
            let turned = occluders.turned(Turn::degrees(degrees), mode);
            assert!((0.0..=1.0).contains(&turned.lost), "{}", turned.lost);
            assert!(turned.solids.iter().all(|s| s.min.cmple(s.max).all()));
            assert!(degrees > 0 || mode == OccluderMode::BoundingBoxes || turned.solids.len() == 3);
        }
    }
    let none = Occluders::none();
    assert_eq!(*none.turned(Turn::degrees(5), SOUND[1]), Default::default());
}

#[test]
fn boxes_of_real_cities_lie_within_if_they_are_there() {
    let Some(root) = std::env::var_os("DAPPLE_DATA").map(PathBuf::from) else {
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "skipped: real cities: DAPPLE_DATA is not set");
        return;
    };
    // The main turn, how many pairs touch at least, and what the turn may cost.
    for (file, degrees, least, most_lost) in
        [("Helsinki.osm.pbf", 87, 500, 0.25), ("delft.city.json", 54, 100, 0.2)]
    {
        let city = city::load(&root.join("city").join(file)).unwrap().city;
        let enclosed = Enclosed::of(&city);
        let occluders = Occluders::of_city(&city, DVec3::ZERO);
        let leaf = occluders.turned(Turn::degrees(degrees), OccluderMode::Leaf);
        assert!(touching(&leaf.solids) >= least, "{file}: {}", touching(&leaf.solids));
        assert!(leaf.lost < most_lost, "{file}: {}", leaf.lost);
        for degrees in [degrees, 0, 31] {
            let turn = Turn::degrees(degrees);
            for mode in SOUND {
                let turned = occluders.turned(turn, mode);
                assert_eq!(enclosed.outside(&turned.solids, turn, 16), 0, "{file} {mode:?}");
            }
        }
    }
}
