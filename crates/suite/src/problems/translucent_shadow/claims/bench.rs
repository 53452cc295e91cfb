//! H10.1 to H10.3 and H10.6: times of the three methods.

use super::{
    bench_times::{self, METHODS, SIDE, above_one, method, timed},
    search_tables::{FRAME_RATES, LAYERS, SCENES},
    verdict::{all_of, count, figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_metrics::stats;
use std::time::Instant;

/// A line fits if no time is further from it, of that time, than this.
const AFFINE: f64 = 0.1;

/// Times are the same if their ratio is this near 1: the thesis's own ratios at 32 layers lie
/// within 0.95 and 1.08.
const SAME: f64 = 0.1;

/// Share of a frame that the processor may take for its commands.
const SUBMISSION: f64 = 0.2;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H10.1",
            statement: "Up to 16 layers opacity maps take less time than deep ones and these less \
                        than bounding ones, in every scene",
            place: "Voicu 2011, tables 6.1.1, 6.2.1 and 6.3.1 (GT 335M, debug build)",
            method: "trees, grass and dense grass, maps of 512, 3 x 3 taps, 512 columns, each \
                     method in the faster of our forms, frames in turn, nine rounds; on graphics \
                     hardware where there is any, else on the processor, which starts from \
                     fragments. At 4, 8 and 16 layers both ratios, median of rounds, must exceed 1 \
                     by 1.5 median absolute deviations; nearer ones are open. Voted over 18 \
                     ratios; the thesis's, and a software adapter's (maps of 256), beside",
            judge: Box::new(order),
        },
        Claim {
            id: "voicu-H10.2",
            statement: "Frames get slower with every doubling of layers, and their time is a line \
                        over K",
            place: "Voicu 2011, tables 6.1.1, 6.2.1 and 6.3.1",
            method: "frames as in H10.1, 4 to 32 layers. Slower: each of 27 ratios of neighbouring \
                     medians above 1 by 1.5 deviations, voted. A line: least squares over the four \
                     times, no residual above 10 % of its time (the thesis's own fits: 8.5 % at \
                     most), voted over nine rows. a/b, the layers that cost as much as what does \
                     not depend on them, beside the thesis's",
            judge: Box::new(affine),
        },
        Claim {
            id: "voicu-H10.3",
            statement: "As layers are added, bounding maps take the same time as deep ones",
            place: "Voicu 2011, section 6.3, figure 6.3.1",
            method: "frames as in H10.1: in a scene the ratio of bounding over deep maps must lie \
                     nearer 1 at 32 layers than at 4, and there within a tenth of 1 (the thesis: \
                     0.93 to 1.05 of time). Voted over three scenes",
            judge: Box::new(converges),
        },
        Claim {
            id: "voicu-H10.6",
            statement: "All three methods are bound by the graphics device: the processor's share \
                        of a frame is small",
            place: "Voicu 2011, section 6",
            method: "time to record the commands of a frame over the whole frame, median of eleven \
                     frames, three methods at 16 layers on grass, below a fifth. Judged on \
                     graphics hardware alone: a software adapter is a processor",
            judge: Box::new(bound),
        },
    ]
}

/// Ratios that must exceed 1, in figures with the thesis's.
fn order(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let times = bench_times::judged(context)?;
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    each(|scene, k, slower| {
        let ratio = times.ratio(scene, (slower, k), (slower - 1, k))?;
        let what = ratio_name(scene, k, slower);
        figures.push(figure(format!("{what}, {}", times.device), ratio.median, ""));
        let theirs = FRAME_RATES[slower - 1][scene][k] / FRAME_RATES[slower][scene][k];
        figures.push(figure(format!("{what}, thesis"), theirs, ""));
        if LAYERS[k] <= 16 {
            cases.push(above_one(ratio));
        }
        Ok(())
    })?;
    if let Some(other) = bench_times::beside(context)? {
        each(|scene, k, slower| {
            let ratio = other.ratio(scene, (slower, k), (slower - 1, k))?;
            let what = format!("{}, {}", ratio_name(scene, k, slower), other.device);
            figures.push(figure(what, ratio.median, ""));
            Ok(())
        })?;
    }
    let agree = cases.iter().filter(|c| **c == Some(true)).count();
    let against = cases.iter().filter(|c| **c == Some(false)).count();
    let because = format!(
        "{}: {agree} of {} ratios are in the thesis's order, {against} against it",
        times.device,
        cases.len()
    );
    Ok(judged(vote_open(&cases), because, figures))
}

