//! Any sequence of shadows, moves and questions: the fast form is the clear form.

use crate::structure::{Roots, broken};
use dapple_many_lights::region::fusion::{Horizon, Verdict, reference};
use dapple_many_lights::region::horizon::{Peak, Projection, Umbra};
use dapple_many_lights::region::{Cuboid, Fusion};
use proptest::prelude::*;

pub const FUSIONS: [Fusion; 3] = [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered];

/// What happens to a horizon.
#[derive(Clone, Debug)]
enum Event {
    Add(Vec<Umbra>),
    /// Times so far away as the last plane.
    Move(f64),
    Test(Vec<Projection>),
}

/// Numbers that often coincide.
fn number(low: i32, high: i32) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![3 => (low..=high).prop_map(f64::from), 1 => f64::from(low)..=f64::from(high)]
}

fn interval(low: i32, high: i32) -> impl Strategy<Value = [f64; 2]> + Clone {
    (number(low, high), number(low, high)).prop_map(|(a, b)| [a.min(b), a.max(b)])
}

/// Shadows, empty ones too; with feet and edges that are not level, if asked for.
fn shadow(is_plain: bool) -> impl Strategy<Value = Umbra> {
    let u = prop_oneof![
        (-20..20_i32, 1..6_i32).prop_map(|(u, width)| [f64::from(u), f64::from(u + width)]),
        interval(-20, 20),
    ];
    let foot = prop_oneof![2 => Just(f64::NEG_INFINITY), 2 => number(-2, 6)];
    let form = 0..4;
    (u, foot, [number(0, 12), number(0, 12), number(0, 3)], form).prop_map(
        move |(u, foot, [a, b, more], form)| match form {
            _ if is_plain => Umbra::flat(u, f64::NEG_INFINITY, a),
            0 | 1 => Umbra::flat(u, foot, a),
            2 => Umbra { top: [a, b], ..Umbra::flat(u, foot, a) },
            _ => {
                let (middle, h) = (0.5 * (u[0] + u[1]), a.max(b) + more);
                let peak = Some(Peak { u: [middle, middle], h }).filter(|_| more > 0.0);
                Umbra { top: [a, b], peak, ..Umbra::flat(u, foot, a) }
            }
        },
    )
}

fn events(is_plain: bool) -> impl Strategy<Value = Vec<Event>> {
    let projections = (interval(-25, 25), interval(-3, 14), 0..4_u8);
    let projections = projections.prop_map(|(u, h, size)| match size {
        0 => Projection { u: [u[0]; 2], h: [h[1]; 2] },
        1 => Projection { u: [u[0], u[0] + 0.1 * (u[1] - u[0])], h: [h[1], h[1] + 0.5] },
        _ => Projection { u, h },
    });
    let event = prop_oneof![
        3 => prop::collection::vec(shadow(is_plain), 0..9).prop_map(Event::Add),
        2 => prop_oneof![Just(1.0), 1.0..1.3_f64].prop_map(Event::Move),
        3 => prop::collection::vec(projections, 1..20).prop_map(Event::Test),
    ];
    prop::collection::vec(event, 1..16)
}

fn cell() -> impl Strategy<Value = Cuboid> {
    (interval(-4, 4), interval(0, 3), interval(0, 8)).prop_map(|(u, w, h)| Cuboid { u, w, h })
}

/// All shadows in an order of their own.
fn sorted(nodes: impl Iterator<Item = Umbra>) -> Vec<String> {
    let mut nodes: Vec<String> = nodes.map(|umbra| format!("{umbra:?}")).collect();
    nodes.sort();
    nodes
}

