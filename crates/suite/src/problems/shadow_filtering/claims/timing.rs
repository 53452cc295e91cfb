//! Two settings timed against each other, frame by frame in turn.

use super::super::subject_gpu::filter_error;
use super::still::{RESOLUTION, Recipe, Still};
use super::verdict::paired;
use crate::{SuiteError, claims::ClaimContext};
use dapple_gpu::Gpu;
use dapple_metrics::stats::Ratio;
use dapple_shadows::filtering::{Counters, Settings, cpu, gpu};
use std::time::Instant;

/// A still under some settings, filtered and shaded on the processor.
struct CpuRun<'a> {
    still: &'a Still,
    filter: cpu::Filter,
    out: Vec<f32>,
}

impl<'a> CpuRun<'a> {
    fn new(still: &'a Still, s: &Settings) -> Result<Self, SuiteError> {
        let filter = cpu::Filter::new(still.map.width, still.map.height, s)?;
        Ok(Self { still, filter, out: vec![0.0; still.receivers.len()] })
    }

    fn ns(&mut self) -> Result<f64, SuiteError> {
        let start = Instant::now();
        self.filter.prefilter(&self.still.map)?;
        self.filter.shade(&self.still.map, &self.still.receivers, &mut self.out)?;
        Ok(start.elapsed().as_nanos() as f64)
    }
}

/// Time of `a` over time of `b` on the processor, 31 pairs, and the counters of both.
///
/// # Errors
/// Settings that the filter refuses.
pub fn cpu(
    (still_a, a): (&Still, &Settings),
    (still_b, b): (&Still, &Settings),
) -> Result<(Ratio, [Counters; 2]), SuiteError> {
    let (mut a, mut b) = (CpuRun::new(still_a, a)?, CpuRun::new(still_b, b)?);
    let ratio = paired(31, || a.ns(), || b.ns())?;
    Ok((ratio, [a.filter.counters(), b.filter.counters()]))
}

/// Time of `a` over time of `b` on the device for the same still, depth pass excluded: 31 pairs,
/// by the device's clock where it is sound.
///
/// # Errors
/// Settings that the filter refuses, or the device's.
pub fn gpu(gpu: &Gpu, still: &Still, a: &Settings, b: &Settings) -> Result<Ratio, SuiteError> {
    let make = |s: &Settings| -> Result<gpu::Filter, SuiteError> {
        let (width, height) = (still.map.width, still.map.height);
        let filter =
            gpu::Filter::new(gpu, width, height, &still.receivers, s).map_err(filter_error)?;
        filter.upload_depths(gpu, &still.map).map_err(filter_error)?;
        Ok(filter)
    };
    let ns = |filter: &gpu::Filter| -> Result<f64, SuiteError> {
        let mut frame = gpu.frame();
        filter.record(&mut frame);
        let times = frame.finish()?;
        Ok(times.gpu_ns.unwrap_or(times.wall_ns) as f64)
    };
    let (a, b) = (make(a)?, make(b)?);
    paired(31, || ns(&a), || ns(&b))
}

/// Time of `a` over `b` on the car at 1920 columns and a map of 1024, where there is hardware.
///
/// # Errors
/// Those of [`gpu`].
pub fn on_hardware(
    context: &ClaimContext<'_>,
    a: &Settings,
    b: &Settings,
) -> Result<Option<f64>, SuiteError> {
    match context.gpu.filter(|_| context.hardware) {
        Some(gpu) => {
            let still = Recipe::of("car", "", 0).timed(1920, 2 * RESOLUTION).still()?;
            Ok(Some(self::gpu(gpu, &still, a, b)?.median))
        }
        None => Ok(None),
    }
}
