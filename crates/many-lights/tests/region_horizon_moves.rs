//! Umbrae moved from plane to plane, projections of what they hide, and the same in other spaces.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod region_horizon_support;

use dapple_many_lights::region::{
    Cuboid, Direction, Edge,
    horizon::{SLACK, Umbra, project, reproject, umbra},
};
use glam::DVec3;
use proptest::prelude::*;
use region_horizon_support::{
    EDGES, Scene, cell, config, corners, interval, meets, mirrored, occluder, scaled, scene,
};

/// Whether two umbrae agree to a share of the greater coordinates. Edges that are steep agree in
/// places, not in heights.
fn agree(a: &Umbra, b: &Umbra, share: f64) -> bool {
    let size = [a, b]
        .into_iter()
        .flat_map(|x| x.u.into_iter().chain([x.lowest(), x.highest(), 1.0]))
        .fold(0.0, |size: f64, x| size.max(x.abs()));
    let close = |a: f64, b: f64| a == b || (a - b).abs() <= share * size;
    let steep = |x: &Umbra| {
        x.vertices().array_windows().any(|[p, q]| (q[1] - p[1]).abs() > 1e3 * (q[0] - p[0]))
    };
    let edges = (0..=8).all(|i| {
        let at = |x: &Umbra| {
            let u = x.u[0] + f64::from(i) / 8.0 * (x.u[1] - x.u[0]);
            x.height(u.min(x.u[1]))
        };
        close(at(a), at(b))
    });
    close(a.u[0], b.u[0])
        && close(a.u[1], b.u[1])
        && close(a.foot, b.foot)
        && (edges || steep(a) || steep(b))
}

/// Whether an umbra is so small that rounding decides if it is there.
fn is_sliver(umbra: &Umbra, size: f64) -> bool {
    umbra.u[1] - umbra.u[0] < 1e-6 * size || umbra.highest() - umbra.foot < 1e-6 * size
}

