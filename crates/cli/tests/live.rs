//! `dapple live` as the dashboard uses it: requests in, events out, nothing that stops it.

mod common;

use common::{dapple, run, said};
use dapple_records::{Feed, FeedLine, Show, Value};
use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, ChildStdin, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

/// Longer than anything here takes, short enough to fail in reasonable time.
const PATIENCE: Duration = Duration::from_secs(120);

struct Live {
    child: Child,
    input: Option<ChildStdin>,
    events: Receiver<Feed>,
    _folder: tempfile::TempDir,
}

impl Live {
    fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut child = dapple(folder.path())
            .arg("live")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, events) = channel();
        let output = BufReader::new(child.stdout.take().unwrap());
        thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                let Ok(Some(FeedLine::Event(event))) = FeedLine::parse(&line) else {
                    panic!("no event: {line}");
                };
                if sender.send(event).is_err() {
                    break;
                }
            }
        });
        let input = child.stdin.take();
        Self { child, input, events, _folder: folder }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.input.as_mut().unwrap().write_all(bytes).unwrap();
    }

    fn ask(&mut self, show: &Show) {
        let line = serde_json::to_string(show).unwrap() + "\n";
        self.send(line.as_bytes());
    }

    /// What is told up to and with the first event that `last` accepts.
    fn until(&self, last: impl Fn(&Feed) -> bool) -> Vec<Feed> {
        let deadline = Instant::now() + PATIENCE;
        let mut told = Vec::new();
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let Ok(event) = self.events.recv_timeout(left) else {
                panic!("the event did not come after {told:?}");
            };
            told.push(event);
            if last(&told[told.len() - 1]) {
                return told;
            }
        }
    }

    /// Closes the input; the exit code.
    fn end(mut self) -> Option<i32> {
        drop(self.input.take());
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            thread::sleep(Duration::from_millis(10));
        }
        self.child.kill().unwrap();
        panic!("it did not end with its input");
    }
}

fn of<const N: usize>(values: [(&str, Value); N]) -> BTreeMap<String, Value> {
    values.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// A case that is ready in no time.
fn show(request: u64) -> Show {
    Show {
        request,
        problem: "shadow-filtering".into(),
        technique: "vsm".into(),
        form: "cpu".into(),
        parameters: of([("width", 48.into()), ("truth_rays", 2.into())]),
        knobs: of([("resolution", 64.into())]),
        ..Show::default()
    }
}

fn is_frame(event: &Feed, of: u64) -> bool {
    matches!(event, Feed::Frame { request, .. } if *request == of)
}

fn is_failed(event: &Feed, of: u64) -> bool {
    matches!(event, Feed::Failed { request, .. } if *request == of)
}

fn names(told: &[Feed]) -> Vec<&'static str> {
    told.iter()
        .map(|event| match event {
            Feed::Stage { stage, .. } if stage == "prepare" => "prepare",
            Feed::Stage { stage, .. } if stage == "check" => "check",
            Feed::Ready { .. } => "ready",
            Feed::Checked { .. } => "checked",
            Feed::Picture { .. } => "picture",
            Feed::Frame { .. } => "frame",
            Feed::Failed { .. } => "failed",
            Feed::Note { .. } => "note",
            _ => "other",
        })
        .filter(|name| *name != "note")
        .collect()
}

fn error(told: &[Feed]) -> f64 {
    let errors = told.iter().find_map(|event| match event {
        Feed::Checked { errors, .. } => errors.get("rmse"),
        _ => None,
    });
    *errors.expect("a check with its error")
}

