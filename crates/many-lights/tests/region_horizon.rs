//! Umbrae of single occluders against what is hidden by trying.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_horizon_support;

use dapple_many_lights::region::{
    Cuboid, Edge,
    horizon::{Umbra, hull, union_of_edges},
};
use proptest::prelude::*;
use region_horizon_support::{EDGES, Scene, cell, config, occluder, scene};

/// Steps off a border, as a share of the coordinates.
const STEP: f64 = 1e-6;

/// Whether the near face decides where a level shadow ends: not of low or floating occluders.
fn is_exact(scene: &Scene) -> bool {
    let Scene { cell, occluder, .. } = scene;
    occluder.h[1] >= cell.h[1] && occluder.h[0] <= cell.h[0] && is_apart(scene)
}

/// Whether the occluder stands behind the cell.
fn is_apart(scene: &Scene) -> bool {
    scene.occluder.w[0] > scene.cell.w[1]
}

proptest! {
    #![proptest_config(config())]

    /// P5, from within: whatever an umbra holds is hidden from all corners, at any scale, with
    /// occluders behind the cell, on it and in its depth.
    #[test]
    fn all_of_an_umbra_is_hidden(scene in scene(0), power in -4_i32..=6) {
        let scene = scene.scaled(10_f64.powi(power) / 32.0);
        for edge in EDGES {
            if let Some(umbra) = scene.umbra(edge) {
                prop_assert!(umbra.u[0] < umbra.u[1] && umbra.foot < umbra.highest());
                let seen = scene.seen_within(&umbra);
                prop_assert!(seen.is_none(), "{edge:?}: {umbra:?} at {seen:?}");
            }
        }
    }

    /// P5, from without: next to either end, and above the edge of a hull, something is seen.
    #[test]
    fn just_outside_of_an_umbra_some_corner_sees(scene in scene(4)) {
        prop_assume!(is_apart(&scene));
        let step = STEP * scene.size * scene.magnification();
        for edge in EDGES {
            let Some(umbra) = scene.umbra(edge) else { continue };
            if edge == Edge::Hull && scene.occluder.h[0] <= scene.cell.h[0] || is_exact(&scene) {
                for share in [0.0, 0.3, 0.9, 1.0] {
                    let foot = umbra.foot.max(-scene.size);
                    let h = foot + share * (umbra.highest() - foot);
                    for u in [umbra.u[0] - step, umbra.u[1] + step] {
                        prop_assert!(!scene.is_hidden(u, h, 0.0), "{edge:?} {umbra:?} {u} {h}");
                    }
                }
            }
            if edge == Edge::Hull && scene.occluder.h[0] <= scene.cell.h[0] {
                for share in [0.0, 0.1, 0.5, 0.77, 1.0] {
                    let u = (umbra.u[0] + share * (umbra.u[1] - umbra.u[0])).min(umbra.u[1]);
                    let h = umbra.height(u) + step * steepness(&umbra).max(1.0);
                    prop_assert!(!scene.is_hidden(u, h, 0.0), "{umbra:?} {u} {h}");
                }
            }
        }
    }

    /// Below a level shadow of an occluder that spans the cell something is seen.
    #[test]
    fn just_below_the_foot_of_a_wide_occluder_some_corner_sees(
        mut scene in scene(4), wider in prop::array::uniform2(0.0..4.0_f64),
        deeper in 0.1..4.0_f64, higher in 0.0..4.0_f64,
    ) {
        prop_assume!(is_apart(&scene));
        let Cuboid { u, h, .. } = scene.cell;
        scene.occluder.u = [u[0] - wider[0], u[1] + wider[1]];
        scene.occluder.h = [h[0] - deeper, h[1] + higher];
        let step = STEP * scene.size * scene.magnification();
        if let Some(umbra) = scene.umbra(Edge::Flat) {
            for share in [0.1, 0.5, 0.9] {
                let u = umbra.u[0] + share * (umbra.u[1] - umbra.u[0]);
                prop_assert!(!scene.is_hidden(u, umbra.foot - step, 0.0));
                prop_assert!(!scene.is_hidden(u, umbra.highest() + step, 0.0));
            }
        }
    }

    /// Row 18: the closed form of a hull is that of its definition; every chord lies below it, and it
    /// has three edges at most (H4.6), as has the union over all points of the cell's top.
    #[test]
    fn hulls_are_as_defined_and_have_three_edges_at_most(
        cell in cell(), occluder in occluder(4), behind in 0.0..20.0_f64,
    ) {
        prop_assume!(occluder.w[0] > cell.w[1]);
        let occluder = Cuboid { h: [f64::NEG_INFINITY, occluder.h[1]], ..occluder };
        let scene = Scene { cell, occluder, plane: occluder.w[1] + behind, size: 32.0 };
        prop_assert!(union_of_edges(&cell, &occluder).len() <= 3);
        let vertices = hull(&cell, &occluder, scene.plane);
        let close = 1e-9 * scene.size * scene.magnification();
        match scene.umbra(Edge::Hull) {
            None => {
                let width = vertices.last().map_or(0.0, |last| last[0] - vertices[0][0]);
                prop_assert!(width <= close, "{vertices:?}");
            }
            Some(umbra) => {
                prop_assume!(umbra.u[1] - umbra.u[0] > 1e-3);
                prop_assert!(umbra.vertices().len() <= 4);
                prop_assert!(vertices.len() <= 4, "{vertices:?}");
                prop_assert!((vertices[0][0] - umbra.u[0]).abs() <= close);
                prop_assert!((vertices[vertices.len() - 1][0] - umbra.u[1]).abs() <= close);
                let close = close * steepness(&umbra).max(1.0);
                for [u, h] in &vertices {
                    let found = umbra.height(u.clamp(umbra.u[0], umbra.u[1]));
                    prop_assert!((found - h).abs() <= close, "{umbra:?} {vertices:?}");
                }
                for edge in [Edge::Flat, Edge::Sloped] {
                    let Some(lower) = scene.umbra(edge) else { continue };
                    prop_assert!(lower.peak.is_none());
                    prop_assert!(lower.u[0] >= umbra.u[0] && lower.u[1] <= umbra.u[1]);
                    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                        let u = (lower.u[0] + share * (lower.u[1] - lower.u[0])).min(lower.u[1]);
                        prop_assert!(lower.height(u) <= umbra.height(u) + close);
                    }
                }
            }
        }
    }

    /// P6: what is hidden from a cell is hidden from each part of it.
    #[test]
    fn smaller_cells_have_larger_umbrae(
        scene in scene(0), shares in prop::array::uniform6(0.0..=1.0_f64),
    ) {
        let part = |[low, high]: [f64; 2], a: f64, b: f64| {
            let at = |share: f64| (low + share * (high - low)).clamp(low, high);
            [at(a.min(b)), at(a.max(b))]
        };
        let Cuboid { u, w, h } = scene.cell;
        let [a, b, c, d, e, f] = shares;
        let small = Cuboid { u: part(u, a, b), w: part(w, c, d), h: part(h, e, f) };
        let Some(large) = scene.umbra(Edge::Flat) else { return Ok(()) };
        let small = Scene { cell: small, ..scene }.umbra(Edge::Flat).unwrap();
        let slack = 1e-12 * scene.size * scene.magnification();
        prop_assert!(small.u[0] <= large.u[0] + slack && small.u[1] >= large.u[1] - slack);
        prop_assert!(small.top[0] >= large.top[0] - slack, "{small:?} {large:?}");
        prop_assert!(small.foot <= large.foot + slack, "{small:?} {large:?}");
    }
}

