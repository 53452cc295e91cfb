//! The page as a parser sees it.

use super::plot::{self, Axis, Dot};
use super::*;
use crate::catalogue::{KnobInfo, TechniqueInfo};
use crate::claim::{ClaimFigure, ClaimLine};
use crate::fixtures::{header, row};
use crate::read::Skipped;
use crate::row::Status;
use crate::stress::StressLine;
use scraper::{Html, Selector};

fn info() -> ProblemInfo {
    ProblemInfo {
        id: "shadow-filtering".into(),
        title: "Shadows".into(),
        axis: "rmse".into(),
        extremes: vec![("scale".into(), String::new(), String::new())],
        ..ProblemInfo::default()
    }
}

fn timed(n: u64, ns: u64, rmse: f64) -> Row {
    let mut row = row(n);
    row.technique = format!("technique-{n}");
    row.samples_ns = vec![vec![ns]];
    row.errors.insert("rmse".into(), rmse);
    row.identified()
}

fn triplet(row: &Row) -> Triplet {
    Triplet {
        key: crate::front::key(row),
        setting: "vsm".into(),
        figures: "f".into(),
        png: [vec![1], vec![2], vec![3]],
        size: [4, 3],
    }
}

fn html(read: &Read, triplets: &[Triplet]) -> String {
    let input = Input {
        read,
        problems: &[info()],
        triplets,
        notes: &[],
        time: "2026-01-02T03:04:05.678Z",
        command: "dapple report",
    };
    page(&input)
}

fn parsed(text: &str) -> Html {
    let html = Html::parse_document(text);
    assert_eq!(html.errors, Vec::<String>::new());
    html
}

fn texts(html: &Html, selector: &str) -> Vec<String> {
    let selector = Selector::parse(selector).unwrap();
    html.select(&selector).map(|e| e.text().collect::<String>()).collect()
}

#[test]
fn every_timed_setting_is_a_point_and_a_line_with_time_and_error() {
    let read = Read {
        headers: vec![header("0123456789abcdef")],
        rows: vec![timed(0, 1000, 0.5), timed(1, 2000, 0.25), timed(2, 4000, 0.75)],
        ..Read::default()
    };
    let html = parsed(&html(&read, &[triplet(&read.rows[0])]));
    assert_eq!(texts(&html, "svg.plot .mark").len(), 3);
    assert_eq!(texts(&html, "svg.plot .mark.on").len(), 2);
    let lines = texts(&html, "#shadow-filtering tbody tr");
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert!(lines[0].contains("1.0 µs") && lines[0].contains("0.5"), "{}", lines[0]);
    assert!(lines[2].contains("beaten by technique-1"), "{}", lines[2]);
    assert_eq!(texts(&html, ".legend li").len(), 3);
    let images = Selector::parse("img").unwrap();
    let sources: Vec<_> = html.select(&images).map(|i| i.attr("src").unwrap()).collect();
    let png = "data:image/png;base64,";
    assert_eq!(sources, [format!("{png}AQ=="), format!("{png}Ag=="), format!("{png}Aw==")]);
    // Pictures of another case stay away.
    let other = Row { case: "other".into(), ..read.rows[0].clone() };
    assert!(!super::tests::html(&read, &[triplet(&other)]).contains(png));
}

#[test]
fn nothing_is_loaded_and_nothing_runs() {
    let read = Read { rows: vec![timed(0, 10, 0.5)], ..Read::default() };
    let text = html(&read, &[triplet(&read.rows[0])]);
    let html = parsed(&text);
    assert!(texts(&html, "script, iframe, object, embed").is_empty());
    let carried = Selector::parse("[src], link[href], a[href]").unwrap();
    let mut seen = 0;
    for element in html.select(&carried) {
        let target = element.attr("src").or(element.attr("href")).unwrap();
        assert!(target.starts_with("data:") || target.starts_with('#'), "{target}");
        seen += 1;
    }
    assert!(seen >= 8, "{seen}");
    assert!(!text.contains("@import") && !text.contains("url("));
}

