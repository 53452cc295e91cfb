use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::Status;
use crate::fixtures::{config, row};

/// A row of its own identity with these repeats of one frame.
fn timed(n: u64, repeats: &[u64]) -> Row {
    Row { samples_ns: repeats.iter().map(|&ns| vec![ns]).collect(), ..row(n) }
}

fn options() -> Options {
    Options::default()
}

fn only(old: &Row, new: &Row, options: &Options) -> Pair {
    let comparison = compare(std::slice::from_ref(old), std::slice::from_ref(new), options);
    assert_eq!(comparison.pairs.len(), 1, "{comparison:?}");
    comparison.pairs[0].clone()
}

fn failed() -> Status {
    Status::Failed { stage: "check".into(), reason: "off by one".into() }
}

/// A row that died before its case was prepared.
fn unplaced(row: &Row, status: Status) -> Row {
    Row {
        status,
        scene_hash: String::new(),
        view: String::new(),
        size: String::new(),
        truth: format!("parameters of {}", row.truth),
        adapter: "none".into(),
        device: "none".into(),
        samples_ns: Vec::new(),
        passes_ns: BTreeMap::new(),
        errors: BTreeMap::new(),
        counters: BTreeMap::new(),
        ratio: None,
        ..row.clone()
    }
    .identified()
}

#[test]
fn a_time_by_hand() {
    // Medians 100 and 120; deviations from them 1 and 2.
    let old = timed(0, &[99, 100, 101, 98, 101]);
    let new = timed(0, &[118, 120, 122, 120, 125]);
    let time = only(&old, &new, &options()).time.unwrap();
    assert_eq!((time.old_ns, time.new_ns, time.ratio), (100.0, 120.0, 1.2));
    assert_eq!((time.verdict, time.because), (Verdict::Worse, ""));
    // Five samples: factor 1.206. hypot(1 / 100, 2 / 120) = 0.019437.
    let band = (3.0 * 1.4826 * 1.206 * 0.019_436_5_f64).exp_m1();
    assert!((time.band - band).abs() < 1e-5, "{} {band}", time.band);
    assert_eq!(only(&old, &new, &options()).changes, [Change::Slower]);

    // The same ratio within the spread, or below the threshold, is none.
    let loose = timed(0, &[90, 120, 150, 100, 140]);
    assert_eq!(only(&old, &loose, &options()).time.unwrap().verdict, Verdict::Same);
    let wide = Options { threshold: 0.25, ..options() };
    assert_eq!(only(&old, &new, &wide).changes, []);
}

#[test]
fn times_without_a_basis_are_shown_and_not_judged() {
    let (old, new) = (timed(0, &[100, 100, 100]), timed(0, &[900, 900, 900]));
    let because = |old: &Row, new: &Row, any_machine| {
        let pair = only(old, new, &Options { any_machine, ..options() });
        assert_eq!(pair.changes, []);
        let time = pair.time.unwrap();
        assert_eq!(time.verdict, Verdict::NotJudged);
        time.because
    };
    assert_eq!(because(&timed(0, &[100, 100]), &new, false), "fewer than 3 repeats");
    assert_eq!(because(&old, &timed(0, &[900, 900]), false), "fewer than 3 repeats");
    assert_eq!(
        because(&old, &Row { clock: "wall".into(), ..new.clone() }, false),
        "different clocks"
    );
    assert_eq!(because(&old, &timed(0, &[0, 0, 0, 5]), false), "a median of 0 ns");
    assert_eq!(because(&old, &new, true), "different machines may be joined");
    // Control: with all of it in order it is judged.
    assert_eq!(only(&old, &new, &options()).changes, [Change::Slower]);
}

