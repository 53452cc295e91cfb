//! What each option of CHC++ does, by counters.

use super::{
    coherence::paths,
    support::{Shown, chc_plus_plus, lost, mean, path, town},
    verdict::{count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{Settings, TightBounds, Work};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "mattausch-2",
            statement: "A random first interval spreads the queries of visible nodes over frames",
            place: "Mattausch et al. 2008, section 4.1; Conte 2018, section 2.2.1",
            method: "queries of a frame, from the twelfth on, 48 frames of two still views of the \
                     generated city and its three paths: standard deviation over mean, with and \
                     without. Still views show it bare: what comes into sight together is asked \
                     together. Met where it is less with; the vote is over all",
            judge: Box::new(jitter),
        },
        Claim {
            id: "mattausch-3",
            statement: "Asking about several hidden nodes together takes fewer queries",
            place: "Mattausch et al. 2008, section 4.2; Conte 2018, section 2.2.1",
            method: "queries a frame with multiqueries and without, on the three paths of 36 frames: \
                     fewer on every path is met; a pixel lost contradicts",
            judge: Box::new(|_| option("queries a frame", &MULTIQUERIES)),
        },
        Claim {
            id: "mattausch-4",
            statement: "Closer boxes cull more than a node's own: fewer triangles are drawn",
            place: "Mattausch et al. 2008, section 4.3",
            method: "triangles drawn a frame with boxes of descendants to depth 3 and without, on \
                     the same paths; boxes asked stand beside them, which is what it costs",
            judge: Box::new(|_| option("triangles a frame", &TIGHT)),
        },
        Claim {
            id: "mattausch-5",
            statement: "Asking about visible leaves while waiting takes stalls away",
            place: "Mattausch et al. 2008, section 3",
            method: "stalls a frame with the queue of visible leaves and without, on the same paths; \
                     answers after 64 operations",
            judge: Box::new(|_| option("stalls a frame", &VISIBLE_QUEUE)),
        },
    ]
}

/// An option: how it is turned off, and the counters it is seen by, first the one that decides.
struct Switch {
    off: fn(&mut Settings),
    decides: fn(&Work) -> u64,
    beside: (&'static str, fn(&Work) -> u64),
}

const MULTIQUERIES: Switch = Switch {
    off: |s| s.multiqueries = false,
    decides: |w| w.queries,
    beside: ("boxes asked", |w| w.boxes),
};
const TIGHT: Switch = Switch {
    off: |s| s.tight_bounds = TightBounds::OFF,
    decides: |w| w.triangles,
    beside: ("boxes asked", |w| w.boxes),
};
const VISIBLE_QUEUE: Switch = Switch {
    off: |s| s.visible_queue = false,
    decides: |w| w.stalls,
    beside: ("batches", |w| w.batches),
};

/// Counters with and without on each path, and pixels lost.
fn helps(pairs: &[[f64; 2]], lost: u64) -> Verdict {
    if lost > 0 {
        return Verdict::Refuted;
    }
    vote(&pairs.iter().map(|[with, without]| with < without).collect::<Vec<_>>())
}

fn option(what: &str, switch: &Switch) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs, mut gone) = (Vec::new(), Vec::new(), 0);
    for (name, path) in paths()? {
        let with = path.shown(&chc_plus_plus(|_| {}))?;
        let without = path.shown(&chc_plus_plus(switch.off))?;
        gone += lost(&with) + lost(&without);
        for (on, shown) in [("with", &with), ("without", &without)] {
            let value = mean(shown, switch.decides);
            figures.push(figure(format!("{name}, {on}: {what}"), value, ""));
            let (beside, of) = switch.beside;
            figures.push(figure(format!("{name}, {on}: {beside} a frame"), mean(shown, of), ""));
        }
        pairs.push([mean(&with, switch.decides), mean(&without, switch.decides)]);
    }
    let ratios: Vec<f64> = pairs.iter().map(|[a, b]| a / b.max(f64::MIN_POSITIVE)).collect();
    let because = format!("{what} are {ratios:.2?} of those without, on the three paths");
    Ok(judged(helps(&pairs, gone), because, figures))
}

/// Standard deviation over mean of the queries of a frame, once all has settled.
fn spread(shown: &[Shown]) -> f64 {
    let queries: Vec<f64> = shown.iter().skip(12).map(|s| s.work.queries as f64).collect();
    let n = queries.len().max(1) as f64;
    let mean = queries.iter().sum::<f64>() / n;
    let variance = queries.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / n;
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}

fn jitter(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let city = town("city", &[])?;
    let mut cases = Vec::new();
    for view in ["close_ended", "birds_eye"] {
        cases.push((view, path(&city, view, 48, 1)?));
    }
    cases.extend(paths()?);
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for (name, path) in cases {
        let with = spread(&path.shown(&chc_plus_plus(|_| {}))?);
        let without = spread(&path.shown(&chc_plus_plus(|s| s.jitter = false))?);
        figures.push(figure(format!("{name}, with: spread of queries"), with, ""));
        figures.push(figure(format!("{name}, without: spread of queries"), without, ""));
        holds.push(with < without);
    }
    let because = format!("queries are spread more evenly in {} cases", count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn an_option_helps_everywhere_or_not() {
        assert_eq!(helps(&[[1.0, 2.0], [3.0, 4.0]], 0), Reproduced);
        assert_eq!(helps(&[[1.0, 2.0], [4.0, 4.0]], 0), Open);
        assert_eq!(helps(&[[2.0, 2.0]], 0), Refuted);
        assert_eq!(helps(&[[1.0, 2.0]], 1), Refuted);
    }

    #[test]
    fn even_queries_have_no_spread() {
        let shown =
            |queries| Shown { work: Work { queries, ..Work::default() }, drawn: vec![], lost: 0 };
        let even: Vec<Shown> = (0..20).map(|_| shown(7)).collect();
        let odd: Vec<Shown> = (0..20).map(|i| shown(if i % 2 == 0 { 0 } else { 10 })).collect();
        assert_eq!(spread(&even), 0.0);
        assert!((spread(&odd) - 1.0).abs() < 1e-12);
        assert_eq!(spread(&[]), 0.0);
    }
}
