//! Eleven frames, one λ each; and the printed loop, which never ends.

use dapple_opacity_maps::{
    Criterion,
    search::{
        Cycle, Shown, Steps,
        state::{PrintedLoop, Trial},
    },
};
use proptest::prelude::*;

const THESIS: Steps = Steps::THESIS;

fn run(cycle: &mut Cycle, score: impl Fn(f32) -> f64) -> (u32, Vec<f32>) {
    let (mut scored, mut drawn) = (0, Vec::new());
    for _ in 0..40 {
        let frame = cycle.frame();
        drawn.push(frame.drawn);
        if let Some(trial) = frame.trial {
            scored += 1;
            cycle.scored(trial, score(trial.lambda));
        }
    }
    (scored, drawn)
}

#[test]
fn a_search_scores_eleven_frames_and_then_rests() {
    let mut cycle = Cycle::new(Criterion::Correlation, THESIS, Shown::Trial);
    let (scored, drawn) = run(&mut cycle, |lambda| f64::from((lambda - 0.62).abs()));
    assert_eq!(scored, 11);
    let trials: Vec<f32> = (0..=10).map(|i| i as f32 / 10.0).collect();
    assert_eq!(drawn[..11], trials);
    assert!(drawn[11..].iter().all(|&lambda| lambda == 0.6));
    assert!(!cycle.is_searching());
}

#[test]
fn the_adopted_split_is_drawn_while_others_are_tried_if_so_asked() {
    let mut cycle = Cycle::new(Criterion::Sad, THESIS, Shown::Adopted);
    let (_, first) = run(&mut cycle, f64::from);
    assert!(first[..11].iter().all(|&l| l == 0.0) && first[11..].iter().all(|&l| l == 1.0));
    cycle.needs_recompute();
    let (scored, second) = run(&mut cycle, |lambda| -f64::from(lambda));
    assert_eq!(scored, 11);
    assert!(second[..11].iter().all(|&l| l == 1.0) && second[11..].iter().all(|&l| l == 0.0));
}

#[test]
fn a_restart_forgets_the_best_and_the_printed_loop_does_not() {
    let mut cycle = Cycle::new(Criterion::Correlation, THESIS, Shown::Adopted);
    let mut printed = PrintedLoop::new(Criterion::Correlation);
    run(&mut cycle, |lambda| -10.0 - f64::from(lambda));
    (0..11).for_each(|_| {
        printed.frame(|lambda| -10.0 - lambda);
    });
    assert_eq!(cycle.adopted(), 1.0);
    cycle.needs_recompute();
    printed.needs_recompute();
    // Scores of another scene, none of which reaches the old best; its own best is at 0.3.
    run(&mut cycle, |lambda| f64::from((lambda - 0.3).abs()));
    (0..11).for_each(|_| {
        printed.frame(|lambda| (lambda - 0.3).abs());
    });
    assert_eq!(cycle.adopted(), 0.3);
    assert!((printed.best() - 1.0).abs() < 1e-9, "the stale best stays");
}

#[test]
fn the_printed_sum_of_tenths_never_is_one_and_one_tenth() {
    let mut printed = PrintedLoop::new(Criterion::Correlation);
    let mut greatest = 0.0f64;
    for _ in 0..1000 {
        greatest = greatest.max(printed.frame(|lambda| lambda));
    }
    assert!(!printed.has_ended());
    assert!(greatest > 1.1, "λ runs out of its range: {greatest}");
    // Nor in 32 bits.
    let mut narrow = 0.0f32;
    assert!((0..100).all(|_| {
        narrow += 0.1;
        narrow != 1.1
    }));
}