#[test]
fn errors_and_counters_by_hand() {
    let with = |errors: &[(&str, f64)], counters: &[(&str, u64)], memory_bytes| Row {
        errors: errors.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
        counters: counters.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
        memory_bytes,
        ..timed(0, &[100, 100, 100])
    };
    let old =
        with(&[("rmse", 0.1), ("leak", 0.0), ("max", 1.0)], &[("texels", 7), ("bytes", 8)], 1);
    let new = with(&[("rmse", 0.09), ("leak", 5e-7), ("p99", 1.0)], &[("texels", 8)], 2);
    let pair = only(&old, &new, &options());
    let verdicts: Vec<_> = pair.errors.iter().map(|e| (e.metric.as_str(), e.verdict)).collect();
    assert_eq!(
        verdicts,
        [
            ("leak", Verdict::Same),
            ("max", Verdict::Vanished),
            ("p99", Verdict::Appeared),
            ("rmse", Verdict::Better)
        ]
    );
    let change = |name: &str, old, new| CounterChange { name: name.into(), old, new };
    assert_eq!(
        pair.counters,
        [
            change("bytes", Some(8), None),
            change("texels", Some(7), Some(8)),
            change("memory_bytes", Some(1), Some(2))
        ]
    );
    assert_eq!(pair.changes, [Change::Worse, Change::Counters, Change::Better]);
    // Other machines need other buffers.
    let any = Options { any_machine: true, ..options() };
    assert_eq!(only(&old, &new, &any).counters.len(), 2);
    // A value that is not finite is worse than any.
    let broken = with(&[("rmse", f64::NAN), ("leak", 0.0), ("max", 1.0)], &[], 1);
    let whole = with(&[("rmse", 0.9), ("leak", 0.0), ("max", 1.0)], &[], 1);
    assert_eq!(only(&whole, &broken, &options()).changes, [Change::Worse]);
    assert_eq!(only(&broken, &whole, &options()).changes, [Change::Better]);
    assert_eq!(only(&broken, &broken, &options()).changes, []);
}

#[test]
fn what_fails_is_fixed_comes_goes_or_is_left_out() {
    let ok = timed(0, &[100, 100, 100]);
    let not_run = Status::NotRun { reason: "no adapter".into() };
    let bad = Row { status: failed(), ..ok.clone() };
    let out = Row { status: not_run.clone(), ..ok.clone() };
    for (old, new, change) in [
        (&ok, &bad, Some(Change::Failed)),
        (&out, &bad, Some(Change::Failed)),
        (&bad, &ok, Some(Change::Fixed)),
        (&ok, &out, Some(Change::NotRun)),
        (&bad, &out, Some(Change::NotRun)),
        (&out, &ok, Some(Change::New)),
        (&bad, &bad, None),
        (&out, &out, None),
    ] {
        let pair = only(old, new, &options());
        assert_eq!(pair.changes, Vec::from_iter(change), "{:?} {:?}", old.status, new.status);
        assert!(change.is_none() || pair.errors.is_empty());
    }
    let alone = |old: &[Row], new: &[Row]| compare(old, new, &options()).pairs[0].changes.clone();
    assert_eq!(alone(&[], std::slice::from_ref(&ok)), [Change::New]);
    assert_eq!(alone(std::slice::from_ref(&ok), &[]), [Change::Gone]);
    assert_eq!(alone(&[], std::slice::from_ref(&bad)), [Change::Failed]);
    assert_eq!(compare(&[], &[], &options()), Comparison::default());
}

#[test]
fn a_row_that_died_before_its_case_is_paired_by_its_setting() {
    let ok = timed(0, &[100, 100, 100]);
    let not_run = Status::NotRun { reason: "no adapter".into() };
    assert_eq!(only(&ok, &unplaced(&ok, failed()), &options()).changes, [Change::Failed]);
    assert_eq!(only(&unplaced(&ok, failed()), &ok, &options()).changes, [Change::Fixed]);
    assert_eq!(only(&ok, &unplaced(&ok, not_run.clone()), &options()).changes, [Change::NotRun]);
    // Two cases that differ in what such a row does not know: the place in the plan decides.
    let other = Row { truth: "another".into(), group: "h".into(), ..ok.clone() }.identified();
    let dead = [unplaced(&ok, failed()), unplaced(&other, failed())];
    let comparison = compare(&[ok.clone(), other.clone()], &dead, &options());
    let found: Vec<_> = comparison.pairs.iter().map(|p| (p.old, p.new)).collect();
    assert_eq!(comparison.pairs.len(), 2, "{found:?}");
    assert!(found.contains(&(Some(0), Some(0))) && found.contains(&(Some(1), Some(1))));
    // Where nothing tells them apart, nothing is guessed.
    let twin = Row { group: ok.group.clone(), ..other };
    let dead = [unplaced(&ok, failed())];
    assert_eq!(compare(&[ok.clone(), twin], &dead, &options()).joined(), 0);

    // On one side the later counts; an omission never stands in for a result.
    let later = |row: Row| Row { time: "2027".into(), ..row };
    let changes = |new: &[Row]| {
        let comparison = compare(std::slice::from_ref(&ok), new, &options());
        assert_eq!(comparison.pairs.len(), 1, "{comparison:?}");
        comparison.pairs[0].changes.clone()
    };
    assert_eq!(changes(&[ok.clone(), later(unplaced(&ok, failed()))]), [Change::Failed]);
    assert_eq!(changes(&[later(ok.clone()), unplaced(&ok, failed())]), []);
    assert_eq!(changes(&[ok.clone(), later(unplaced(&ok, not_run))]), []);
}

