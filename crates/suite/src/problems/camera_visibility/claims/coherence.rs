//! What coherence buys: stalls, changes of state, wasted queries, by CHC and by CHC++.

use super::{
    support::{Path, Shown, asks, chc_plus_plus, lost, mean, path, sum, town},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::Technique;
use std::rc::Rc;

/// An order of magnitude, from half of one on a logarithmic scale.
const NEARLY_TENFOLD: f64 = 3.162_277_660_168_38;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "bittner-1",
            statement: "Coherent hierarchical culling waits less often than stop-and-wait, and asks \
                        less",
            place: "Bittner et al. 2004, section 4; Conte 2018, section 2.2.1",
            method: "three paths through the generated city, 36 frames each, 256 x 144, answers \
                     after 64 operations. Stop-and-wait must stall once a query. Met if CHC stalls \
                     less and asks less on every path and both lose no pixel",
            judge: Box::new(stop_and_wait),
        },
        Claim {
            id: "mattausch-1",
            statement: "Asking in batches takes an order of magnitude fewer changes of state",
            place: "Mattausch et al. 2008, section 3; Conte 2018, section 2.2.1 (of CHC)",
            method: "batches of queries, each a change from drawing to asking and back, on the same \
                     paths: CHC over CHC++, and CHC++ with batches of 1 over batches of 50. Tenfold \
                     on every path: met; on none above the middle of the logarithmic scale, 3.2: \
                     contradicted",
            judge: Box::new(batches),
        },
        Claim {
            id: "dapple-S5.1",
            statement: "CHC++ comes to no stall a frame on a coherent path",
            place: "goal of this project, after Mattausch et al. 2008, section 3",
            method: "stalls a frame in the second half of the same paths, answers after 64 \
                     operations: on average less than one every other frame on every path is met, \
                     one a frame or more on every path is not. What was hidden has to be answered \
                     before the frame can end, so only other work can hide the wait",
            judge: Box::new(stalls),
        },
        Claim {
            id: "dapple-S5.2",
            statement: "Wasted queries fall as visible nodes are assumed visible for longer",
            place: "goal of this project, after Mattausch et al. 2008, section 4.1",
            method: "queries of CHC++ that culled nothing, a frame, on the same paths, for 0, 1, 2, \
                     5, 10 and 20 frames of assumed visibility: met on a path if no step rises and \
                     the last is below half of the first",
            judge: Box::new(wasted),
        },
    ]
}

/// Three coherent paths of the generated city.
///
/// # Errors
/// None that the city's making has not met.
pub fn paths() -> Result<Vec<(&'static str, Rc<Path>)>, SuiteError> {
    let city = town("city", &[])?;
    let one = |(name, step)| Ok((name, path(&city, name, 36, step)?));
    [("street", 1), ("turn", 1), ("tour", 3)].map(one).into_iter().collect()
}

/// Work of stop-and-wait and of CHC on one path.
#[derive(Clone, Copy, Debug, Default)]
struct Waits {
    stalls: [f64; 2],
    queries: [f64; 2],
    lost: u64,
}

fn waits_less(paths: &[Waits]) -> Verdict {
    let sound = paths.iter().all(|w| w.lost == 0 && w.stalls[0] == w.queries[0]);
    if !sound {
        return Verdict::Refuted;
    }
    let less = |w: &Waits| w.stalls[1] < w.stalls[0] && w.queries[1] < w.queries[0];
    vote(&paths.iter().map(less).collect::<Vec<_>>())
}

fn stop_and_wait(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for (name, path) in paths()? {
        let mut waits = Waits::default();
        for (i, technique) in [Technique::StopAndWait, Technique::Chc].into_iter().enumerate() {
            let shown = path.shown(&asks(technique))?;
            let what = format!("{name}, {}", technique.name());
            waits.stalls[i] = sum(&shown, |w| w.stalls);
            waits.queries[i] = sum(&shown, |w| w.queries);
            waits.lost += lost(&shown);
            figures.push(figure(format!("{what}: stalls a frame"), mean(&shown, |w| w.stalls), ""));
            let queries = mean(&shown, |w| w.queries);
            figures.push(figure(format!("{what}: queries a frame"), queries, ""));
        }
        all.push(waits);
    }
    let ratios: Vec<f64> = all.iter().map(|w| w.stalls[1] / w.stalls[0].max(1.0)).collect();
    let because = format!("CHC has {ratios:.2?} of the stalls on the three paths");
    Ok(judged(waits_less(&all), because, figures))
}

