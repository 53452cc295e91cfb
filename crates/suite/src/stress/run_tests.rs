//! Deaths of the pushing process, played by a shell script in its place.

use super::*;
use crate::{problem::Form, testing::played_by};
use std::sync::atomic::Ordering;

/// One axis of a real problem; the script decides what becomes of it.
fn plan(limit_s: u64) -> StressPlan {
    let problem = problems::find("partition-offsets").unwrap();
    let block = Measure {
        problem: "partition-offsets".into(),
        scenes: Vec::new(),
        views: Vec::new(),
        seeds: Vec::new(),
        parameters: BTreeMap::new(),
        forms: vec![Form::Cpu],
        knobs: BTreeMap::new(),
        technique: Vec::new(),
    };
    let axes = axes(problem, &["factors".into()], &block).unwrap();
    assert_eq!((axes.len(), axes[0].settings.len()), (1, 2));
    StressPlan { axes, refine: 0, limit_s }
}

fn run_script(script: &str, limit_s: u64) -> Finished {
    let folder = tempfile::tempdir().unwrap();
    let never = AtomicBool::new(false);
    let options = played_by(script, folder.path());
    run(&plan(limit_s), &options, &never, &mut |_| ()).unwrap()
}

/// The script dies at each point that is asked of it, having said where it is.
const DIES: &str = r#"read job; case "$job" in *'"setting":0,"value":0.0'*) s=1;; *) s=0;; esac
echo '{"event":"begin","setting":'$s',"stage":"check","value":0.0}'; echo 'it broke' >&2; exit 3"#;

#[test]
fn a_death_is_a_point_for_its_culprit_and_the_others_go_on() {
    let finished = run_script(DIES, 60);
    let crashed: Vec<_> = finished.points.iter().map(|p| p.technique.as_str()).collect();
    assert_eq!(crashed, ["cpu-thread", "cpu-threads"]);
    for point in &finished.points {
        assert_eq!((point.verdict.as_str(), point.value), ("crashed", 0.0));
        assert_eq!((point.adapter.as_str(), point.device.as_str()), ("cpu", "cpu"));
        assert!(point.reason.contains("it broke"), "{}", point.reason);
        assert!(!point.is_safe() && super::super::line::is_fault(point));
    }
    // The third process says that it is at a point that is known: nothing goes round for ever.
    assert_eq!(finished.failed.len(), 1);
    assert!(finished.failed[0].0.contains("without a point"), "{:?}", finished.failed);
}

#[test]
fn a_hang_meets_the_limit_of_its_stage() {
    let script = DIES.replace("exit 3", "sleep 60");
    let begun = Instant::now();
    let finished = run_script(&script, 1);
    assert!(begun.elapsed() < Duration::from_secs(30));
    assert_eq!(finished.points.len(), 2);
    assert!(finished.points.iter().all(|p| p.reason == "no end after 1 s"), "{finished:?}");
}

#[test]
fn a_death_while_preparing_is_every_waiting_techniques() {
    let script = r#"read job
        echo '{"event":"begin","setting":99,"stage":"prepare","value":0.0}'; kill -9 $$"#;
    let finished = run_script(script, 60);
    assert_eq!(finished.points.len(), 2);
    assert!(finished.points.iter().all(|p| p.reason.contains("SIGKILL")), "{finished:?}");
}

#[test]
fn an_axis_that_cannot_begin_fails_with_its_code() {
    let script = r#"read job; echo '{"event":"failed","reason":"no such scene","code":2}'"#;
    let finished = run_script(script, 60);
    assert_eq!(finished.points.len(), 0);
    let expected = "partition-offsets factors crown: no such scene";
    assert_eq!(finished.failed, [(expected.to_string(), 2)]);
    let finished = run_script("exit 7", 60);
    assert_eq!(finished.failed[0].1, 3);
}

#[test]
fn a_stopped_run_is_resumed_with_its_points() {
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let options = played_by(DIES, folder.path());
    let error = run(&plan(60), &options, &stop, &mut |progress| {
        if matches!(progress, Progress::Point(_)) {
            stop.store(true, Ordering::Relaxed);
        }
    })
    .unwrap_err();
    let SuiteError::Interrupted { done: 1, path, .. } = error else { panic!("{error}") };
    let mut resumed = 0;
    let finished = run(&plan(60), &options, &AtomicBool::new(false), &mut |progress| {
        if let Progress::Started { resumed: found, .. } = progress {
            resumed = found;
        }
    })
    .unwrap();
    assert_eq!((resumed, &finished.path), (1, &path));
    assert_eq!(finished.points.len(), 2);
    assert_eq!(dapple_records::read_file(&path).unwrap().stress, finished.points);
}

#[test]
fn unknown_axes_and_two_cases_of_one_name_are_refused() {
    let problem = problems::find("partition-offsets").unwrap();
    let mut block = Measure {
        problem: "partition-offsets".into(),
        scenes: Vec::new(),
        views: Vec::new(),
        seeds: Vec::new(),
        parameters: BTreeMap::new(),
        forms: Vec::new(),
        knobs: BTreeMap::new(),
        technique: Vec::new(),
    };
    let error = axes(problem, &["beauty".into()], &block).unwrap_err();
    assert!(error.to_string().contains("there is: "), "{error}");
    block.parameters.insert("frames".into(), vec![1.into(), 2.into()]);
    let error = axes(problem, &[], &block).unwrap_err();
    assert!(error.to_string().contains("one value"), "{error}");
    assert_eq!(error.exit_code(), 2);
}
