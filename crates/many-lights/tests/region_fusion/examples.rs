//! What the thesis's figures and sentences say, in numbers.

use dapple_many_lights::region::fusion::{Horizon, Verdict, reference::Shadow};
use dapple_many_lights::region::horizon::{Projection, Umbra, umbra};
use dapple_many_lights::region::{Cuboid, Edge, Fusion};

const LOW: f64 = f64::NEG_INFINITY;

fn flat(u: [f64; 2], top: f64) -> Umbra {
    Umbra::flat(u, LOW, top)
}

fn leaf(umbra: Umbra) -> Shadow {
    Shadow { umbra, children: Vec::new() }
}

fn verdict(horizon: &Horizon, u: [f64; 2], h: [f64; 2]) -> Verdict {
    horizon.test(&Projection { u, h }, &mut 0)
}

/// Figure 4.8: two that overlap, then one that overlaps their group and one that does not.
#[test]
fn groups_are_as_low_as_their_lowest() {
    let mut horizon = Horizon::new(Fusion::Insertion);
    let [a, b, c, d] = [
        flat([0.0, 4.0], 8.0),
        flat([3.0, 6.0], 5.0),
        flat([6.0, 9.0], 3.0),
        flat([20.0, 22.0], 6.0),
    ];
    horizon.add(&[a, b]);
    // The lower one adds nothing to the group.
    let group = Shadow { umbra: flat([0.0, 6.0], 5.0), children: vec![leaf(a)] };
    assert_eq!(horizon.roots(), std::slice::from_ref(&group));
    horizon.add(&[c, d]);
    let above = Shadow { umbra: flat([0.0, 9.0], 3.0), children: vec![group] };
    assert_eq!(horizon.roots(), [above, leaf(d)]);
    assert_eq!(verdict(&horizon, [1.0, 8.5], [0.0, 3.0]), Verdict::Hidden);
    assert_eq!(verdict(&horizon, [1.0, 5.5], [0.0, 5.0]), Verdict::Hidden);
    assert_eq!(verdict(&horizon, [1.0, 5.5], [0.0, 5.1]), Verdict::Partial);
    assert_eq!(verdict(&horizon, [1.0, 3.5], [0.0, 8.0]), Verdict::Hidden);
    assert_eq!(verdict(&horizon, [20.0, 22.0], [0.0, 6.0]), Verdict::Hidden);
    assert_eq!(verdict(&horizon, [8.0, 21.0], [0.0, 1.0]), Verdict::Partial);
    assert_eq!(verdict(&horizon, [9.5, 19.5], [0.0, 1.0]), Verdict::Free);
    assert_eq!(verdict(&horizon, [0.0, 30.0], [8.1, 9.0]), Verdict::Free);
}

/// Two tall walls that touch, and a low one that comes between them in order.
#[test]
fn the_tallest_first_keeps_what_the_order_of_arrival_loses() {
    let walls = [flat([0.0, 4.0], 9.0), flat([3.0, 5.0], 2.0), flat([4.0, 8.0], 9.0)];
    let hides = |fusion| {
        let mut horizon = Horizon::new(fusion);
        walls.iter().for_each(|wall| horizon.add(&[*wall]));
        verdict(&horizon, [1.0, 7.0], [0.0, 8.0]) == Verdict::Hidden
    };
    assert_eq!(
        [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered].map(hides),
        [false, false, true]
    );
}

/// H4.4, Figure 4.9: a wall of width o, D before a cell of width v, hides nothing from D v / (v - o)
/// on. Two that touch, each narrower than the cell, hide together for as long as one twice as wide.
#[test]
fn a_group_outlives_its_members() {
    let (v, o, distance) = (15.0, 10.0, 20.0);
    let cell = Cuboid { u: [-0.5 * v, 0.5 * v], w: [0.0, 0.0], h: [0.0, 3.0] };
    let wall = |u: [f64; 2], top: f64| {
        let wall = Cuboid { u, w: [distance; 2], h: [LOW, top] };
        umbra(&cell, &wall, distance, Edge::Flat).unwrap()
    };
    let shadows = [wall([-o, 0.0], 9.0), wall([0.0, o], 7.0)];
    let end = distance * v / (v - o);
    for fusion in [Fusion::Insertion, Fusion::HeightOrdered] {
        for (by, left) in [(1.0 - 1e-6, 2), (1.0 + 1e-6, 1)] {
            let mut horizon = Horizon::new(fusion);
            horizon.add(&shadows);
            assert_eq!(horizon.reproject(&cell, distance, end * by), left, "{fusion:?}");
        }
        let mut horizon = Horizon::new(fusion);
        horizon.add(&shadows);
        // As wide as the two together, at any distance; in steps as at once.
        for (from, to) in [(distance, 50.0), (50.0, 61.0), (61.0, 1e4)] {
            horizon.reproject(&cell, from, to);
        }
        let both = Cuboid { u: [-o, o], w: [distance; 2], h: [LOW, 7.0] };
        let direct = umbra(&cell, &both, 1e4, Edge::Flat).unwrap();
        let nodes: Vec<Umbra> = horizon.nodes().collect();
        assert_eq!(nodes.len(), 1);
        assert!((nodes[0].u[0] - direct.u[0]).abs() < 1e-9 * direct.u[0].abs());
        assert!((nodes[0].top[0] - direct.top[0]).abs() < 1e-9 * direct.top[0].abs());
        // What joins it takes nothing from it.
        horizon.add(&[flat([0.0, 1.0], 1e6)]);
        assert_eq!(verdict(&horizon, direct.u.map(|u| 0.99 * u), [0.0, 7.0]), Verdict::Hidden);
    }
    let mut horizon = Horizon::new(Fusion::None);
    horizon.add(&shadows);
    assert_eq!(horizon.reproject(&cell, distance, end * (1.0 + 1e-6)), 0);
    assert!(horizon.is_empty());
}