#[test]
fn names_and_reasons_cannot_become_markup() {
    const EVIL: &str = "<script>alert(\"1\")</script>&'";
    let mut bad = timed(0, 10, 0.5);
    for text in [&mut bad.technique, &mut bad.case, &mut bad.view, &mut bad.truth, &mut bad.cpu] {
        *text = EVIL.into();
    }
    bad.knobs.insert(EVIL.into(), EVIL.into());
    let failed = Row {
        status: Status::Failed { stage: EVIL.into(), reason: EVIL.into() },
        ..timed(1, 10, 0.5)
    };
    let claim = ClaimLine {
        problem: "shadow-filtering".into(),
        id: EVIL.into(),
        verdict: EVIL.into(),
        statement: EVIL.into(),
        figures: vec![ClaimFigure { what: EVIL.into(), value: f64::NAN, unit: EVIL.into() }],
        ..ClaimLine::default()
    };
    let point = StressLine {
        problem: "shadow-filtering".into(),
        technique: EVIL.into(),
        axis: "scale".into(),
        verdict: "broken".into(),
        reason: EVIL.into(),
        command: EVIL.into(),
        ..StressLine::default()
    };
    let mut header = header(EVIL);
    header.command = EVIL.into();
    let read = Read {
        headers: vec![header],
        rows: vec![bad, failed],
        claims: vec![claim],
        stress: vec![point],
        skipped: vec![Skipped { path: EVIL.into(), line: 1, reason: EVIL.into() }],
        ..Read::default()
    };
    let text = html(&read, &[Triplet { setting: EVIL.into(), ..triplet(&read.rows[0]) }]);
    let html = parsed(&text);
    assert!(texts(&html, "script").is_empty());
    let shown = texts(&html, "body").concat().matches(EVIL).count();
    assert!(shown >= 12, "shown {shown} times");
    // The control: the parser does find one that is not escaped.
    assert_eq!(texts(&Html::parse_document(&format!("<p>{EVIL}")), "script").len(), 1);
}

#[test]
fn only_turned_knobs_are_listed() {
    let knob = |name: &str, default: i64| KnobInfo {
        name: name.into(),
        default: default.into(),
        ..KnobInfo::default()
    };
    let mut problem = info();
    problem.techniques = vec![TechniqueInfo {
        id: "technique-7".into(),
        knobs: vec![knob("resolution", 7), knob("bias", 0)],
        ..TechniqueInfo::default()
    }];
    let read = Read { rows: vec![timed(7, 10, 0.5)], ..Read::default() };
    let page = page(&Input {
        read: &read,
        problems: &[problem],
        triplets: &[],
        notes: &[],
        time: "",
        command: "",
    });
    let cells = texts(&parsed(&page), "#shadow-filtering td");
    assert_eq!(cells.last().unwrap(), "bias=0.002");
}

#[test]
fn empty_records_say_what_to_run() {
    let html = parsed(&html(&Read::default(), &[]));
    let said = texts(&html, ".nothing code");
    for verb in ["measure", "stress", "claims", "verify"] {
        let command = format!("dapple {verb} shadow-filtering");
        assert!(said.contains(&command), "{said:?}");
    }
    assert!(texts(&html, "svg.plot").is_empty());
}

#[test]
fn what_is_not_ranked_and_what_failed_is_said_with_its_reason() {
    let mut nan = timed(0, 10, 0.5);
    nan.errors.insert("rmse".into(), f64::NAN);
    let failed = Row {
        status: Status::Failed { stage: "check".into(), reason: "off by one".into() },
        ..timed(1, 10, 0.5)
    };
    let read = Read { rows: vec![nan, failed, timed(2, 10, 0.5)], ..Read::default() };
    let html = parsed(&html(&read, &[]));
    assert!(texts(&html, "#shadow-filtering details").concat().contains("rmse is NaN"));
    assert!(texts(&html, "#failures").concat().contains("off by one"));
    assert_eq!(texts(&html, "svg.plot .mark").len(), 1);
}

