//! What the thesis says of extraction (Gumbau 2011, §3.7), judged.

use super::{
    case::Crown,
    spec::{CROWN, SPEC},
    subject,
};
use crate::{
    SuiteError,
    case::Case,
    claims::{Claim, ClaimContext, Judged, Verdict, figure},
    knob::{self, Knobs},
    problem::Form,
};
use dapple_metrics::stats;

/// The thesis's largest crown, *Cedrus atlantica* (Table 3.1).
const CEDRUS: i64 = 131_042;

/// The claims.
pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H3.2",
            statement: "Extraction costs a fixed part and a part in proportion to the kept leaves",
            place: "Gumbau 2011, §3.7, Table 3.3",
            method: "least-squares line of bytes moved against kept leaves over a path of 24 \
                     factors, thread per cell's counters (cpu-thread without an adapter); \
                     reproduced if R² >= 0.999; the time's R² is printed beside it",
            judge: Box::new(affine),
        },
        Claim {
            id: "gumbau-H3.3",
            statement: "The same algorithm on one processor core loses to the graphics device",
            place: "Gumbau 2011, §3.7 (L1039)",
            method: "median path time, cpu-thread over the best gpu variant on the largest crown; \
                     judged on hardware only",
            judge: Box::new(device_wins),
        },
        Claim {
            id: "gumbau-H3.13",
            statement: "A change of detail moves no geometry over the bus",
            place: "Gumbau 2011, §3.1 (L723, L746)",
            method: "bytes uploaded a frame by the device variants must be at most the factors \
                     (4 a cell) and not grow with the kept leaves; cpu-upload is the contrast",
            judge: Box::new(no_upload),
        },
    ]
}

fn crown<'g>(context: &ClaimContext<'g>) -> Result<Crown<'g>, SuiteError> {
    let given = Knobs::from([("leaves".into(), CEDRUS.into())]);
    let case = Case {
        problem: SPEC.id.into(),
        scene: CROWN.into(),
        view: String::new(),
        seed: 0,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    };
    Crown::prepare(&case, context.gpu)
}

/// Kept leaves, bytes moved, bytes uploaded and time, frame by frame.
struct Path {
    kept: Vec<f64>,
    bytes: Vec<f64>,
    uploaded: Vec<f64>,
    ns: Vec<f64>,
}

fn path(crown: &Crown<'_>, technique: &str) -> Result<Path, SuiteError> {
    let mut path = Path { kept: vec![], bytes: vec![], uploaded: vec![], ns: vec![] };
    let mut packer = subject::packer(technique, crown.gpu, &crown.cells)?;
    for q in &crown.factors {
        let mut times = Vec::new();
        for _ in 0..5 {
            let time = packer.frame(crown.gpu, &crown.cells, q)?;
            times.push(time.wall_ns as f64);
        }
        let counters = packer.counters();
        path.kept.push(counters.leaves_kept as f64);
        path.bytes.push((counters.bytes_read + counters.bytes_written) as f64);
        path.uploaded.push(counters.bytes_uploaded as f64);
        path.ns.push(stats::median(&times)?);
    }
    Ok(path)
}

/// Intercept, slope and R² of the least-squares line.
fn line(x: &[f64], y: &[f64]) -> (f64, f64, f64) {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(a, b)| f(*a, *b)).sum::<f64>();
    let (xx, xy) = (sum(&|a, _| (a - mx).powi(2)), sum(&|a, b| (a - mx) * (b - my)));
    let slope = xy / xx;
    let rest = sum(&|a, b| (b - my - slope * (a - mx)).powi(2));
    (my - slope * mx, slope, 1.0 - rest / sum(&|_, b| (b - my).powi(2)))
}

