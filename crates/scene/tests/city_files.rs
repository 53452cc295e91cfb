//! Cities from CityJSON and OpenStreetMap: small files written here, damaged ones, and the real ones.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

mod city_support;

use city_support::{Pbf, box_solid, cityjson, load, message, square_way};
use dapple_scene::city::{self, City, GroundKind, LoadedCity, covered_share, holds};
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::io::Write;
use std::path::PathBuf;

#[test]
fn a_box_of_cityjson_becomes_a_building() {
    // Stored in millimetres at a far place; two boxes that share a wall, 6 m and 9 m high.
    let objects = format!(
        r#""a":{},"b":{},"road":{{"type":"Road","geometry":[{{"type":"MultiSurface","lod":"1",
        "boundaries":[[[0,1,2,3]]]}}]}}"#,
        box_solid(0),
        box_solid(8)
    );
    let mut corners = city_support::box_corners([0, 0, 0], [10_000, 8_000, 6_000]);
    corners.extend(city_support::box_corners([10_000, 0, 0], [25_000, 8_000, 9_000]));
    let text = cityjson("2.0", "https://www.opengis.net/def/crs/EPSG/0/7415", &objects, &corners);
    let LoadedCity { city, warnings } = load("far.city.json", text.as_bytes()).unwrap();
    assert_eq!((city.name.as_str(), city.buildings.len()), ("far", 2), "{warnings:?}");
    assert!(warnings[0].ends_with("2 buildings of level of detail 1 are shown"), "{warnings:?}");
    assert!(city.projection.contains("EPSG/0/7415"), "{}", city.projection);
    let [a, b] = &city.buildings[..] else { panic!("two") };
    let heights = |b: &city::Building| [b.base_m, b.eaves_m];
    assert_eq!((heights(a), heights(b)), ([0.0, 6.0], [0.0, 9.0]));
    assert_eq!((a.storeys, b.storeys), (2, 3));
    assert!((a.footprint.area_m2() - 80.0).abs() < 1e-6 && a.roof.len() == 2);
    // East is +x and north -z: b lies to the east; the middle of both is the origin, to the metre.
    assert!((b.outer.centre() - a.outer.centre() - DVec3::new(12.5, 1.5, 0.0)).length() < 1e-6);
    assert!((a.outer.min - DVec3::new(-13.0, 0.0, -4.0)).length() < 1e-6, "{:?}", a.outer);
    // The shared wall, and no other: all of a's side, 8 of 8 m of b's.
    for building in [a, b] {
        let party: Vec<_> = building.facades.iter().filter(|f| f.party).collect();
        assert_eq!(party.len(), 1, "{party:?}");
        assert!((party[0].from.x - (-3.0)).abs() < 1e-9 && (party[0].to.x + 3.0).abs() < 1e-9);
    }
    for building in [a, b] {
        assert_eq!(building.inner.len(), 1);
        let (inner, size) = (building.inner[0], building.outer.max - building.outer.min);
        assert!((inner.half - (0.5 * size - DVec3::splat(1e-3))).length() < 1e-6, "{inner:?}");
        assert_eq!(inner.axis, DVec2::X);
    }
    assert_eq!(city.grounds[0].kind, GroundKind::Street);
    invariants(&city);
}

