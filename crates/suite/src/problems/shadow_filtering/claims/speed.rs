//! Our own goals of speed, judged like the source's claims.

use super::{
    super::subject_gpu::filter_error,
    still::VSM,
    verdict::{all_of, figure, judged, paired},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_gpu::{Gpu, copy_rate};
use dapple_metrics::stats;
use dapple_shadows::filtering::{DepthMap, Estimator, KernelShape, Receiver, Settings, cpu, gpu};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::time::Instant;

/// Share of a copy's rate that a separable pass should reach on hardware.
const COPY_SHARE: f64 = 0.6;

/// Windows of 31 texels may take this much longer than windows of 3: the border of a line is
/// padded by the window, 5 % of a line of 512, and machines are noisy.
const FLAT: f64 = 1.25;

/// Two threads should be this much faster than one.
const SCALING: f64 = 1.8;

/// Window of the separable passes, texels.
const WINDOW: u32 = 9;

/// Largest map side tried; the device's binding limit may allow less.
const MOST_SIDE: u32 = 8192;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "dapple-S7.1",
            statement: "A separable filter pass reaches 60 % of the rate of a plain copy",
            place: "goal of this project, not of a source",
            method: "Chebyshev f32 (8 bytes a texel), window of 9, the largest map whose channels \
                     are one binding of the device, up to 8192 a side; bytes read and written \
                     once over the median device time of each pass, over the rate of a copy of \
                     the same bytes in the same run; judged on hardware only",
            judge: Box::new(filter_passes),
        },
        Claim {
            id: "dapple-S7.2",
            statement: "Box, minimum and maximum windows cost the same at every width",
            place: "goal of this project, not of a source",
            method: "the power CDF's three channels on a map of 512, pre-filter on the processor, \
                     windows of 31 against 3: texels read must be equal and the median of 31 \
                     paired time ratios at most 1.25; a Gaussian's ratio stands beside it as the \
                     contrast, since it costs O(K)",
            judge: Box::new(flat_windows),
        },
        Claim {
            id: "dapple-S7.3",
            statement: "Filtering on two threads is 1.8 times as fast as on one",
            place: "goal of this project, not of a source",
            method: "moments of a map of 1024, window of 15, pre-filter on the processor, median \
                     of 31 paired ratios of pools of one and two threads; needs two processors",
            judge: Box::new(scaling),
        },
    ]
}

/// A map of smooth slopes and steps, the same on every machine.
fn map(side: u32) -> DepthMap {
    let depth = |i: u32| {
        let (x, y) = (i % side, i / side);
        let step = if (x / 37 + y / 53) % 3 == 0 { 0.2 } else { 0.6 };
        step + 0.2 * (x as f32 / side as f32)
    };
    DepthMap { width: side, height: side, depths: (0..side * side).map(depth).collect() }
}

fn filter_passes(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let Some(gpu) = context.gpu else {
        return Ok(judged(Verdict::NeedsHardware, "no adapter", Vec::new()));
    };
    let settings = Settings { width_texels: WINDOW, ..Settings::new(VSM) };
    let texel = 8;
    let binding = gpu.limits().max_storage_buffer_binding_size;
    let mut side = MOST_SIDE;
    while u64::from(side) * u64::from(side) * texel > binding {
        side /= 2;
    }
    let bytes = 2 * texel * u64::from(side) * u64::from(side);
    let rate = copy_rate(gpu, bytes)?;
    let mut figures = vec![
        figure("map side", f64::from(side), "texels"),
        figure("footprint of a pass, read and written", bytes as f64 / 1e6, "MB"),
        figure("plain copy of that footprint", rate / 1e9, "GB/s"),
    ];
    let mut shares = Vec::new();
    for (pass, ns) in pass_times(gpu, side, &settings)? {
        let share = bytes as f64 / (ns * 1e-9) / rate;
        figures.push(figure(format!("{pass}: share of the copy"), share, ""));
        shares.push(share);
    }
    if shares.is_empty() {
        return Ok(judged(Verdict::NeedsHardware, "the adapter's timestamps are unsound", figures));
    }
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let because = format!("the slower pass reaches {:.0} % of the copy", 100.0 * least);
    Ok(judged(goal(least >= COPY_SHARE, context.hardware), because, figures))
}

