//! Horizons from single points against rays, and extremes of umbrae.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_horizon_support;

use dapple_many_lights::region::{
    Cuboid, Edge,
    horizon::{
        Umbra,
        point::{Corner, silhouette, table},
        project, reproject, umbra,
    },
};
use proptest::prelude::*;
use region_horizon_support::{EDGES, config, interval};

/// Along a horizontal ray, the distances at which it enters and leaves a box's plan.
fn across(eye: [f64; 3], along: [f64; 2], of: &Cuboid) -> Option<[f64; 2]> {
    let mut inside = [0.0_f64, f64::INFINITY];
    for (axis, [low, high]) in [of.u, of.w].into_iter().enumerate() {
        let ends = [(low - eye[axis]) / along[axis], (high - eye[axis]) / along[axis]];
        inside[0] = inside[0].max(ends[0].min(ends[1]));
        inside[1] = inside[1].min(ends[0].max(ends[1]));
    }
    (inside[0] < inside[1]).then_some(inside)
}

/// Where the ray crosses the horizon: distances.
fn crossings(eye: [f64; 3], along: [f64; 2], list: &[Corner], of: &Cuboid) -> Vec<f64> {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let from_eye = |corner: Corner| {
        let [u, w] = corner.place(of);
        [u - eye[0], w - eye[1]]
    };
    list.array_windows()
        .filter_map(|&[a, b]| {
            let (a, b) = (from_eye(a), from_eye(b));
            let (left, right) = (cross(along, a), cross(along, b));
            // From left to right as the eye sees it: `a` to the left of the ray, `b` to the right.
            (left >= 0.0 && right < 0.0).then(|| {
                let share = left / (left - right);
                let at = [0, 1].map(|i| a[i] + share * (b[i] - a[i]));
                at[0] * along[0] + at[1] * along[1]
            })
        })
        .collect()
}

proptest! {
    #![proptest_config(config())]

    /// Row 17: in each section and class, the outline that rays find.
    #[test]
    fn horizons_of_points_are_the_outline(
        eye in prop::array::uniform3(-10.0..10.0_f64),
        u in interval(-4, 4), w in interval(-4, 4), top in -5.0..5.0_f64,
        angle in 0.0..std::f64::consts::TAU,
    ) {
        prop_assume!(u[0] < u[1] && w[0] < w[1]);
        let of = Cuboid { u, w, h: [f64::NEG_INFINITY, top] };
        let along = [angle.cos(), angle.sin()];
        let (Some(list), Some(whole)) = (table(eye, &of), silhouette(eye, &of)) else {
            let is_over = u[0] <= eye[0] && eye[0] <= u[1] && w[0] <= eye[1] && eye[1] <= w[1];
            prop_assert!(is_over);
            return Ok(());
        };
        let is_above = eye[2] > top;
        let found = across(eye, along, &of).filter(|[near, far]| far - near > 1e-6);
        let hits = crossings(eye, along, whole, &of);
        if let Some([near, far]) = found {
            // The highest point of the box along the ray: its near side from below, its far one from
            // above. The outline is there, and there alone.
            let expected = if is_above { far } else { near };
            prop_assert_eq!(hits.len(), 1);
            prop_assert!((hits[0] - expected).abs() < 1e-9);
            // The thesis's list is as high or absent.
            for hit in crossings(eye, along, list, &of) {
                prop_assert!((hit - expected).abs() < 1e-9);
            }
        }
        let is_beside = u[0] <= eye[0] && eye[0] <= u[1] || w[0] <= eye[1] && eye[1] <= w[1];
        prop_assert_eq!(list.len() - 1, if is_beside { 1 } else { 2 });
        prop_assert_eq!(whole == list, !(is_beside && is_above));
    }

    /// Nothing panics, and nothing that is not a number hides.
    #[test]
    fn numbers_that_are_none_give_nothing(
        numbers in prop::array::uniform13(prop_oneof![
            4 => -10.0..10.0_f64,
            1 => prop::sample::select(vec![
                f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 1.0, 1e-308, 1e308, -1e308,
            ]),
        ]),
        to in prop::sample::select(vec![f64::NAN, f64::INFINITY, 1e308, 20.0]),
    ) {
        let side = |i: usize| [numbers[i], numbers[i + 1]];
        let cell = Cuboid { u: side(0), w: side(2), h: side(4) };
        let solid = Cuboid { u: side(6), w: side(8), h: side(10) };
        let plane = numbers[12];
        for edge in EDGES {
            let found = umbra(&cell, &solid, plane, edge);
            let moved = found.and_then(|found| reproject(&cell, &found, plane, to));
            for umbra in [found, moved].into_iter().flatten() {
                prop_assert!(numbers.iter().all(|x| !x.is_nan()), "{umbra:?}");
                prop_assert!(umbra.u[0] < umbra.u[1] && umbra.foot < umbra.highest());
            }
            if to.is_nan() || to == f64::INFINITY {
                prop_assert!(moved.is_none());
            }
            let projection = project(&cell, &solid, plane);
            let nowhere = numbers[..10].iter().any(|x| x.is_nan()) || plane.is_nan();
            let around = Umbra::flat([-1e300, 1e300], -1e300, 1e300);
            prop_assert!(!(nowhere && around.hides(&projection)), "{projection:?}");
        }
    }
}