#[test]
fn machines_and_adapters_are_joined_only_when_told() {
    let here = timed(0, &[100, 100, 100]);
    let elsewhere = [
        Row { machine: "other".into(), ..here.clone() },
        Row { cpu: "other".into(), ..here.clone() },
        Row { adapter: "other".into(), ..here.clone() }.identified(),
        Row { threads: 64, ..here.clone() }.identified(),
    ];
    for there in elsewhere {
        let there = Row { samples_ns: vec![vec![900]; 3], ..there };
        let comparison =
            compare(std::slice::from_ref(&here), std::slice::from_ref(&there), &options());
        assert!(comparison.pairs.is_empty(), "{comparison:?}");
        assert_eq!(comparison.refused.len(), 1);
        assert!(comparison.refused[0].starts_with("1 rows were measured on "));
        let any = Options { any_machine: true, ..options() };
        let pair = only(&here, &there, &any);
        assert_eq!((pair.changes.len(), pair.time.unwrap().ratio), (0, 9.0));
    }
    // Another driver or revision of the same place is what a comparison is for.
    let newer = Row { driver: "driver 2".into(), revision: "def".into(), ..here.clone() };
    assert_eq!(only(&here, &newer, &options()).changes, []);
}

#[test]
fn only_the_latest_row_of_an_identity_counts() {
    let old = timed(0, &[100, 100, 100]);
    let stale = timed(0, &[900, 900, 900]);
    let fresh = Row { time: "2027".into(), ..old.clone() };
    for new in [[stale.clone(), fresh.clone()], [fresh.clone(), stale.clone()]] {
        let comparison = compare(std::slice::from_ref(&old), &new, &options());
        assert_eq!((comparison.pairs.len(), comparison.superseded_new), (1, 1));
        assert_eq!(comparison.pairs[0].changes, []);
    }
}

#[test]
fn the_summary_of_times_is_geometric() {
    let old = [timed(0, &[100; 3]), timed(1, &[100; 3]), timed(2, &[100; 3])];
    let new = [timed(0, &[50; 3]), timed(1, &[200; 3]), timed(2, &[100; 3])];
    let times = compare(&old, &new, &options()).times().unwrap();
    assert_eq!(times.count, 3);
    assert!((times.geometric_mean - 1.0).abs() < 1e-12);
    let spread = (2.0 * 2_f64.ln().powi(2) / 3.0).sqrt().exp();
    assert!((times.spread - spread).abs() < 1e-12);
    assert_eq!(compare(&old, &[], &options()).times(), None);
}