/// Times fewer batches, one a path.
fn fewer(ratios: &[f64]) -> Verdict {
    if ratios.is_empty() {
        Verdict::Open
    } else if ratios.iter().all(|r| *r >= 10.0) {
        Verdict::Reproduced
    } else if ratios.iter().any(|r| *r >= NEARLY_TENFOLD) {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn batches(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut by_chc, mut by_one) = (Vec::new(), Vec::new(), Vec::new());
    for (name, path) in paths()? {
        let of = |shown: &[Shown]| mean(shown, |w| w.batches);
        let chc = of(&path.shown(&asks(Technique::Chc))?);
        let fifty = of(&path.shown(&chc_plus_plus(|_| {}))?);
        let one = of(&path.shown(&chc_plus_plus(|s| s.batch = 1))?);
        for (what, value) in [("CHC", chc), ("CHC++", fifty), ("CHC++, batches of 1", one)] {
            figures.push(figure(format!("{name}, {what}: batches a frame"), value, ""));
        }
        by_chc.push(chc / fifty.max(f64::MIN_POSITIVE));
        by_one.push(one / fifty.max(f64::MIN_POSITIVE));
    }
    let because = format!(
        "CHC changes state {by_chc:.1?} times as often as CHC++ on the three paths, CHC++ asking \
         one by one {by_one:.1?} times"
    );
    // What the batches alone do, and what the whole of CHC++ does, must both.
    let verdict = match [fewer(&by_chc), fewer(&by_one)] {
        [a, b] if a == b => a,
        _ => Verdict::Open,
    };
    Ok(judged(verdict, because, figures))
}

/// Stalls a frame, one a path.
fn none(stalls: &[f64]) -> Verdict {
    if stalls.is_empty() {
        Verdict::Open
    } else if stalls.iter().all(|s| *s < 0.5) {
        Verdict::Reproduced
    } else if stalls.iter().all(|s| *s >= 1.0) {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn stalls(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for (name, path) in paths()? {
        let mut later = |what: &str, way| -> Result<f64, SuiteError> {
            let shown = path.shown(&way)?;
            let stalls = mean(&shown[shown.len() / 2..], |w| w.stalls);
            figures.push(figure(format!("{name}, {what}: stalls a frame"), stalls, ""));
            Ok(stalls)
        };
        later("stop-and-wait", asks(Technique::StopAndWait))?;
        later("CHC", asks(Technique::Chc))?;
        later(
            "CHC++ without the queue of visible leaves",
            chc_plus_plus(|s| {
                s.visible_queue = false;
            }),
        )?;
        all.push(later("CHC++", chc_plus_plus(|_| {}))?);
    }
    let because = format!("CHC++ stalls {all:.2?} times a frame on the three paths");
    Ok(judged(none(&all), because, figures))
}

/// Wasted queries a frame at rising spans.
fn falls(values: &[f64]) -> bool {
    let steady = values.windows(2).all(|w| w[1] <= w[0]);
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return false };
    steady && *last < 0.5 * first
}

fn wasted(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let mut figures: Vec<Figure> = Vec::new();
    let mut holds = Vec::new();
    for (name, path) in paths()? {
        let mut values = Vec::new();
        for frames in [0, 1, 2, 5, 10, 20] {
            let shown = path.shown(&chc_plus_plus(|s| s.assumed_visible = frames))?;
            let value = mean(&shown, |w| w.wasted);
            figures.push(figure(
                format!("{name}, assumed visible for {frames}: wasted queries a frame"),
                value,
                "",
            ));
            values.push(value);
        }
        holds.push(falls(&values));
    }
    let because = format!("they fall to below half on {} paths", count(&holds));
    Ok(judged(all_of(&[vote(&holds)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn waiting_less_is_fewer_stalls_and_queries() {
        let good = Waits { stalls: [9.0, 2.0], queries: [9.0, 5.0], lost: 0 };
        assert_eq!(waits_less(&[good]), Reproduced);
        assert_eq!(waits_less(&[Waits { queries: [9.0, 9.5], ..good }]), Refuted);
        assert_eq!(waits_less(&[good, Waits { queries: [9.0, 9.5], ..good }]), Open);
        assert_eq!(waits_less(&[Waits { lost: 1, ..good }]), Refuted);
        assert_eq!(waits_less(&[Waits { stalls: [8.0, 2.0], ..good }]), Refuted);
        assert_eq!(waits_less(&[]), Open);
    }

    #[test]
    fn tenfold_is_tenfold_everywhere() {
        assert_eq!(fewer(&[10.0, 30.0]), Reproduced);
        assert_eq!(fewer(&[10.0, 4.0]), Open);
        assert_eq!(fewer(&[3.0, 2.0]), Refuted);
        assert_eq!(fewer(&[]), Open);
    }

    #[test]
    fn stalls_vanish_or_not() {
        assert_eq!(none(&[0.0, 0.4]), Reproduced);
        assert_eq!(none(&[0.0, 1.4]), Open);
        assert_eq!(none(&[1.0, 1.4]), Refuted);
        assert_eq!(none(&[]), Open);
    }

    #[test]
    fn waste_falls_steadily_and_by_half() {
        assert!(falls(&[9.0, 5.0, 3.0]));
        assert!(!falls(&[9.0, 3.0, 4.0]));
        assert!(!falls(&[9.0, 8.0, 7.0]));
        assert!(!falls(&[]) && !falls(&[f64::NAN, 1.0]));
    }
}