/// Calls `one` with every scene, number of layers and method but the first.
fn each(
    mut one: impl FnMut(usize, usize, usize) -> Result<(), SuiteError>,
) -> Result<(), SuiteError> {
    for scene in 0..SCENES.len() {
        for k in 0..LAYERS.len() {
            for slower in 1..METHODS.len() {
                one(scene, k, slower)?;
            }
        }
    }
    Ok(())
}

fn ratio_name(scene: usize, k: usize, slower: usize) -> String {
    let (name, layers) = (SCENES[scene], LAYERS[k]);
    format!("{name}, {layers} layers: {} over {}", METHODS[slower], METHODS[slower - 1])
}

/// Constant and slope of times over [`LAYERS`], and the largest residual as a part of its time.
fn line(times: &[f64; 4]) -> (f64, f64, f64) {
    let k = LAYERS.map(f64::from);
    let mean = |v: &[f64; 4]| v.iter().sum::<f64>() / 4.0;
    let (mean_k, mean_t) = (mean(&k), mean(times));
    let rise: f64 = k.iter().zip(times).map(|(k, t)| (k - mean_k) * (t - mean_t)).sum();
    let slope = rise / k.iter().map(|k| (k - mean_k) * (k - mean_k)).sum::<f64>();
    let base = mean_t - slope * mean_k;
    let off = k.iter().zip(times).map(|(k, t)| ((base + slope * k - t) / t).abs());
    (base, slope, off.fold(0.0, f64::max))
}

/// The same, a form of all nine rows: whether each step takes longer, and each row's residual.
fn slower_and_affine(steps: &[Option<bool>], residuals: &[f64]) -> (Verdict, Vec<bool>) {
    let lines: Vec<bool> = residuals.iter().map(|r| *r <= AFFINE).collect();
    (all_of(&[vote_open(steps), vote(&lines)]), lines)
}

fn affine(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let times = bench_times::judged(context)?;
    let (mut figures, mut steps, mut residuals) = (Vec::new(), Vec::new(), Vec::new());
    for (scene, scene_name) in SCENES.into_iter().enumerate() {
        for (at, method) in METHODS.into_iter().enumerate() {
            for k in 1..LAYERS.len() {
                steps.push(above_one(times.ratio(scene, (at, k), (at, k - 1))?));
            }
            let theirs = FRAME_RATES[at][scene].map(|rate| 1000.0 / rate);
            for (who, row) in [(times.device, times.by_layers(scene, at)?), ("thesis", theirs)] {
                let (base, slope, off) = line(&row);
                let what = format!("{scene_name}, {method}, {who}");
                figures.push(figure(format!("{what}: largest residual"), off, ""));
                figures.push(figure(format!("{what}: a/b"), base / slope, "layers"));
                figures.push(figure(format!("{what}: 32 layers over 4"), row[3] / row[0], ""));
                if who != "thesis" {
                    residuals.push(off);
                }
            }
        }
    }
    let (verdict, lines) = slower_and_affine(&steps, &residuals);
    let slower = steps.iter().filter(|s| **s == Some(true)).count();
    let because = format!(
        "{}: {slower} of {} steps are slower; a line fits {} rows",
        times.device,
        steps.len(),
        count(&lines)
    );
    Ok(judged(verdict, because, figures))
}

/// Ratios at the fewest and at the most layers.
fn nears_one([few, many]: [f64; 2]) -> bool {
    (many - 1.0).abs() < (few - 1.0).abs() && (many - 1.0).abs() <= SAME
}