/// The steepest part of an edge.
fn steepness(umbra: &Umbra) -> f64 {
    let rise = |[a, b]: &[[f64; 2]; 2]| ((b[1] - a[1]) / (b[0] - a[0])).abs();
    umbra.vertices().array_windows().map(rise).fold(0.0, f64::max)
}

/// A cell before a house, seen on the house's far face.
const STREET: Scene = Scene {
    cell: Cuboid { u: [0.0, 10.0], w: [-2.0, 0.0], h: [0.0, 6.0] },
    occluder: Cuboid { u: [2.0, 30.0], w: [12.0, 22.0], h: [f64::NEG_INFINITY, 9.0] },
    plane: 30.0,
    size: 32.0,
};

/// Negative controls: each of these is no umbra, and trying finds that out.
#[test]
fn faulty_umbrae_are_found_out() {
    assert_eq!(STREET.seen_within(&STREET.umbra(Edge::Flat).unwrap()), None);
    // The union of the corners' shadows rather than what they have in common.
    let points = region_horizon_support::corners(&STREET.cell).map(|[u, w, h]| {
        let cell = Cuboid { u: [u; 2], w: [w; 2], h: [h; 2] };
        Scene { cell, ..STREET }.umbra(Edge::Flat).unwrap()
    });
    let union = points.into_iter().reduce(|a, b| Umbra {
        u: [a.u[0].min(b.u[0]), a.u[1].max(b.u[1])],
        top: [a.top[0].max(b.top[0]); 2],
        ..a
    });
    assert!(STREET.seen_within(&union.unwrap()).is_some());
    // The height seen from the cell's foot.
    let Cuboid { h, .. } = STREET.cell;
    let low = Scene { cell: Cuboid { h: [h[0]; 2], ..STREET.cell }, ..STREET };
    assert!(STREET.seen_within(&low.umbra(Edge::Flat).unwrap()).is_some());
    // The depth of the cell left out.
    let flat = Scene { cell: Cuboid { w: [0.0; 2], ..STREET.cell }, ..STREET };
    assert!(STREET.seen_within(&flat.umbra(Edge::Flat).unwrap()).is_some());
    // A straight line from end to end of a hull's peak and beyond it.
    let hull = STREET.umbra(Edge::Hull).unwrap();
    let level = Umbra { top: [hull.highest(); 2], peak: None, ..hull };
    assert!(hull.peak.is_some());
    assert!(STREET.seen_within(&level).is_some());
}