/// Median device time of the two filter passes, seven frames.
fn pass_times(
    gpu: &Gpu,
    side: u32,
    settings: &Settings,
) -> Result<Vec<(&'static str, f64)>, SuiteError> {
    let receivers = [Receiver::new(0.5, 0.5, 0.5)];
    let filter = gpu::Filter::new(gpu, side, side, &receivers, settings).map_err(filter_error)?;
    filter.upload_depths(gpu, &map(side)).map_err(filter_error)?;
    let mut times = Vec::new();
    for _ in 0..7 {
        let mut frame = gpu.frame();
        filter.record(&mut frame);
        times.extend(frame.finish()?.passes);
    }
    let mut medians = Vec::new();
    for pass in ["filter-x", "filter-y"] {
        let of: Vec<f64> = times.iter().filter(|t| t.0 == pass).map(|t| t.1 as f64).collect();
        if !of.is_empty() {
            medians.push((pass, stats::median(&of)?));
        }
    }
    Ok(medians)
}

fn goal(reached: bool, judged_here: bool) -> Verdict {
    match (judged_here, reached) {
        (false, _) => Verdict::NeedsHardware,
        (true, true) => Verdict::Reproduced,
        (true, false) => Verdict::Refuted,
    }
}

fn prefilter_ns(filter: &mut cpu::Filter, map: &DepthMap) -> Result<f64, SuiteError> {
    let start = Instant::now();
    filter.prefilter(map)?;
    Ok(start.elapsed().as_nanos() as f64)
}

fn flat_windows(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let map = map(512);
    let run = |kernel: KernelShape| -> Result<_, SuiteError> {
        let filter = |width_texels| {
            let settings = Settings { width_texels, kernel, ..Settings::new(Estimator::PowerCdf) };
            cpu::Filter::new(map.width, map.height, &settings)
        };
        let (mut wide, mut narrow) = (filter(31)?, filter(3)?);
        let ratio =
            paired(31, || prefilter_ns(&mut wide, &map), || prefilter_ns(&mut narrow, &map))?;
        Ok((ratio, [wide.counters(), narrow.counters()].map(|c| c.prefilter_texels)))
    };
    let (boxed, [wide, narrow]) = run(KernelShape::Box)?;
    let (gaussian, _) = run(KernelShape::Gaussian)?;
    let figures = vec![
        figure("texels read, window of 31", wide as f64, ""),
        figure("texels read, window of 3", narrow as f64, ""),
        figure("box, minimum, maximum: time of 31 over 3", boxed.median, ""),
        figure("the same, MAD", boxed.mad, ""),
        figure("Gaussian mean beside the same minimum and maximum", gaussian.median, ""),
    ];
    let because = format!("31 texels take {:.2} times as long as 3", boxed.median);
    Ok(judged(flat(wide == narrow, boxed.median, boxed.mad), because, figures))
}

/// The texels decide first; a time that the machine's noise could explain stays open.
fn flat(texels_equal: bool, ratio: f64, mad: f64) -> Verdict {
    let texels = if texels_equal { Verdict::Reproduced } else { Verdict::Refuted };
    let time = if ratio <= FLAT {
        Verdict::Reproduced
    } else if ratio - 3.0 * mad <= FLAT {
        Verdict::Open
    } else {
        Verdict::Refuted
    };
    all_of(&[texels, time])
}

fn scaling(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let pool = |threads| -> Result<ThreadPool, SuiteError> {
        let built = ThreadPoolBuilder::new().num_threads(threads).build();
        built.map_err(|e| SuiteError::Internal(e.to_string()))
    };
    let (one, two) = (pool(1)?, pool(2)?);
    let map = map(1024);
    let settings = Settings { width_texels: 15, ..Settings::new(Estimator::Msm) };
    let make = || cpu::Filter::new(map.width, map.height, &settings);
    let (mut a, mut b) = (make()?, make()?);
    let ratio = paired(
        31,
        || one.install(|| prefilter_ns(&mut a, &map)),
        || two.install(|| prefilter_ns(&mut b, &map)),
    )?;
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let figures = vec![
        figure("one thread over two, median of pairs", ratio.median, ""),
        figure("the same, MAD", ratio.mad, ""),
        figure("processors", processors as f64, ""),
    ];
    let because = format!("{:.2} times as fast on {processors} processors", ratio.median);
    Ok(judged(goal(ratio.median >= SCALING, processors >= 2), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn goals_give_each_verdict() {
        assert_eq!(goal(true, true), Reproduced);
        assert_eq!(goal(false, true), Refuted);
        assert_eq!(goal(true, false), NeedsHardware);
        assert_eq!(flat(true, 1.1, 0.01), Reproduced);
        assert_eq!(flat(true, 1.4, 0.1), Open);
        assert_eq!(flat(true, 2.0, 0.1), Refuted);
        assert_eq!(flat(false, 1.0, 0.0), Refuted);
        assert_eq!(flat(true, f64::NAN, 0.0), Refuted);
    }
}