fn converges(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let times = bench_times::judged(context)?;
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for (scene, name) in SCENES.into_iter().enumerate() {
        let mut ends = [0.0; 2];
        for k in 0..LAYERS.len() {
            let ratio = times.ratio(scene, (2, k), (1, k))?.median;
            let what = format!("{name}, {} layers: bom over dom", LAYERS[k]);
            figures.push(figure(format!("{what}, {}", times.device), ratio, ""));
            let theirs = FRAME_RATES[1][scene][k] / FRAME_RATES[2][scene][k];
            figures.push(figure(format!("{what}, thesis"), theirs, ""));
            match k {
                0 => ends[0] = ratio,
                3 => ends[1] = ratio,
                _ => {}
            }
        }
        holds.push(nears_one(ends));
    }
    let because = format!("{}: the ratio nears 1 in {} scenes", times.device, count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

fn small(shares: &[f64], hardware: bool) -> Verdict {
    let holds: Vec<bool> = shares.iter().map(|s| *s < SUBMISSION).collect();
    if hardware { vote(&holds) } else { Verdict::NeedsHardware }
}

fn bound(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let Some(gpu) = context.gpu else {
        return Ok(judged(Verdict::NeedsHardware, "no adapter", Vec::new()));
    };
    let still = timed("grass")?;
    let device = if context.hardware { "graphics hardware" } else { "software adapter" };
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for (at, name) in METHODS.into_iter().enumerate() {
        let side = if context.hardware { SIDE } else { SIDE / 2 };
        let renderer = still.renderer(gpu, &method(&still, at, 16, side)?)?;
        let mut shares = Vec::new();
        for _ in 0..11 {
            let start = Instant::now();
            let mut frame = gpu.frame();
            renderer.record(&mut frame);
            let recorded = start.elapsed().as_nanos() as f64;
            shares.push(recorded / frame.finish()?.wall_ns.max(1) as f64);
        }
        let share = stats::median(&shares)?;
        figures.push(figure(format!("{name}, {device}: recording over frame"), share, ""));
        all.push(share);
    }
    let most = all.iter().copied().fold(0.0, f64::max);
    let because = format!("recording takes at most {most:.3} of a frame on a {device}");
    Ok(judged(small(&all, context.hardware), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn lines_are_fitted_and_steps_counted() {
        let (base, slope, off) = line(&LAYERS.map(|k| 7.0 + 0.5 * f64::from(k)));
        assert!((base - 7.0).abs() < 1e-12 && (slope - 0.5).abs() < 1e-12 && off < 1e-12);
        assert!(line(&[1.0, 2.0, 30.0, 31.0]).2 > AFFINE);
        assert_eq!(slower_and_affine(&[Some(true)], &[0.05]).0, Reproduced);
        assert_eq!(slower_and_affine(&[Some(true)], &[0.2]).0, Refuted);
        assert_eq!(slower_and_affine(&[Some(true)], &[0.2, 0.05]).0, Open);
        assert_eq!(slower_and_affine(&[None], &[0.05]).0, Open);
        assert_eq!(slower_and_affine(&[Some(false)], &[f64::NAN]).0, Refuted);
    }

    #[test]
    fn the_thesis_s_own_rows() {
        let mut worst = 0.0_f64;
        for method in FRAME_RATES {
            for rates in method {
                assert!(rates.windows(2).all(|w| w[1] < w[0]));
                worst = worst.max(line(&rates.map(|r| 1000.0 / r)).2);
            }
        }
        assert!((0.08..0.09).contains(&worst), "{worst}");
    }

    #[test]
    fn a_ratio_must_come_near_one() {
        assert!(nears_one([1.4, 1.05]) && nears_one([0.7, 0.95]));
        assert!(!nears_one([1.4, 1.2]) && !nears_one([1.01, 1.05]) && !nears_one([1.4, f64::NAN]));
    }

    #[test]
    fn submission_is_judged_on_hardware() {
        assert_eq!(small(&[0.1, 0.1], true), Reproduced);
        assert_eq!(small(&[0.1, 0.3], true), Open);
        assert_eq!(small(&[0.3], true), Refuted);
        assert_eq!(small(&[0.1], false), NeedsHardware);
    }
}
