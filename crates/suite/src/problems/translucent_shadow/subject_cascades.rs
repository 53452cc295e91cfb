//! Parallel-split shadow maps of all geometry, in all forms: the binary yardstick.

use super::{cascades, case::TranslucentCase, errors, port, subject_gpu};
use crate::{
    SuiteError,
    problem::{Checked, Form, FrameTime, Picture, Setting, Subject},
};
use dapple_gpu::Gpu;
use dapple_shadows::{
    cascades::{CascadeReceiver, Counters, cpu, gpu, reference},
    filtering::DepthMap,
};
use std::time::Instant;

/// Share of texels whose depth may differ between rasteriser and rays by more than [`DEPTH_STEP`]:
/// thin geometry is all edges.
const DEPTH_TEXELS: f64 = 0.02;

/// Depths that differ by more are different surfaces.
const DEPTH_STEP: f32 = 1e-3;

/// Which form runs.
enum Run<'g> {
    Reference,
    Cpu(cpu::Shadows),
    Gpu(&'g Gpu, Box<gpu::Shadows>),
}

/// Cascades with their maps, receivers and result.
pub struct CascadeSubject<'a, 'g> {
    case: &'a TranslucentCase<'g>,
    wishes: cascades::Wishes,
    maps: Vec<DepthMap>,
    receivers: Vec<CascadeReceiver>,
    run: Run<'g>,
    result: Vec<f32>,
}

impl<'a, 'g> CascadeSubject<'a, 'g> {
    /// Allocates everything a frame needs and casts the maps' rays.
    ///
    /// # Errors
    /// Knobs that are refused, or a device that is too small.
    pub fn new(
        case: &'a TranslucentCase<'g>,
        gpu: Option<&'g Gpu>,
        setting: &Setting,
    ) -> Result<Self, SuiteError> {
        let wishes = cascades::wishes(case, setting)?;
        let receivers = cascades::receivers(case);
        let (side, slices) = (wishes.side, &wishes.cascades);
        let run = match (setting.form, gpu) {
            (Form::Reference, _) => Run::Reference,
            (Form::Cpu, _) => Run::Cpu(cpu::Shadows::new(side, slices, &wishes.settings)?),
            (Form::Gpu, Some(gpu)) => {
                let mesh = case.light_mesh(false);
                let settings = &wishes.settings;
                let made = gpu::Shadows::new(gpu, &mesh, slices, side, &receivers, settings);
                Run::Gpu(gpu, Box::new(made.map_err(refused)?))
            }
            (Form::Gpu, None) => {
                return Err(SuiteError::Usage(format!("{setting} needs a graphics adapter")));
            }
        };
        let maps = slices.iter().map(|c| cascades::depth_map(case, c, side)).collect();
        let result = vec![0.0; receivers.len()];
        Ok(Self { case, wishes, maps, receivers, run, result })
    }

    fn shade(&mut self) -> Result<FrameTime, SuiteError> {
        match &self.run {
            Run::Reference => {
                let (cascades, settings) = (&self.wishes.cascades, &self.wishes.settings);
                let all = reference::visibility(&self.maps, cascades, &self.receivers, settings)?;
                self.result = all.into_iter().map(|v| v as f32).collect();
                Ok(FrameTime::default())
            }
            Run::Cpu(shadows) => {
                let start = Instant::now();
                shadows.shade(&self.maps, &self.receivers, &mut self.result)?;
                let wall_ns = start.elapsed().as_nanos() as u64;
                Ok(FrameTime { wall_ns, gpu_ns: None, passes: vec![("shade", wall_ns)] })
            }
            Run::Gpu(gpu, shadows) => {
                let mut frame = gpu.frame();
                shadows.record(&mut frame);
                let times = frame.finish()?;
                Ok(FrameTime { wall_ns: times.wall_ns, gpu_ns: times.gpu_ns, passes: times.passes })
            }
        }
    }

    /// Holds the result against what rounding may do to the reference over `maps`.
    fn check_port(&self, maps: &[DepthMap], checked: &mut Checked) -> Result<(), SuiteError> {
        let (cascades, settings) = (&self.wishes.cascades, &self.wishes.settings);
        let bounds = reference::port_bounds(maps, cascades, &self.receivers, settings)?;
        let outside = |(v, (low, high)): (&f32, &(f64, f64))| {
            !(low.min(*high) - 1e-6..=low.max(*high) + 1e-6).contains(&f64::from(*v))
        };
        let beyond = self.result.iter().zip(&bounds).filter(|p| outside((p.0, p.1))).count();
        let share = beyond as f64 / bounds.len().max(1) as f64;
        checked.port_errors.insert("transmittance_beyond".into(), share);
        if beyond > 0 {
            checked.violations.push(format!(
                "port: {beyond} receivers lie outside what rounding can do to the reference"
            ));
        }
        Ok(())
    }
}

impl Subject for CascadeSubject<'_, '_> {
    fn frames(&self) -> usize {
        1
    }

    /// A still view: no frame depends on an earlier one.
    fn reset(&mut self) -> Result<(), SuiteError> {
        Ok(())
    }

    fn frame(&mut self, _index: usize) -> Result<FrameTime, SuiteError> {
        self.shade()
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.shade()?;
        let mut checked = Checked::default();
        let counters: Option<Counters> = match &self.run {
            Run::Reference => None,
            Run::Cpu(shadows) => {
                self.check_port(&self.maps, &mut checked)?;
                Some(shadows.counters(&self.receivers))
            }
            Run::Gpu(gpu, shadows) => {
                self.result = shadows.read(gpu)?;
                let maps = shadows.read_maps(gpu)?;
                self.check_port(&maps, &mut checked)?;
                check_raster(&self.maps, &maps, &mut checked);
                Some(shadows.counters())
            }
        };
        port::check_range(&self.result, &mut checked);
        checked.errors = errors::against_truth(self.case, &self.result)?;
        if let Some(c) = counters {
            checked.counters = [
                ("geometry_passes", c.geometry_passes),
                ("map_bytes", c.map_bytes),
                ("texels_fetched", c.shade_texels),
                ("receivers", self.receivers.len() as u64),
            ]
            .map(|(name, value)| (name.to_string(), value))
            .into();
            // A receiver is 32 bytes and its visibility 4.
            checked.memory_bytes = c.map_bytes + 36 * self.receivers.len() as u64;
        }
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        self.shade()?;
        if let Run::Gpu(gpu, shadows) = &self.run {
            self.result = shadows.read(gpu)?;
        }
        Ok(Some(self.case.picture(&self.result)))
    }
}

/// Rasterised maps against ray-cast ones.
fn check_raster(cast: &[DepthMap], raster: &[DepthMap], checked: &mut Checked) {
    let pairs = || cast.iter().zip(raster).flat_map(|(a, b)| a.depths.iter().zip(&b.depths));
    let different = pairs().filter(|(a, b)| (*a - *b).abs() > DEPTH_STEP).count();
    let share = different as f64 / pairs().count().max(1) as f64;
    checked.port_errors.insert("raster_texels".into(), share);
    if share > DEPTH_TEXELS {
        checked.violations.push(format!(
            "raster: {:.2} % of texels have another depth than rays find (allowed: {} %)",
            100.0 * share,
            100.0 * DEPTH_TEXELS
        ));
    }
}

pub fn refused(error: gpu::GpuCascadeError) -> SuiteError {
    match error {
        gpu::GpuCascadeError::Cascade(error) => error.into(),
        gpu::GpuCascadeError::Gpu(error) => subject_gpu::device_error(error),
        gpu::GpuCascadeError::Depth(error) => SuiteError::Usage(error.to_string()),
    }
}