fn checked(
    fusion: Fusion,
    cell: &Cuboid,
    events: &[Event],
    is_plain: bool,
) -> Result<[u64; 4], TestCaseError> {
    let (mut fast, mut clear) = (Horizon::new(fusion), reference::Horizon::new(fusion));
    let (mut plane, mut added, mut moved, mut verdicts) = (10.0, 0, false, [0; 4]);
    for event in events {
        match event {
            Event::Add(shadows) => {
                fast.add(shadows);
                clear.add(shadows);
                added += shadows.len();
            }
            Event::Move(by) => {
                let to = plane * by;
                let left = fast.reproject(cell, plane, to);
                prop_assert_eq!(left, clear.reproject(cell, plane, to));
                plane = to;
            }
            Event::Test(projections) => {
                for p in projections {
                    let (mut few, mut all) = (0, 0);
                    let verdict = fast.test(p, &mut few);
                    prop_assert_eq!(verdict, clear.test(p, &mut all), "{:?}", p);
                    prop_assert!(few <= all);
                    prop_assert_eq!(all, fast.len() as u64);
                    verdicts[verdict as usize] += 1;
                }
            }
        }
        prop_assert_eq!(sorted(fast.nodes()), sorted(clear.nodes().into_iter()), "{:?}", event);
        prop_assert_eq!(fast.is_empty(), clear.is_empty());
        // Where feet let a parent collapse, its children may meet others that they were kept from.
        moved |= matches!(event, Event::Move(_));
        let roots = match (fusion, moved) {
            (Fusion::None, _) => Roots::Single,
            (_, false) => Roots::Joined,
            (_, true) if is_plain => Roots::JoinedAndMoved,
            (_, true) => Roots::Moved,
        };
        let trees = fast.roots();
        prop_assert_eq!(broken(&trees, roots), None);
        // No memory is taken by what lies in others.
        let most = match fusion {
            Fusion::None => added,
            Fusion::HeightOrdered if is_plain => added,
            Fusion::HeightOrdered => usize::MAX,
            Fusion::Insertion => 2 * added,
        };
        prop_assert!(fast.len() <= most, "{} of {} shadows", fast.len(), added);
        verdicts[3] = verdicts[3].max(trees.iter().map(depth).max().unwrap_or(0));
    }
    Ok(verdicts)
}

fn depth(shadow: &reference::Shadow) -> u64 {
    1 + shadow.children.iter().map(depth).max().unwrap_or(0)
}

fn cases(count: u32) -> ProptestConfig {
    ProptestConfig { cases: count, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn the_fast_form_is_the_clear_form(cell in cell(), events in events(false)) {
        for fusion in FUSIONS {
            checked(fusion, &cell, &events, false)?;
        }
    }

    #[test]
    fn so_it_is_for_shadows_of_the_thesis(cell in cell(), events in events(true)) {
        for fusion in FUSIONS {
            checked(fusion, &cell, &events, true)?;
        }
    }
}

#[test]
fn streams_meet_every_verdict_and_deep_trees() {
    use proptest::{strategy::ValueTree, test_runner::TestRunner};
    let mut runner = TestRunner::deterministic();
    let mut sum = [0; 4];
    for _ in 0..300 {
        let (cell, events) = (cell(), events(false)).new_tree(&mut runner).unwrap().current();
        let found = checked(Fusion::HeightOrdered, &cell, &events, false).unwrap();
        (0..3).for_each(|i| sum[i] += found[i]);
        sum[3] = sum[3].max(found[3]);
    }
    let [hidden, partial, free, deepest] = sum;
    assert!(hidden > 500 && partial > 500 && free > 500 && deepest > 4, "{sum:?}");
    assert_eq!(Verdict::Free as usize, 2);
}

#[test]
fn nothing_more_is_taken_from_memory_once_warm() {
    use proptest::{strategy::ValueTree, test_runner::TestRunner};
    let mut runner = TestRunner::deterministic();
    let shadows = prop::collection::vec(shadow(false), 200).new_tree(&mut runner).unwrap();
    let shadows = shadows.current();
    let cell = Cuboid { u: [0.0, 1.0], w: [0.0, 1.0], h: [0.0, 3.0] };
    for fusion in FUSIONS {
        let mut horizon = Horizon::new(fusion);
        let mut run = || {
            horizon.clear();
            for (n, some) in shadows.chunks(20).enumerate() {
                horizon.add(some);
                horizon.reproject(&cell, 10.0 + n as f64, 11.0 + n as f64);
            }
            assert!(!horizon.is_empty());
            horizon.bytes()
        };
        let first = run();
        // The two lists that take turns have both grown after the second.
        let second = run();
        assert!(first > 0 && second < 500_000, "{first} {second}");
        assert_eq!(run(), second, "{fusion:?}");
        assert_eq!(run(), second, "{fusion:?}");
    }
}
