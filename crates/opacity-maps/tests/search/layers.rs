//! The number of layers that a budget buys, on a modelled clock.

use crate::rays::random;
use dapple_opacity_maps::auto_layers::{
    Controller, Line, Rule, Timed, WINDOW, largest_within, raised_while_fast,
};
use proptest::prelude::*;
use rand::RngExt;

const CHOICES: [u32; 6] = [4, 8, 12, 16, 24, 32];

/// A frame of 5 ms and 0.5 ms a layer.
fn clock(layers: u32) -> f64 {
    5.0 + 0.5 * f64::from(layers)
}

fn rule(budget_ms: f64) -> Rule {
    Rule { budget_ms, margin: 0.05 }
}

fn settle(controller: &mut Controller, mut ms: impl FnMut(u32) -> f64, frames: usize) -> usize {
    let mut changes = 0;
    for _ in 0..frames {
        let layers = controller.layers();
        controller.observe(ms(layers));
        changes += usize::from(controller.layers() != layers);
    }
    changes
}

#[test]
fn the_largest_number_of_layers_within_the_budget_is_found() {
    let measured = CHOICES.map(|layers| Timed { layers, ms: clock(layers) });
    for (budget, most) in
        [(6.9, None), (7.0, Some(4)), (12.99, Some(12)), (13.0, Some(16)), (99.0, Some(32))]
    {
        assert_eq!(largest_within(budget, &measured), most, "{budget} ms");
    }
    assert_eq!(largest_within(1e9, &[Timed { layers: 4, ms: f64::NAN }]), None);
    let line = Line::through(&measured).unwrap();
    assert!((line.base_ms - 5.0).abs() < 1e-9 && (line.layer_ms - 0.5).abs() < 1e-9);
    assert_eq!(line.largest_within(13.0 + 1e-9, 256), Some(16));
    assert_eq!(line.largest_within(5.2, 256), None);
    assert_eq!(line.largest_within(1e6, 256), Some(256));
    assert_eq!(Line::through(&measured[..1]), None);
    let falling = [Timed { layers: 4, ms: 3.0 }, Timed { layers: 8, ms: 1.0 }];
    assert_eq!(Line::through(&falling).unwrap(), Line { base_ms: 2.0, layer_ms: 0.0 });
}

#[test]
fn the_published_rule_ends_one_step_beyond_the_budget_or_at_one_slow_frame() {
    let budget = 1000.0 / 30.0;
    let ended = raised_while_fast(30.0, 4, 4, 256, clock);
    assert_eq!(ended, 60);
    assert!(clock(ended) > budget && clock(ended - 4) <= budget);
    let hiccup = raised_while_fast(30.0, 4, 4, 256, |k| if k == 16 { 50.0 } else { clock(k) });
    assert_eq!(hiccup, 16);
    assert_eq!(raised_while_fast(30.0, 4, 4, 32, clock), 32);
    // The controller passes the slow frame by and ends within the budget.
    let choices: Vec<u32> = (1..=64).map(|k| 4 * k).collect();
    let mut controller =
        Controller::new(Rule { budget_ms: budget, margin: 0.0 }, &choices).unwrap();
    let mut frame = 0;
    settle(
        &mut controller,
        |k| {
            frame += 1;
            if frame == 40 { 500.0 } else { clock(k) }
        },
        60 * WINDOW,
    );
    assert_eq!(controller.layers(), 56);
}

