//! Generated cities: repeatable, of the promised counts, and built as described.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::Scene;
use dapple_scene::city::{
    BlockShape, Building, City, GroundKind, Heights, Knobs, Part, Tree, generate, windows,
};
use dapple_scene::generate::city_of;
use glam::{DVec2, DVec3};

/// Lights a block of the thesis's cities: 39,202 / 36, 88,278 / 81, 245,106 / 225.
const THESIS_LIGHTS_PER_BLOCK: f64 = 1089.4;

fn blocks(n: u32) -> Knobs {
    Knobs { blocks_x: n, blocks_z: n, ..Knobs::default() }
}

fn of(knobs: &Knobs) -> City {
    generate(knobs, 11).unwrap()
}

/// Everything a city holds, by bits.
fn digest(city: &City) -> String {
    let data = format!("{:?}", (&city.buildings, &city.blocks, &city.lights, &city.trees));
    format!("{} {:?}", city.scene().scene.hash(), blake3::hash(data.as_bytes()))
}

/// Distance along a ray to the nearest building's box, in front of the origin.
fn hit(city: &City, origin: DVec3, direction: DVec3) -> Option<f64> {
    let slabs = |b: &Building| {
        let (to_min, to_max) =
            ((b.outer.min - origin) / direction, (b.outer.max - origin) / direction);
        let (near, far) = (to_min.min(to_max).max_element(), to_min.max(to_max).min_element());
        (near <= far && far >= 0.0).then_some(near.max(0.0))
    };
    city.buildings.iter().filter_map(slabs).min_by(f64::total_cmp)
}

fn camera<'a>(city: &'a City, name: &str) -> &'a dapple_scene::Camera {
    city.cameras.iter().find(|c| c.name == name).unwrap()
}

#[test]
fn a_seed_repeats_and_another_differs() {
    for name in ["city", "city_trees"] {
        let hash = |seed| digest(&city_of(name, seed).unwrap());
        assert_eq!(hash(1), hash(1));
        assert_ne!(hash(1), hash(2));
    }
    assert!(city_of("spheres", 1).is_none());
}

#[test]
fn lights_come_within_5_percent_of_the_thesis_and_grow_with_the_blocks() {
    let per_block = |n: u32| of(&blocks(n)).lights.len() as f64 / f64::from(n * n);
    let reference = per_block(6);
    assert!((reference / THESIS_LIGHTS_PER_BLOCK - 1.0).abs() < 0.05, "{reference}");
    for n in [3, 9, 15, 24] {
        let ratio = per_block(n) / reference;
        println!("{n} x {n}: {ratio}");
        assert!((ratio - 1.0).abs() < 0.01, "{n}: {ratio}");
    }
    let ring = of(&Knobs { shape: BlockShape::Ring(12), ..Knobs::default() });
    let per_block = ring.lights.len() as f64 / 36.0;
    assert!((per_block / THESIS_LIGHTS_PER_BLOCK - 1.0).abs() < 0.05, "{per_block}");
    assert_eq!(ring.buildings.len(), 36 * 44);
}

#[test]
fn height_laws_have_their_mean_and_variance() {
    let moments = |heights| {
        let city = of(&Knobs { heights, ..blocks(15) });
        let n = city.buildings.len() as f64;
        let mean = city.buildings.iter().map(|b| f64::from(b.storeys)).sum::<f64>() / n;
        let square = |b: &Building| (f64::from(b.storeys) - mean).powi(2);
        (mean, city.buildings.iter().map(square).sum::<f64>() / n)
    };
    assert_eq!(moments(Heights::Fixed(7)), (7.0, 0.0));
    for law in
        [Heights::Stratified { least: 1, most: 7 }, Heights::Independent { least: 1, most: 7 }]
    {
        let (mean, variance) = moments(law);
        println!("{law:?}: {mean} {variance}");
        assert!((mean - 4.0).abs() < 0.1 && (variance - 4.0).abs() < 0.1, "{mean} {variance}");
    }
    // Every block alike in the stratified law, not so in the independent.
    let spread = |heights| {
        let city = of(&Knobs { heights, ..Knobs::default() });
        let sum = |r: &std::ops::Range<u32>| {
            city.buildings[r.start as usize..r.end as usize].iter().map(|b| b.storeys).sum::<u32>()
        };
        let sums: Vec<u32> = city.blocks.iter().map(sum).collect();
        sums.iter().max().unwrap() - sums.iter().min().unwrap()
    };
    assert_eq!(spread(Heights::Stratified { least: 1, most: 7 }), 0);
    assert!(spread(Heights::Independent { least: 1, most: 7 }) > 10);
}

