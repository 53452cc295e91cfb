//! The filters as compute passes over storage buffers.
//!
//! Channels are stored in words of explicit format (`pack2x16float`, integers rounded by hand, or
//! raw f32), not in textures, so that rounding is the same on every adapter. Passes of a frame:
//! "pack", "filter-x", "filter-y" (each rounds to the format) and "shade"; estimators that are
//! not pre-filtered have no filter passes, and pack only to round depths to 16 bits. Nothing is created in [`Filter::record`].
//!
//! Planes are words of one kind, row by row, so that neighbouring invocations read and write
//! neighbouring words in every pass. A row pass stages a run of texels in workgroup memory; a
//! column pass makes strips of 16 texels an invocation. Both combine what the windows of a strip
//! share once, and never subtract (`shaders/common/window.wgsl`).

mod plan;

use dapple_gpu::{Frame, Gpu, GpuError, wgpu};
use plan::{PackParams, Planes};
use thiserror::Error;

use super::channels::Channels;
use super::kernel::Kernel;
use super::{Counters, DepthMap, FilterError, Format, Lookup, Receiver, Settings};

/// Why a filter cannot be made or fed.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GpuFilterError {
    /// A knob or an input is out of its range.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The device refused, or a named limit of it is too small.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A depth buffer that is not one f32 a texel.
    #[error("the depth buffer holds {actual} bytes; the map needs {expected}")]
    DepthBuffer {
        /// Bytes of the map.
        expected: u64,
        /// Bytes of the buffer.
        actual: u64,
    },
}

/// Where the depths come from.
#[derive(Clone, Copy, Debug)]
pub enum DepthSource<'a> {
    /// A buffer of the filter's own, filled by [`Filter::upload_depths`].
    Upload,
    /// A buffer that another pass of the frame fills, for example
    /// [`DepthRaster::depths`](super::gpu_depth::DepthRaster::depths): row-major f32 in 0..=1.
    Buffer(&'a wgpu::Buffer),
}

#[derive(Debug)]
struct Pass {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 3],
}

/// A filter for maps of one size and one set of receivers.
#[derive(Debug)]
pub struct Filter {
    settings: Settings,
    width: u32,
    height: u32,
    receivers: usize,
    planes: Planes,
    passes: Vec<Pass>,
    depths: wgpu::Buffer,
    layers: wgpu::Buffer,
    filtered: Option<wgpu::Buffer>,
    visibilities: wgpu::Buffer,
    counters: Counters,
}

impl Filter {
    /// A filter that is fed by [`Filter::upload_depths`].
    ///
    /// # Errors
    /// As [`Filter::with_depths`].
    pub fn new(
        gpu: &Gpu,
        width: u32,
        height: u32,
        receivers: &[Receiver],
        settings: &Settings,
    ) -> Result<Self, GpuFilterError> {
        Self::with_depths(gpu, width, height, receivers, settings, DepthSource::Upload)
    }