#[test]
fn a_knob_keeps_the_case_and_a_parameter_does_not() {
    let mut live = Live::start(&[]);
    live.ask(&show(1));
    let first = live.until(|e| is_frame(e, 1));
    assert_eq!(names(&first), ["prepare", "check", "ready", "checked", "picture", "frame"]);
    let Some(Feed::Picture { width, height, truth, .. }) = first.iter().rev().nth(1) else {
        panic!("{first:?}");
    };
    assert_eq!((*width, *height, truth.len()), (48, 27, 48 * 27 * 4 / 3));

    let coarse = Show { knobs: of([("resolution", 16.into())]), ..show(2) };
    live.ask(&coarse);
    let second = live.until(|e| is_frame(e, 2));
    let since = second.iter().position(|e| !is_frame(e, 1)).unwrap();
    assert_eq!(names(&second[since..]), ["check", "checked", "picture", "frame"]);
    assert_ne!(error(&first), error(&second));

    // The same again is answered from what is there, under its own number.
    live.ask(&Show { request: 3, ..coarse });
    let third = live.until(|e| is_frame(e, 3));
    let since = third.iter().position(|e| !is_frame(e, 2)).unwrap();
    assert_eq!(names(&third[since..]), ["checked", "picture", "frame"]);
    assert_eq!(error(&third), error(&second));

    let turned = Show { view: "orbit:90,20,1.5".into(), ..show(4) };
    live.ask(&turned);
    let fourth = live.until(|e| is_frame(e, 4));
    assert!(names(&fourth).contains(&"prepare") && names(&fourth).contains(&"ready"));
    assert_ne!(error(&fourth), error(&first));
    assert_eq!(live.end(), Some(0));
}

#[test]
fn bad_requests_are_refused_by_number_and_the_next_is_answered() {
    let mut live = Live::start(&[]);
    for (request, bad, expect) in [
        (1, Show { technique: "none".into(), ..show(1) }, "no technique `none`; there is: vsm"),
        (2, Show { knobs: of([("resolution", 3.into())]), ..show(2) }, "16..=8192"),
        (3, Show { scene: "no/such.glb".into(), ..show(3) }, "no/such.glb"),
        (4, Show { view: "orbit:1,2".into(), ..show(4) }, "orbit:AZIMUTH,ELEVATION,DISTANCE"),
        (5, Show { scene: "data:x.glb".into(), ..show(5) }, "DAPPLE_DATA"),
    ] {
        live.ask(&bad);
        let told = live.until(|e| is_failed(e, request));
        let Some(Feed::Failed { reason, .. }) = told.last() else { panic!("{told:?}") };
        assert!(reason.contains(expect), "{reason}");
    }
    // A setting that its case refuses costs the setting, not the case.
    live.ask(&show(6));
    live.until(|e| is_frame(e, 6));
    let three = Show {
        technique: "lvsm".into(),
        knobs: of([("resolution", 64.into()), ("layers", 3.into())]),
        ..show(7)
    };
    live.ask(&three);
    live.until(|e| is_failed(e, 7));
    live.ask(&show(8));
    let told = live.until(|e| is_frame(e, 8));
    assert!(!names(&told).contains(&"prepare"), "{told:?}");
    assert_eq!(live.end(), Some(0));
}

#[test]
fn no_line_stops_it() {
    let mut live = Live::start(&[]);
    live.send(b"rubbish\n\xff\xfe\x00\n{}\n[[[[\n\n\r\n{\"request\":12}\n");
    live.until(|e| is_failed(e, 12));
    live.send(&vec![b'['; 3 << 20]);
    live.send(b"\n");
    live.until(|e| matches!(e, Feed::Failed { reason, .. } if reason.contains("bytes")));
    live.ask(&show(13));
    live.until(|e| is_frame(e, 13));
    assert_eq!(live.end(), Some(0));
}

#[test]
fn of_a_storm_the_last_is_answered_and_few_others() {
    let mut live = Live::start(&[]);
    let mut storm = String::new();
    for request in 1..=400 {
        let resolution = if request % 2 == 0 { 64 } else { 32 };
        let one = Show { knobs: of([("resolution", resolution.into())]), ..show(request) };
        storm += &(serde_json::to_string(&one).unwrap() + "\n");
    }
    live.send(storm.as_bytes());
    let told = live.until(|e| is_frame(e, 400));
    let checked: Vec<u64> = told
        .iter()
        .filter_map(|e| match e {
            Feed::Checked { request, .. } => Some(*request),
            _ => None,
        })
        .collect();
    assert_eq!(checked.last(), Some(&400));
    assert!(checked.is_sorted(), "{checked:?}");
    // Reading a line takes microseconds, preparing a case much longer.
    assert!(checked.len() <= 20, "{checked:?}");
    assert!(
        !told.iter().any(|e| matches!(e, Feed::Failed { .. })),
        "a replaced one has not failed"
    );
    assert_eq!(live.end(), Some(0));
}