#[test]
fn as_many_lots_are_empty_as_asked_and_walls_beside_them_are_lit() {
    for share in [0.0, 0.1, 0.25, 0.5] {
        let city = of(&Knobs { empty_lots: share, ..Knobs::default() });
        let empty = 1.0 - city.buildings.len() as f64 / (36.0 * 44.0);
        assert!((empty - share).abs() < 0.5 / (36.0 * 44.0), "{share}: {empty}");
        // A party wall is shared: its ends are those of a neighbour's, the other way round.
        for range in &city.blocks {
            let block = &city.buildings[range.start as usize..range.end as usize];
            for facade in block.iter().flat_map(|b| &b.facades) {
                let back = |b: &Building| {
                    b.facades.iter().any(|f| f.from == facade.to && f.to == facade.from)
                };
                assert_eq!(facade.party, block.iter().any(back));
            }
        }
    }
}

#[test]
fn every_storey_is_eight_quads_and_every_part_belongs_where_it_says() {
    let city = of(&Knobs { empty_lots: 0.2, trees_per_block: 5, ..blocks(3) });
    let all = city.scene();
    all.scene.validate().unwrap();
    assert_eq!(all.parts.len(), all.scene.instances.len());
    let mut storeys = 0;
    for (instance, part) in all.scene.instances.iter().zip(&all.parts) {
        let mesh = &all.scene.meshes[instance.mesh as usize];
        match *part {
            Part::Storey { block, building, facade, storey } => {
                storeys += 1;
                assert_eq!((instance.mesh, mesh.triangles.len()), (0, 16));
                assert!(city.blocks[block as usize].contains(&building));
                let b = &city.buildings[building as usize];
                let f = &b.facades[facade as usize];
                let at =
                    |x: f64, y: f64| instance.transform.transform_point3(DVec3::new(x, y, 0.0));
                let y = 3.0 * f64::from(storey);
                assert_eq!(at(0.0, 0.0), DVec3::new(f.from.x, y, f.from.y));
                assert_eq!(at(10.0, 3.0), DVec3::new(f.to.x, y + 3.0, f.to.y));
                assert!(storey < b.storeys);
            }
            Part::Roof { block, building } => {
                assert!(city.blocks[block as usize].contains(&building));
                let b = &city.buildings[building as usize];
                assert_eq!(instance.transform.translation.y, b.eaves_m);
            }
            Part::Ground { ground } => {
                assert_eq!(mesh.triangles.len(), city.grounds[ground as usize].triangles.len());
            }
            Part::Tree { tree } => {
                let tree = &city.trees[tree as usize];
                assert_eq!(instance.transform.translation, tree.position);
                let material = &all.scene.materials[mesh.material as usize];
                assert!(material.alpha_test.is_some());
            }
        }
    }
    let of_buildings: u32 = city.buildings.iter().map(|b| 4 * b.storeys).sum();
    assert_eq!(storeys, of_buildings);
    assert_eq!(city.trees.len(), 45);
    // One mesh for all storeys, one for all roofs.
    let used = |name: &str| all.scene.meshes.iter().filter(|m| m.name == name).count();
    assert_eq!((used("storey"), used("roof"), used("tree")), (1, 1, 1));
}

