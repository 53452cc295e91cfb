//! A technique on a graphics adapter: a frame rasterises, blends and shades, each pass timed.

use super::{
    case::TranslucentCase,
    port::{self, Grid},
};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_gpu::{Gpu, GpuError};
use dapple_opacity_maps::{
    Fragments, Settings,
    gpu::{self, OpacityGpuError, Renderer},
};

/// Share of texels whose fragments may differ in number between rasteriser and rays: those whose
/// centre lies within the rasteriser's sub-pixel step of a triangle's edge. Thin geometry is all
/// edges.
pub const RASTER_TEXELS: f64 = 0.05;

/// The renderer with what it is judged by.
pub struct GpuSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    gpu: &'g Gpu,
    settings: Settings,
    grid: Grid,
    renderer: Renderer,
}

impl<'a, 'g> GpuSubject<'a, 'g> {
    /// Makes every buffer and pipeline.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn new(
        case: &'a TranslucentCase<'g>,
        gpu: &'g Gpu,
        setting: &Setting,
    ) -> Result<Self, SuiteError> {
        let (grid, settings) = Grid::asked(case, setting)?;
        let size = [grid.resolution; 2];
        let mesh = case.light_mesh(grid.crop);
        let renderer = Renderer::new(gpu, &mesh, grid.model, &grid.receivers, size, &settings)
            .map_err(refused)?;
        Ok(Self { case, gpu, grid, renderer, settings })
    }

    /// What this device rasterises, by which its own maps are judged.
    fn rasterised(&self) -> Result<Fragments, SuiteError> {
        let size = [self.grid.fragments.width, self.grid.fragments.height];
        let mesh = self.case.light_mesh(self.grid.crop);
        gpu::fragments(self.gpu, &mesh, self.grid.model, size).map_err(refused)
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
        self.renderer.record(&mut frame);
        let times = frame.finish()?;
        Ok(FrameTime { wall_ns: times.wall_ns, gpu_ns: times.gpu_ns, passes: times.passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.frame(0)?;
        let result = self.renderer.read(self.gpu).map_err(refused)?;
        let mut checked = Checked::default();
        port::measure(self.case, &self.grid, &self.settings, &result, &mut checked)?;
        // The port: against the reference on this device's own fragments.
        let rasterised = self.rasterised()?;
        port::hold(self.case, &self.grid, &self.settings, &rasterised, &result, &mut checked)?;
        // The rasteriser: against the rays.
        check_raster(&self.grid.fragments, &rasterised, &mut checked);
        let counters = self.renderer.counters();
        checked.counters = [
            ("fragments", rasterised.items.len() as u64),
            ("geometry_passes", counters.geometry_passes),
            ("map_bytes", counters.map_bytes),
            ("bytes_per_fragment", counters.bytes_per_fragment),
            ("receivers", counters.receivers),
            ("texels_fetched", counters.texture_fetches),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        checked.memory_bytes = self.renderer.memory_bytes();
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        self.frame(0)?;
        let result = self.renderer.read(self.gpu).map_err(refused)?;
        Ok(Some(self.case.picture(&result)))
    }
}

/// Holds what a device rasterises against what rays find.
pub fn check_raster(rays: &Fragments, rasterised: &Fragments, checked: &mut Checked) {
    let texels = rays.texels();
    let differ = |t: &usize| rays.texel(*t).len() != rasterised.texel(*t).len();
    let share = (0..texels).filter(differ).count() as f64 / texels as f64;
    checked.port_errors.insert("raster_texels".into(), share);
    if share > RASTER_TEXELS {
        checked.violations.push(format!(
            "raster: {:.2} % of texels have another number of fragments than rays find \
             (allowed: {} %)",
            100.0 * share,
            100.0 * RASTER_TEXELS
        ));
    }
}

/// The renderer's refusal as the suite's.
pub fn refused(error: OpacityGpuError) -> SuiteError {
    match error {
        OpacityGpuError::Opacity(error) => error.into(),
        OpacityGpuError::Gpu(error) => device_error(error),
        other => SuiteError::Usage(other.to_string()),
    }
}

/// What a device is too small for is the setting's fault, not the environment's.
pub fn device_error(error: GpuError) -> SuiteError {
    match error {
        GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. } => {
            SuiteError::Usage(error.to_string())
        }
        other => other.into(),
    }
}
