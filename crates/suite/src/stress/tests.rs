//! Axes as problems declare them, and a fake one pushed in this process.

use super::{
    child::{AxisJob, probe_all},
    line::is_fault,
    *,
};
use crate::{
    problem::{Checked, Facts, FrameTime, Subject, Technique},
    problems,
    run::protocol::Event,
    testing,
};
use dapple_records::{StressLine, safe_set::safe_set};
use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

/// A case at a value; `blunt` ignores it, `sharp` has an error that grows with it, `proud` takes
/// what it must refuse, `broken` has no error at all.
struct Fake(f64);

struct FakeSubject {
    technique: String,
    value: f64,
}

const NEGATIVE: f64 = -1.0;

impl Prepared for Fake {
    fn facts(&self) -> Facts {
        Facts::default()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        if self.0 == NEGATIVE && setting.technique != "proud" {
            return Err(SuiteError::Usage("element 3 is negative".into()));
        }
        Ok(Box::new(FakeSubject { technique: setting.technique.clone(), value: self.0 }))
    }
}

impl Subject for FakeSubject {
    fn frames(&self) -> usize {
        1
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(())
    }

    fn frame(&mut self, _: usize) -> Result<FrameTime, SuiteError> {
        Ok(FrameTime::default())
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        let error = match self.technique.as_str() {
            "sharp" => 0.1 + self.value * 1e-3,
            "broken" => f64::NAN,
            _ => 0.1,
        };
        Ok(Checked { errors: [("rmse".into(), error)].into(), ..Checked::default() })
    }
}

fn axis(values: Values, home: f64, prepared: &Arc<AtomicUsize>) -> Axis {
    let prepared = Arc::clone(prepared);
    Axis {
        id: "fake",
        unit: "m",
        help: "",
        values,
        home,
        parameters: &[],
        forms: &[Form::Cpu],
        criterion: Criterion { metric: "rmse", times: 1.5, plus: 0.0 },
        must_refuse: |value| value == NEGATIVE,
        prepare: Box::new(move |_, value, _| {
            prepared.fetch_add(1, Ordering::Relaxed);
            if value > 1e5 {
                return Err(SuiteError::Usage("nothing in view".into()));
            }
            Ok(Box::new(Fake(value)))
        }),
        setting: Box::new(|setting, value| {
            (setting.technique != "picky" || value < 50.0).then(|| setting.clone())
        }),
    }
}

fn job(techniques: &[&str]) -> AxisJob {
    let setting = |technique: &&str| Setting {
        technique: (*technique).into(),
        variant: "plain".into(),
        form: Form::Cpu,
        knobs: Knobs::new(),
    };
    AxisJob {
        run: "r".into(),
        axis: "fake".into(),
        case: Case {
            problem: "fake".into(),
            scene: "none".into(),
            view: String::new(),
            seed: 0,
            parameters: Knobs::new(),
        },
        settings: techniques.iter().map(setting).collect(),
        done: Vec::new(),
        refine: 6,
        adapter: None,
        fault: None,
    }
}

/// Points by technique, and how often a case was prepared.
fn push(values: Values, home: f64, techniques: &[&str]) -> (Vec<StressLine>, usize) {
    let prepared = Arc::default();
    let mut points = Vec::new();
    let axis = axis(values, home, &prepared);
    probe_all(&mut job(techniques), &axis, None, &mut |event| {
        if let Event::Stress(line) = event {
            points.push(*line);
        }
    })
    .unwrap();
    (points, prepared.load(Ordering::Relaxed))
}

fn of<'a>(points: &'a [StressLine], technique: &str) -> Vec<&'a StressLine> {
    points.iter().filter(|line| line.technique == technique).collect()
}

const DECADES: Values = Values::Log { least: 1e-3, greatest: 1e4, per_decade: 1 };