/// Area of what a storey's quads cover, and whether each is one upright rectangle.
#[test]
fn a_storeys_quads_tile_it_side_by_side() {
    let scene = city_of("city_small", 1).unwrap().scene().scene;
    let storey = &scene.meshes[0];
    let mut area = 0.0;
    for quad in storey.triangles.chunks(2) {
        let corners: Vec<_> =
            quad.iter().flatten().map(|&i| storey.positions[i as usize]).collect();
        let (min, max) =
            corners.iter().fold((corners[0], corners[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        assert!(
            corners.iter().all(|p| (p.x == min.x || p.x == max.x) && (p.y == 0.0 || p.y == 3.0))
        );
        area += (max.x - min.x) * (max.y - min.y);
    }
    assert_eq!(area, 30.0);
}

#[test]
fn lights_stand_outside_all_boxes_before_walls_that_are_not_shared() {
    let city = of(&Knobs { empty_lots: 0.1, ..blocks(3) });
    for light in &city.lights {
        let building = &city.buildings[light.building as usize];
        let facade = &building.facades[light.facade as usize];
        assert!(!facade.party);
        let normal = light.direction;
        assert_eq!(normal.abs().max_element(), 1.0, "along an axis");
        assert_eq!(normal.abs().element_sum(), 1.0);
        let wall = DVec3::new(facade.from.x, light.position.y, facade.from.y);
        let outside = (light.position - wall).dot(normal);
        assert!((outside - windows::OUTSIDE_M).abs() < 1e-9, "{outside}");
        assert_eq!((light.position.y / 3.0) as u32, light.storey);
        let p = light.position;
        let inside = |b: &Building| p.cmpge(b.outer.min).all() && p.cmple(b.outer.max).all();
        assert!(!city.buildings.iter().any(inside), "{p}");
        assert!(light.intensity.is_finite() && light.intensity.min_element() > 0.0);
    }
    // 3 a storey on every wall that is not shared, in order.
    let expected: u32 = city
        .buildings
        .iter()
        .map(|b| 3 * b.storeys * b.facades.iter().filter(|f| !f.party).count() as u32)
        .sum();
    assert_eq!(city.lights.len(), expected as usize);
    let keys: Vec<_> = city.lights.iter().map(|l| (l.building, l.facade, l.storey)).collect();
    assert!(keys.is_sorted());
    // A lamp inside a building is caught by the same test of boxes.
    let b = &city.buildings[0];
    let centre = b.outer.centre();
    assert!(centre.cmpge(b.outer.min).all() && centre.cmple(b.outer.max).all());
}

#[test]
fn a_window_shines_half_as_much_at_half_its_cone() {
    let light = of(&blocks(1)).lights[0];
    let at = |degrees: f64| light.falloff(degrees.to_radians());
    assert_eq!(at(0.0), 1.0);
    assert!((at(22.5) - 0.5).abs() < 1e-15);
    assert!(at(45.0).abs() < 1e-15);
    assert_eq!((at(46.0), at(90.0), at(180.0)), (0.0, 0.0, 0.0));
}

#[test]
fn offset_streets_are_closed_and_others_are_not() {
    // From row to row: a block's depth, its sidewalks, a street.
    let two_blocks = 2.0 * (25.0 + 4.0 + 12.0);
    let city = of(&Knobs::default());
    let closed = camera(&city, "close_ended");
    let forward = (closed.target - closed.position).normalize();
    let distance = hit(&city, closed.position, forward).unwrap();
    assert!(distance < two_blocks, "{distance}");
    let long = camera(&city, "street");
    let forward = (long.target - long.position).normalize();
    assert_eq!(hit(&city, long.position, forward), None, "leaves the city");
    // Without offset the same street across is open.
    let grid = of(&Knobs { brick_offset: false, ..Knobs::default() });
    let corner = grid.buildings.iter().map(|b| b.outer.min.x).fold(f64::INFINITY, f64::min);
    let across = DVec3::new(corner + 220.0 + 2.0 + 6.0, 1.7, 1000.0);
    assert_eq!(hit(&grid, across, DVec3::NEG_Z), None);
    let closed = camera(&grid, "close_ended");
    assert!(hit(&grid, closed.position, DVec3::NEG_Z).unwrap() < two_blocks);
    let facade = camera(&city, "facade");
    let distance = hit(&city, facade.position, DVec3::NEG_Z).unwrap();
    assert!((4.0..5.0).contains(&distance), "{distance}");
}

fn extremes() -> Vec<Knobs> {
    let base = blocks(1);
    let mut all = vec![base, blocks(2), blocks(3)];
    for shape in [
        BlockShape::DoubleRow(1),
        BlockShape::DoubleRow(2),
        BlockShape::DoubleRow(64),
        BlockShape::Ring(3),
        BlockShape::Ring(12),
    ] {
        for brick_offset in [false, true] {
            for (x, z) in [(1, 1), (1, 3), (3, 1), (2, 2)] {
                for empty_lots in [0.0, 0.5] {
                    let street_m = if empty_lots == 0.0 { 6.0 } else { 30.0 };
                    let (blocks_x, blocks_z) = (x, z);
                    all.push(Knobs {
                        shape,
                        brick_offset,
                        blocks_x,
                        blocks_z,
                        empty_lots,
                        street_m,
                        ..base
                    });
                }
            }
        }
    }
    all.push(Knobs {
        heights: Heights::Fixed(100),
        lights_per_storey: 8,
        trees_per_block: 64,
        ..base
    });
    all.push(Knobs {
        street_m: 7.123_456,
        heights: Heights::Independent { least: 1, most: 1 },
        ..base
    });
    all
}

#[test]
fn cameras_walk_in_the_open_by_small_steps() {
    for knobs in extremes().into_iter().chain([Knobs::default(), blocks(24)]) {
        let city = of(&knobs);
        let scene = city.scene().scene;
        scene.validate().unwrap();
        let names: Vec<&str> = city.cameras.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["street", "close_ended", "facade", "birds_eye"]);
        let names: Vec<&str> = city.paths.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["street", "turn", "tour"]);
        let free = |p: DVec3| {
            let inside = |b: &&Building| {
                p.cmpge(b.outer.min - 0.1).all() && p.cmple(b.outer.max + 0.1).all()
            };
            assert!(p.y > 0.5, "{knobs:?}: {p}");
            let found = city.buildings.iter().find(inside);
            assert!(found.is_none(), "{knobs:?}: {p} is inside {:?}", found.map(|b| &b.outer));
        };
        city.cameras.iter().for_each(|c| free(c.position));
        for path in &city.paths {
            let frames: Vec<_> = (0..path.frames).map(|i| path.camera(i).unwrap()).collect();
            let wanted = if path.name == "tour" { 125..=155 } else { 60..=60 };
            assert!(wanted.contains(&path.frames), "{}: {}", path.name, path.frames);
            // A flight is as fast as its way is long; nowhere does it jump.
            let steps = frames.windows(2).map(|p| p[1].position.distance(p[0].position));
            let length: f64 = steps.sum();
            for pair in frames.windows(2) {
                free(pair[1].position);
                let step = pair[1].position.distance(pair[0].position);
                let forward = |c: &dapple_scene::Camera| (c.target - c.position).normalize();
                let turn = forward(&pair[0]).angle_between(forward(&pair[1])).to_degrees();
                let most = if path.name == "tour" { (length / 25.0).max(12.0) } else { 1.6 };
                assert!(
                    step <= most && turn <= 6.0,
                    "{knobs:?}, {}: {step} m, {turn} degrees",
                    path.name
                );
            }
        }
    }
}

#[test]
fn the_tour_visits_the_four_views() {
    let city = of(&Knobs::default());
    let tour = city.paths.iter().find(|p| p.name == "tour").unwrap();
    for view in &city.cameras {
        let near = tour.keys.iter().any(|k| {
            k.position.distance(view.position) < 1e-9 && k.target.distance(view.target) < 1e-9
        });
        assert!(near, "{}", view.name);
    }
}

/// Twice the area of a triangle seen from above.
fn double_area([a, b, c]: &[DVec3; 3]) -> f64 {
    (*b - *a).cross(*c - *a).y
}

#[test]
fn grounds_tile_the_city_without_overlap() {
    for knobs in extremes() {
        let city = of(&knobs);
        let mut rectangles = vec![];
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut area = 0.0;
        for ground in &city.grounds {
            let corners: Vec<DVec3> = ground.triangles.iter().flatten().copied().collect();
            assert!(corners.iter().all(|p| p.y == 0.0));
            assert!(ground.triangles.iter().all(|t| double_area(t) > 0.0), "faces up");
            area += ground.triangles.iter().map(double_area).sum::<f64>() / 2.0;
            let flat = corners.iter().map(|p| DVec2::new(p.x, p.z));
            let (min, max) =
                flat.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            (lo, hi) = (lo.min(min), hi.max(max));
            rectangles.push((min, max));
        }
        for (i, a) in rectangles.iter().enumerate() {
            for b in &rectangles[..i] {
                let (min, max) = (a.0.max(b.0), a.1.min(b.1));
                assert!(max.x <= min.x || max.y <= min.y, "{a:?} and {b:?}");
            }
        }
        let size = hi - lo;
        assert!((area / (size.x * size.y) - 1.0).abs() < 1e-12, "{knobs:?}: a gap");
        assert!(city.grounds.iter().any(|g| g.kind == GroundKind::Sidewalk));
        assert!(city.buildings.iter().all(|b| {
            b.outer.min.x > lo.x
                && b.outer.max.x < hi.x
                && b.outer.min.z > lo.y
                && b.outer.max.z < hi.y
        }));
    }
}

/// Edges of all triangles but grounds, by the bits of their f32 ends relative to the origin.
fn open_edges(scene: &Scene, parts: &[Part], keep: impl Fn(&Part) -> bool) -> usize {
    let mut edges = std::collections::BTreeMap::new();
    for ((instance, _), t) in scene.world_triangles() {
        if !keep(&parts[instance as usize]) {
            continue;
        }
        let t = t.map(|p| (p + DVec3::ZERO).as_vec3().to_array().map(f32::to_bits));
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0usize) += 1;
        }
    }
    edges.iter().filter(|(_, n)| **n != 2).count()
}

