//! What coherence buys: stalls, changes of state, wasted queries, by CHC and by CHC++.

use super::{
    support::{Path, Shown, asks, chc_plus_plus, lost, mean, path, sum, town},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_occlusion::camera::{Technique, Work};
use std::rc::Rc;

/// An order of magnitude, from half of one on a logarithmic scale.
const NEARLY_TENFOLD: f64 = 3.162_277_660_168_38;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "bittner-1",
            statement: "Coherent hierarchical culling waits less often than stop-and-wait",
            place: "Bittner et al. 2004, section 4; Conte 2018, section 2.2.1",
            method: "three paths through the generated city, 36 frames each, 256 x 144, answers \
                     after 64 operations. Stop-and-wait must stall once a query. Met if CHC stalls \
                     less on every path and both lose no pixel",
            judge: Box::new(|_| stop_and_wait("stalls", |w| w.stalls)),
        },
        Claim {
            id: "bittner-2",
            statement: "Coherent hierarchical culling asks fewer queries than stop-and-wait",
            place: "Bittner et al. 2004, section 4; Conte 2018, section 2.2.1",
            method: "queries of the same runs: met if CHC asks fewer on every path. It does not ask \
                     about inner nodes in sight, but asks about what is behind before what is in \
                     front is known to show",
            judge: Box::new(|_| stop_and_wait("queries", |w| w.queries)),
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

/// A counter of stop-and-wait and of CHC on one path.
#[derive(Clone, Copy, Debug, Default)]
struct Two {
    /// Whether stop-and-wait stalled once a query and nothing was lost.
    sound: bool,
    counted: [f64; 2],
}

fn less(paths: &[Two]) -> Verdict {
    if paths.iter().any(|p| !p.sound) {
        return Verdict::Refuted;
    }
    vote(&paths.iter().map(|p| p.counted[1] < p.counted[0]).collect::<Vec<_>>())
}

fn stop_and_wait(what: &str, of: fn(&Work) -> u64) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for (name, path) in paths()? {
        let waiting = path.shown(&asks(Technique::StopAndWait))?;
        let coherent = path.shown(&asks(Technique::Chc))?;
        for (technique, shown) in [("stop-and-wait", &waiting), ("CHC", &coherent)] {
            figures.push(figure(
                format!("{name}, {technique}: {what} a frame"),
                mean(shown, of),
                "",
            ));
        }
        let stalls_once = sum(&waiting, |w| w.stalls) == sum(&waiting, |w| w.queries);
        all.push(Two {
            sound: stalls_once && lost(&waiting) + lost(&coherent) == 0,
            counted: [mean(&waiting, of), mean(&coherent, of)],
        });
    }
    let ratios: Vec<f64> = all.iter().map(|t| t.counted[1] / t.counted[0].max(1.0)).collect();
    let because = format!("CHC has {ratios:.2?} of the {what} on the three paths");
    Ok(judged(less(&all), because, figures))
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
    let (mut holds, mut steady) = (Vec::new(), Vec::new());
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
        steady.push(values.windows(2).all(|w| w[1] <= w[0]));
        holds.push(falls(&values));
    }
    let because = format!(
        "they fall at every step on {} paths, and to below half on {}",
        count(&steady),
        count(&holds)
    );
    Ok(judged(all_of(&[vote(&holds)]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn less_is_less_on_every_path() {
        let good = Two { sound: true, counted: [9.0, 2.0] };
        assert_eq!(less(&[good]), Reproduced);
        assert_eq!(less(&[Two { counted: [9.0, 9.5], ..good }]), Refuted);
        assert_eq!(less(&[good, Two { counted: [9.0, 9.5], ..good }]), Open);
        assert_eq!(less(&[Two { sound: false, ..good }]), Refuted);
        assert_eq!(less(&[]), Open);
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
