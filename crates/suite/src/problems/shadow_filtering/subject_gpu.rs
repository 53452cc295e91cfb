//! A filter on a graphics adapter: a frame rasterises the depth map, filters it and shades every
//! pixel, each pass timed.

use super::{case::ShadowCase, memory, port, tolerance};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Subject},
};
use dapple_gpu::{AdapterKind, Gpu, GpuError};
use dapple_shadows::filtering::{
    DepthMap, Settings,
    gpu::{DepthSource, Filter, GpuFilterError},
    gpu_depth::{DepthRaster, DepthRasterError},
    reference::Rounding,
};
use std::rc::Rc;

/// The filter with its rasteriser.
pub struct GpuSubject<'a, 'g> {
    case: &'a ShadowCase<'g>,
    gpu: &'g Gpu,
    settings: Settings,
    resolution: u32,
    raster: Rc<DepthRaster>,
    filter: Filter,
}

impl<'a, 'g> GpuSubject<'a, 'g> {
    /// Makes every buffer and pipeline.
    ///
    /// # Errors
    /// Settings that the filter refuses, or a device that is too small.
    pub fn new(
        case: &'a ShadowCase<'g>,
        gpu: &'g Gpu,
        resolution: u32,
        settings: Settings,
    ) -> Result<Self, SuiteError> {
        // A software adapter's memory is the host's; the other's own is asked for piece by piece.
        let device = match gpu.facts.kind {
            AdapterKind::Software => memory::device_bytes(resolution, &settings),
            AdapterKind::Hardware => 0,
        };
        // Rays' map and raster's, for the check.
        let host = 8 * u64::from(resolution).pow(2);
        memory::check_host(resolution, &settings, device + host)?;
        let raster = case.raster(gpu, resolution)?;
        let source = DepthSource::Buffer(raster.depths());
        let filter =
            Filter::with_depths(gpu, resolution, resolution, case.receivers(), &settings, source)
                .map_err(filter_error)?;
        Ok(Self { case, gpu, settings, resolution, raster, filter })
    }

    /// The filter alone, over the depths that are in the buffer.
    fn filter_once(&self) -> Result<Vec<f32>, SuiteError> {
        let mut frame = self.gpu.frame();
        self.filter.record(&mut frame);
        frame.finish()?;
        Ok(self.filter.read(self.gpu)?)
    }

    /// The map as this device rasterises it.
    fn rasterise(&self) -> Result<DepthMap, SuiteError> {
        let mut frame = self.gpu.frame();
        self.raster.record(&mut frame);
        frame.finish()?;
        let depths = self.raster.read(self.gpu)?;
        Ok(DepthMap { width: self.resolution, height: self.resolution, depths })
    }
}

impl Subject for GpuSubject<'_, '_> {
    fn frames(&self) -> usize {
        1
    }

    /// A still view: no frame depends on an earlier one.
    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        let mut frame = self.gpu.frame();
        self.raster.record(&mut frame);
        self.filter.record(&mut frame);
        let times = frame.finish()?;
        Ok(FrameTime { wall_ns: times.wall_ns, gpu_ns: times.gpu_ns, passes: times.passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        let mut checked = Checked::default();
        let subset = self.case.subset(self.resolution);
        // The filter alone, over the same depths as the reference.
        let cast = self.case.depth_map(self.resolution);
        self.filter.upload_depths(self.gpu, &cast).map_err(filter_error)?;
        let over_cast = self.filter_once()?;
        port::check_range(&over_cast, &mut checked);
        let (s, rounding) = (&self.settings, Rounding::gpu(&self.settings));
        port::check_port(self.case, s, &cast, &over_cast, &subset, &rounding, &mut checked)?;
        // The rasteriser alone.
        let map = self.rasterise()?;
        tolerance::check_raster(&cast, &map, &mut checked);
        // The whole frame.
        self.filter.fit_layers(self.gpu, &map).map_err(filter_error)?;
        self.frame(0)?;
        let result = self.filter.read(self.gpu)?;
        port::check_range(&result, &mut checked);
        checked.errors = self.case.errors(&result)?;
        port::estimator_error(self.case, &self.settings, &map, &result, &subset, &mut checked)?;
        checked.counters = port::counters(self.case, &self.settings, &self.filter.counters());
        checked.memory_bytes = memory::device_bytes(self.resolution, &self.settings)
            + 36 * self.case.receivers().len() as u64;
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        self.frame(0)?;
        let result = self.filter.read(self.gpu)?;
        Ok(Some(port::picture(self.case, &result)))
    }
}

/// The filter's refusal as the suite's.
pub fn filter_error(error: GpuFilterError) -> SuiteError {
    match error {
        GpuFilterError::Filter(error) => error.into(),
        GpuFilterError::Gpu(error) => device_error(error),
        GpuFilterError::DepthBuffer { .. } => SuiteError::Internal(error.to_string()),
    }
}

/// The rasteriser's refusal as the suite's.
pub fn raster_error(error: DepthRasterError) -> SuiteError {
    match error {
        DepthRasterError::Gpu(error) => device_error(error),
        other => SuiteError::Usage(other.to_string()),
    }
}

/// What a device is too small for is the setting's fault, not the environment's.
fn device_error(error: GpuError) -> SuiteError {
    match error {
        GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. } => {
            SuiteError::Usage(error.to_string())
        }
        other => other.into(),
    }
}
