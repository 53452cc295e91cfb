//! The race between candidates.

use super::{
    Advice, Answer, Found, Goal, Oracle, Request, Space,
    descent::{Descent, Known, Need},
    goal::{Score, dominates, knee},
    space::Point,
};
use crate::{SuiteError, problem::Setting};
use dapple_records::text::{duration, significant};

/// A candidate whose every result is dominated by this factor, in time and in error, is dropped
/// before its search is over. The factor starts here and falls as more of it is known.
const EARLY_MARGIN: f64 = 2.0;

/// Results a candidate must have before it may be dropped.
const LEAST_RESULTS: usize = 4;

/// Rivals go on to the final when their best is within this factor of the choice's.
const FINAL: f64 = 1.5;

/// Turns of the final: equal error, equal time, and again.
const MOST_FINALS: usize = 4;

/// Why a search ends before its time.
enum Stop {
    TimeOver,
    Error(SuiteError),
}

/// Finds what `request` asks for in `space`.
///
/// # Errors
/// Those of the oracle.
pub fn advise(
    space: &Space,
    request: &Request,
    oracle: &mut dyn Oracle,
) -> Result<Advice, SuiteError> {
    let mut race = Race::new(space, request);
    let cut_short = match race.run(oracle) {
        Ok(()) => false,
        Err(Stop::TimeOver) => true,
        Err(Stop::Error(error)) => return Err(error),
    };
    if !cut_short {
        race.confirm(oracle)?;
    }
    Ok(race.advice(cut_short))
}

struct Race<'a> {
    space: &'a Space,
    request: &'a Request,
    known: Vec<Known>,
    /// Why a candidate is out of the race.
    out: Vec<Option<String>>,
    /// The last reason a setting of a candidate failed for.
    failures: Vec<Option<String>>,
    asked: usize,
}

/// A candidate's index and a point of it.
type At = (usize, Point);

impl<'a> Race<'a> {
    fn new(space: &'a Space, request: &'a Request) -> Self {
        let n = space.candidates.len();
        Self {
            space,
            request,
            known: vec![Known::new(); n],
            out: vec![None; n],
            failures: vec![None; n],
            asked: 0,
        }
    }

    fn run(&mut self, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        match self.request.goal {
            Goal::Knee => self.find_knee(oracle),
            goal => {
                self.heats(goal, oracle)?;
                self.settle(goal, false, oracle)?;
                self.finals(goal, oracle)?;
                match self.choice(goal).map(|at| self.score(&at)) {
                    // Where the goal is out of reach so far, nobody is out of the question.
                    Some(score) if !score.meets(goal) => {
                        self.settle(goal, true, oracle)?;
                        self.finals(goal, oracle)
                    }
                    _ => Ok(()),
                }
            }
        }
    }

    /// Every candidate alone, side by side, from its defaults; the dominated are dropped on the way.
    fn heats(&mut self, goal: Goal, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        self.advance(oracle, true, &|race, c| race.descent(c, goal).sketch().map(|_| ()))
    }

