//! Held to made-up techniques whose every answer is known: whenever some setting meets the goal, so
//! does the choice, from a fifth of them, in all but a few.

use super::{Answer, Candidate, Dial, Goal, Measured, Oracle, Request, Space, advise};
use crate::{
    SuiteError,
    knob::Accuracy,
    problem::{Form, Setting},
};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use std::collections::BTreeMap;

/// A technique: what it costs and how wrong it is by the positions of its knobs.
#[derive(Clone, Debug)]
struct Made {
    time: f64,
    error: f64,
    /// Factor in error for each rung; the time doubles.
    rung: f64,
    /// The best position of the tuned knob, and the factor in error for each step from it.
    best: usize,
    step: f64,
    /// Factors in time and error of the second word.
    word: [f64; 2],
}

const RUNGS: usize = 6;
const STEPS: usize = 9;

impl Made {
    fn at(&self, rung: usize, step: usize, word: usize) -> [f64; 2] {
        let word = if word == 1 { self.word } else { [1.0, 1.0] };
        let away = step.abs_diff(self.best) as i32;
        [
            self.time * 2f64.powi(rung as i32) * word[0],
            self.error * self.rung.powi(rung as i32) * self.step.powi(away) * word[1],
        ]
    }
}

struct Surfaces<'a>(&'a [Made], usize);

impl Oracle for Surfaces<'_> {
    fn ask(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError> {
        self.1 += settings.len();
        let at = |s: &Setting, knob: &str| s.knobs[knob].as_u64().unwrap() as usize;
        let answer = |s: &Setting| {
            let made = &self.0[s.technique.parse::<usize>().unwrap()];
            let [time_ns, error] = made.at(at(s, "rung"), at(s, "step"), at(s, "word"));
            let errors = BTreeMap::from([("e".to_string(), error)]);
            Answer::Measured(Measured { time_ns, mad_ns: 0.0, errors })
        };
        Ok(settings.iter().map(answer).collect())
    }
}

fn space(made: &[Made]) -> Space {
    let dial = |name: &str, n: usize, default, accuracy, ordered| Dial {
        name: name.into(),
        values: (0..n as u64).map(Into::into).collect(),
        default,
        accuracy,
        ordered,
        apart: false,
    };
    let candidate = |i: usize| Candidate {
        technique: i.to_string(),
        variant: "made".into(),
        form: Form::Cpu,
        dials: vec![
            dial("rung", RUNGS, 2, Accuracy::Monotone, true),
            dial("step", STEPS, 4, Accuracy::Unimodal, true),
            dial("word", 2, 0, Accuracy::None, false),
        ],
    };
    Space { candidates: (0..made.len()).map(candidate).collect() }
}

fn made() -> impl Strategy<Value = Made> {
    let word = (0.7..1.4f64, 0.7..1.4f64).prop_map(|(t, e)| [t, e]);
    (1e5..1e7f64, 0.02..0.5f64, 0.5..0.95f64, 0..STEPS, 1.05..1.6f64, word).prop_map(
        |(time, error, rung, best, step, word)| Made { time, error, rung, best, step, word },
    )
}

/// Goals put to the search, from a fixed seed.
const GOALS: usize = 400;
/// A search from a fifth of the settings may miss a goal that only a few of them meet; in a
/// hundred goals, at most this many.
const MOST_MISSED_PERCENT: usize = 2;
/// What is then chosen is at most this much beyond the goal.
const NEAR: f64 = 1.5;

/// Searches for `GOALS` goals on random surfaces: what was chosen, over the goal's limit.
fn beyond(search: impl Fn(&Space, &Request, &mut Surfaces<'_>) -> [f64; 2]) -> Vec<f64> {
    let mut runner = TestRunner::deterministic();
    let goals = (prop::collection::vec(made(), 3..8), 0.0..1.0f64, any::<bool>());
    let one = |runner: &mut TestRunner| {
        let (made, share, budget) = goals.new_tree(runner).unwrap().current();
        let mut all: Vec<[f64; 2]> = Vec::new();
        for m in &made {
            for rung in 0..RUNGS {
                for step in 0..STEPS {
                    all.extend([m.at(rung, step, 0), m.at(rung, step, 1)]);
                }
            }
        }
        let column = usize::from(!budget);
        all.sort_by(|a, b| a[column].total_cmp(&b[column]));
        let limit = all[((all.len() - 1) as f64 * share) as usize][column];
        let goal = if budget { Goal::Budget { ns: limit } } else { Goal::Error { at_most: limit } };
        let request = Request { metric: "e".into(), goal, constraints: Vec::new() };
        let mut oracle = Surfaces(&made, 0);
        let chosen = search(&space(&made), &request, &mut oracle)[column];
        assert!(5 * oracle.1 <= all.len(), "{} of {} asked", oracle.1, all.len());
        chosen / limit
    };
    (0..GOALS).map(|_| one(&mut runner)).collect()
}

fn missed(beyond: &[f64]) -> usize {
    beyond.iter().filter(|b| **b > 1.0).count()
}

#[test]
fn what_can_be_met_is_met_from_a_fifth() {
    let beyond = beyond(|space, request, oracle| {
        let advice = advise(space, request, oracle).unwrap();
        let choice = advice.choice.unwrap();
        [choice.time_ns, choice.error]
    });
    let missed = missed(&beyond);
    assert!(beyond.iter().all(|b| *b <= NEAR), "one of {missed} missed goals by far");
    assert!(100 * missed <= MOST_MISSED_PERCENT * GOALS, "{missed} of {GOALS} goals missed");
}

/// Control: taking the first technique at its defaults misses far more.
#[test]
fn a_search_that_does_not_search_is_noticed() {
    let beyond = beyond(|space, _, oracle| {
        let first = &space.candidates[0];
        let setting = first.setting(&first.defaults());
        let Answer::Measured(m) = oracle.ask(&[setting]).unwrap().remove(0) else { unreachable!() };
        [m.time_ns, m.errors["e"]]
    });
    let missed = missed(&beyond);
    assert!(100 * missed > 10 * MOST_MISSED_PERCENT * GOALS, "only {missed} of {GOALS} missed");
}
