//! Footprints and the boxes within them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::city::{Footprint, InnerKnobs, covered_share, holds, inner_boxes};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn points(list: &[[f64; 2]]) -> Vec<DVec2> {
    list.iter().map(|&p| DVec2::from(p)).collect()
}

/// Shapes in units: L, U, a slit block, a square with a courtyard, a triangle, a sliver, a star.
fn shapes() -> Vec<(&'static str, Footprint)> {
    let star: Vec<DVec2> = (0..10)
        .map(|i| {
            DVec2::from_angle(f64::from(i) * 0.2 * std::f64::consts::PI)
                * [1.0, 0.4][i as usize % 2]
        })
        .collect();
    let u = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [2.0, 3.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    let slit = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 2.0],
        [1.001, 2.0],
        [1.001, 0.1],
        [1.0, 0.1],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let square = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
    let yard = points(&[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]);
    let made = |outer: &[DVec2], holes: &[Vec<DVec2>]| Footprint::new(outer, holes, 0.0).unwrap();
    vec![
        (
            "l",
            made(
                &points(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]),
                &[],
            ),
        ),
        ("u", made(&points(&u), &[])),
        ("slit", made(&points(&slit), &[])),
        ("yard", made(&points(&square), &[yard])),
        ("triangle", made(&points(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]), &[])),
        ("sliver", made(&points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1e-6]]), &[])),
        ("star", made(&star, &[])),
    ]
}

fn placed(shape: &Footprint, scale: f64, turn: f64, shift: DVec2) -> Footprint {
    let place = |ring: &Vec<DVec2>| -> Vec<DVec2> {
        ring.iter().map(|p| DVec2::from_angle(turn).rotate(*p) * scale + shift).collect()
    };
    let holes: Vec<Vec<DVec2>> = shape.holes.iter().map(place).collect();
    Footprint::new(&place(&shape.outer), &holes, 0.0).unwrap()
}

#[test]
fn rings_are_turned_whichever_way_they_come() {
    let square = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let reversed: Vec<DVec2> = square.iter().rev().copied().collect();
    let hole = |k: f64| points(&[[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.4 + 0.2 * k]]);
    for outer in [&square, &reversed] {
        let f = Footprint::new(outer, &[hole(1.0)], 0.0).unwrap();
        assert!((f.area_m2() - 0.96).abs() < 1e-12);
        assert!(f.contains(DVec2::splat(0.1)) && !f.contains(DVec2::splat(0.5)));
        assert!(!f.contains(DVec2::splat(1.1)));
        // The outward normal of an edge (x, z) is (-z, x), for courtyards too.
        for [a, b] in f.edges() {
            let d = (b - a).normalize() * 1e-3;
            let middle = 0.5 * (a + b);
            assert!(
                !f.contains(middle + DVec2::new(-d.y, d.x))
                    && f.contains(middle - DVec2::new(-d.y, d.x))
            );
        }
    }
}

#[test]
fn what_is_no_polygon_is_refused() {
    let square = points(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]);
    let refused = |outer: &[[f64; 2]], part: &str| {
        let reason = Footprint::new(&points(outer), &[], 1e-3).unwrap_err();
        assert!(reason.contains(part), "{reason}");
    };
    refused(&[[0.0, 0.0], [1.0, 0.0]], "three corners");
    refused(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "three corners");
    refused(&[[0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0]], "finite");
    refused(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]], "cross");
    // Touches itself at a corner.
    refused(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]], "cross");
    let many: Vec<[f64; 2]> = (0..10_001).map(|i| [f64::from(i), f64::from(i % 2)]).collect();
    refused(&many, "10000");
    let hole = |x: f64| points(&[[x, 1.0], [x + 1.0, 1.0], [x + 1.0, 2.0], [x, 2.0]]);
    for (holes, part) in [
        (vec![hole(2.5)], "touch"),
        (vec![hole(9.0)], "outside"),
        (vec![hole(1.0), hole(1.5)], "touch"),
    ] {
        assert!(Footprint::new(&square, &holes, 0.0).unwrap_err().contains(part));
    }
}

#[test]
fn triangles_cover_the_area_and_face_up() {
    for (name, shape) in shapes() {
        for (scale, shift) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (10.0, 1e6)] {
            let f = placed(&shape, scale, 0.3, DVec2::splat(shift));
            let triangles = f.triangulate().unwrap_or_else(|e| panic!("{name} x {scale}: {e}"));
            let up = |t: &[DVec2; 3]| -0.5 * (t[1] - t[0]).perp_dot(t[2] - t[0]);
            let covered: f64 = triangles.iter().map(up).sum();
            assert!((covered / f.area_m2() - 1.0).abs() < 1e-6, "{name} x {scale}");
            assert!(triangles.iter().all(|t| up(t) >= 0.0), "{name} x {scale}");
        }
    }
}