#[test]
fn a_score_counts_for_the_split_its_maps_were_rendered_with_however_late_it_comes() {
    let score = |lambda: f32| f64::from((lambda - 0.4).abs());
    for delay in 0..5usize {
        let mut cycle = Cycle::new(Criterion::Correlation, THESIS, Shown::Adopted);
        let mut shifted = Cycle::new(Criterion::Correlation, THESIS, Shown::Adopted);
        let mut waiting: Vec<Trial> = Vec::new();
        for frame in 0..20usize {
            waiting.extend(cycle.frame().trial);
            // The thesis's own source scores the maps of a frame before under this frame's λ.
            if let Some(trial) = shifted.frame().trial {
                let rendered = (frame.saturating_sub(delay)) as f32 / 10.0;
                shifted.scored(trial, score(rendered));
            }
            if waiting.len() > delay || frame >= 11 {
                if waiting.is_empty() {
                    continue;
                }
                let trial = waiting.remove(0);
                cycle.scored(trial, score(trial.lambda));
            }
        }
        assert_eq!(cycle.adopted(), 0.4, "delay {delay}");
        assert_eq!(shifted.adopted() == 0.4, delay == 0, "delay {delay}");
    }
}

#[test]
fn scores_of_an_abandoned_search_and_second_scores_change_nothing() {
    let mut cycle = Cycle::new(Criterion::Correlation, THESIS, Shown::Adopted);
    let old = cycle.frame().trial.unwrap();
    cycle.needs_recompute();
    let first = cycle.frame().trial.unwrap();
    assert_eq!(cycle.scored(old, -1e9), None);
    cycle.scored(first, 5.0);
    cycle.scored(first, -1e9);
    while let Some(trial) = cycle.frame().trial {
        cycle.scored(trial, 1.0 + f64::from((trial.lambda - 0.7).abs()));
    }
    assert_eq!(cycle.adopted(), 0.7);
}

#[test]
fn scores_that_are_no_numbers_leave_the_even_split() {
    let mut cycle = Cycle::new(Criterion::Correlation, THESIS, Shown::Adopted);
    let (scored, _) = run(&mut cycle, |_| f64::NAN);
    assert_eq!((scored, cycle.adopted(), cycle.is_searching()), (11, 0.0, false));
    cycle.needs_recompute();
    run(&mut cycle, |lambda| if lambda == 0.5 { 1e30 } else { f64::NAN });
    assert_eq!(cycle.adopted(), 0.5);
}

#[test]
fn other_steps_of_the_split_are_whole_parts_of_one() {
    for (step, values) in [(0.05, 21), (0.1, 11), (0.125, 9), (0.2, 6), (0.25, 5)] {
        let steps = Steps::of(step).unwrap();
        assert_eq!(steps.values(), values);
        assert_eq!((steps.lambda(0), steps.lambda(values - 1)), (0.0, 1.0));
        let mut cycle = Cycle::new(Criterion::Sad, steps, Shown::Adopted);
        assert_eq!(run(&mut cycle, f64::from).0, values);
        assert_eq!(cycle.adopted(), 1.0);
    }
    assert_eq!(Steps::of(0.1).unwrap(), THESIS);
    for step in [0.0, 0.04, 0.07, 0.3, -0.1, f32::NAN, f32::INFINITY] {
        assert!(Steps::of(step).unwrap_err().to_string().contains("lambda step"));
    }
}

proptest! {
    /// P12, against the smallest (or greatest) of eleven scores taken at once; ties go to the first.
    #[test]
    fn a_search_finds_the_best_of_its_values_and_finds_it_again(
        scores in prop::collection::vec(-3i8..3, 11),
        greatest in any::<bool>(),
        order in Just((0..11).collect::<Vec<usize>>()).prop_shuffle(),
    ) {
        let criterion = if greatest { Criterion::Sad } else { Criterion::Correlation };
        let signed = |i: usize| f64::from(scores[i]) * if greatest { -1.0 } else { 1.0 };
        let best = (0..11).reduce(|a, b| if signed(b) < signed(a) { b } else { a }).unwrap();
        let mut cycle = Cycle::new(criterion, THESIS, Shown::Adopted);
        for _ in 0..2 {
            let trials: Vec<Trial> = (0..11).map(|_| cycle.frame().trial.unwrap()).collect();
            prop_assert!(cycle.frame().trial.is_none());
            let ends = order.iter().filter(|&&i| {
                cycle.scored(trials[i], f64::from(scores[i])).is_some()
            });
            prop_assert_eq!(ends.count(), 1);
            prop_assert_eq!(cycle.adopted(), best as f32 / 10.0);
            cycle.needs_recompute();
        }
    }
}
