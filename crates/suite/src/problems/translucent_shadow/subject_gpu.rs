//! A technique on a graphics adapter: a frame rasterises, blends and shades, each pass timed.

use super::{case::TranslucentCase, port, settings};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_gpu::{Gpu, GpuError};
use dapple_opacity_maps::{
    Fragments, Model, Receiver, Settings,
    exact::Exact,
    gpu::{self, OpacityGpuError, Renderer},
    reference::Reference,
};
use rayon::prelude::*;
use std::rc::Rc;

/// Most receivers held against the reference.
pub const MOST_CHECKED: usize = 4096;

/// Share of texels whose fragments may differ in number between rasteriser and rays: those whose
/// centre lies within the rasteriser's sub-pixel step of a triangle's edge. Thin geometry is all
/// edges.
pub const RASTER_TEXELS: f64 = 0.05;

/// The renderer with what it is judged by.
pub struct GpuSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    gpu: &'g Gpu,
    settings: Settings,
    model: Model,
    crop: bool,
    fragments: Rc<Fragments>,
    own: Rc<Exact>,
    law: Rc<Exact>,
    receivers: Rc<Vec<Receiver>>,
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
        let (resolution, crop) = (settings::resolution(setting)?, settings::crop(setting)?);
        let model = settings::model(setting)?;
        let own = case.exact(crop, resolution, model)?;
        let settings = settings::settings(setting, || Ok(own.deepest_span()))?;
        let receivers = case.receivers(crop);
        let size = [resolution, resolution];
        let mesh = case.light_mesh(crop);
        let renderer =
            Renderer::new(gpu, &mesh, model, &receivers, size, &settings).map_err(refused)?;
        Ok(Self {
            case,
            gpu,
            model,
            crop,
            fragments: case.fragments(crop, resolution, model)?,
            law: case.exact(crop, resolution, case.law())?,
            own,
            receivers,
            renderer,
            settings,
        })
    }

    /// What this device rasterises, by which its own maps are judged.
    fn rasterised(&self) -> Result<Fragments, SuiteError> {
        let size = [self.fragments.width, self.fragments.height];
        let mesh = self.case.light_mesh(self.crop);
        gpu::fragments(self.gpu, &mesh, self.model, size).map_err(refused)
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
        let grid = port::Grid {
            fragments: &self.fragments,
            own: &self.own,
            law: &self.law,
            receivers: &self.receivers,
        };
        port::measure(self.case, &grid, &self.settings, &result, &mut checked)?;
        // The port: against the reference on this device's own fragments.
        let rasterised = self.rasterised()?;
        let reference = Reference::new(&self.settings, &rasterised)?;
        let (subset, receivers) = (self.case.subset(MOST_CHECKED), &self.receivers[..]);
        let allowed: Vec<(f64, f64)> =
            subset.par_iter().map(|i| reference.interval(&receivers[*i])).collect();
        let got: Vec<f32> = subset.iter().map(|i| result[*i]).collect();
        port::check_port(&self.settings, &rasterised, &got, &allowed, &mut checked);
        // The rasteriser: against the rays.
        check_raster(&self.fragments, &rasterised, &mut checked);
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
