//! Looking for the worst cluster, against looking at each alone.

use super::super::LightsCase;
use super::{
    cuts::TABLE,
    support::{FINE, PAIRS, cut, on_device, prepared, run, setting, time_ratio},
    verdict::{figure, judged, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::{Form, Setting},
};
use serde_json::json;

/// Trees that both are given.
const TREES: [&str; 2] = ["city", "original"];

/// Columns on the processor, where lists take their time.
const SMALL: u32 = 64;

/// Pairs of frames timed there.
const FEW: usize = 3;

/// Halvings of the logarithm of T until both are as exact.
const HALVINGS: usize = 12;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H3.8",
        statement: "On a GPU, splitting the worst cluster, found in a list or by a heap, is slower \
                    than testing each cluster alone",
        place: "Conte 2018, section 3.2",
        method: "close-ended street of the city, 128 x 72 (64 x 36 but on hardware), Lightcuts at 2 % \
                 and at most 1,000 nodes against R4 at the coarsest T whose error (99th percentile) \
                 is not larger, over the revised and over Walter's tree. Time on a device, the list's over R4's: above 1 with \
                 both trees is met on hardware, below 1 with both contradicts. Visits, and times of \
                 list and heap on the processor, stand beside. No heap runs on the device",
        judge: Box::new(selection),
    }]
}

fn lightcuts(form: Form, tree: &str, selection: &str) -> Result<Setting, SuiteError> {
    setting("lightcuts", form, &[("tree", json!(tree)), ("selection", json!(selection))])
}

/// The coarsest threshold at which R4's error is no larger than `error`, between a thousandth of the
/// source's and a thousand times it.
fn as_exact(case: &LightsCase<'_>, tree: &str, error: f64) -> Result<f64, SuiteError> {
    let [mut least, mut most] = [FINE * 1e-3, FINE * 1e3].map(f64::ln);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        let is_exact = run(case, &cut(tree, middle.exp())?)?.error("error_p99") <= error;
        if is_exact { least = middle } else { most = middle }
    }
    Ok(least.exp())
}

/// Times on hardware, of list over R4.
fn slower(ratios: &[f64], is_hardware: bool) -> Verdict {
    if !is_hardware || ratios.is_empty() {
        return Verdict::NeedsHardware;
    }
    let one = |r: &f64| {
        if *r > 1.0 {
            Some(true)
        } else if *r < 1.0 {
            Some(false)
        } else {
            None
        }
    };
    vote_open(&ratios.iter().map(one).collect::<Vec<_>>())
}

fn selection(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(TABLE.0, TABLE.1, &[("width", json!(SMALL))])?;
    let (mut figures, mut ratios, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for tree in TREES {
        let [heap, list] =
            [lightcuts(Form::Cpu, tree, "heap")?, lightcuts(Form::Cpu, tree, "scan")?];
        let found = run(&case, &heap)?;
        let threshold = as_exact(&case, tree, found.error("error_p99"))?;
        let alone = cut(tree, threshold)?;
        let tested = run(&case, &alone)?;
        let by_heap = time_ratio(&case, &heap, &alone, FEW)?.median;
        let by_list = time_ratio(&case, &list, &alone, FEW)?.median;
        figures.extend([
            figure(
                format!("{tree}: error of Lightcuts, 99th percentile"),
                found.error("error_p99"),
                "",
            ),
            figure(format!("{tree}: T as exact"), threshold, ""),
            figure(format!("{tree}: visits a pixel, Lightcuts"), found.a_pixel(|w| w.visits), ""),
            figure(format!("{tree}: visits a pixel, R4"), tested.a_pixel(|w| w.visits), ""),
            figure(
                format!("{tree}: cuts ended at 1,000 nodes"),
                100.0 * found.a_pixel(|w| w.ended),
                "%",
            ),
            figure(format!("{tree}: time of the heap over R4's, processor"), by_heap, ""),
            figure(format!("{tree}: time of the list over R4's, processor"), by_list, ""),
        ]);
        told.push(format!("{tree} {by_list:.1} (heap {by_heap:.1})"));
        if let Some(gpu) = context.gpu {
            let width = if context.hardware { 128 } else { SMALL };
            let case = on_device(TABLE.0, TABLE.1, &[("width", json!(width))], gpu)?;
            let pairs = if context.hardware { 2 * PAIRS } else { 1 };
            let [list, alone] = [list, alone].map(|s| Setting { form: Form::Gpu, ..s });
            let time = time_ratio(&case, &list, &alone, pairs)?.median;
            figures.push(figure(format!("{tree}: time of the list over R4's, device"), time, ""));
            ratios.push(time);
        }
    }
    let device: Vec<String> = ratios.iter().map(|r| format!("{r:.1}")).collect();
    let because = format!(
        "time of the list over R4's: {} on the processor; on the device {}",
        told.join(", "),
        if device.is_empty() { "unknown".into() } else { device.join(", ") }
    );
    Ok(judged(slower(&ratios, context.hardware), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn lists_are_slower_or_not() {
        assert_eq!(slower(&[2.0, 3.0], true), Reproduced);
        assert_eq!(slower(&[0.5, 3.0], true), Open);
        assert_eq!(slower(&[0.5, 0.9], true), Refuted);
        assert_eq!(slower(&[f64::NAN, 2.0], true), Open);
        assert_eq!(slower(&[2.0], false), NeedsHardware);
        assert_eq!(slower(&[], true), NeedsHardware);
    }
}