#[test]
fn gables_and_a_pitched_roof_come_from_the_solid() {
    // A house with a ridge along its length: eaves at 3 m, ridge at 5 m.
    let corners = [
        [0, 0, 0],
        [10_000, 0, 0],
        [10_000, 6_000, 0],
        [0, 6_000, 0],
        [0, 0, 3_000],
        [10_000, 0, 3_000],
        [10_000, 6_000, 3_000],
        [0, 6_000, 3_000],
        [0, 3_000, 5_000],
        [10_000, 3_000, 5_000],
    ];
    let solid = r#""h":{"type":"Building","geometry":[{"type":"Solid","lod":"2.2","boundaries":[[
        [[0,3,2,1]],[[0,1,5,4]],[[2,3,7,6]],[[1,2,6,9,5]],[[3,0,4,8,7]],[[4,5,9,8]],[[6,7,8,9]]]],
        "semantics":{"surfaces":[{"type":"GroundSurface"},{"type":"WallSurface"},
        {"type":"RoofSurface"}],"values":[[0,1,1,1,1,2,2]]}}]}"#;
    let text = cityjson("1.1", "urn:ogc:def:crs:EPSG::28992", solid, &corners);
    let LoadedCity { city, warnings } = load("house.json", text.as_bytes()).unwrap();
    let house = &city.buildings[0];
    assert!((house.eaves_m - 3.0).abs() < 1e-9 && (house.outer.max.y - 5.0).abs() < 1e-9);
    let area = |ts: &[[DVec3; 3]]| -> f64 {
        ts.iter().map(|t| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).length()).sum()
    };
    // Two slopes of 10 by sqrt(13), two gables of 6 by 2 over 2; cut 2 mm above the eaves.
    assert!((area(&house.roof) - 20.0 * 13f64.sqrt()).abs() < 1e-6, "{}", area(&house.roof));
    assert!((area(&house.gables) - 12.0).abs() < 0.03, "{}", area(&house.gables));
    assert!(warnings[0].contains("level of detail 2.2"));
    invariants(&city);
}