/// H4.2: the farther the occluder, the less of its shadow is lost to a single edge; and to a level one.
#[test]
fn single_edges_lose_less_of_what_is_far() {
    let lost = |edge: Edge, distance: f64| {
        let w = [distance, distance + 10.0];
        let occluder = Cuboid { w, u: [-4.0, 14.0], h: [f64::NEG_INFINITY, 9.0] };
        let narrow = Cuboid { u: [2.0, 30.0], ..occluder };
        [occluder, narrow].map(|occluder| {
            let scene = Scene { occluder, plane: w[1] + 5.0, ..STREET };
            let area = |edge: Edge| {
                let vertices = scene.umbra(edge).unwrap().vertices();
                let strip = |[a, b]: &[[f64; 2]; 2]| 0.5 * (a[1] + b[1]) * (b[0] - a[0]);
                vertices.array_windows().map(strip).sum::<f64>()
            };
            1.0 - area(edge) / area(Edge::Hull)
        })
    };
    for edge in [Edge::Flat, Edge::Sloped] {
        let all: Vec<[f64; 2]> =
            [3.0, 6.0, 12.0, 24.0, 48.0, 96.0].map(|distance| lost(edge, distance)).into();
        for [near, far] in all.array_windows() {
            assert!(far[1] < near[1] && far[0] <= near[0], "{edge:?} {all:?}");
        }
        assert!(all[0][1] > 0.1 && all[5][1] < 0.05, "{edge:?} {all:?}");
    }
}

/// Where heights lie on both sides of the occluder's top, the union over all points would have the
/// sides of both classes: the top of the cell decides, and leaves three.
#[test]
fn both_classes_of_height_together_have_four_edges() {
    let cell = Cuboid { u: [0.0, 10.0], w: [0.0, 1.0], h: [0.0, 9.0] };
    let occluder = Cuboid { u: [4.0, 6.0], w: [5.0, 8.0], h: [f64::NEG_INFINITY, 5.0] };
    let low = Cuboid { h: [0.0, 4.0], ..cell };
    let mut all = union_of_edges(&cell, &occluder);
    assert_eq!(all.len(), 3);
    all.extend(union_of_edges(&low, &occluder));
    let is_same = |a: &[_; 2], b: &[_; 2]| a == b || a == &[b[1], b[0]];
    let mut distinct: Vec<_> = Vec::new();
    for edge in all {
        if !distinct.iter().any(|other| is_same(other, &edge)) {
            distinct.push(edge);
        }
    }
    assert_eq!(distinct.len(), 4);
}
