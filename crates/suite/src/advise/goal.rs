//! What is asked for, and which of two results is nearer to it.

use super::{Answer, Measured};
use dapple_records::front::Constraint;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The cheapest with an error of at most this.
    Error {
        /// Greatest error.
        at_most: f64,
    },
    /// The most accurate within this time.
    Budget {
        /// Greatest time of a frame.
        ns: f64,
    },
    /// Where more time begins to buy little: see [`knee`].
    Knee,
}

/// A goal in a metric, under hard constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Error metric.
    pub metric: String,
    /// What is asked for.
    pub goal: Goal,
    /// What no choice may break.
    pub constraints: Vec<Constraint>,
}

/// Times closer than this share are the same, however small the spread of a few repeats came out.
const LEAST_BAND: f64 = 0.02;

/// What decides about a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Score {
    pub time_ns: f64,
    pub mad_ns: f64,
    pub error: f64,
}

impl Request {
    /// What decides about an answer; `Err` with the reason where it may not be chosen.
    pub(super) fn score(&self, answer: &Answer) -> Result<Score, String> {
        let measured = match answer {
            Answer::Measured(measured) => measured,
            Answer::Failed(reason) => return Err(reason.clone()),
            Answer::Unasked => return Err("not measured".into()),
        };
        let value = |name: &str| measured.errors.get(name).copied().filter(|e| e.is_finite());
        for constraint in &self.constraints {
            match value(&constraint.name) {
                Some(value) if value <= constraint.at_most => {}
                Some(value) => {
                    return Err(format!(
                        "{} is {value}, above {}",
                        constraint.name, constraint.at_most
                    ));
                }
                None => return Err(format!("{} was not measured", constraint.name)),
            }
        }
        let Some(error) = value(&self.metric) else {
            return Err(format!("{} was not measured", self.metric));
        };
        let Measured { time_ns, mad_ns, .. } = *measured;
        if !(time_ns.is_finite() && time_ns > 0.0) {
            return Err("it has no time".into());
        }
        Ok(Score { time_ns, mad_ns: mad_ns.max(0.0), error })
    }
}

impl Score {
    /// Whether two times cannot be told apart: closer than both spreads together.
    pub fn ties(&self, other: &Self) -> bool {
        let band = self.mad_ns + other.mad_ns;
        let least = LEAST_BAND * self.time_ns.min(other.time_ns);
        (self.time_ns - other.time_ns).abs() <= band.max(least)
    }

    /// Whether the goal is met. The knee is met by whatever was found.
    pub fn meets(&self, goal: Goal) -> bool {
        match goal {
            Goal::Error { at_most } => self.error <= at_most,
            Goal::Budget { ns } => self.time_ns <= ns,
            Goal::Knee => true,
        }
    }

    /// Whether this is nearer to the goal than `other`. Of results that meet it, the cheaper one (of
    /// equal times the more accurate) or the more accurate one (of equal errors the cheaper); of
    /// results that miss it, the one that misses by less. For the knee, whose place is not known
    /// while the search goes on, the smaller product of time and error.
    pub fn beats(&self, other: &Self, goal: Goal) -> bool {
        let cheaper = || match self.ties(other) {
            true => (self.error, self.time_ns) < (other.error, other.time_ns),
            false => self.time_ns < other.time_ns,
        };
        let closer = || (self.error, self.time_ns) < (other.error, other.time_ns);
        match (self.meets(goal), other.meets(goal), goal) {
            (true, false, _) => true,
            (false, true, _) => false,
            (true, true, Goal::Error { .. }) | (false, false, Goal::Budget { .. }) => cheaper(),
            (true, true, Goal::Budget { .. }) | (false, false, _) => closer(),
            (true, true, Goal::Knee) => {
                self.time_ns * self.error.max(f64::MIN_POSITIVE)
                    < other.time_ns * other.error.max(f64::MIN_POSITIVE)
            }
        }
    }
}

/// Whether (time, error) `a` is at least as good as `b` in both and better in one.
pub fn dominates(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1])
}