#[test]
fn a_buildings_parts_meet_corner_to_corner() {
    let city = of(&Knobs { street_m: 7.123_456, ..blocks(3) });
    let all = city.scene();
    for wanted in [0u32, 50, 300] {
        let storeys = city.buildings[wanted as usize].storeys;
        let open = open_edges(&all.scene, &all.parts, |part| match *part {
            Part::Storey { building, .. } | Part::Roof { building, .. } => building == wanted,
            _ => false,
        });
        // All but the lower edges of the lowest storey, 8 a facade.
        assert_eq!(open, 32, "{storeys} storeys");
        // Without its roof it is open above as well.
        let open = open_edges(
            &all.scene,
            &all.parts,
            |part| matches!(*part, Part::Storey { building, .. } if building == wanted),
        );
        assert_eq!(open, 64);
    }
}

#[test]
fn knobs_beyond_their_range_are_refused_by_name() {
    let base = Knobs::default();
    for (knobs, name, limit) in [
        (Knobs { blocks_x: 0, ..base }, "blocks_x", "1..=24"),
        (Knobs { blocks_z: 25, ..base }, "blocks_z", "1..=24"),
        (Knobs { shape: BlockShape::DoubleRow(0), ..base }, "double row", "1..=64"),
        (Knobs { shape: BlockShape::Ring(2), ..base }, "ring", "3..=64"),
        (Knobs { heights: Heights::Fixed(0), ..base }, "storeys", "1..=100"),
        (Knobs { heights: Heights::Stratified { least: 5, most: 4 }, ..base }, "most", "5..=100"),
        (Knobs { heights: Heights::Independent { least: 0, most: 4 }, ..base }, "least", "1..=100"),
        (Knobs { empty_lots: 0.51, ..base }, "empty_lots", "0..=0.5"),
        (Knobs { empty_lots: f64::NAN, ..base }, "empty_lots", "NaN"),
        (Knobs { street_m: 5.9, ..base }, "street_m", "6..=30"),
        (Knobs { street_m: f64::INFINITY, ..base }, "street_m", "inf"),
        (Knobs { lights_per_storey: 0, ..base }, "lights_per_storey", "1..=8"),
        (Knobs { lights_per_storey: 9, ..base }, "lights_per_storey", "9"),
        (Knobs { trees_per_block: 65, ..base }, "trees_per_block", "0..=64"),
    ] {
        let message = generate(&knobs, 1).unwrap_err().to_string();
        assert!(message.contains(name) && message.contains(limit), "{message}");
    }
    assert!(windows::light(&mut City::default(), 0, 1).is_err());
}