#[test]
fn a_threshold_is_found_within_resolution_and_who_ignores_the_value_is_safe_everywhere() {
    let (points, prepared) = push(DECADES, 1.0, &["blunt", "sharp"]);
    let blunt = safe_set(&of(&points, "blunt"));
    assert_eq!(blunt.len(), 1);
    assert_eq!((blunt[0].from, blunt[0].to), (1e-3, 1e4));
    assert!(blunt[0].open_below && blunt[0].open_above);
    assert_eq!(of(&points, "blunt").len(), 8, "nothing to refine");
    // 1.5 times the error at home, 0.101, is reached at 51.5.
    let sharp = safe_set(&of(&points, "sharp"));
    assert_eq!(sharp.len(), 1);
    assert!(sharp[0].open_below && !sharp[0].open_above);
    let resolution = (33.0_f64 / 64.0).powi(6);
    let below = (51.5_f64 / sharp[0].to).log10();
    assert!((0.0..=resolution).contains(&below), "{:?}", sharp[0]);
    let broken = of(&points, "sharp").into_iter().filter(|p| p.verdict == "broken");
    let first = broken.min_by(|a, b| a.value.total_cmp(&b.value)).unwrap();
    assert!((first.value / 51.5).log10() <= resolution);
    assert!(first.refined && first.reason.contains("exceeds 0.1515"), "{}", first.reason);
    // The grid once for both, and the six refinements.
    assert_eq!(prepared, 8 + 6);
}

#[test]
fn bad_input_is_right_only_when_refused() {
    let values = Values::Linear { least: NEGATIVE, greatest: 1.0, steps: 2 };
    let (points, _) = push(values, 0.0, &["blunt", "proud"]);
    let at = |technique| {
        let of = of(&points, technique);
        of.into_iter().find(|line| line.value == NEGATIVE).unwrap()
    };
    let refused = at("blunt");
    assert!(refused.is_safe() && refused.must_refuse && !is_fault(refused));
    assert_eq!(
        (refused.verdict.as_str(), refused.reason.as_str()),
        ("refused", "element 3 is negative")
    );
    let accepted = at("proud");
    assert!(!accepted.is_safe() && is_fault(accepted));
    assert!(accepted.reason.contains("accepted"), "{}", accepted.reason);
}

#[test]
fn a_case_that_there_is_not_is_a_limit_with_its_reason_and_no_fault() {
    let values = Values::Log { least: 1e-3, greatest: 1e6, per_decade: 1 };
    let (points, _) = push(values, 1.0, &["blunt"]);
    let last = points.iter().find(|line| line.value == 1e6).unwrap();
    assert_eq!((last.verdict.as_str(), last.reason.as_str()), ("refused", "nothing in view"));
    assert!(!last.is_safe() && !is_fault(last));
    // At home it is the axis that cannot be pushed.
    let prepared = Arc::default();
    let axis = axis(values, 1e6, &prepared);
    let error = probe_all(&mut job(&["blunt"]), &axis, None, &mut |_| ()).unwrap_err();
    assert_eq!((error.to_string().as_str(), error.exit_code()), ("nothing in view", 2));
}

#[test]
fn who_fails_at_home_is_safe_nowhere_and_where_an_axis_means_nothing_there_is_no_point() {
    let (points, _) = push(DECADES, 1.0, &["broken", "picky"]);
    assert_eq!(safe_set(&of(&points, "broken")), []);
    assert!(of(&points, "broken").iter().all(|line| line.reason.contains("not finite")));
    let picky = of(&points, "picky");
    assert_eq!(picky.len(), 5, "{picky:?}");
    assert!(picky.iter().all(|line| line.value < 50.0));
}