/// What is low collapses in height before what is tall: its group goes, the tall one stays.
#[test]
fn a_group_that_collapses_in_height_leaves_its_tall_members() {
    let cell = Cuboid { u: [0.0, 2.0], w: [0.0, 0.0], h: [0.0, 21.0] };
    let shadows = [Umbra::flat([-9.0, 5.0], 0.0, 30.0), Umbra::flat([4.0, 9.0], 0.0, 6.0)];
    for fusion in [Fusion::Insertion, Fusion::HeightOrdered] {
        let mut horizon = Horizon::new(fusion);
        horizon.add(&shadows);
        assert_eq!(horizon.len(), 2);
        assert_eq!(verdict(&horizon, [0.0, 8.0], [0.0, 5.0]), Verdict::Hidden);
        assert_eq!(horizon.reproject(&cell, 10.0, 20.0), 1);
        let tall = horizon.nodes().next().unwrap();
        assert!(tall.top[0] > 35.0 && tall.u[1] < 9.0, "{tall:?}");
        assert_eq!(verdict(&horizon, [0.0, 7.0], [0.0, 30.0]), Verdict::Hidden);
    }
}

/// Feet above the tops of neighbours: nothing hides over both, each hides on its own.
#[test]
fn shadows_at_different_heights_stay_beside_each_other() {
    for fusion in [Fusion::Insertion, Fusion::HeightOrdered] {
        let mut horizon = Horizon::new(fusion);
        let (high, low) = (Umbra::flat([0.0, 6.0], 10.0, 15.0), Umbra::flat([4.0, 9.0], 0.0, 8.0));
        horizon.add(&[high, low]);
        assert_eq!(horizon.roots(), [leaf(high), leaf(low)]);
        assert_eq!(verdict(&horizon, [1.0, 2.0], [11.0, 12.0]), Verdict::Hidden);
        assert_eq!(verdict(&horizon, [7.0, 8.0], [1.0, 2.0]), Verdict::Hidden);
        assert_eq!(verdict(&horizon, [1.0, 2.0], [1.0, 2.0]), Verdict::Free);
        assert_eq!(verdict(&horizon, [1.0, 8.0], [1.0, 12.0]), Verdict::Partial);
        // A third joins the one that it can be joined with.
        horizon.add(&[Umbra::flat([8.5, 12.0], 1.0, 7.0)]);
        assert_eq!(verdict(&horizon, [5.0, 11.0], [2.0, 6.0]), Verdict::Hidden);
        assert_eq!(verdict(&horizon, [1.0, 2.0], [11.0, 12.0]), Verdict::Hidden);
    }
}

#[test]
fn what_is_empty_or_no_number_hides_nothing() {
    let nan = f64::NAN;
    let wrong = [
        flat([1.0, 1.0], 5.0),
        flat([2.0, 1.0], 5.0),
        Umbra::flat([0.0, 1.0], 5.0, 5.0),
        flat([nan, 1.0], 5.0),
        flat([0.0, nan], 5.0),
        flat([0.0, 1.0], nan),
        Umbra::flat([0.0, 1.0], nan, 5.0),
        Umbra { top: [5.0, f64::INFINITY], ..flat([0.0, 1.0], 5.0) },
    ];
    let cell = Cuboid { u: [0.0, 1.0], w: [0.0, 1.0], h: [0.0, 1.0] };
    for fusion in [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered] {
        let mut horizon = Horizon::new(fusion);
        horizon.add(&wrong);
        horizon.add(&[]);
        assert!(horizon.is_empty() && horizon.roots().is_empty());
        assert_eq!(verdict(&horizon, [0.2, 0.3], [1.0, 2.0]), Verdict::Free);
        horizon.add(&[flat([0.0, 1.0], 5.0)]);
        for p in [[nan, 0.5], [0.5, nan], [nan, nan]] {
            assert_ne!(verdict(&horizon, p, [1.0, 2.0]), Verdict::Hidden);
            assert_ne!(verdict(&horizon, [0.4, 0.5], p), Verdict::Hidden);
        }
        for to in [nan, f64::INFINITY, 0.5] {
            let mut moved = horizon.clone();
            assert_eq!(moved.reproject(&cell, 10.0, to), 0, "{to}");
            assert!(moved.is_empty());
        }
    }
}
