//! Lanes that wait for each other.

use super::super::LightsCase;
use super::{
    cuts::{TABLE, TREES, lit},
    support::{FINE, PAIRS, Run, VIEWS, cut, on_device, prepared, run, setting, time_ratio},
    verdict::{count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::{Form, Setting},
};
use dapple_many_lights::cut::tile::{Spread, spread};
use serde_json::json;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H3.9",
            statement: "A shallow tree lowers divergence and the variance of what pixels visit",
            place: "Conte 2018, section 3.1",
            method: "R4 at T = 1/25500, four views of the city from the roots and the source's from \
                     precuts, 128 x 72: D (64 times the most visits of 8 x 8 pixels over their sum) \
                     and variance of visits by pixel, revised against Walter's tree and halves. Both \
                     lower is met in a case, both higher contradicts; all cases must agree. The \
                     coefficient of variation, which does not count that there are fewer nodes, \
                     stands beside",
            judge: Box::new(shallow),
        },
        Claim {
            id: "conte-3.1-waiting",
            statement: "Every lane waits for the slowest one, and what it waits is wasted",
            place: "Conte 2018, section 3.1",
            method: "D of the revised tree as above, and of one cut for 8 x 8 pixels, whose lanes \
                     walk together: lanes waste if D of a cut a pixel is 1.1 or more. Whether the \
                     shared cut pays is told by its waited visits and its nodes, both over those of \
                     a cut a pixel; times of the processor, and of a device where there is one, \
                     stand beside. No device decides: it is counted",
            judge: Box::new(waiting),
        },
    ]
}

fn spread_of(case: &LightsCase<'_>, run: &Run) -> Spread {
    spread(&case.world().frames[0], &run.frames[0].visits)
}

/// Whether the revised tree's divergence and variance are both lower than the other's.
fn is_calmer(ours: Spread, theirs: Spread) -> Option<bool> {
    let lower = [ours.divergence < theirs.divergence, ours.variance < theirs.variance];
    match lower {
        [true, true] => Some(true),
        [false, false] => Some(false),
        _ => None,
    }
}

fn shallow(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    for (view, is_culled) in VIEWS.map(|view| (view, false)).into_iter().chain([(TABLE.1, true)]) {
        let case = prepared(TABLE.0, view, &[])?;
        let name = if is_culled { "precuts" } else { view };
        let mut spreads = Vec::new();
        for tree in TREES {
            let run =
                if is_culled { lit(tree, FINE, true)? } else { run(&case, &cut(tree, FINE)?)? };
            let spread = spread_of(&case, &run);
            let variation = spread.variance.sqrt() / spread.mean.max(f64::MIN_POSITIVE);
            figures.extend([
                figure(format!("{name}, {tree}: D"), spread.divergence, ""),
                figure(format!("{name}, {tree}: variance of visits"), spread.variance, ""),
                figure(format!("{name}, {tree}: coefficient of variation"), variation, ""),
            ]);
            spreads.push(spread);
        }
        cases.extend(spreads[1..].iter().map(|theirs| is_calmer(spreads[0], *theirs)));
    }
    let both = cases.iter().filter(|c| **c == Some(true)).count();
    let neither = cases.iter().filter(|c| **c == Some(false)).count();
    let because =
        format!("of {} cases both are lower in {both}, both higher in {neither}", cases.len());
    Ok(judged(super::verdict::vote_open(&cases), because, figures))
}

/// D of cuts a pixel, view by view.
fn wastes(divergences: &[f64]) -> Verdict {
    vote(&divergences.iter().map(|d| *d >= 1.1).collect::<Vec<_>>())
}

fn shared(form: Form, name: &str) -> Result<Setting, SuiteError> {
    setting(name, form, &[("tree", json!("city")), ("threshold", json!(FINE))])
}

fn waiting(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut divergences, mut pays) = (Vec::new(), Vec::new(), Vec::new());
    let [pixel, tile] = ["absolute-cut/pixel", "absolute-cut/tile"];
    for view in VIEWS {
        let case = prepared(TABLE.0, view, &[])?;
        let (own, together) = (shared(Form::Cpu, pixel)?, shared(Form::Cpu, tile)?);
        let (one, all) = (run(&case, &own)?, run(&case, &together)?);
        let ratio = |a: u64, b: u64| a as f64 / b.max(1) as f64;
        let waited = ratio(all.work.lane_visits, one.work.lane_visits);
        let time = time_ratio(&case, &together, &own, PAIRS)?;
        figures.extend([
            figure(format!("{view}: D, a cut a pixel"), one.work.divergence(), ""),
            figure(format!("{view}: D, a cut for 8 x 8"), all.work.divergence(), ""),
            figure(format!("{view}: waited visits, shared over own"), waited, ""),
            figure(
                format!("{view}: nodes of a cut, shared over own"),
                ratio(all.work.cut, one.work.cut),
                "",
            ),
            figure(
                format!("{view}: bounds, shared over own"),
                ratio(all.work.bounds, one.work.bounds),
                "",
            ),
            figure(format!("{view}: time, shared over own, processor"), time.median, ""),
        ]);
        if let Some(gpu) = context.gpu.filter(|_| context.hardware || view == TABLE.1) {
            let case = on_device(TABLE.0, view, &[], gpu)?;
            let pairs = if context.hardware { 4 * PAIRS } else { 1 };
            let (own, together) = (shared(Form::Gpu, pixel)?, shared(Form::Gpu, tile)?);
            let time = time_ratio(&case, &together, &own, pairs)?;
            figures.push(figure(format!("{view}: time, shared over own, device"), time.median, ""));
        }
        divergences.push(one.work.divergence());
        pays.push(waited < 1.0);
    }
    let told: Vec<String> = divergences.iter().map(|d| format!("{d:.2}")).collect();
    let because =
        format!("D is {}; one cut for 8 x 8 waits less in {} views", told.join(", "), count(&pays));
    Ok(judged(wastes(&divergences), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn calmer_is_both() {
        let spread = |divergence, variance| Spread { divergence, variance, mean: 1.0 };
        assert_eq!(is_calmer(spread(1.1, 2.0), spread(1.2, 3.0)), Some(true));
        assert_eq!(is_calmer(spread(1.3, 2.0), spread(1.2, 3.0)), None);
        assert_eq!(is_calmer(spread(1.3, 4.0), spread(1.2, 3.0)), Some(false));
    }

    #[test]
    fn lanes_waste_or_not() {
        assert_eq!(wastes(&[1.2, 1.5]), Reproduced);
        assert_eq!(wastes(&[1.0, 1.5]), Open);
        assert_eq!(wastes(&[1.0, f64::NAN]), Refuted);
    }
}