#[test]
fn what_cityjson_must_not_say_is_refused_by_name() {
    let corners = city_support::box_corners([0, 0, 0], [10_000, 8_000, 6_000]);
    let crs = "https://www.opengis.net/def/crs/EPSG/0/7415";
    let good = format!(r#""a":{}"#, box_solid(0));
    let refused = |version: &str, crs: &str, objects: &str, parts: &[&str]| {
        let text = cityjson(version, crs, objects, &corners);
        let message = message("x.city.json", text.as_bytes());
        assert!(parts.iter().all(|p| message.contains(p)), "{message} lacks one of {parts:?}");
    };
    refused("3.0", crs, &good, &["version", "3.0", "1.1"]);
    refused("2.0", "https://www.opengis.net/def/crs/EPSG/0/4326", &good, &["4326", "degrees"]);
    refused("2.0", "https://www.opengis.net/def/crs/OGC/0/CRS84", &good, &["CRS84", "degrees"]);
    refused(
        "2.0",
        crs,
        &good.replace("[[0,3,2,1]]", "[[0,3,2,99]]"),
        &["\"a\"", "99", "8 vertices"],
    );
    refused("2.0", crs, &good.replace("[[0,3,2,1]]", "[[0,3,2,-1]]"), &["\"a\"", "-1"]);
    refused("2.0", crs, &good.replace("[[0,3,2,1]]", "7"), &["\"a\"", "list"]);
    let parents = |of: &str, to: &str| {
        format!(r#""{of}":{{"type":"BuildingPart","geometry":[],"parents":["{to}"]}}"#)
    };
    let cycle = format!("{},{}", parents("p", "q"), parents("q", "p"));
    refused("2.0", crs, &cycle, &["\"p\"", "cycle"]);
    refused("2.0", crs, &parents("p", "nobody"), &["\"p\"", "\"nobody\""]);
    refused("2.0", crs, "", &["no building"]);
    let far = [[i64::MAX, 0, 0]; 3];
    let text = cityjson("2.0", crs, &good, &far);
    assert!(message("x.json", text.as_bytes()).contains("vertex 0"));
    for (bytes, part) in [
        (&b"{}"[..], "CityJSON"),
        (b"", "line 1"),
        (b"[1,2]", "CityJSON"),
        (b"7", "line 1"),
        (br#"{"type":"CityJSONFeature","version":"2.0"}"#, "sequence"),
        (br#"{"type":"CityJSON","version":"2.0","CityObjects":{},"vertices":[[1,2]]}"#, "line 1"),
        (
            br#"{"type":"CityJSON","version":"2.0","CityObjects":{},"vertices":[[1e999,2,3]]}"#,
            "line 1",
        ),
    ] {
        let message = message("x.json", bytes);
        assert!(message.contains("x.json") && message.contains(part), "{message}");
    }
    assert!(load("x.xml", b"").unwrap_err().to_string().contains("osm.pbf"));
}

#[test]
fn what_cannot_be_shown_is_counted() {
    let corners = city_support::box_corners([0, 0, 0], [10_000, 8_000, 6_000]);
    let objects = format!(
        r#""a":{},"b":{{"type":"Building","geometry":[{{"type":"GeometryInstance","template":0,
        "boundaries":[0],"transformationMatrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}}]}},
        "t":{{"type":"SolitaryVegetationObject","geometry":[{{"type":"GeometryInstance","template":0,
        "boundaries":[6]}}],"attributes":{{"height":12.0}}}},
        "c":{{"type":"Tunnel","geometry":[]}}"#,
        box_solid(0)
    );
    let text = cityjson("2.0", "urn:ogc:def:crs:EPSG::28992", &objects, &corners);
    let LoadedCity { city, warnings } = load("x.city.json", text.as_bytes()).unwrap();
    let all = warnings.join("\n");
    for part in [
        "geometries of type GeometryInstance",
        "1 objects of type Tunnel",
        "1 buildings without surfaces",
    ] {
        assert!(all.contains(part), "{all}");
    }
    assert_eq!((city.buildings.len(), city.trees.len()), (1, 1));
    assert_eq!(city.trees[0].height_m, 12.0);
}

#[test]
fn outlines_courtyards_lamps_and_trees_come_from_a_pbf() {
    let mut pbf = Pbf::default();
    square_way(&mut pbf, 1, [0.0, 0.0], 30.0, &[]);
    square_way(&mut pbf, 2, [10.0, 10.0], 10.0, &[]);
    pbf.relation(
        7,
        &[(1, "outer"), (2, "inner")],
        &[("type", "multipolygon"), ("building", "yes"), ("height", "21 m")],
    );
    square_way(&mut pbf, 3, [50.0, 0.0], 10.0, &[("building", "yes"), ("building:levels", "4")]);
    square_way(&mut pbf, 4, [70.0, 0.0], 10.0, &[("building", "yes")]);
    square_way(&mut pbf, 5, [90.0, 0.0], 10.0, &[("building", "no")]);
    pbf.way(6, &[9001, 9002, 9003, 9001], &[("building", "yes")]);
    let bow = [[110.0, 0.0], [120.0, 10.0], [120.0, 0.0], [110.0, 5.0]];
    pbf.ring(8, &bow, &[("building", "yes")]);
    pbf.point([40.0, 5.0], &[("highway", "street_lamp")]);
    pbf.point([41.0, 5.0], &[("highway", "street_lamp"), ("height", "4.5")]);
    pbf.point([42.0, 5.0], &[("natural", "tree"), ("height", "11")]);
    for dense in [true, false] {
        let LoadedCity { city, warnings } = load("t.osm.pbf", &pbf.bytes(dense)).unwrap();
        let all = warnings.join("\n");
        assert_eq!((city.name.as_str(), city.buildings.len()), ("t", 3), "{all}");
        let by = |id: &str| city.buildings.iter().find(|b| b.id == id).unwrap();
        let yard = by("relation/7");
        assert!((yard.footprint.area_m2() - 800.0).abs() < 0.5, "{}", yard.footprint.area_m2());
        assert_eq!((yard.footprint.holes.len(), yard.eaves_m, yard.facades.len()), (1, 21.0, 8));
        assert_eq!((by("way/3").eaves_m, by("way/3").storeys), (12.0, 4));
        // The median of 12 and 21, the upper one.
        assert_eq!(by("way/4").eaves_m, 21.0);
        for part in [
            "1 buildings without height or levels are 21 m high: the median of the 2",
            "1 buildings (ways) with nodes that the file does not hold",
            "1 buildings (ways) that cross themselves",
            "1 street lamps without height are 6 m high",
        ] {
            assert!(all.contains(part), "{all}");
        }
        let lamps: Vec<f64> = city.lamps.iter().map(|l| l.position.y).collect();
        assert_eq!((lamps, city.trees.len(), city.trees[0].height_m), (vec![6.0, 4.5], 1, 11.0));
        // 40 m east of the first corner; the file's unit is a centimetre.
        let corner = yard.footprint.bounds()[0];
        let across = city.lamps[0].position.x - corner.x;
        assert!((across - 40.0).abs() < 0.02, "{across}");
        assert!(city.projection.contains("WGS 84"), "{}", city.projection);
        invariants(&city);
    }
}

#[test]
fn what_a_pbf_must_not_say_is_refused_by_name() {
    let mut pbf = Pbf::default();
    square_way(&mut pbf, 3, [50.0, 0.0], 10.0, &[("building", "yes")]);
    let good = pbf.bytes(true);
    load("g.pbf", &good).unwrap();
    for cut in [1, 3, 5, good.len() / 2, good.len() - 1] {
        let message = message("cut.osm.pbf", &good[..cut]);
        assert!(message.contains("cut.osm.pbf") && message.contains("byte"), "{cut}: {message}");
    }
    assert!(message("e.pbf", b"").contains("no OpenStreetMap header"));
    pbf.features = vec!["HistoricalInformation".into()];
    assert!(message("h.pbf", &pbf.bytes(true)).contains("HistoricalInformation"));
    let mut wide = Pbf::default();
    square_way(&mut wide, 1, [0.0, 0.0], 10.0, &[("building", "yes")]);
    square_way(&mut wide, 2, [3e5, 0.0], 10.0, &[("building", "yes")]);
    assert!(message("w.pbf", &wide.bytes(true)).contains("degrees from their middle"));
    let mut none = Pbf::default();
    square_way(&mut none, 1, [0.0, 0.0], 10.0, &[]);
    assert!(message("n.pbf", &none.bytes(true)).contains("no building, lamp or tree"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any byte of a file may be damaged: an error that names the file, or a city that holds.
    #[test]
    fn damaged_files_never_panic(
        at in 0.0f64..1.0, byte in any::<u8>(), more in 0.0f64..1.0, other in any::<u8>(), json in any::<bool>(),
    ) {
        let (name, mut bytes) = if json {
            let corners = city_support::box_corners([0, 0, 0], [10_000, 8_000, 6_000]);
            let objects = format!(r#""a":{}"#, box_solid(0));
            ("d.city.json", cityjson("2.0", "urn:ogc:def:crs:EPSG::28992", &objects, &corners).into_bytes())
        } else {
            let mut pbf = Pbf::default();
            square_way(&mut pbf, 1, [0.0, 0.0], 30.0, &[("building", "yes"), ("height", "9")]);
            square_way(&mut pbf, 2, [10.0, 10.0], 10.0, &[]);
            pbf.relation(7, &[(1, "outer"), (2, "inner")], &[("type", "multipolygon"), ("building", "yes")]);
            pbf.point([40.0, 5.0], &[("highway", "street_lamp")]);
            ("d.osm.pbf", pbf.bytes_raw(true))
        };
        for (place, value) in [(at, byte), (more, other)] {
            let index = (place * bytes.len() as f64) as usize;
            bytes[index] = value;
        }
        match load(name, &bytes) {
            Ok(loaded) => invariants(&loaded.city),
            Err(error) => prop_assert!(error.to_string().contains(name), "{error}"),
        }
    }
}

/// What every city must hold.
fn invariants(city: &City) {
    let mut next = 0;
    for block in &city.blocks {
        assert_eq!(block.start, next);
        next = block.end;
    }
    assert_eq!(next as usize, city.buildings.len());
    for b in &city.buildings {
        assert!(b.footprint.area_m2() > 0.0 && b.eaves_m > b.base_m && b.storeys > 0, "{}", b.id);
        let edges: Vec<[DVec2; 2]> = b.footprint.edges().collect();
        assert!(edges.iter().zip(&b.facades).all(|(e, f)| *e == [f.from, f.to]));
        assert_eq!(edges.len(), b.facades.len());
        for inner in &b.inner {
            assert!(holds(&b.footprint, inner), "{}", b.id);
            assert!(
                inner.centre.y - inner.half.y > b.base_m
                    && inner.centre.y + inner.half.y < b.eaves_m
            );
        }
        let grown = 1e-6;
        for p in b.roof.iter().flatten() {
            assert!(
                (*p - b.outer.min).min_element() >= -grown
                    && (b.outer.max - *p).min_element() >= -grown
            );
        }
    }
    if !city.buildings.is_empty() {
        assert!(city.cameras.iter().any(|c| c.name == "birds_eye"));
    }
    for (camera, own) in city.cameras.iter().map(|c| (c, c.name != "birds_eye")) {
        let place = DVec2::new(camera.position.x, camera.position.z);
        assert!(
            !own || !city.buildings.iter().any(|b| b.footprint.contains(place)),
            "{}",
            camera.name
        );
    }
    for path in &city.paths {
        let places: Vec<DVec3> =
            (0..path.frames).filter_map(|i| path.camera(i)).map(|c| c.position).collect();
        assert!(places.windows(2).all(|s| s[0].distance(s[1]) < 9.0), "{} leaps", path.name);
        let on_foot = path.name == "street";
        for p in places.iter().filter(|_| on_foot) {
            let place = DVec2::new(p.x, p.z);
            assert!(!city.buildings.iter().any(|b| b.footprint.contains(place)), "{p}");
        }
    }
}

#[test]
fn real_cities_load_if_they_are_there() {
    let Some(root) = std::env::var_os("DAPPLE_DATA").map(PathBuf::from) else {
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "skipped: real cities: DAPPLE_DATA is not set");
        return;
    };
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let figures = |city: &City| {
        let covered =
            city.buildings.iter().map(|b| covered_share(&b.footprint, &b.inner)).collect();
        let outer = city.buildings.iter().map(|b| {
            let size = b.outer.max - b.outer.min;
            size.x * size.z / b.footprint.area_m2()
        });
        let aligned = |b: &&city::Building| {
            b.footprint.edges().all(|[p, q]| (q - p).abs().min_element() < 1e-3 * p.distance(q))
        };
        (median(covered), median(outer.collect()), city.buildings.iter().filter(aligned).count())
    };

    let LoadedCity { city, warnings } = city::load(&root.join("city/delft.city.json")).unwrap();
    assert_eq!((city.name.as_str(), city.buildings.len()), ("delft", 160), "{warnings:?}");
    // 143 roads, 126 plant covers, 81 land uses, 54 others, 3 bridges, 3 waters.
    assert_eq!((city.grounds.len(), city.trees.len()), (410, 0));
    let streets = city.grounds.iter().filter(|g| g.kind == GroundKind::Street).count();
    assert_eq!(streets, 143 + 3);
    invariants(&city);
    let (covered, outer, aligned) = figures(&city);
    assert!(covered > 0.95 && (1.9..2.8).contains(&outer), "{covered} {outer}");
    assert_eq!(aligned, 0);
    assert_eq!(city.cameras.len(), 4, "{:?}", city.cameras);

    let LoadedCity { city, warnings } = city::load(&root.join("city/Helsinki.osm.pbf")).unwrap();
    assert_eq!((city.lamps.len(), city.trees.len()), (586, 649), "{warnings:?}");
    // Of the file's 433 building ways, those that close and are not repeated by a relation.
    let ways = city.buildings.iter().filter(|b| b.id.starts_with("way/")).count();
    let left_out: usize = warnings
        .iter()
        .filter(|w| w.contains(" buildings (ways) "))
        .filter_map(|w| w.split_once(": ")?.1.split(' ').next()?.parse::<usize>().ok())
        .sum();
    assert_eq!(ways + left_out, 433, "{warnings:?}");
    invariants(&city);
    let (covered, outer, aligned) = figures(&city);
    assert!(covered > 0.95 && outer > 1.1, "{covered} {outer}");
    assert_eq!(aligned, 0);
    assert_eq!(city.cameras.len(), 4, "{:?}", city.cameras);
}