proptest! {
    #![proptest_config(config())]

    /// P4: level shadows and hulls of single occluders lose nothing on their way, in one step or in
    /// two; sloped ones gain nothing.
    #[test]
    fn moving_a_shadow_is_projecting_the_occluder_again(
        scene in scene(4), first in 0.0..10.0_f64, second in 0.0..10.0_f64,
    ) {
        prop_assume!(scene.occluder.w[0] > scene.cell.w[1]);
        let Scene { cell, occluder, plane: p, .. } = scene;
        let (q, s) = (p + first, p + first + second);
        let share = 1e-9 * scene.magnification();
        for edge in EDGES {
            let on = |plane| umbra(&cell, &occluder, plane, edge);
            let once = on(p).and_then(|x| reproject(&cell, &x, p, s));
            let twice = on(p)
                .and_then(|x| reproject(&cell, &x, p, q))
                .and_then(|x| reproject(&cell, &x, q, s));
            match (on(s), once, twice) {
                (Some(direct), Some(once), Some(twice)) if edge != Edge::Sloped => {
                    let foot = direct.foot > cell.h[0] || direct.foot == f64::NEG_INFINITY;
                    prop_assert!(agree(&once, &twice, share), "{once:?} {twice:?}");
                    if foot || edge == Edge::Flat {
                        prop_assert!(agree(&direct, &once, share), "{direct:?} {once:?}");
                    }
                }
                (direct, once, _) if edge == Edge::Sloped => {
                    let Some(once) = once else { continue };
                    let direct = direct.unwrap();
                    let slack = share * scene.size;
                    prop_assert!(once.u[0] >= direct.u[0] - slack);
                    prop_assert!(once.u[1] <= direct.u[1] + slack);
                }
                (direct, once, twice) => {
                    for left in [direct, once, twice].into_iter().flatten() {
                        prop_assert!(is_sliver(&left, scene.size), "{edge:?} {left:?}");
                    }
                }
            }
        }
    }

    /// Wherever it was moved, an umbra holds only what is hidden.
    #[test]
    fn all_of_a_moved_umbra_is_hidden(
        scene in scene(0), steps in prop::collection::vec(0.0..5.0_f64, 1..6), power in -4_i32..=6,
    ) {
        let by = 10_f64.powi(power) / 32.0;
        let mut scene = scene.scaled(by);
        for edge in EDGES {
            let mut umbra = scene.umbra(edge);
            for step in &steps {
                let to = scene.plane + step * by;
                umbra = umbra.and_then(|x| reproject(&scene.cell, &x, scene.plane, to));
                scene.plane = to;
                if let Some(umbra) = umbra {
                    let seen = scene.seen_within(&umbra);
                    prop_assert!(seen.is_none(), "{edge:?}: {umbra:?} at {seen:?}");
                }
            }
        }
    }

    /// A projection holds every crossing, and is no larger than it has to be.
    #[test]
    fn projections_hold_every_crossing(
        cell in cell(), u in interval(-5, 12), w in interval(4, 12), h in interval(0, 12),
        share in 0.0..=1.0_f64, power in -4_i32..=6,
    ) {
        let by = 10_f64.powi(power);
        let (cell, light) = (scaled(&cell, by), scaled(&Cuboid { u, w, h }, by));
        let plane = (cell.w[1] + share * (light.w[0] - cell.w[1])).min(light.w[0]);
        let found = project(&cell, &light, plane);
        let mut around = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for from in corners(&cell) {
            for to in corners(&light) {
                let at = if to[1] > from[1] { (plane - from[1]) / (to[1] - from[1]) } else { 1.0 };
                for (side, axis) in [(0, 0), (1, 2)] {
                    let x = from[axis] + at * (to[axis] - from[axis]);
                    around[side] = [around[side][0].min(x), around[side][1].max(x)];
                }
            }
        }
        let slack = 3.0 * SLACK * 24.0 * by;
        for (side, around) in [found.u, found.h].into_iter().zip(around) {
            prop_assert!(side[0] <= around[0] && side[0] >= around[0] - slack);
            prop_assert!(side[1] >= around[1] && side[1] <= around[1] + slack);
        }
    }

    /// What is hidden by its projection is hidden from every corner at every corner.
    #[test]
    fn what_an_umbra_hides_is_hidden(
        scene in scene(0), behind in 0.0..10.0_f64, u in 0.0..=1.0_f64, h in 0.0..=1.0_f64,
        width in prop::sample::select(vec![0.0, 0.1, 1.0]),
    ) {
        for edge in EDGES {
            let Some(umbra) = scene.umbra(edge) else { continue };
            let foot = umbra.foot.max(umbra.highest() - 10.0);
            let u = umbra.u[0] + u * (umbra.u[1] - umbra.u[0]);
            let h = foot + h * (umbra.highest() - foot);
            let w = scene.plane + behind;
            let light = Cuboid { u: [u, u + width], w: [w, w + width], h: [h, h + width] };
            if umbra.hides(&project(&scene.cell, &light, scene.plane)) {
                for to in corners(&light) {
                    for from in corners(&scene.cell) {
                        prop_assert!(meets(from, to, &scene.occluder, 1e-10 * scene.size));
                    }
                }
            }
        }
    }

    /// P9: the mirror, powers of two and quarter turns change nothing at all.
    #[test]
    fn other_spaces_give_the_same_umbrae(scene in scene(0), power in -12_i32..=12) {
        let by = 2_f64.powi(power);
        for edge in EDGES {
            let here = scene.umbra(edge);
            let mirror = |x: Umbra| Umbra {
                u: [-x.u[1], -x.u[0]],
                top: [x.top[1], x.top[0]],
                peak: x.peak.map(|mut peak| {
                    peak.u = [-peak.u[1], -peak.u[0]];
                    peak
                }),
                ..x
            };
            let there = umbra(&mirrored(&scene.cell), &mirrored(&scene.occluder), scene.plane, edge);
            if edge == Edge::Flat {
                prop_assert_eq!(there.map(mirror), here);
            } else if let (Some(here), Some(there)) = (here, there.map(mirror)) {
                prop_assert!(agree(&here, &there, 1e-12 * scene.magnification()));
            }
            let there = scene.scaled(by).umbra(edge);
            let small = |x: Umbra| Umbra {
                u: x.u.map(|u| u / by),
                top: x.top.map(|h| h / by),
                foot: x.foot / by,
                peak: x.peak.map(|mut peak| {
                    peak.u = peak.u.map(|u| u / by);
                    peak.h /= by;
                    peak
                }),
            };
            prop_assert_eq!(there.map(small), here);
        }
        // Turned boxes by the quarter, each seen along the direction that w has become.
        let (low, high) = (|c: &Cuboid| DVec3::new(c.u[0], c.h[0], c.w[0]), |c: &Cuboid| {
            DVec3::new(c.u[1], c.h[1], c.w[1])
        });
        for direction in Direction::ALL {
            let seen = |c: &Cuboid| {
                let [a, b] = [low(c), high(c)].map(|v| direction.turned(v.x, v.z, v.y));
                direction.cuboid(a.min(b), a.max(b))
            };
            prop_assert_eq!(seen(&scene.cell), scene.cell);
            prop_assert_eq!(seen(&scene.occluder), scene.occluder);
        }
    }

    /// Far from the origin the same scene loses no more than rounding takes, and gains nothing, over
    /// many planes.
    #[test]
    fn far_from_the_origin_umbrae_only_shrink(
        scene in scene(4), steps in prop::collection::vec(0_u32..8, 1..30),
    ) {
        // Numbers that stay exact when they are moved by 2^20.
        let exact = |x: f64| (x * 1024.0).round() / 1024.0;
        let tidy = |c: &Cuboid, by: f64| {
            let side = |side: [f64; 2]| side.map(|x| exact(x) + by);
            Cuboid { u: side(c.u), w: c.w.map(exact), h: side(c.h) }
        };
        let by = f64::from(1 << 20);
        let follow = |by: f64| {
            let (cell, occluder) = (tidy(&scene.cell, by), tidy(&scene.occluder, by));
            let mut plane = exact(scene.plane).max(occluder.w[1]);
            let mut all = vec![umbra(&cell, &occluder, plane, Edge::Flat)];
            for step in &steps {
                let to = plane + f64::from(*step);
                let last = all[all.len() - 1];
                all.push(last.and_then(|x| reproject(&cell, &x, plane, to)));
                plane = to;
            }
            all
        };
        for (near, far) in follow(0.0).into_iter().zip(follow(by)) {
            let Some(far) = far else { continue };
            let near = near.unwrap();
            let slack = 1e-12 * scene.size * scene.magnification();
            prop_assert!(far.u[0] - by >= near.u[0] - slack && far.u[1] - by <= near.u[1] + slack);
            prop_assert!(far.top[0] - by <= near.top[0] + slack);
            prop_assert!(far.foot - by >= near.foot - slack);
        }
    }

    /// Walls that touch have shadows that touch on the plane of their far faces, at any scale, and
    /// between them nothing is seen there.
    #[test]
    fn shadows_of_touching_walls_touch(
        cell in cell(), left in occluder(0), width in 0.1..5.0_f64, power in -4_i32..=6,
    ) {
        let by = 10_f64.powi(power) / 3.0;
        let cell = scaled(&cell, by);
        let left = scaled(&left, by);
        let right = Cuboid { u: [left.u[1], left.u[1] + width * by], ..left };
        for edge in EDGES {
            let on = |c: &Cuboid| umbra(&cell, c, left.w[1], edge);
            if let (Some(left), Some(right)) = (on(&left), on(&right)) {
                prop_assert!(right.u[0] <= left.u[1], "{left:?} {right:?}");
            }
        }
    }
}