#[test]
fn an_upright_box_is_its_own_inner_box() {
    let f =
        Footprint::new(&points(&[[2.0, 5.0], [12.0, 5.0], [12.0, 11.0], [2.0, 11.0]]), &[], 0.0)
            .unwrap();
    let boxes = inner_boxes(&f, 1.0, 10.0, &InnerKnobs::default());
    let [only] = &boxes[..] else { panic!("{boxes:?}") };
    assert_eq!((only.axis, only.centre), (DVec2::X, DVec3::new(7.0, 5.5, 8.0)));
    assert!((only.half - DVec3::new(5.0, 4.5, 3.0) + DVec3::splat(1e-3)).length() < 1e-9);
    assert!(covered_share(&f, &boxes) > 0.99);
    assert!(inner_boxes(&f, 1.0, 1.0, &InnerKnobs::default()).is_empty(), "no height");
    assert!(inner_boxes(&Footprint::default(), 0.0, 9.0, &InnerKnobs::default()).is_empty());
    let one = InnerKnobs { most: 0, ..InnerKnobs::default() };
    assert!(inner_boxes(&f, 1.0, 10.0, &one).is_empty());
}

#[test]
fn boxes_fill_what_boxes_can() {
    // Two boxes fill an L, three a U; the best of one fills 2/3 of the L.
    for (name, shape) in shapes() {
        let f = placed(&shape, 20.0, 0.3, DVec2::new(100.0, -50.0));
        let boxes = inner_boxes(&f, 0.0, 10.0, &InnerKnobs::default());
        let least = match name {
            "l" | "u" | "yard" | "slit" => 0.97,
            "triangle" => 0.7,
            "star" => 0.5,
            _ => 0.0,
        };
        let share = covered_share(&f, &boxes);
        assert!(share >= least && share <= 1.001, "{name}: {share} by {}", boxes.len());
        assert!(boxes.windows(2).all(|b| b[0].volume_m3() >= b[1].volume_m3()), "{name}");
    }
    let (_, l) = &shapes()[0];
    let one = InnerKnobs { most: 1, ..InnerKnobs::default() };
    let share = covered_share(
        &placed(l, 20.0, 0.0, DVec2::ZERO),
        &inner_boxes(&placed(l, 20.0, 0.0, DVec2::ZERO), 0.0, 9.0, &one),
    );
    assert!((share - 2.0 / 3.0).abs() < 0.01, "{share}");
}

#[test]
fn a_box_that_leaves_the_footprint_is_not_held() {
    let (_, yard) = &shapes()[3];
    let f = placed(yard, 10.0, 0.0, DVec2::ZERO);
    let mut inner = inner_boxes(&f, 0.0, 9.0, &InnerKnobs::default())[0];
    assert!(holds(&f, &inner));
    inner.half.x += 2e-3;
    inner.half.z += 2e-3;
    assert!(!holds(&f, &inner), "2 mm too wide");
    // All of the courtyard and more: no edge of the outer ring is met, those of the hole are.
    inner.centre = DVec3::new(15.0, 4.0, 15.0);
    inner.half = DVec3::new(9.0, 1.0, 9.0);
    assert!(!holds(&f, &inner));
    inner.half = DVec3::new(1.0, 1.0, 1.0);
    assert!(!holds(&f, &inner), "within the courtyard");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// Wherever, however large and however turned: points of a box are points of the footprint.
    #[test]
    fn boxes_lie_inside(
        shape in 0usize..7, scale in -3.0f64..6.0, turn in 0.0f64..6.3, shift in -1e6f64..1e6,
        points in prop::collection::vec([-1.0f64..1.0, -1.0f64..1.0], 20),
    ) {
        let f = placed(&shapes()[shape].1, 10f64.powf(scale), turn, DVec2::new(shift, -0.3 * shift));
        for inner in inner_boxes(&f, 0.0, 10.0, &InnerKnobs::default()) {
            let across = DVec2::new(-inner.axis.y, inner.axis.x);
            let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
            for [u, v] in points.iter().copied().chain(corners) {
                let p = DVec2::new(inner.centre.x, inner.centre.z)
                    + inner.axis * (u * inner.half.x) + across * (v * inner.half.z);
                prop_assert!(f.contains(p), "{p}");
            }
            prop_assert!(inner.centre.y + inner.half.y < 10.0 && inner.centre.y - inner.half.y > 0.0);
        }
    }
}