/// The knee of a front of (time, error) sorted by time: the point farthest below the chord between
/// its ends, both axes logarithmic and scaled to the ends. To the left of it a little time buys much
/// accuracy, to the right much time buys little.
///
/// Based on: Satopaa, Albrecht, Irwin, Raghavan, "Finding a 'Kneedle' in a Haystack: Detecting Knee
/// Points in System Behavior", ICDCSW 2011, sections II and III. Deviations: logarithmic axes, no
/// smoothing (a front is monotone), and the greatest distance alone rather than every local one. A
/// front without three points has no chord: of one or two the smaller product is taken.
pub fn knee(front: &[[f64; 2]]) -> Option<usize> {
    // An error of 0 lies infinitely far below: it counts as a thousandth of the least other one.
    let errors = front.iter().map(|p| p[1]).filter(|e| *e > 0.0);
    let floor = 1e-3 * errors.fold(f64::INFINITY, f64::min).min(1.0);
    let logs: Vec<[f64; 2]> =
        front.iter().map(|p| [p[0].max(f64::MIN_POSITIVE).ln(), p[1].max(floor).ln()]).collect();
    let (first, last) = (logs.first()?, logs.last()?);
    let [width, height] = [last[0] - first[0], first[1] - last[1]];
    let depth = |p: &[f64; 2]| match logs.len() {
        // Below the chord from (0, 1) to (1, 0) by 1 - x - y, up to a constant factor.
        3.. if width > 0.0 && height > 0.0 => {
            1.0 - (p[0] - first[0]) / width - (p[1] - last[1]) / height
        }
        _ => -(p[0] + p[1]),
    };
    (0..logs.len()).rev().max_by(|a, b| depth(&logs[*a]).total_cmp(&depth(&logs[*b])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(time_ns: f64, error: f64) -> Score {
        Score { time_ns, mad_ns: 0.0, error }
    }

    #[test]
    fn the_knee_by_hand() {
        // Decades: a drop of two for one, then of a tenth for three: the knee is the second.
        let front = [[1.0, 1.0], [10.0, 0.01], [100.0, 0.0098], [10_000.0, 0.008]];
        assert_eq!(knee(&front), Some(1));
        assert_eq!(knee(&[[1.0, 1.0], [2.0, 0.1]]), Some(1));
        assert_eq!(knee(&[[1.0, 0.0]]), Some(0));
        // An error of 0 is infinitely far down, and yet no chord falls to it.
        assert!(knee(&[[1.0, 0.5], [1.5, 0.2], [2.0, 0.0]]).is_some());
        assert_eq!(knee(&[]), None);
    }

    #[test]
    fn nearer_to_the_goal_by_hand() {
        let error = Goal::Error { at_most: 0.1 };
        assert!(score(5.0, 0.1).beats(&score(1.0, 0.11), error), "meeting it comes first");
        assert!(score(4.0, 0.1).beats(&score(5.0, 0.01), error), "then time");
        assert!(score(5.0, 0.05).beats(&score(4.95, 0.1), error), "times that tie: error");
        assert!(score(9.0, 0.2).beats(&score(1.0, 0.3), error), "missing it by less");
        let budget = Goal::Budget { ns: 5.0 };
        assert!(score(5.0, 0.5).beats(&score(5.1, 0.1), budget));
        assert!(score(5.0, 0.1).beats(&score(1.0, 0.2), budget));
        assert!(score(1.0, 0.1).beats(&score(2.0, 0.1), budget));
        assert!(score(6.0, 0.9).beats(&score(7.0, 0.1), budget));
        for goal in [error, budget, Goal::Knee] {
            assert!(!score(5.0, 0.1).beats(&score(5.0, 0.1), goal));
        }
    }

    #[test]
    fn what_may_not_be_chosen_says_why() {
        let errors = |list: &[(&str, f64)]| {
            Answer::Measured(Measured {
                time_ns: 1.0,
                mad_ns: 0.0,
                errors: list.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
            })
        };
        let request = Request {
            metric: "rmse".into(),
            goal: Goal::Knee,
            constraints: vec![Constraint { name: "wrong".into(), at_most: 0.0 }],
        };
        assert!(request.score(&errors(&[("rmse", 0.1), ("wrong", 0.0)])).is_ok());
        for (answer, why) in [
            (errors(&[("rmse", 0.1), ("wrong", 1.0)]), "wrong is 1, above 0"),
            (errors(&[("rmse", 0.1)]), "wrong was not measured"),
            (errors(&[("rmse", 0.1), ("wrong", f64::NAN)]), "wrong was not measured"),
            (errors(&[("wrong", 0.0)]), "rmse was not measured"),
            (Answer::Failed("it broke".into()), "it broke"),
        ] {
            assert_eq!(request.score(&answer).unwrap_err(), why);
        }
    }
}