#[test]
fn sloped_edges_lose_on_their_way_and_hulls_do_not() {
    let cell = Cuboid { u: [0.0, 10.0], w: [-2.0, 0.0], h: [0.0, 6.0] };
    let occluder = Cuboid { u: [2.0, 30.0], w: [12.0, 22.0], h: [0.0, 9.0] };
    let at = |edge| {
        let direct = umbra(&cell, &occluder, 60.0, edge).unwrap();
        let start = umbra(&cell, &occluder, 22.0, edge).unwrap();
        (direct, reproject(&cell, &start, 22.0, 60.0).unwrap())
    };
    let (direct, moved) = at(Edge::Sloped);
    assert!(moved.top[0] + moved.top[1] < direct.top[0] + direct.top[1] - 0.1);
    for edge in [Edge::Flat, Edge::Hull] {
        let (direct, moved) = at(edge);
        assert!(agree(&direct, &moved, 1e-12), "{direct:?} {moved:?}");
    }
    assert!(at(Edge::Hull).1.peak.is_some());
}

/// Row 22: behind a wall of width o at distance D, the shadow ends at D v / (v - o) for a flat cell of
/// width v.
#[test]
fn shadows_of_narrow_walls_end_where_they_have_to() {
    for (distance, width, cell_width) in [(10.0, 4.0, 5.0), (3.0, 0.5, 20.0), (1e3, 7.0, 7.5)] {
        let cell = Cuboid { u: [-0.5 * cell_width, 0.5 * cell_width], w: [0.0; 2], h: [0.0; 2] };
        let wall = Cuboid {
            u: [-0.5 * width, 0.5 * width],
            w: [distance; 2],
            h: [f64::NEG_INFINITY, 5.0],
        };
        let expected = distance * cell_width / (cell_width - width);
        let start = umbra(&cell, &wall, distance, Edge::Flat).unwrap();
        let is_there = |plane: f64| {
            let moved = reproject(&cell, &start, distance, plane).is_some();
            assert_eq!(umbra(&cell, &wall, plane, Edge::Flat).is_some(), moved);
            moved
        };
        assert!(is_there(expected * (1.0 - 1e-6)));
        assert!(!is_there(expected * (1.0 + 1e-6)));
    }
}

/// What lies exactly on the border of an umbra is visible.
#[test]
fn ties_are_visible() {
    let cell = Cuboid { u: [0.0; 2], w: [0.0; 2], h: [2.0; 2] };
    let wall = Cuboid { u: [0.0, 5.0], w: [4.0; 2], h: [f64::NEG_INFINITY, 2.0] };
    let shadow = umbra(&cell, &wall, 4.0, Edge::Flat).unwrap();
    let light = |u: f64, h: f64| Cuboid { u: [u; 2], w: [8.0; 2], h: [h; 2] };
    let hides = |light: Cuboid| shadow.hides(&project(&cell, &light, 4.0));
    assert!(hides(light(1.0, 1.0)) && hides(light(1e-9, 2.0 - 1e-9)));
    assert!(!hides(light(0.0, 1.0)) && !hides(light(10.0, 1.0)) && !hides(light(1.0, 2.0)));
}
