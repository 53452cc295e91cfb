//! The number of layers that a frame's budget buys.

use super::{ALL, About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::auto_layers::{
    Controller, Line, Rule, Timed, WINDOW, largest_within, raised_while_fast,
};
use rand::RngExt;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "row 37 budget",
                "the layers that a budget buys are the most that keep it, and never fewer of a \
                 larger one",
                "as published: raised until a frame has been too slow, and left there",
            ),
            budget,
        ),
        gate(
            about(
                "row 37 controller",
                "frame by frame the controller comes to the most layers that keep the budget, but \
                 for its margin, and stays",
                "it takes its times for half of what they are",
            ),
            controller,
        ),
    ]
}

const CHOICES: [u32; 6] = [4, 8, 16, 32, 64, 128];

fn budget(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "budget", case);
        let line =
            Line { base_ms: rng.random_range(1.0..10.0), layer_ms: rng.random_range(0.05..0.8) };
        let timed = CHOICES.map(|layers| Timed { layers, ms: line.ms(layers) });
        let mut before = None;
        for budget in (1..12).map(|i| f64::from(i) * 10.0) {
            let expected = CHOICES.into_iter().filter(|k| line.ms(*k) <= budget).max();
            let found = if faulty {
                Some(raised_while_fast(1000.0 / budget, 4, 4, 128, |k| line.ms(k)))
            } else {
                largest_within(budget, &timed)
            };
            let what = || format!("{line:?} within {budget} ms: {found:?}, most {expected:?}");
            tally.check(found == expected, what);
            tally.check(found >= before, what);
            before = found;
            // By the line through two measurements, every number of layers is tried.
            let through = Line::through(&timed[..2]).and_then(|l| l.largest_within(budget, 128));
            let most = (1..=128).filter(|k| line.ms(*k) <= budget + 1e-9).max();
            let near = through == most || through.map(|k| k + 1) == most;
            tally.check(near, || format!("{line:?} within {budget}: {through:?}, not {most:?}"));
        }
    }
    Ok(tally)
}

fn controller(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let margin = 0.1;
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "controller", case);
        let line =
            Line { base_ms: rng.random_range(1.0..10.0), layer_ms: rng.random_range(0.05..0.8) };
        let budget_ms = rng.random_range(12.0..60.0);
        let mut controller = Controller::new(Rule { budget_ms, margin }, &CHOICES)?;
        let believed = if faulty { 0.5 } else { 1.0 };
        let mut drawn = Vec::new();
        for _ in 0..20 * WINDOW {
            drawn.push(controller.layers());
            controller.observe(believed * line.ms(controller.layers()));
        }
        let most = |limit: f64| CHOICES.into_iter().filter(|k| line.ms(*k) <= limit).max();
        let allowed = [most(budget_ms * (1.0 - margin)), most(budget_ms)];
        let last = &drawn[10 * WINDOW..];
        let what = || format!("{line:?} within {budget_ms}: {:?}, {allowed:?}", last.last());
        tally.check(last.iter().all(|k| k == &last[0]), what);
        let found = last.first().copied();
        let fewest = Some(CHOICES[0]);
        let right = found >= allowed[0].or(fewest) && found <= allowed[1].or(fewest);
        tally.check(right, what);
    }
    Ok(tally)
}
