//! The search against random truths, and the axes that it must survive.

use super::*;
use proptest::prelude::*;

/// Probes until nothing is wanted; `truth` says where it is safe.
fn search(
    values: Values,
    home: f64,
    refine: u32,
    mut known: Vec<Known>,
    truth: impl Fn(f64) -> Option<bool>,
) -> Vec<Known> {
    let most = most_points(values, home, refine);
    while let Some(value) = next(values, home, &known, refine) {
        assert!(known.len() < most, "more than {most} points");
        assert!(known.iter().all(|k| k.value != value), "{value} twice");
        known.push(Known { value, safe: truth(value) });
    }
    known
}

fn sorted(mut known: Vec<Known>) -> Vec<Known> {
    known.sort_by(|a, b| a.value.total_cmp(&b.value));
    known
}

fn values(log: bool, least: f64, width: f64, steps: u32) -> Values {
    if log {
        let least = 10_f64.powf(least);
        Values::Log { least, greatest: least * 10_f64.powf(width), per_decade: steps.div_ceil(8) }
    } else {
        Values::Linear { least, greatest: least + width, steps }
    }
}

/// Ends of alternating safe and unsafe stretches, each wider than `step`, on the axis's scale.
fn stretches(values: Values, gaps: &[f64], step: f64) -> Vec<f64> {
    let (least, _) = ends(values).unwrap();
    let mut at = scale(values, least);
    gaps.iter()
        .map(|gap| {
            at += step * (1.05 + gap);
            at
        })
        .collect()
}