/// Normal deviates by Box and Muller from a counted hash: seeded, and the same everywhere.
fn normal(seed: u64, n: u64) -> f64 {
    let uniform = |salt: u64| {
        let bytes = [seed.to_le_bytes(), n.to_le_bytes(), salt.to_le_bytes()].concat();
        let hash = blake3::hash(&bytes);
        let mut word = [0; 8];
        word.copy_from_slice(&hash.as_bytes()[..8]);
        (u64::from_le_bytes(word) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (-2.0 * (1.0 - uniform(0)).ln()).sqrt() * (std::f64::consts::TAU * uniform(1)).cos()
}

/// The share of rows that are flagged, of `rows` whose repeats on both sides are of one
/// distribution with this relative deviation, the new side slower by `factor`.
/// And the share that the threshold alone would flag.
fn flagged(repeats: usize, deviation: f64, rows: u64, factor: f64) -> (f64, f64) {
    let side = |side: u64, factor: f64| -> Vec<Row> {
        let sample = |n: u64, i: usize| {
            let log = deviation * normal(side, n * 100 + i as u64);
            (1e6 * factor * log.exp()) as u64
        };
        (0..rows)
            .map(|n| timed(n, &(0..repeats).map(|i| sample(n, i)).collect::<Vec<_>>()))
            .collect()
    };
    let comparison = compare(&side(1, 1.0), &side(2, factor), &options());
    assert_eq!(comparison.joined() as u64, rows);
    let share = |test: &dyn Fn(&Pair) -> bool| {
        comparison.pairs.iter().filter(|pair| test(pair)).count() as f64 / rows as f64
    };
    let beyond = |pair: &Pair| pair.time.as_ref().unwrap().ratio.ln().abs() > 1.05_f64.ln();
    (share(&Pair::is_changed), share(&beyond))
}

/// Stated in `docs/methodology.md`: of rows that did not change, noise alone flags at most 5 % at
/// 3 repeats, 1.5 % at 5 and 0.5 % at 9.
#[test]
fn noise_alone_flags_few_rows_and_a_real_change_most() {
    for (repeats, most) in [(3, 0.05), (5, 0.015), (9, 0.005)] {
        for deviation in [0.01, 0.05, 0.1, 0.3] {
            let (share, by_threshold) = flagged(repeats, deviation, 1500, 1.0);
            assert!(share <= most, "{repeats} repeats, deviation {deviation}: {share}");
            // Control: without the band, noise beyond the threshold would flag far more.
            assert!(
                deviation < 0.1 || by_threshold > 0.25,
                "{repeats} {deviation}: {by_threshold}"
            );
        }
        let (real, _) = flagged(repeats, 0.02, 300, 1.5);
        assert!(real > 0.95, "{repeats} repeats: only {real} of a real change is seen");
    }
}

fn repeats() -> impl Strategy<Value = Vec<u64>> {
    prop::collection::vec(1_u64..1_000_000, 1..8)
}

fn rows() -> impl Strategy<Value = Vec<Row>> {
    let errors = prop::option::of(prop_oneof![Just(0.0), 0.0_f64..1.0]);
    let one = (0_u64..6, repeats(), errors, 0_u64..3, 0_u8..8);
    prop::collection::vec(one, 0..8).prop_map(|all| {
        let build =
            |(i, (n, repeats, error, counter, kind)): (usize, (u64, Vec<u64>, _, u64, u8))| {
                let mut row: Row = timed(n, &repeats);
                // No two at one time: which of them is later would be the order's to say.
                row.time = format!("2026-01-02T03:04:05.{i:03}Z");
                let error: Option<f64> = error;
                row.errors = error.map(|e| ("rmse".to_owned(), e)).into_iter().collect();
                row.counters.insert("texels".into(), counter);
                match kind {
                    0 => row.status = failed(),
                    1 => row = unplaced(&row, failed()),
                    2 => row = unplaced(&row, Status::NotRun { reason: "none".into() }),
                    3 => row.machine = "other".into(),
                    _ => {}
                }
                row
            };
        all.into_iter().enumerate().map(build).collect()
    })
}

/// What a comparison says, without positions.
fn content(old: &[Row], new: &[Row], c: &Comparison) -> (Vec<String>, Vec<String>) {
    let say = |pair: &Pair| {
        let (a, b) = (pair.old.map(|i| &old[i]), pair.new.map(|i| &new[i]));
        let rest = Pair { old: None, new: None, ..pair.clone() };
        format!("{a:?} {b:?} {rest:?}")
    };
    (c.pairs.iter().map(say).collect(), c.refused.clone())
}

fn swapped(verdict: Verdict) -> Verdict {
    match verdict {
        Verdict::Better => Verdict::Worse,
        Verdict::Worse => Verdict::Better,
        Verdict::Appeared => Verdict::Vanished,
        Verdict::Vanished => Verdict::Appeared,
        other => other,
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_side_compared_with_itself_has_not_changed(rows in rows(), any_machine in any::<bool>()) {
        let comparison = compare(&rows, &rows, &Options { any_machine, threshold: 0.0 });
        prop_assert!(comparison.pairs.iter().all(|p| !p.is_changed()), "{comparison:?}");
        prop_assert_eq!(comparison.joined(), comparison.pairs.len());
        prop_assert!(comparison.refused.is_empty());
        prop_assert_eq!(rows.is_empty(), comparison.pairs.is_empty());
    }

    #[test]
    fn a_swap_of_the_sides_swaps_every_verdict(a in rows(), b in rows()) {
        let forth = compare(&a, &b, &options());
        let back = compare(&b, &a, &options());
        prop_assert_eq!(forth.pairs.len(), back.pairs.len());
        for pair in &forth.pairs {
            let twin = back.pairs.iter().find(|p| p.old == pair.new && p.new == pair.old);
            let twin = twin.expect("the same pairs");
            let times = (pair.time.as_ref(), twin.time.as_ref());
            if let (Some(time), Some(other)) = times {
                prop_assert_eq!(time.verdict, swapped(other.verdict));
                prop_assert_eq!(time.band, other.band);
            }
            prop_assert_eq!(pair.time.is_some(), twin.time.is_some());
            let verdicts: Vec<_> = pair.errors.iter().map(|e| e.verdict).collect();
            let others: Vec<_> = twin.errors.iter().map(|e| swapped(e.verdict)).collect();
            prop_assert_eq!(verdicts, others);
            prop_assert_eq!(pair.counters.len(), twin.counters.len());
        }
    }

    #[test]
    fn the_order_of_rows_changes_nothing(a in rows(), b in rows(), turn in 0_usize..8) {
        let (mut c, mut d) = (a.clone(), b.clone());
        c.reverse();
        if !d.is_empty() {
            let turn = turn % d.len();
            d.rotate_left(turn);
        }
        let (one, two) = (compare(&a, &b, &options()), compare(&c, &d, &options()));
        prop_assert_eq!(content(&a, &b, &one), content(&c, &d, &two));
    }

    #[test]
    fn twice_the_time_flags_exactly_the_timed_rows(
        timed_rows in prop::collection::vec(prop::collection::vec(1000_u64..1010, 3..8), 1..6),
        untimed in 0_u64..3,
    ) {
        let mut old: Vec<Row> =
            timed_rows.iter().enumerate().map(|(n, repeats)| timed(n as u64, repeats)).collect();
        old.extend((100..100 + untimed).map(|n| Row {
            samples_ns: Vec::new(),
            clock: "none".into(),
            ..row(n)
        }));
        let mut new = old.clone();
        new.iter_mut().flat_map(|r| &mut r.samples_ns).flatten().for_each(|ns| *ns *= 2);
        let comparison = compare(&old, &new, &options());
        for pair in &comparison.pairs {
            let is_timed = pair.old.is_some_and(|i| !old[i].samples_ns.is_empty());
            let expected: &[Change] = if is_timed { &[Change::Slower] } else { &[] };
            prop_assert_eq!(&pair.changes[..], expected);
        }
        prop_assert_eq!(comparison.joined(), old.len());
        // Control: the band of a wild time covers a factor of two.
        let wild = only(&timed(0, &[100, 1000, 10_000]), &timed(0, &[200, 2000, 20_000]), &options());
        prop_assert!(!wild.is_changed());
    }
}

#[test]
fn the_worst_comes_first() {
    let old: Vec<Row> = (0..4).map(|n| timed(n, &[100, 100, 100])).collect();
    let new = [
        timed(0, &[50, 50, 50]),
        timed(1, &[200, 200, 200]),
        timed(2, &[400, 400, 400]),
        Row { status: failed(), ..timed(3, &[100, 100, 100]) },
    ];
    let comparison = compare(&old, &new, &options());
    let order: Vec<_> = comparison.pairs.iter().map(|p| (p.old.unwrap(), p.changes[0])).collect();
    let expected =
        [(3, Change::Failed), (2, Change::Slower), (1, Change::Slower), (0, Change::Faster)];
    assert_eq!(order, expected);
    assert_eq!(comparison.counts()[&Change::Slower], 2);
    assert!(Change::ALL.is_sorted());
}