#[test]
fn an_empty_city_survives() {
    let mut city = City::default();
    windows::light(&mut city, 3, 1).unwrap();
    let all = city.scene();
    assert!(all.parts.is_empty() && all.scene.validate().is_err());
    assert_eq!(city.bytes().total(), 0);
    city.trees.push(Tree { position: DVec3::ZERO, height_m: 5.0, crown_radius_m: 2.0 });
    let all = city.scene();
    all.scene.validate().unwrap();
    assert_eq!(all.parts, [Part::Tree { tree: 0 }]);
}

#[test]
fn the_largest_city_takes_bounded_memory() {
    for n in [6, 9, 15, 24] {
        let city = of(&blocks(n));
        let all = city.scene();
        let triangles = all.scene.triangle_count() as u64;
        let facades = city.buildings.iter().map(|b| b.facades.len()).sum::<usize>() as u64;
        let bytes = city.bytes();
        println!(
            "{n} x {n}: {triangles} triangles, {} lights, {facades} facades, {} objects; scene {} B \
             ({:.2} a triangle), lights {} B, buildings {} B ({:.1} a facade)",
            city.lights.len(),
            all.parts.len(),
            all.bytes(),
            all.bytes() as f64 / triangles as f64,
            bytes.lights,
            bytes.buildings,
            bytes.buildings as f64 / facades as f64,
        );
        assert_eq!(bytes.lights, 80 * city.lights.len() as u64);
        assert!(all.bytes() < 10 * triangles);
        assert!(bytes.buildings < 400 * facades);
    }
}