    /// Equal error, then equal time, among those that came near, until neither changes the choice.
    fn finals(&mut self, goal: Goal, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        for _ in 0..MOST_FINALS {
            let Some(before) = self.choice(goal) else { return Ok(()) };
            let score = self.score(&before);
            let (mut error, mut time) =
                (Goal::Error { at_most: score.error }, Goal::Budget { ns: score.time_ns });
            match goal {
                Goal::Error { .. } if score.meets(goal) => error = goal,
                Goal::Budget { .. } if score.meets(goal) => time = goal,
                _ => {}
            }
            self.transfer(&before, goal, oracle)?;
            for goal in [error, time] {
                self.settle(goal, false, oracle)?;
            }
            if self.choice(goal).as_ref() == Some(&before) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Every other candidate at the choice's values of the knobs they share, the rest as it did best:
    /// what suits one technique on a scene is a good guess for its relatives.
    fn transfer(&mut self, choice: &At, goal: Goal, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        let model = &self.space.candidates[choice.0].dials;
        let mut wanted = Vec::new();
        for (c, candidate) in self.space.candidates.iter().enumerate() {
            let Some(mut point) = self.best_of(c, goal).filter(|_| self.out[c].is_none()) else {
                continue;
            };
            for (dial, at) in candidate.dials.iter().zip(&mut point) {
                let same = model.iter().position(|d| d.name == dial.name);
                let value = same.map(|i| &model[i].values[choice.1[i]]);
                let there = dial.values.iter().position(|v| Some(v) == value);
                *at = there.unwrap_or(*at);
            }
            if !self.known[c].contains_key(&point) {
                wanted.push((c, point));
            }
        }
        if wanted.is_empty() { Ok(()) } else { self.ask(&wanted, oracle) }
    }

    /// Every candidate near the choice (or each one) goes on from its own best until nothing changes.
    fn settle(&mut self, goal: Goal, all: bool, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        let Some(lead) = self.choice(goal).map(|at| self.score(&at)) else { return Ok(()) };
        let near = |best: Score| {
            all || best.time_ns <= FINAL * lead.time_ns
                && (best.error <= FINAL * lead.error || lead.error <= 0.0)
        };
        let starts: Vec<Option<Point>> = (0..self.known.len())
            .map(|c| self.best_of(c, goal).filter(|p| self.known[c][p].is_some_and(near)))
            .collect();
        self.advance(oracle, false, &|race, c| match &starts[c] {
            Some(start) => race.descent(c, goal).settle(start).map(|_| ()),
            None => Ok(()),
        })
    }

    /// Sketches the front, then finishes it around its knee, which may move it.
    fn find_knee(&mut self, oracle: &mut dyn Oracle) -> Result<(), Stop> {
        self.heats(Goal::Knee, oracle)?;
        for _ in 0..MOST_FINALS {
            let Some(before) = self.choice(Goal::Knee) else { return Ok(()) };
            let score = self.score(&before);
            self.transfer(&before, Goal::Knee, oracle)?;
            self.settle(Goal::Error { at_most: score.error }, false, oracle)?;
            self.settle(Goal::Budget { ns: score.time_ns }, false, oracle)?;
            if self.choice(Goal::Knee).as_ref() == Some(&before) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Those that the answer will name once more, for a surer time. They may change places.
    fn confirm(&mut self, oracle: &mut dyn Oracle) -> Result<(), SuiteError> {
        let advice = self.advice(false);
        let named = [advice.choice, advice.runner_up, advice.cheaper, advice.better];
        let mut settings: Vec<Setting> = Vec::new();
        for found in named.into_iter().flatten() {
            if !settings.contains(&found.setting) {
                settings.push(found.setting);
            }
        }
        if settings.is_empty() {
            return Ok(());
        }
        let answers = oracle.again(&settings)?;
        let named: Vec<(At, Score)> = self.results().collect();
        for ((c, point), _) in named {
            let setting = self.space.candidates[c].setting(&point);
            let answer = settings.iter().position(|s| *s == setting).and_then(|i| answers.get(i));
            if let Some(answer @ Answer::Measured(_)) = answer {
                self.known[c].insert(point, self.request.score(answer).ok());
            }
        }
        Ok(())
    }

    fn descent(&self, c: usize, goal: Goal) -> Descent<'_> {
        let meets = self.known.iter().flat_map(|known| known.values().copied().flatten());
        let times = meets.filter(|score| score.meets(goal)).map(|score| score.time_ns);
        let lead_ns = times.reduce(f64::min);
        Descent { candidate: &self.space.candidates[c], known: &self.known[c], goal, lead_ns }
    }

    /// Lets every candidate in the race take `step` until none needs more answers.
    fn advance(
        &mut self,
        oracle: &mut dyn Oracle,
        drop: bool,
        step: &dyn Fn(&Self, usize) -> Result<(), Need>,
    ) -> Result<(), Stop> {
        loop {
            let mut wanted: Vec<At> = Vec::new();
            for c in 0..self.known.len() {
                if self.out[c].is_some() {
                    continue;
                }
                if let Err(points) = step(self, c) {
                    wanted.extend(points.into_iter().map(|p| (c, p)));
                }
            }
            if wanted.is_empty() {
                return Ok(());
            }
            self.ask(&wanted, oracle)?;
            if drop {
                self.drop_dominated();
            }
        }
    }

    fn ask(&mut self, wanted: &[At], oracle: &mut dyn Oracle) -> Result<(), Stop> {
        let settings: Vec<Setting> =
            wanted.iter().map(|(c, p)| self.space.candidates[*c].setting(p)).collect();
        let answers = oracle.ask(&settings).map_err(Stop::Error)?;
        let mut over = answers.len() < wanted.len();
        for ((c, point), answer) in wanted.iter().zip(&answers) {
            if *answer == Answer::Unasked {
                over = true;
                continue;
            }
            self.asked += 1;
            let score = self.request.score(answer);
            if let Err(reason) = &score {
                self.failures[*c] = Some(reason.clone());
            }
            self.known[*c].insert(point.clone(), score.ok());
        }
        if over { Err(Stop::TimeOver) } else { Ok(()) }
    }

    /// Every result so far, with whose it is.
    fn results(&self) -> impl Iterator<Item = (At, Score)> {
        self.known.iter().enumerate().flat_map(|(c, known)| {
            known.iter().filter_map(move |(p, score)| Some(((c, p.clone()), (*score)?)))
        })
    }

    fn drop_dominated(&mut self) {
        let results: Vec<(At, Score)> = self.results().collect();
        for c in 0..self.known.len() {
            let own: Vec<Score> = self.known[c].values().copied().flatten().collect();
            if self.out[c].is_some() || own.len() < LEAST_RESULTS {
                continue;
            }
            // The more is known of it, the less can still be hoped for.
            let margin = 1.0 + (EARLY_MARGIN - 1.0) * LEAST_RESULTS as f64 / own.len() as f64;
            let beaten_by = |own: &Score| {
                results.iter().find(|((other, _), score)| {
                    *other != c
                        && self.out[*other].is_none()
                        && score.time_ns * margin <= own.time_ns
                        // Of results without error the cheapest setting is still to be found.
                        && own.error > 0.0
                        && score.error * margin <= own.error
                })
            };
            if own.iter().all(|own| beaten_by(own).is_some())
                && let Some(((other, _), _)) = own.first().and_then(beaten_by)
            {
                let by = self.space.candidates[*other].name();
                self.out[c] = Some(format!("dominated {margin:.1}-fold in time and error by {by}"));
            }
        }
    }

    fn score(&self, (c, point): &At) -> Score {
        // Only asked of results.
        self.known[*c][point].unwrap_or(Score { time_ns: f64::MAX, mad_ns: 0.0, error: f64::MAX })
    }

    fn best_of(&self, c: usize, goal: Goal) -> Option<Point> {
        let results = self.known[c].iter().filter_map(|(p, s)| Some(((c, p.clone()), (*s)?)));
        pick(results.collect(), goal).map(|(_, point)| point)
    }

    fn choice(&self, goal: Goal) -> Option<At> {
        pick(self.results().collect(), goal)
    }

    fn found(&self, at: &At) -> Found {
        let Score { time_ns, mad_ns, error } = self.score(at);
        let setting = self.space.candidates[at.0].setting(&at.1);
        Found { setting, time_ns, mad_ns, error }
    }

    fn advice(&self, cut_short: bool) -> Advice {
        let goal = self.request.goal;
        let choice = self.choice(goal);
        let technique = |c: usize| &self.space.candidates[c].technique;
        let others = |chosen: &At| -> Vec<(At, Score)> {
            self.results().filter(|((c, _), _)| technique(*c) != technique(chosen.0)).collect()
        };
        let front = front(self.results().collect());
        let at = |p: &(At, Score)| self.found(&p.0);
        let score = choice.as_ref().map(|at| self.score(at));
        Advice {
            met: score.is_some_and(|score| score.meets(goal)),
            runner_up: choice
                .as_ref()
                .and_then(|c| pick(others(c), goal))
                .map(|at| self.found(&at)),
            cheaper: score.and_then(|own| {
                let cheaper = |s: &Score| s.time_ns < own.time_ns && !s.ties(&own);
                front.iter().rfind(|p| cheaper(&p.1)).map(at)
            }),
            better: score.and_then(|own| {
                let better = |s: &Score| s.error < own.error && !s.ties(&own);
                front.iter().find(|p| better(&p.1)).map(at)
            }),
            front: front.iter().map(at).collect(),
            dropped: self.dropped(choice.as_ref()),
            asked: self.asked,
            of: self.space.size(),
            cut_short,
            choice: choice.map(|at| self.found(&at)),
        }
    }

    /// Why each candidate is not the choice.
    fn dropped(&self, choice: Option<&At>) -> Vec<(String, String)> {
        let goal = self.request.goal;
        let mut dropped = Vec::new();
        for (c, candidate) in self.space.candidates.iter().enumerate() {
            if choice.is_some_and(|(chosen, _)| *chosen == c) {
                continue;
            }
            let best = self.best_of(c, goal).map(|point| self.score(&(c, point)));
            let reason = match (&self.out[c], best, &self.failures[c]) {
                (Some(reason), ..) => reason.clone(),
                (None, Some(best), _) => {
                    let ends = if best.meets(goal) { "its best" } else { "misses: its nearest" };
                    let (error, time) = (significant(best.error), duration(best.time_ns));
                    format!("{ends} has {} {error} at {time}", self.request.metric)
                }
                (None, None, Some(reason)) => format!("failed: {reason}"),
                (None, None, None) => "not measured: no time was left".into(),
            };
            dropped.push((candidate.name(), reason));
        }
        dropped
    }
}

/// The nearest to the goal. For the knee, the knee of their front. Otherwise the first of all,
/// then, of those that tie with it in time, the most accurate; and never one that another of them
/// dominates.
fn pick(results: Vec<(At, Score)>, goal: Goal) -> Option<At> {
    if goal == Goal::Knee {
        let front = front(results);
        let points: Vec<[f64; 2]> = front.iter().map(|(_, s)| [s.time_ns, s.error]).collect();
        return knee(&points).map(|i| front[i].0.clone());
    }
    let lead = |a: (At, Score), b: (At, Score)| {
        // Without ties, which are no order.
        let key = |s: &Score| match goal {
            Goal::Error { .. } if s.meets(goal) => (s.time_ns, s.error),
            Goal::Budget { .. } if !s.meets(goal) => (s.time_ns, s.error),
            _ => (s.error, s.time_ns),
        };
        let (meets_a, meets_b) = (a.1.meets(goal), b.1.meets(goal));
        if (meets_b && !meets_a) || (meets_a == meets_b && key(&b.1) < key(&a.1)) { b } else { a }
    };
    let first = results.iter().cloned().reduce(lead)?;
    let mut best = first.clone();
    for result in &results {
        let same = result.1.meets(goal) == first.1.meets(goal) && result.1.ties(&first.1);
        if same && result.1.beats(&best.1, goal) {
            best = result.clone();
        }
    }
    while let Some(other) = results
        .iter()
        .find(|(_, s)| dominates([s.time_ns, s.error], [best.1.time_ns, best.1.error]))
    {
        best = other.clone();
    }
    Some(best.0)
}

/// Those that nothing dominates, by time; of equal ones the first.
fn front(mut results: Vec<(At, Score)>) -> Vec<(At, Score)> {
    results
        .sort_by(|a, b| a.1.time_ns.total_cmp(&b.1.time_ns).then(a.1.error.total_cmp(&b.1.error)));
    let mut front: Vec<(At, Score)> = Vec::new();
    for result in results {
        if front.last().is_none_or(|last| result.1.error < last.1.error) {
            front.push(result);
        }
    }
    front
}
