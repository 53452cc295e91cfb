//! Held to recorded exhaustive sweeps: every choice must stand among all rows, of which a fifth may
//! be asked for.

use super::{
    Advice, Answer, Candidate, Dial, Goal, Measured, Oracle, Request, Space, advise, dominates,
};
use crate::{
    SuiteError,
    problem::{Form, Setting},
    problems,
};
use dapple_records::Row;
use std::{collections::BTreeMap, path::Path};

/// Rows of one case with their times as recorded.
struct Sweep {
    rows: Vec<Row>,
    space: Space,
}

/// A setting's name among the rows: technique, variant and knobs as JSON.
fn key(technique: &str, variant: &str, knobs: &crate::knob::Knobs) -> String {
    let knobs: BTreeMap<_, _> = knobs.iter().map(|(n, v)| (n, value(v))).collect();
    format!("{technique}/{variant} {knobs:?}")
}

/// Records write whole floats as they like.
fn value(value: &serde_json::Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), |v| v.to_string())
}

impl Sweep {
    fn load(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records/advise");
        let read = dapple_records::read_file(&path.join(format!("{name}.jsonl"))).unwrap();
        assert!(read.skipped.is_empty(), "{:?}", read.skipped);
        let spec = problems::find(&read.rows[0].problem).unwrap().spec();
        let mut space = Space::default();
        for technique in spec.techniques {
            let own: Vec<&Row> = read.rows.iter().filter(|r| r.technique == technique.id).collect();
            let Some(first) = own.first() else { continue };
            let mut candidate = Candidate::of(technique, &first.variant, Form::Cpu);
            for dial in &mut candidate.dials {
                let seen = |v: &serde_json::Value| {
                    own.iter().any(|row| value(&row.knobs[&dial.name]) == value(v))
                };
                let default = dial.values[dial.default].clone();
                let values: Vec<_> = dial.values.iter().filter(|v| seen(v)).cloned().collect();
                let default = values.iter().position(|v| *v == default).unwrap();
                *dial = Dial { values, default, ..dial.clone() };
            }
            let settings: usize = candidate.dials.iter().map(|d| d.values.len()).product();
            assert_eq!(settings, own.len(), "{}: the sweep is exhaustive", technique.id);
            space.candidates.push(candidate);
        }
        assert_eq!(space.size(), read.rows.len() as u64);
        Self { rows: read.rows, space }
    }

    fn answers(&self) -> BTreeMap<String, Answer> {
        self.rows.iter().map(|r| (key(&r.technique, &r.variant, &r.knobs), answer(r))).collect()
    }

    /// Goals over the whole range of what the rows hold: error limits and budgets from beyond the
    /// least to beyond the greatest, and the knee.
    fn requests(&self) -> Vec<Request> {
        let metrics: Vec<&String> = self.rows[0].errors.keys().collect();
        let mut requests = Vec::new();
        for metric in metrics {
            let request = |goal| Request { metric: metric.clone(), goal, constraints: Vec::new() };
            let mut errors: Vec<f64> = self.rows.iter().map(|r| r.errors[metric]).collect();
            let mut times: Vec<f64> = self.rows.iter().filter_map(Row::median_ns).collect();
            errors.sort_by(f64::total_cmp);
            times.sort_by(f64::total_cmp);
            for share in [0, 1, 5, 10, 20, 30, 40, 50, 60, 80, 100] {
                let at = (self.rows.len() - 1) * share / 100;
                requests.push(request(Goal::Error { at_most: errors[at] }));
                requests.push(request(Goal::Budget { ns: times[at] }));
            }
            requests.push(request(Goal::Error { at_most: 0.9 * errors[0] }));
            requests.push(request(Goal::Budget { ns: 0.9 * times[0] }));
            requests.push(request(Goal::Knee));
        }
        requests
    }