#[test]
fn the_latest_stress_point_counts_and_a_hole_shows() {
    let point = |value: f64, verdict: &str, time: &str| StressLine {
        problem: "shadow-filtering".into(),
        technique: "vsm".into(),
        axis: "scale".into(),
        value,
        label: value.to_string(),
        verdict: verdict.into(),
        reason: "because".into(),
        time: time.into(),
        ..StressLine::default()
    };
    let read = Read {
        stress: vec![
            point(1.0, "safe", "1"),
            point(2.0, "safe", "1"),
            point(2.0, "broken", "2"),
            point(3.0, "safe", "1"),
        ],
        ..Read::default()
    };
    let mut words = read.clone();
    words.stress.iter_mut().for_each(|p| p.label = format!("kind-{}", p.value));
    let listed = texts(&parsed(&super::tests::html(&words, &[])), "#shadow-filtering td");
    assert!(listed[0].starts_with("safe in kind-1, kind-3"), "{listed:?}");
    let html = parsed(&html(&read, &[]));
    let cells = texts(&html, "#shadow-filtering td");
    assert!(cells[0].starts_with("safe in 1, 3"), "{cells:?}");
    assert!(cells[0].contains("1 of 3 points broke") && cells[0].contains("because"), "{cells:?}");
}

#[test]
fn a_plot_by_hand() {
    let dot = |time_ns: f64, error: f64, on_front: bool| Dot {
        time_ns,
        error,
        series: 0,
        on_front,
        label: String::new(),
    };
    let dots = [dot(1e3, 1.0, true), dot(1e5, 0.0, true), dot(1e4, 1.0, false)];
    let svg = plot::scatter("t", "d", "rmse", &dots).into_string();
    let html = Html::parse_fragment(&svg);
    let circles = Selector::parse("circle").unwrap();
    let at: Vec<(f64, f64)> = html
        .select(&circles)
        .map(|c| (c.attr("cx").unwrap().parse().unwrap(), c.attr("cy").unwrap().parse().unwrap()))
        .collect();
    // The middle of two decades lies in the middle, the zero in its band below all others.
    assert!((at[2].0 - (at[0].0 + at[1].0) / 2.0).abs() <= 0.1, "{at:?}");
    assert_eq!(at[0].1, at[2].1);
    assert!((344.0..370.0).contains(&at[1].1) && at[0].1 < 344.0, "{at:?}");
    // Level to the second point, then down.
    let steps = Selector::parse("path.step").unwrap();
    let path = html.select(&steps).next().unwrap().attr("d").unwrap().to_owned();
    let [(x0, y0), (x1, y1), _] = at[..] else { panic!("{at:?}") };
    assert_eq!(path, format!("M{x0} 14H{x0}V{y0}H{x1}V{y1}H745"));
}

#[test]
fn axes_hold_their_values_at_any_extent() {
    for values in [
        vec![],
        vec![1.0],
        vec![1e-12, 1e12],
        vec![0.0, f64::NAN, f64::INFINITY],
        vec![f64::MIN_POSITIVE, f64::MAX],
        vec![3.0, 4.0],
    ] {
        let axis = Axis::spanning(values.iter().copied(), 70.0, 745.0);
        for value in values.iter().filter(|v| v.is_finite() && **v > 0.0) {
            let at = axis.at(*value);
            assert!((69.9..=745.1).contains(&at), "{values:?}: {at}");
        }
        let ticks = axis.ticks();
        assert!(ticks.len() <= 30, "{values:?}: {} ticks", ticks.len());
        assert!(ticks.iter().all(|t| (69.9..=745.1).contains(&axis.at(*t))));
    }
    let decades = Axis::spanning([1.0, 1e4].into_iter(), 0.0, 1.0).ticks();
    assert_eq!(decades, [1.0, 10.0, 100.0, 1000.0, 1e4]);
    assert_eq!(Axis::spanning([3.0, 8.0].into_iter(), 0.0, 1.0).ticks(), [5.0]);
}

#[test]
fn long_fronts_are_cut_and_say_so() {
    let rows: Vec<Row> = (0..2000).map(|n| timed(n, 1000 + n, 0.5)).collect();
    let text = html(&Read { rows, ..Read::default() }, &[]);
    let html = parsed(&text);
    assert_eq!(texts(&html, "svg.plot .mark").len(), 300);
    assert!(texts(&html, "p.dim").concat().contains("1700 slower dominated settings"));
    assert!(text.len() < 1_000_000, "{}", text.len());
}