#[test]
fn noise_moves_the_controller_nowhere_once_it_has_settled() {
    // 13.3 ms: 16 layers take 13.0, so noise of a tenth crosses the budget in many a frame.
    for seed in 0..20 {
        let mut random = random(seed);
        let mut controller = Controller::new(rule(13.3), &CHOICES).unwrap();
        let mut noisy = |k: u32| clock(k) * (0.9 + 0.2 * random.random::<f64>());
        settle(&mut controller, &mut noisy, 40 * WINDOW);
        let changes = settle(&mut controller, &mut noisy, 1000 * WINDOW);
        assert!(changes <= 1, "seed {seed}: {changes} changes");
        assert!([12, 16].contains(&controller.layers()), "{}", controller.layers());
    }
    // Without the memory of what was too slow, it would flip for ever.
    let mut random = random(1);
    let mut controller = Controller::new(rule(13.3), &CHOICES).unwrap();
    let mut changes = 0;
    for _ in 0..200 {
        controller.forget();
        changes +=
            settle(&mut controller, |k| clock(k) * (0.9 + 0.2 * random.random::<f64>()), WINDOW);
    }
    assert!(changes > 50, "{changes}");
}

#[test]
fn a_heavier_view_lowers_the_number_of_layers_and_a_lighter_one_raises_it() {
    let mut controller = Controller::new(rule(15.0), &CHOICES).unwrap();
    settle(&mut controller, clock, 20 * WINDOW);
    assert_eq!(controller.layers(), 16);
    settle(&mut controller, |k| 2.0 * clock(k), 20 * WINDOW);
    assert_eq!(controller.layers(), 4);
    // Nobody says that the view is light again: the times do.
    settle(&mut controller, clock, 20 * WINDOW);
    assert_eq!(controller.layers(), 16);
    settle(&mut controller, |k| 0.5 * clock(k), 20 * WINDOW);
    assert_eq!(controller.layers(), 32);
    // Nothing meets a budget below the fewest layers: these are kept.
    let mut poor = Controller::new(rule(1.0), &CHOICES).unwrap();
    settle(&mut poor, clock, 20 * WINDOW);
    assert_eq!(poor.layers(), 4);
}

#[test]
fn rules_and_choices_out_of_range_are_refused_by_name() {
    let named = |rule: Rule, choices: &[u32], name: &str| {
        let error = Controller::new(rule, choices).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    };
    named(rule(0.0), &CHOICES, "budget");
    named(rule(f64::NAN), &CHOICES, "budget");
    named(Rule { budget_ms: 1.0, margin: 0.6 }, &CHOICES, "margin");
    for choices in [&[][..], &[4, 4], &[8, 4], &[0, 4], &[4, 257]] {
        named(rule(1.0), choices, "choices");
    }
    let mut controller = Controller::new(rule(9.0), &CHOICES).unwrap();
    settle(&mut controller, |_| f64::NAN, 100);
    assert_eq!(controller.layers(), 4);
}

proptest! {
    #[test]
    fn more_budget_never_buys_fewer_layers(
        times in prop::collection::vec((1u32..=256, 0.1f64..50.0), 0..20),
        budgets in (0.0f64..60.0, 0.0f64..60.0),
    ) {
        let measured: Vec<Timed> =
            times.iter().map(|&(layers, ms)| Timed { layers, ms }).collect();
        let (low, high) = (budgets.0.min(budgets.1), budgets.0.max(budgets.1));
        let (few, many) = (largest_within(low, &measured), largest_within(high, &measured));
        prop_assert!(few <= many);
        if let Some(layers) = many {
            prop_assert!(measured.iter().any(|t| t.layers == layers && t.ms <= high));
            prop_assert!(measured.iter().all(|t| t.layers <= layers || t.ms > high));
        }
        if let Some(line) = Line::through(&measured) {
            prop_assert!(line.largest_within(low, 256) <= line.largest_within(high, 256));
        }
    }

    #[test]
    fn the_controller_ends_at_the_largest_choice_within_a_steady_budget(budget in 7.1f64..30.0) {
        let mut controller = Controller::new(Rule { budget_ms: budget, margin: 0.0 }, &CHOICES)
            .unwrap();
        settle(&mut controller, clock, 20 * WINDOW);
        let measured = CHOICES.map(|layers| Timed { layers, ms: clock(layers) });
        prop_assert_eq!(Some(controller.layers()), largest_within(budget, &measured));
        prop_assert_eq!(settle(&mut controller, clock, 20 * WINDOW), 0);
    }
}