    /// What is wrong with an answer: nothing may dominate it, a goal that some row meets is met, and
    /// a fifth of the rows was asked for at most.
    fn fault(&self, request: &Request, advice: &Advice) -> Option<String> {
        let point = |row: &Row| [row.median_ns().unwrap(), row.errors[&request.metric]];
        let meets = |p: [f64; 2]| match request.goal {
            Goal::Error { at_most } => p[1] <= at_most,
            Goal::Budget { ns } => p[0] <= ns,
            Goal::Knee => true,
        };
        let Some(choice) = &advice.choice else { return Some("no choice".into()) };
        let own = [choice.time_ns, choice.error];
        if !meets(own) && self.rows.iter().any(|r| meets(point(r))) {
            return Some(format!("{own:?} misses a goal that can be met"));
        }
        // Below these shares one of the two is luck: of the clock, of a last digit.
        let beyond = |row: &Row| {
            let ([time, error], mad) = (point(row), row.mad_ns().unwrap() + choice.mad_ns);
            own[0] - time > mad.max(0.02 * time) || own[1] - error > 0.01 * own[1]
        };
        let better = |r: &&Row| dominates(point(r), own) && beyond(r);
        if let Some(row) = self.rows.iter().find(better) {
            let knobs = &row.knobs;
            return Some(format!(
                "{} is dominated by {} {:?}",
                key(&choice.setting.technique, "", &choice.setting.knobs) + &format!("{own:?}"),
                key(&row.technique, "", knobs),
                point(row)
            ));
        }
        (5 * advice.asked > self.rows.len())
            .then(|| format!("{} of {} rows were asked for", advice.asked, self.rows.len()))
    }
}

fn answer(row: &Row) -> Answer {
    Answer::Measured(Measured {
        time_ns: row.median_ns().unwrap(),
        mad_ns: row.mad_ns().unwrap(),
        errors: row.errors.clone(),
    })
}

/// Looks answers up, until as many were asked for as may be.
struct Recorded<'a> {
    answers: &'a BTreeMap<String, Answer>,
    left: usize,
}

impl Oracle for Recorded<'_> {
    fn ask(&mut self, settings: &[Setting]) -> Result<Vec<Answer>, SuiteError> {
        let mut answer = |s: &Setting| {
            if self.left == 0 {
                return Answer::Unasked;
            }
            self.left -= 1;
            self.answers[&key(&s.technique, &s.variant, &s.knobs)].clone()
        };
        Ok(settings.iter().map(&mut answer).collect())
    }
}

const SWEEPS: [&str; 2] = ["spheres", "bunny"];

#[test]
fn the_choice_is_never_dominated_and_a_fifth_of_the_rows_is_enough() {
    let (mut asked, mut worst, mut faults) = (0, 0, Vec::new());
    let mut searches = 0;
    for name in SWEEPS {
        let sweep = Sweep::load(name);
        let answers = sweep.answers();
        for request in sweep.requests() {
            let mut oracle = Recorded { answers: &answers, left: sweep.rows.len() / 5 };
            let advice = advise(&sweep.space, &request, &mut oracle).unwrap();
            if let Some(fault) = sweep.fault(&request, &advice) {
                faults.push(format!("{name} {} {:?}: {fault}", request.metric, request.goal));
            }
            searches += 1;
            asked += advice.asked;
            worst = worst.max(100 * advice.asked / sweep.rows.len());
        }
    }
    eprintln!("{searches} searches, {} asked on average, at most {worst} %", asked / searches);
    assert!(searches >= 300, "{searches}");
    assert!(faults.is_empty(), "{} of {searches}:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn a_search_that_takes_the_first_good_enough_is_caught() {
    let sweep = Sweep::load(SWEEPS[0]);
    let (mut caught, mut tried) = (0, 0);
    for request in sweep.requests() {
        let Goal::Error { at_most } = request.goal else { continue };
        let first = sweep.rows.iter().find(|r| r.errors[&request.metric] <= at_most);
        let Some(row) = first else { continue };
        let mut oracle = Recorded { answers: &sweep.answers(), left: 0 };
        let mut advice = advise(&sweep.space, &request, &mut oracle).unwrap();
        assert!(advice.cut_short && advice.choice.is_none() && advice.asked == 0);
        let (time_ns, mad_ns) = (row.median_ns().unwrap(), row.mad_ns().unwrap());
        let setting = Setting {
            technique: row.technique.clone(),
            variant: row.variant.clone(),
            form: Form::Cpu,
            knobs: row.knobs.clone(),
        };
        advice.choice =
            Some(super::Found { setting, time_ns, mad_ns, error: row.errors[&request.metric] });
        tried += 1;
        caught += usize::from(sweep.fault(&request, &advice).is_some());
    }
    assert!(tried >= 50 && 3 * caught > tried, "{caught} of {tried}");
}
