//! The graphics form: fragments are rasterised into maps, receivers are shaded from them, frame
//! after frame, without reading anything back.
//!
//! Passes of a frame: "opaque" (the nearest opaque depths), what the technique needs ("bounds",
//! "opacity", ...), and "shade". Everything is made in [`Renderer::new`]; the port is checked on
//! the [`fragments`] that this very device rasterises.

mod bins;
mod bounds;
mod error;
mod fragments;
mod join;
mod layered;
mod layers;
mod nearest;
mod raster;
mod score;
mod search;
mod series;
mod shade;
mod stage;
mod survivors;
mod targets;
mod technique;
mod tiled;

pub use error::OpacityGpuError;
pub use fragments::fragments;
pub use search::{SearchCounters, SearchRenderer};

use crate::{Blur, Model, Opaque, Receiver, Settings, Taps};
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_gpu::{Frame, Gpu};
use raster::Raster;
use shade::{Decoder, Shade};
use technique::{Cost, Technique};

/// Work and room of a frame, from how things are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Passes over the translucent geometry.
    pub geometry_passes: u64,
    /// Bytes of the technique's maps as shading reads them, the opaque map included where it is
    /// compared.
    pub map_bytes: u64,
    /// Bytes that the opacity passes write for a fragment of the first layer.
    pub bytes_per_fragment: u64,
    /// Receivers.
    pub receivers: u64,
    /// Texels that the receivers in the map ask for if all lie between the bounds.
    pub texture_fetches: u64,
}

/// A deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The opacity pass tests and writes depths: what lies behind a surface drawn before is lost.
    DepthTested,
}

/// One technique over one mesh, one map size and one set of receivers.
#[derive(Debug)]
pub struct Renderer {
    raster: Raster,
    technique: Technique,
    shade: Shade,
    counters: Counters,
}

impl Renderer {
    /// Uploads mesh and receivers and makes everything a frame of maps of `size` (width, height)
    /// needs.
    ///
    /// # Errors
    /// Settings out of range, an empty map, an unsound mesh; [`OpacityGpuError::NoForm`]; a limit
    /// or feature of the device, by name.
    pub fn new(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        model: Model,
        receivers: &[Receiver],
        size: [u32; 2],
        settings: &Settings,
    ) -> Result<Self, OpacityGpuError> {
        Self::build(gpu, mesh, model, receivers, size, settings, None)
    }

    /// The same with a deliberate fault, for what must find it.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_fault(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        model: Model,
        receivers: &[Receiver],
        size: [u32; 2],
        settings: &Settings,
        fault: Fault,
    ) -> Result<Self, OpacityGpuError> {
        Self::build(gpu, mesh, model, receivers, size, settings, Some(fault))
    }

    fn build(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        model: Model,
        receivers: &[Receiver],
        size: [u32; 2],
        settings: &Settings,
        fault: Option<Fault>,
    ) -> Result<Self, OpacityGpuError> {
        settings.check()?;
        let raster = Raster::new(gpu, mesh, model, size, settings.opaque)?;
        let depth_tested = fault == Some(Fault::DepthTested);
        let technique = Technique::new(gpu, &raster, settings, depth_tested)?;
        let shade = technique.with_decoder(|decoder: &Decoder<'_>| {
            Shade::new(gpu, receivers, settings, size, raster.opaque_view(), decoder)
        })?;
        gpu.check()?;
        let cost = |taps| technique.cost(taps, settings.blur);
        let counters = counters(&raster, cost, receivers, settings);
        Ok(Self { raster, technique, shade, counters })
    }

    /// Records a frame's passes.
    pub fn record(&self, frame: &mut Frame<'_>) {
        self.raster.record_opaque(frame);
        self.technique.record(frame, &self.raster);
        self.shade.record(frame);
    }

    /// Transmittances of the last frame, one a receiver.
    ///
    /// # Errors
    /// A lost device, or one that does not finish.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, OpacityGpuError> {
        Ok(self.shade.read(gpu)?)
    }

    /// First and last depth of each texel of the last frame, (1, 0) without any; empty where the
    /// technique keeps none. The last is 0 where only the first is kept.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub fn read_bounds(&self, gpu: &Gpu) -> Result<Vec<[f32; 2]>, OpacityGpuError> {
        match self.technique.bounds() {
            Some(bounds) => Ok(bounds.read(gpu)?),
            None => Ok(Vec::new()),
        }
    }

    /// Stored numbers of the last frame, one map after the other, each row-major.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub fn read_maps(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, OpacityGpuError> {
        Ok(self.technique.read(gpu)?)
    }

    /// Work and room of a frame.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Bytes on the device: maps and what their making needs, mesh, receivers and results.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let cost = self.technique.cost(1, Blur::Transmittance);
        let technique = cost.map_bytes + cost.other_bytes;
        technique + self.raster.bytes() + self.shade.bytes()
    }
}

fn counters(
    raster: &Raster,
    cost: impl FnOnce(u64) -> Cost,
    receivers: &[Receiver],
    settings: &Settings,
) -> Counters {
    let taps = match settings.taps {
        Taps::One => 1,
        Taps::Box3 => 9,
        Taps::Box4 | Taps::Stochastic16 => 16,
    };
    let in_map = receivers.iter().filter(|r| r.in_map()).count() as u64;
    let cost = cost(taps);
    let (opaque_bytes, opaque_taps) = match settings.opaque {
        Opaque::Separate => (raster.opaque_bytes(), taps),
        Opaque::Weight { .. } => (0, 0),
    };
    Counters {
        geometry_passes: cost.geometry_passes,
        map_bytes: cost.map_bytes + opaque_bytes,
        bytes_per_fragment: cost.bytes_per_fragment,
        receivers: receivers.len() as u64,
        texture_fetches: in_map * (cost.fetches + opaque_taps),
    }
}

/// Holds a struct against the shader's, field by field.
#[cfg(test)]
fn mirror<T>(path: &str, name: &str, fields: &[(&str, u32)]) {
    let source = dapple_shaders::source(path).unwrap();
    let layout = dapple_shaders::struct_layout(&source, name).unwrap();
    let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
    assert_eq!(names, fields);
    assert_eq!(layout.size as usize, size_of::<T>());
}