fn is_safe(values: Values, switches: &[f64], first: bool, value: f64) -> bool {
    first ^ (switches.iter().filter(|s| scale(values, value) > **s).count() % 2 == 1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_end_is_bracketed_and_no_stretch_is_missed(
        log: bool,
        least in -6.0..3.0_f64,
        width in 0.5..12.0_f64,
        steps in 4_u32..40,
        home in 0.0..1.0_f64,
        refine in 0_u32..8,
        first: bool,
        gaps in prop::collection::vec(0.0..6.0_f64, 0..8),
    ) {
        let values = values(log, least, width, steps);
        let (low, high) = ends(values).unwrap();
        let home = unscale(values, scale(values, low) * (1.0 - home) + scale(values, high) * home);
        let step = step(values, home);
        let mut switches = stretches(values, &gaps, step);
        // The last stretch is as wide as the others, or there is none.
        switches.retain(|s| *s + step * 1.05 < scale(values, high));
        let safe = |v: f64| is_safe(values, &switches, first, v);
        let known = sorted(search(values, home, refine, Vec::new(), |v| Some(safe(v))));

        prop_assert_eq!(known.iter().filter(|k| k.value == at_home(values, home).unwrap()).count(), 1);
        prop_assert!(known.iter().all(|k| (low..=high).contains(&k.value)));
        prop_assert!(known.iter().all(|k| k.value.to_bits() != (-0.0_f64).to_bits()));
        let brackets: Vec<_> = known.windows(2).filter(|w| w[0].safe != w[1].safe).collect();
        prop_assert_eq!(brackets.len(), switches.len(), "a stretch was missed");
        let resolution = step * (33.0_f64 / 64.0).powi(refine as i32) * (1.0 + 1e-9);
        for (bracket, switch) in brackets.iter().zip(&switches) {
            let [from, to] = [bracket[0].value, bracket[1].value].map(|v| scale(values, v));
            prop_assert!(from <= *switch && *switch <= to, "{from} .. {to} holds no {switch}");
            prop_assert!(to - from <= resolution, "{} > {resolution}", to - from);
        }
    }

    #[test]
    fn the_order_of_what_is_known_does_not_matter_and_a_part_resumes_exactly(
        log: bool,
        gaps in prop::collection::vec(0.0..6.0_f64, 1..5),
        cut in 0.0..1.0_f64,
        seed: u64,
    ) {
        let values = values(log, -2.0, 6.0, 16);
        let switches = stretches(values, &gaps, step(values, 0.1));
        let safe = |v: f64| Some(is_safe(values, &switches, true, v));
        let whole = search(values, 0.1, 5, Vec::new(), safe);
        let mut part = whole[..(cut * whole.len() as f64) as usize].to_vec();
        let here = next(values, 0.1, &part, 5);
        // A seeded rotation and reversal stand for any order.
        let turn = seed as usize % part.len().max(1);
        part.rotate_left(turn);
        if seed % 2 == 0 {
            part.reverse();
        }
        prop_assert_eq!(next(values, 0.1, &part, 5), here);
        prop_assert_eq!(sorted(search(values, 0.1, 5, part, safe)), sorted(whole));
    }

    #[test]
    fn whole_numbers_are_bracketed_to_one(
        least in 0_u32..3,
        greatest in 3_u32..10_000_000,
        per_decade in 1_u32..4,
        switch in 0.0..1.0_f64,
    ) {
        let values = Values::Whole { least, greatest, per_decade };
        let switch = (f64::from(greatest) * switch.powi(4)).floor();
        let known = sorted(search(values, 1.0, 40, Vec::new(), |v| Some(v <= switch)));
        prop_assert!(known.iter().all(|k| k.value.fract() == 0.0));
        prop_assert_eq!((known[0].value, known.last().unwrap().value),
            (f64::from(least), f64::from(greatest)));
        for pair in known.windows(2).filter(|w| w[0].safe != w[1].safe) {
            prop_assert_eq!((pair[0].value, pair[1].value), (switch, switch + 1.0));
        }
    }

    #[test]
    fn no_axis_makes_it_panic_or_leave_its_ends(
        kind in 0..4,
        least: f64,
        greatest: f64,
        whole: (u32, u32),
        per_decade: u32,
        home: f64,
    ) {
        let values = match kind {
            0 => Values::Log { least, greatest, per_decade },
            1 => Values::FromZero { least, greatest, per_decade },
            2 => Values::Linear { least, greatest, steps: per_decade },
            _ => Values::Whole { least: whole.0, greatest: whole.1, per_decade },
        };
        let grid = grid(values, home);
        prop_assert!(grid.len() <= MOST_POINTS + 3);
        prop_assert!(grid.is_sorted());
        if let Some((low, high)) = ends(values) {
            prop_assert!(grid.iter().all(|v| (low..=high).contains(v)));
            let half = low / 2.0 + high / 2.0;
            let known: Vec<_> =
                grid.iter().map(|v| Known { value: *v, safe: Some(*v < half) }).collect();
            let wanted = wanted(values, home, &known, 3);
            prop_assert!(wanted.iter().all(|v| (low..=high).contains(v)));
        } else {
            prop_assert!(grid.is_empty());
        }
    }
}

#[test]
fn values_are_short_to_write() {
    let values = Values::Log { least: 1e-3, greatest: 1e3, per_decade: 2 };
    let grid = grid(values, 1.0);
    let texts: Vec<String> = grid.iter().map(|v| format!("{v:e}")).collect();
    assert_eq!(
        texts,
        [
            "1e-3", "3.2e-3", "1e-2", "3.2e-2", "1e-1", "3.2e-1", "1e0", "3.2e0", "1e1", "3.2e1",
            "1e2", "3.2e2", "1e3"
        ]
    );
    let known: Vec<_> = grid.iter().map(|v| Known { value: *v, safe: Some(*v < 50.0) }).collect();
    assert_eq!(wanted(values, 1.0, &known, 4), [57.0]);
}

#[test]
fn home_comes_first_and_what_cannot_be_seen_is_not_refined() {
    let values = Values::Linear { least: 0.0, greatest: 4.0, steps: 4 };
    assert_eq!(wanted(values, 2.5, &[], 3), [2.5]);
    let unseen = search(values, 2.5, 3, Vec::new(), |v| (v != 3.0).then_some(v < 3.0));
    let probed: Vec<f64> = unseen.iter().map(|k| k.value).collect();
    assert_eq!(probed, [2.5, 0.0, 1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn zero_stands_beside_a_logarithm() {
    let values = Values::FromZero { least: 1e-2, greatest: 1.0, per_decade: 1 };
    assert_eq!(grid(values, 0.0), [0.0, 0.01, 0.1, 1.0]);
    // The home of a value that means nothing here is 0.
    assert_eq!(at_home(values, 1e-4), Some(0.0));
    let known = sorted(search(values, 0.0, 2, Vec::new(), |v| Some(v == 0.0)));
    assert_eq!(known.len(), 4, "nothing is probed between 0 and the least: {known:?}");
    let known = search(values, 0.0, 2, Vec::new(), |v| Some(v < 0.5));
    assert_eq!(known.len(), 6);
}

#[test]
fn degenerate_axes_end() {
    let none = |values| assert_eq!(next(values, 1.0, &[], 4), None, "{values:?}");
    none(Values::Log { least: 0.0, greatest: 1.0, per_decade: 1 });
    none(Values::Log { least: 2.0, greatest: 1.0, per_decade: 1 });
    none(Values::Linear { least: f64::NAN, greatest: 1.0, steps: 1 });
    none(Values::Linear { least: 0.0, greatest: f64::INFINITY, steps: 1 });
    none(Values::Whole { least: 3, greatest: 2, per_decade: 1 });
    none(Values::Words(&[]));
    let one = Values::Log { least: 2.0, greatest: 2.0, per_decade: 3 };
    // Home outside is the nearest end.
    for home in [2.0, 9.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(grid(one, home), [2.0], "{home}");
    }
    assert_eq!(grid(Values::Whole { least: 0, greatest: 0, per_decade: 1 }, 0.0), [0.0]);
    assert_eq!(
        grid(Values::Whole { least: 0, greatest: 20, per_decade: 1 }, 7.4),
        [0.0, 1.0, 4.0, 7.0, 20.0]
    );
    // Values are told apart by their bits: there is one zero.
    let from_minus_zero = Values::Linear { least: -0.0, greatest: 1.0, steps: 2 };
    for values in [from_minus_zero, Values::Linear { least: -1.0, greatest: 1.0, steps: 2 }] {
        for home in [-0.0, 1.0] {
            let zeros = grid(values, home).into_iter().filter(|value| *value == 0.0);
            assert_eq!(zeros.map(f64::to_bits).collect::<Vec<_>>(), [0], "{values:?} {home}");
        }
    }
    let words = Values::Words(&["none", "nan", "infinite"]);
    let probed = search(words, 0.0, 9, Vec::new(), |v| Some(v == 0.0));
    assert_eq!(probed.len(), 3, "words are not refined");
}

#[test]
fn a_technique_that_ignores_the_value_is_safe_everywhere() {
    let values = Values::Log { least: 1e-6, greatest: 1e6, per_decade: 1 };
    let known = search(values, 1.0, 9, Vec::new(), |_| Some(true));
    assert_eq!(known.len(), 13, "and nothing is refined");
}