fn affine(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let crown = crown(context)?;
    let technique = if context.gpu.is_some() { "thread-per-cell" } else { "cpu-thread" };
    let path = path(&crown, technique)?;
    let (fixed, slope, fit) = line(&path.kept, &path.bytes);
    let (fixed_ns, slope_ns, fit_ns) = line(&path.kept, &path.ns);
    let verdict = if fit >= 0.999 { Verdict::Reproduced } else { Verdict::Refuted };
    Ok(Judged {
        verdict,
        figures: vec![
            figure(format!("{technique}: bytes, fixed"), fixed, "B"),
            figure(format!("{technique}: bytes a kept leaf"), slope, "B"),
            figure(format!("{technique}: bytes, R²"), fit, ""),
            figure(format!("{technique}: time, fixed (thesis: 0.50 ms)"), fixed_ns / 1e6, "ms"),
            figure(format!("{technique}: time a kept leaf (thesis: 21.7 ns)"), slope_ns, "ns"),
            figure(format!("{technique}: time, R² (thesis: 0.94)"), fit_ns, ""),
        ],
        because: format!("bytes are affine in kept leaves with R² = {fit:.5} ({CEDRUS} leaves)"),
    })
}

fn device_wins(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let crown = crown(context)?;
    let total = |technique: &str| path(&crown, technique).map(|p| p.ns.iter().sum::<f64>());
    let processor = total("cpu-thread")?;
    let mut figures = vec![figure("cpu-thread, the whole path", processor / 1e6, "ms")];
    let mut best = f64::INFINITY;
    if context.gpu.is_some() {
        for technique in SPEC.techniques.iter().filter(|t| t.forms.contains(&Form::Gpu)) {
            let ns = total(technique.id)?;
            figures.push(figure(format!("{}, the whole path", technique.id), ns / 1e6, "ms"));
            if technique.id != "cpu-upload" {
                best = best.min(ns);
            }
        }
    }
    let ratio = processor / best;
    let (verdict, because) = if !context.hardware {
        (
            Verdict::NeedsHardware,
            "no hardware adapter: the device's times above are software".into(),
        )
    } else if ratio > 1.0 {
        (Verdict::Reproduced, format!("the device is {ratio:.1} times faster"))
    } else {
        (Verdict::Refuted, format!("the device takes {:.1} times as long", 1.0 / ratio))
    };
    Ok(Judged { verdict, figures, because })
}

fn no_upload(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    if context.gpu.is_none() {
        return Ok(Judged {
            verdict: Verdict::NeedsHardware,
            figures: Vec::new(),
            because: "no adapter: the device variants cannot run".into(),
        });
    }
    let crown = crown(context)?;
    let factors = 4.0 * crown.cells.len() as f64;
    let mut figures = Vec::new();
    let mut worst = 0.0_f64;
    for technique in SPEC.techniques.iter().filter(|t| t.forms.contains(&Form::Gpu)) {
        let path = path(&crown, technique.id)?;
        let most = path.uploaded.iter().copied().fold(0.0, f64::max);
        figures.push(figure(
            format!("{}: most bytes uploaded in a frame", technique.id),
            most,
            "B",
        ));
        if technique.id != "cpu-upload" {
            worst = worst.max(most);
        }
    }
    let verdict = if worst <= factors { Verdict::Reproduced } else { Verdict::Refuted };
    let because = format!("at most {worst} B a frame, of which the factors are {factors} B");
    Ok(Judged { verdict, figures, because })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{Prepared, Setting};

    #[test]
    fn a_line_is_found() {
        let (fixed, slope, fit) = line(&[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0]);
        assert_eq!((fixed, slope, fit), (1.0, 2.0, 1.0));
        let (_, _, fit) = line(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 0.0, 1.0]);
        assert!(fit < 0.5);
    }

    #[test]
    fn a_subject_is_checked_against_truth() {
        let context = ClaimContext { gpu: None, hardware: false };
        let crown = crown(&context).unwrap();
        let setting = Setting {
            technique: "cpu-thread".into(),
            variant: "plain".into(),
            form: Form::Cpu,
            knobs: Knobs::new(),
        };
        let checked = crown.subject(&setting).unwrap().check().unwrap();
        assert_eq!(checked.errors["wrong_frames"], 0.0);
        assert!(checked.errors["bytes_per_leaf"] >= 28.0, "{:?}", checked.errors);
    }
}