const LOW: f64 = f64::NEG_INFINITY;

fn cuboid(u: [f64; 2], w: [f64; 2], h: [f64; 2]) -> Cuboid {
    Cuboid { u, w, h }
}

fn flat(cell: Cuboid, solid: Cuboid, plane: f64) -> Option<Umbra> {
    umbra(&cell, &solid, plane, Edge::Flat)
}

#[test]
fn extremes_of_cells_and_occluders() {
    let cell = cuboid([0.0, 4.0], [-1.0, 0.0], [0.0, 3.0]);
    let wall = |w: [f64; 2]| cuboid([-1.0, 5.0], w, [LOW, 3.0]);
    // As high as the cell: as high behind, wherever the plane is.
    for plane in [5.0, 6.0, 1e3] {
        for edge in EDGES {
            let shadow = umbra(&cell, &wall([5.0, 5.0]), plane, edge).unwrap();
            assert_eq!((shadow.top, shadow.foot, shadow.peak), ([3.0; 2], LOW, None));
        }
    }
    // Behind, at the front, before and beside the cell's depth: nothing; the part that stands out: that.
    assert_eq!(flat(cell, wall([-9.0, -2.0]), 8.0), None);
    assert_eq!(flat(cell, wall([-1.0, 0.0]), 8.0), None);
    assert_eq!(flat(cell, wall([9.0, 9.5]), 8.0), None);
    assert_eq!(flat(cell, wall([-0.5, 5.0]), 8.0), flat(cell, wall([0.0, 5.0]), 8.0));
    assert!(flat(cell, wall([0.0, 5.0]), 8.0).is_some());
    // On the plane, cut by it, beginning at it.
    let shadow = flat(cell, wall([8.0, 8.0]), 8.0).unwrap();
    assert_eq!(shadow, Umbra::flat([-1.0, 5.0], LOW, 3.0));
    assert_eq!(flat(cell, wall([5.0, 20.0]), 8.0), flat(cell, wall([5.0, 8.0]), 8.0));
    assert_eq!(flat(cell, wall([8.0, 20.0]), 8.0), Some(shadow));
    // A point as a cell: central projection of what it sees.
    let eye = cuboid([1.0; 2], [0.0; 2], [1.0; 2]);
    let shadow = flat(eye, wall([5.0, 5.0]), 10.0).unwrap();
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14 * 10.0);
    near(shadow.u[0], -3.0);
    near(shadow.u[1], 9.0);
    near(shadow.top[0], 5.0);
    // A point within an occluder: it sees nothing of what lies behind; its far face alone is used.
    assert!(flat(eye, wall([-1.0, 5.0]), 10.0).unwrap().u[0] < -2.9);
    // Feet: at the cell's they stay, below they sink, above they rise; a slab in the air.
    let slab = |foot: f64| cuboid([-1.0, 5.0], [5.0; 2], [foot, 3.0]);
    assert_eq!(flat(cell, slab(0.0), 10.0).unwrap().foot, 0.0);
    near(flat(cell, slab(-1.0), 11.0).unwrap().foot, -2.0);
    near(flat(cell, slab(0.5), 10.0).unwrap().foot, 1.0);
    assert_eq!(flat(cell, slab(2.0), 20.0), None);
    // No height, no width: nothing; no depth: a wall.
    assert_eq!(flat(cell, cuboid([-1.0, 5.0], [5.0; 2], [3.0; 2]), 10.0), None);
    assert_eq!(flat(cell, cuboid([2.0; 2], [5.0, 6.0], [LOW, 9.0]), 10.0), None);
    // Seen from the side, a wall along w is as wide as it is long.
    let side = flat(cell, cuboid([-1.0; 2], [5.0, 9.0], [LOW, 9.0]), 9.0).unwrap();
    assert!(side.u[0] < -1.5 && side.u[1] == -1.0);
    // Sides the wrong way round are no boxes.
    assert_eq!(flat(cell, cuboid([5.0, -1.0], [5.0; 2], [LOW, 9.0]), 9.0), None);
    assert_eq!(flat(cell, cuboid([-1.0, 5.0], [6.0, 5.0], [LOW, 9.0]), 9.0), None);
    assert_eq!(flat(cell, cuboid([-1.0, 5.0], [5.0; 2], [9.0, 1.0]), 9.0), None);
    let inside_out = cuboid([0.0, 4.0], [0.0, -1.0], [0.0, 3.0]);
    assert_eq!(flat(inside_out, wall([5.0, 5.0]), 8.0), None);
}