    /// Makes every buffer, pipeline and bind group of a frame.
    ///
    /// Layers are uniform until [`Filter::upload_depths`] or [`Filter::fit_layers`] has seen a
    /// map.
    ///
    /// # Errors
    /// Those of [`Settings::check`]; [`GpuFilterError::Gpu`] where a buffer or dispatch exceeds a
    /// named limit of the device; [`GpuFilterError::DepthBuffer`].
    pub fn with_depths(
        gpu: &Gpu,
        width: u32,
        height: u32,
        receivers: &[Receiver],
        settings: &Settings,
        source: DepthSource<'_>,
    ) -> Result<Self, GpuFilterError> {
        settings.check(width, height)?;
        let texels = u64::from(width) * u64::from(height);
        let depths = match source {
            DepthSource::Upload => gpu.buffer("depths", 4 * texels)?,
            DepthSource::Buffer(buffer) if buffer.size() < 4 * texels => {
                return Err(GpuFilterError::DepthBuffer {
                    expected: 4 * texels,
                    actual: buffer.size(),
                });
            }
            DepthSource::Buffer(buffer) => buffer.clone(),
        };
        let nothing = DepthMap { width: 1, height: 1, depths: vec![1.0] };
        let channels = Channels::new(settings, &nothing);
        let planes = Planes::new(settings, &channels);
        let layers = gpu.upload("layers", &layer_words(&channels))?;
        let kernel = Kernel::of(settings);

        let mut passes = Vec::new();
        let mut filtered = None;
        if settings.prefiltered() || settings.format != Format::F32 {
            let words = gpu.buffer("channels", 4 * texels * u64::from(planes.count()))?;
            passes.push(pack_pass(gpu, settings, planes, texels, [&layers, &depths, &words])?);
            filtered = Some(words);
        }
        if let (Some(words), true) = (&filtered, settings.prefiltered()) {
            let map = Map { width, height, planes };
            passes.extend(filter_passes(gpu, settings, &kernel, &channels, map, words)?);
        }
        let max = gpu.limits().max_compute_workgroups_per_dimension;
        for pass in &passes {
            if let Some(&asked) = pass.workgroups.iter().find(|&&n| n > max) {
                return Err(GpuFilterError::Gpu(GpuError::TooLarge {
                    what: format!("pass `{}` over {width} x {height} texels", pass.name),
                    asked: asked.into(),
                    limit: "max_compute_workgroups_per_dimension",
                    max: max.into(),
                }));
            }
        }

        let count = u32::try_from(receivers.len()).map_err(|_| GpuError::TooLarge {
            what: "receivers".into(),
            asked: receivers.len() as u64,
            limit: "u32 indices",
            max: u32::MAX.into(),
        })?;
        let taps = comparison_taps(settings, &kernel);
        let params = plan::shade_params(settings, width, height, count, planes.layers, &taps);
        // A binding holds one receiver at least; the shader reads as many as there are.
        let no_receiver = [Receiver::new(0.0, 0.0, 0.0)];
        let shown = if receivers.is_empty() { &no_receiver } else { receivers };
        let visibilities = gpu.buffer("visibilities", 4 * u64::from(count))?;
        let pipeline =
            gpu.compute("shadows/shade.wgsl", "shade", &plan::shade_constants(settings, planes))?;
        let group = gpu.bind(
            &pipeline,
            0,
            &[
                &gpu.uniform("shade", &params)?,
                &gpu.upload("receivers", shown)?,
                filtered.as_ref().unwrap_or(&depths),
                &gpu.upload("comparison taps", &taps)?,
                &layers,
                &visibilities,
            ],
        );
        let workgroups = gpu.workgroups(u64::from(count), 64)?;
        passes.push(Pass { name: "shade", pipeline, group, workgroups });
        gpu.check()?;
        let counters = counters(settings, width, height, receivers, planes, &kernel, &taps);
        Ok(Self {
            settings: *settings,
            width,
            height,
            receivers: receivers.len(),
            planes,
            passes,
            depths,
            layers,
            filtered,
            visibilities,
            counters,
        })
    }

    /// Hands over a map: its depths, and its layers where the splits depend on them.
    ///
    /// # Errors
    /// [`FilterError::MapSize`] and what [`DepthMap::check`] finds.
    pub fn upload_depths(&self, gpu: &Gpu, map: &DepthMap) -> Result<(), GpuFilterError> {
        self.fit_layers(gpu, map)?;
        gpu.queue.write_buffer(&self.depths, 0, bytemuck::cast_slice(&map.depths));
        Ok(())
    }

    /// Fits the layers to a map without uploading it: for Lloyd splits over rasterised depths.
    ///
    /// # Errors
    /// As [`Filter::upload_depths`].
    pub fn fit_layers(&self, gpu: &Gpu, map: &DepthMap) -> Result<(), GpuFilterError> {
        map.check_size(self.width, self.height)?;
        map.check()?;
        let words = layer_words(&Channels::new(&self.settings, map));
        gpu.queue.write_buffer(&self.layers, 0, bytemuck::cast_slice(&words));
        Ok(())
    }