#[test]
fn what_was_asked_last_is_answered_after_the_input_ended() {
    let mut live = Live::start(&[]);
    live.ask(&show(5));
    drop(live.input.take());
    let told = live.until(|e| matches!(e, Feed::Picture { request: 5, .. }));
    assert!(error(&told) > 0.0);
    assert_eq!(live.end(), Some(0));
    // And without any request it just ends.
    assert_eq!(Live::start(&[]).end(), Some(0));
}

#[test]
fn frames_come_at_a_pace_for_the_eye() {
    let mut live = Live::start(&[]);
    live.ask(&show(1));
    live.until(|e| is_frame(e, 1));
    let begun = Instant::now();
    for _ in 0..15 {
        live.until(|e| is_frame(e, 1));
    }
    // 15 frames at 30 a second are half a second; a loaded machine is slower, never faster.
    assert!(begun.elapsed() > Duration::from_millis(350), "{:?}", begun.elapsed());
    assert_eq!(live.end(), Some(0));
}

#[test]
fn an_oracle_is_shown_and_never_timed_and_a_problem_without_pictures_has_none() {
    let mut live = Live::start(&[]);
    live.ask(&Show { form: "reference".into(), ..show(1) });
    live.until(|e| matches!(e, Feed::Picture { request: 1, .. }));
    live.ask(&Show {
        problem: "partition-offsets".into(),
        technique: "cpu-thread".into(),
        parameters: of([("leaves", 5000.into()), ("cells", 16.into()), ("frames", 3.into())]),
        knobs: BTreeMap::new(),
        ..show(2)
    });
    let told = live.until(|e| is_frame(e, 2));
    assert!(!told.iter().any(|e| is_frame(e, 1)), "an oracle has no time");
    assert!(!told.iter().any(|e| matches!(e, Feed::Picture { request: 2, .. })), "{told:?}");
    let frames = told.iter().find_map(|e| match e {
        Feed::Ready { frames, .. } => Some(*frames),
        _ => None,
    });
    assert_eq!(frames, Some(3));
    assert_eq!(live.end(), Some(0));
}

#[test]
fn an_adapter_that_is_not_there_costs_its_forms_only() {
    let mut live = Live::start(&["--adapter", "no-such-adapter"]);
    for request in [1, 2] {
        live.ask(&Show { form: "gpu".into(), ..show(request) });
        let told = live.until(|e| is_failed(e, request));
        let Some(Feed::Failed { reason, .. }) = told.last() else { panic!("{told:?}") };
        assert!(reason.contains("adapter"), "{reason}");
    }
    live.ask(&show(3));
    live.until(|e| is_frame(e, 3));
    assert_eq!(live.end(), Some(0));
}

#[test]
fn a_view_that_was_turned_live_is_rendered_by_the_same_words() {
    let folder = tempfile::tempdir().unwrap();
    let render = |view: &str, output: &Path| {
        let out = output.to_string_lossy().into_owned();
        let common = ["render", "shadow-filtering", "vsm", "--knob", "resolution=64"];
        let case = ["--param", "width=48", "--param", "truth_rays=2", "--view", view, "-o", &out];
        run(folder.path(), &[&common[..], &case[..]].concat())
    };
    let first = folder.path().join("first");
    let turned = folder.path().join("turned");
    for (view, output) in [("orbit:0,0,1", &first), ("orbit:90,20,1.5", &turned)] {
        let done = render(view, output);
        assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    }
    let read = |folder: &Path| std::fs::read(folder.join("truth.png")).unwrap();
    assert_ne!(read(&first), read(&turned));
    let bad = render("orbit:1,2", &first);
    assert_eq!(bad.status.code(), Some(2));
    assert!(said(&bad).contains("orbit:AZIMUTH,ELEVATION,DISTANCE"), "{}", said(&bad));
}