#[test]
fn a_search_cut_anywhere_goes_on_without_doing_a_point_twice() {
    let prepared = Arc::default();
    let axis = axis(DECADES, 1.0, &prepared);
    let run = |mut job: AxisJob| {
        let mut lines = Vec::new();
        probe_all(&mut job, &axis, None, &mut |event| {
            if let Event::Stress(line) = event {
                lines.push((line.technique, line.value.to_bits(), line.verdict));
            }
        })
        .unwrap();
        (job.done, lines)
    };
    let (done, mut whole) = run(job(&["blunt", "sharp"]));
    whole.sort();
    for cut in 0..done.len() {
        let mut rest = done[..cut].to_vec();
        rest.reverse();
        let (_, lines) = run(AxisJob { done: rest, ..job(&["blunt", "sharp"]) });
        let before = run(job(&["blunt", "sharp"])).1.into_iter().take(cut);
        let mut all: Vec<_> = before.chain(lines).collect();
        all.sort();
        assert_eq!(all, whole, "cut at {cut}");
    }
}

#[test]
fn labels_read_back_bit_for_bit() {
    for values in [DECADES, Values::Linear { least: -3.0, greatest: 89.9, steps: 7 }] {
        for value in search::grid(values, 1.0) {
            let label = values.label(value);
            assert_eq!(values.parse("x", &label).unwrap().to_bits(), value.to_bits(), "{label}");
        }
    }
    assert_eq!(DECADES.label(1e-3), "0.001");
    let wide = Values::Log { least: 1e-6, greatest: 1e7, per_decade: 1 };
    assert_eq!((wide.label(1e-6).as_str(), wide.label(3.2e7).as_str()), ("1e-6", "3.2e7"));
    let words = Values::Words(&["none", "nan"]);
    assert_eq!((words.label(1.0).as_str(), words.parse("x", "nan").unwrap()), ("nan", 1.0));
    assert_eq!(words.label(7.0), "7");
    let error = words.parse("x", "inf").unwrap_err().to_string();
    assert!(error.contains("there is: none, nan"), "{error}");
    for text in ["1e-4", "1e5", "NaN", "inf", "many", ""] {
        let error = DECADES.parse("scale", text).unwrap_err();
        assert!(error.to_string().contains("axis `scale`"), "{error}");
        assert!(error.to_string().contains("a number in 0.001..=10000"), "{error}");
        assert_eq!(error.exit_code(), 2);
    }
    let whole = Values::Whole { least: 0, greatest: 9, per_decade: 1 };
    assert!(whole.parse("x", "2.5").is_err() && whole.parse("x", "2").is_ok());
}

#[test]
fn every_axis_is_declared_soundly() {
    for problem in problems::ALL {
        let spec = problem.spec();
        let axes = problem.stress();
        for axis in &axes {
            assert_eq!(axis.fault(spec), None, "{} {}", spec.id, axis.id);
            assert!(!axis.help.is_empty() && axis.grid().len() > 1, "{} {}", spec.id, axis.id);
            assert_eq!(axes.iter().filter(|other| other.id == axis.id).count(), 1);
            let plain = |t: &Technique| testing::setting(spec, t.id, "", t.forms[0], &[]);
            let meant = |t: &Technique| (axis.setting)(&plain(t), axis.home).is_some();
            let what = format!("{} {} means nothing to any technique", spec.id, axis.id);
            assert!(spec.techniques.iter().any(meant), "{what}");
            if let Some(fault) = find_axis(*problem, "no-such-axis").err() {
                assert!(fault.to_string().contains(axis.id), "{fault}");
            }
        }
    }
}

#[test]
fn a_careless_declaration_is_caught() {
    let spec = problems::ALL[0].spec();
    let careless = |change: fn(&mut Axis)| {
        let mut axis = axis(DECADES, 1.0, &Arc::default());
        change(&mut axis);
        axis.fault(spec)
    };
    assert_eq!(careless(|_| ()), None);
    let faults: [fn(&mut Axis); 7] = [
        |axis| axis.home = 1e9,
        |axis| axis.home = f64::NAN,
        |axis| axis.must_refuse = |_| true,
        |axis| axis.criterion.metric = "beauty",
        |axis| axis.criterion.times = 0.5,
        |axis| axis.forms = &[],
        |axis| axis.parameters = &[("width", "many")],
    ];
    for (i, fault) in faults.into_iter().enumerate() {
        assert!(careless(fault).is_some(), "fault {i} passed");
    }
}