    /// Records the passes of a frame: "pack", "filter-x" and "filter-y" where the estimator is
    /// pre-filtered ("pack" alone for comparisons with 16-bit depths), and "shade".
    pub fn record(&self, frame: &mut Frame<'_>) {
        for pass in &self.passes {
            let [x, y, z] = pass.workgroups;
            frame.compute(pass.name, |compute| {
                compute.set_pipeline(&pass.pipeline);
                compute.set_bind_group(0, &pass.group, &[]);
                compute.dispatch_workgroups(x, y, z);
            });
        }
    }

    /// Visibilities of the last frame, one a receiver.
    ///
    /// # Errors
    /// Those of [`Gpu::read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, GpuError> {
        gpu.read(&self.visibilities, 0, self.receivers)
    }

    /// The filtered channels of the last frame, in the order of [`super::channels`], each
    /// row-major; empty for comparisons with f32 depths.
    ///
    /// # Errors
    /// Those of [`Gpu::read`].
    pub fn read_channels(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, GpuError> {
        let Some(filtered) = &self.filtered else { return Ok(Vec::new()) };
        let texels = self.width as usize * self.height as usize;
        let words: Vec<u32> = gpu.read(filtered, 0, texels * self.planes.count() as usize)?;
        let channels = self.planes.channels_per_layer * self.planes.layers;
        let decode = |word: u32, half: u32| match self.settings.format {
            Format::F32 => f32::from_bits(word),
            Format::F16 => half::f16::from_bits((word >> (16 * half)) as u16).to_f32(),
            Format::U16 => ((word >> (16 * half)) & 0xffff) as f32 / 65_535.0,
        };
        Ok((0..channels)
            .map(|channel| {
                let (plane, half) = self.planes.place(channel);
                let start = plane as usize * texels;
                words[start..start + texels].iter().map(|&word| decode(word, half)).collect()
            })
            .collect())
    }

    /// Work of a frame. Texels are those the kernels ask memory for; bytes are the compulsory
    /// traffic of the map passes (each reads its input and writes its output once) and everything
    /// the receivers ask for.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }
}

/// Size of the filtered map.
#[derive(Clone, Copy)]
struct Map {
    width: u32,
    height: u32,
    planes: Planes,
}

/// Depths to channels; `buffers` are layers, depths and channels.
fn pack_pass(
    gpu: &Gpu,
    settings: &Settings,
    planes: Planes,
    texels: u64,
    buffers: [&wgpu::Buffer; 3],
) -> Result<Pass, GpuError> {
    let params = PackParams {
        // The buffers hold 4 bytes and more a texel, so there are fewer than 2^32 texels.
        texels: texels as u32,
        channels: planes.channels_per_layer,
        layers: planes.layers,
        exponent: settings.exponent,
    };
    let pipeline = gpu.compute("shadows/pack.wgsl", "pack", &plan::pack_constants(settings))?;
    let [layers, depths, words] = buffers;
    let group = gpu.bind(&pipeline, 0, &[&gpu.uniform("pack", &params)?, layers, depths, words]);
    Ok(Pass { name: "pack", pipeline, group, workgroups: gpu.workgroups(texels, 64)? })
}

/// The passes that filter the channels in place, by way of another buffer.
fn filter_passes(
    gpu: &Gpu,
    settings: &Settings,
    kernel: &Kernel,
    channels: &Channels,
    map: Map,
    words: &wgpu::Buffer,
) -> Result<[Pass; 2], GpuError> {
    let Map { width, height, planes } = map;
    let rows = gpu.buffer("channels filtered along x", words.size())?;
    let params = gpu.uniform("filter", &plan::filter_params(settings, kernel, width, height))?;
    let ops = gpu.upload("plane operations", &plan::plane_ops(settings, channels, planes))?;
    let weights = gpu.upload("weights", &plan::filter_weights(kernel))?;

    let limit = gpu.limits().max_compute_workgroup_storage_size;
    let constants = plan::row_constants(settings, kernel, limit);
    let pipeline = row_pipeline(gpu, &constants)?;
    let group = gpu.bind(&pipeline, 0, &[&params, &ops, &weights, words, &rows]);
    let workgroups = [width.div_ceil(plan::ROW_RUN), height, planes.count()];
    let filter_x = Pass { name: "filter-x", pipeline, group, workgroups };

    let constants = plan::column_constants(settings, kernel);
    let pipeline = gpu.compute("shadows/filter_y.wgsl", "filter_y", &constants)?;
    let group = gpu.bind(&pipeline, 0, &[&params, &ops, &weights, &rows, words]);
    let workgroups = [
        width.div_ceil(plan::COLUMN_LANES),
        height.div_ceil(plan::COLUMN_STRIP * plan::COLUMN_STRIPS),
        planes.count(),
    ];
    Ok([filter_x, Pass { name: "filter-y", pipeline, group, workgroups }])
}

