//! Our own goals of speed, judged like the sources' claims.
//!
//! Index generation is bandwidth work: the yardstick is a plain copy of the same footprint on the
//! same device in the same run.

use super::{
    spec::SPEC,
    subject::{self, Packer},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict, figure},
    problem::Form,
};
use dapple_foliage::partition::{
    Cells, FULL,
    cpu::{Extractor, Threads},
};
use dapple_gpu::copy_rate;
use dapple_metrics::stats;
use std::time::Instant;

/// Share of a copy's rate that index generation should reach on hardware.
const GOAL: f64 = 0.5;

/// Leaves of the largest footprint tried: 28 bytes each, above any last-level cache.
const LEAVES: usize = 10_000_000;

/// Two threads should be this much faster than one.
const SCALING: f64 = 1.8;

/// Timed repeats, interleaved.
const REPEATS: usize = 7;

/// The goals.
pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "dapple-S5.2",
            statement: "Index generation reaches half the rate of a plain copy of its footprint",
            place: "goal of this project, not of a source",
            method: "bytes of the pass `emit` by the counters over its median device time, all \
                     leaves kept, over the rate of a copy of the same bytes; the best variant \
                     that copies; judged on hardware only",
            judge: Box::new(copy_share),
        },
        Claim {
            id: "dapple-S5.4",
            statement: "Packing on two threads is 1.8 times as fast as on one",
            place: "goal of this project, not of a source",
            method: "median of paired ratios of seven interleaved frames, pools of one and two \
                     threads, all leaves kept; reproduced at >= 1.8, needs two processors",
            judge: Box::new(scaling),
        },
    ]
}

fn copy_share(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let Some(gpu) = context.gpu else {
        return Ok(Judged {
            verdict: Verdict::NeedsHardware,
            figures: Vec::new(),
            because: "no adapter".into(),
        });
    };
    // The indices of every leaf are one binding.
    let binding = gpu.limits().max_storage_buffer_binding_size / 32;
    let leaves = LEAVES.min(binding as usize);
    let cells = Cells::generate(0, leaves, 512)?;
    let q = vec![FULL; cells.len()];
    let bytes = 28 * leaves as u64;
    let rate = copy_rate(gpu, bytes)?;
    let mut figures = vec![
        figure("footprint, read and written", bytes as f64 / 1e6, "MB"),
        figure("plain copy of that footprint", rate / 1e9, "GB/s"),
    ];
    let mut best = 0.0_f64;
    for technique in SPEC.techniques.iter().filter(|t| t.forms.contains(&Form::Gpu)) {
        let mut packer = subject::packer(technique.id, Some(gpu), &cells)?;
        if !matches!(packer, Packer::Gpu(_)) || technique.id == "multi-draw" {
            continue;
        }
        let mut emit = Vec::new();
        for _ in 0..REPEATS {
            let time = packer.frame(Some(gpu), &cells, &q)?;
            emit.extend(time.passes.iter().filter(|p| p.0 == "emit").map(|p| p.1 as f64));
        }
        if emit.is_empty() {
            continue;
        }
        let reached = bytes as f64 / (stats::median(&emit)? * 1e-9);
        best = best.max(reached / rate);
        figures.push(figure(format!("{}: share of the copy", technique.id), reached / rate, ""));
    }
    Ok(judge_share(best, context.hardware, figures))
}

fn judge_share(best: f64, hardware: bool, figures: Vec<Figure>) -> Judged {
    let verdict = match (hardware, best >= GOAL) {
        (false, _) => Verdict::NeedsHardware,
        (true, true) => Verdict::Reproduced,
        (true, false) => Verdict::Refuted,
    };
    Judged { verdict, figures, because: format!("the best variant reaches {:.0} %", 100.0 * best) }
}

fn scaling(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let cells = Cells::generate(0, 2_000_000, 512)?;
    let q = vec![FULL; cells.len()];
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| SuiteError::Internal(e.to_string()))
    };
    let (one, two) = (pool(1)?, pool(2)?);
    let mut extractor = Extractor::new(&cells, Threads::Pool)?;
    let mut frame = |pool: &rayon::ThreadPool| -> Result<f64, SuiteError> {
        let start = Instant::now();
        pool.install(|| extractor.extract(&cells, &q).map(|_| ()))?;
        Ok(start.elapsed().as_nanos() as f64)
    };
    let (mut single, mut double) = (Vec::new(), Vec::new());
    for _ in 0..REPEATS {
        single.push(frame(&one)?);
        double.push(frame(&two)?);
    }
    let speedup = stats::paired_ratio(&single, &double)?;
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let verdict = match (processors >= 2, speedup.median >= SCALING) {
        (false, _) => Verdict::NeedsHardware,
        (true, true) => Verdict::Reproduced,
        (true, false) => Verdict::Refuted,
    };
    Ok(Judged {
        verdict,
        figures: vec![
            figure("one thread, 2,000,000 leaves", stats::median(&single)? / 1e6, "ms"),
            figure("two threads", stats::median(&double)? / 1e6, "ms"),
            figure("speed-up, median of pairs", speedup.median, ""),
            figure("speed-up, MAD", speedup.mad, ""),
            figure("bytes moved", 56.0, "MB"),
        ],
        because: format!("{:.2} times as fast on {processors} processors", speedup.median),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_judged_on_hardware_alone() {
        let verdict = |best, hardware| judge_share(best, hardware, Vec::new()).verdict;
        assert_eq!(verdict(0.9, false), Verdict::NeedsHardware);
        assert_eq!(verdict(0.5, true), Verdict::Reproduced);
        assert_eq!(verdict(0.49, true), Verdict::Refuted);
    }
}