/// As [`Gpu::compute`], but without zeroing workgroup memory, of which the kernel reads only what
/// it has written: the fill and its barrier would cost as much as the tile's load.
fn row_pipeline(gpu: &Gpu, constants: &[(&str, f64)]) -> Result<wgpu::ComputePipeline, GpuError> {
    let path = "shadows/filter_x.wgsl";
    let module = gpu.module(path)?;
    gpu.scoped(path, || {
        gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(path),
            layout: None,
            module: &module,
            entry_point: Some("filter_x"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        })
    })
}

/// (first receiver, start of the warp, end, 0) of each layer.
fn layer_words(channels: &Channels) -> Vec<[f32; 4]> {
    channels.layers().as_slice().iter().map(|l| [l.first, l.start, l.end, 0.0]).collect()
}

/// Offsets and weights along one axis of what is compared; one texel where nothing is.
fn comparison_taps(settings: &Settings, kernel: &Kernel) -> Vec<[f32; 2]> {
    let taps = match settings.estimator {
        super::Estimator::Pcf { taps } => taps,
        _ => 1,
    };
    kernel.taps(taps).into_iter().map(|(offset, weight)| [offset as f32, weight as f32]).collect()
}

fn counters(
    settings: &Settings,
    width: u32,
    height: u32,
    receivers: &[Receiver],
    planes: Planes,
    kernel: &Kernel,
    taps: &[[f32; 2]],
) -> Counters {
    let (w, h) = (u64::from(width), u64::from(height));
    let (texels, support) = (w * h, kernel.support() as u64);
    let mut c = Counters::default();
    if settings.prefiltered() {
        let stored = 4 * u64::from(planes.count());
        let (run, strip) = (u64::from(plan::ROW_RUN), u64::from(plan::ROW_STRIP));
        let run_texels = |n: u64| n.next_multiple_of(strip) + support - 1;
        let rest = w % run;
        let in_row = w / run * run_texels(run) + if rest > 0 { run_texels(rest) } else { 0 };
        let strip = u64::from(plan::COLUMN_STRIP);
        let in_column = h.div_ceil(strip) * (support + strip - 1);
        c.prefilter_texels = texels + h * in_row + w * in_column;
        c.bytes_read = texels * (4 + 2 * stored);
        c.bytes_written = texels * 3 * stored;
    } else if settings.format != Format::F32 {
        c.prefilter_texels = texels;
        c.bytes_read = 4 * texels;
        c.bytes_written = 4 * texels;
    }
    let in_map = receivers.iter().filter(|r| r.in_map()).count() as u64;
    let bilinear = settings.lookup == Lookup::Bilinear;
    let (lookups, bytes) = if settings.prefiltered() {
        (if bilinear { 4 } else { 1 }, 4 * u64::from(planes.per_layer))
    } else {
        let n = taps.len() as u64;
        let contiguous = taps.windows(2).all(|pair| pair[1][0] - pair[0][0] == 1.0);
        let along = match (bilinear, contiguous) {
            (false, _) => n,
            (true, true) => n + 1,
            (true, false) => 2 * n,
        };
        (along * along, 4)
    };
    c.shade_texels = in_map * lookups;
    c.texels_fetched = c.prefilter_texels + c.shade_texels;
    c.bytes_read += c.shade_texels * bytes + 32 * receivers.len() as u64;
    c.bytes_written += 4 * receivers.len() as u64;
    c
}
