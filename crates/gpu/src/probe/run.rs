//! The probes themselves: each runs on a device of its own and returns what it read, unjudged.

use super::{
    ArithmeticReading, F16_ROUNDING, F16_SUBNORMAL, LOOP_ITERATIONS, LoopReading, TimestampReading,
};
use crate::{Gpu, GpuError, Targets};

/// Side of the probes' image, and rectangles (x, y, width, height) of the occlusion queries:
/// 5000 and 1000 pixels.
const SIDE: u32 = 128;
const RECTANGLES: [[u32; 4]; 3] = [[10, 10, 100, 50], [0, 70, 40, 25], [10, 10, 100, 50]];

/// Invocations of the timestamp probe's workload, 64 a workgroup.
const WORKERS: u32 = 16_384;
/// The workload grows until it takes this long: far above the cost of a submission.
const WORKLOAD_NS: u64 = 10_000_000;
/// Runs of the timestamp probe.
const TIMESTAMP_RUNS: usize = 3;

fn dispatch(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
) -> Result<(), GpuError> {
    let mut frame = gpu.frame();
    frame.compute("probe", |pass| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    });
    frame.finish().map(|_| ())
}

pub(super) fn loops(gpu: &Gpu) -> Result<[LoopReading; 2], GpuError> {
    let asked = gpu.upload("loop lengths", &LOOP_ITERATIONS)?;
    let seen = gpu.upload("loop results", &[u32::MAX; 4])?;
    let pipeline = gpu.compute("gpu/loops.wgsl", "count_iterations", &[])?;
    let group = gpu.bind(&pipeline, 0, &[&asked, &seen]);
    dispatch(gpu, &pipeline, &group)?;
    let [a, x, b, y] = first(gpu.read::<u32>(&seen, 0, 4)?);
    Ok([LoopReading { counted: a, state: x }, LoopReading { counted: b, state: y }])
}

pub(super) fn arithmetic(gpu: &Gpu) -> Result<ArithmeticReading, GpuError> {
    let halves: Vec<f32> = F16_ROUNDING.iter().chain(&F16_SUBNORMAL).map(|(v, _)| *v).collect();
    let tail = [f32::MIN_POSITIVE, 0.5, 1.0 + 2f32.powi(-12), 1.0 + 2f32.powi(-11), 1.0, 3.0];
    let values = gpu.upload("values", &[&halves[..], &tail].concat())?;
    let pairs = halves.len() / 2;
    let bits = gpu.upload("bits", &vec![u32::MAX; pairs + 3])?;
    let pipeline = gpu.compute("gpu/arithmetic.wgsl", "round_f32", &[])?;
    let group = gpu.bind(&pipeline, 0, &[&values, &bits]);
    dispatch(gpu, &pipeline, &group)?;
    let packed = gpu.read::<u32>(&bits, 0, pairs)?;
    let [halved, square_difference, third] = first(gpu.read(&bits, 4 * pairs as u64, 3)?);
    let packed = packed.iter().flat_map(|&pair| [pair as u16, (pair >> 16) as u16]).collect();
    Ok(ArithmeticReading { packed, halved, square_difference, third })
}

pub(super) fn f16_store(gpu: &Gpu) -> Result<Vec<u16>, GpuError> {
    let values = gpu.upload("values", &F16_ROUNDING.map(|(v, _)| v))?;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
    let format = wgpu::TextureFormat::Rgba16Float;
    let width = (values.size() / 4) as u32;
    let image = gpu.texture("f16 values", width, 1, format, usage)?;
    let pipeline = gpu.compute("gpu/f16_store.wgsl", "store_f16", &[])?;
    let group = gpu.scoped("f16 store probe", || {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &values,
                        offset: 0,
                        size: std::num::NonZeroU64::new(values.size()),
                    }),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(
                        &image.create_view(&Default::default()),
                    ),
                },
            ],
        })
    })?;
    dispatch(gpu, &pipeline, &group)?;
    let channels: Vec<u16> = bytemuck::pod_collect_to_vec(&gpu.read_texture(&image)?);
    Ok(channels.chunks_exact(4).map(|texel| texel[0]).take(F16_ROUNDING.len()).collect())
}

pub(super) fn occlusion(gpu: &Gpu) -> Result<[u64; 4], GpuError> {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let format = wgpu::TextureFormat::Depth32Float;
    let depth = gpu.texture("occlusion depth", SIDE, SIDE, format, usage)?;
    let view = depth.create_view(&Default::default());
    let pipeline = raster(gpu, None, Some(format))?;
    let queries = gpu.scoped("occlusion queries", || {
        gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("occlusion"),
            ty: wgpu::QueryType::Occlusion,
            count: 4,
        })
    })?;
    let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
    let resolved = gpu.create("occlusion counts", 32, usage, false)?;
    let mut frame = gpu.frame();
    let depth = Targets::cleared_depth(&view, 1.0);
    frame.raster("occlusion", Targets { colour: &[], depth, occlusion: Some(&queries) }, |pass| {
        pass.set_pipeline(&pipeline);
        for (query, [x, y, width, height]) in (0..).zip(RECTANGLES) {
            pass.set_scissor_rect(x, y, width, height);
            pass.begin_occlusion_query(query);
            pass.draw(0..3, 0..1);
            pass.end_occlusion_query();
        }
        pass.begin_occlusion_query(3);
        pass.end_occlusion_query();
    });
    frame.encoder().resolve_query_set(&queries, 0..4, &resolved, 0);
    frame.finish()?;
    Ok(first(gpu.read(&resolved, 0, 4)?))
}

pub(super) fn timestamps(mut gpu: Gpu) -> Result<Vec<TimestampReading>, GpuError> {
    if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        let what = "GPU time".into();
        return Err(GpuError::Missing { what, feature: "TIMESTAMP_QUERY" });
    }
    gpu.abilities.timestamps = true;
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let image = gpu.texture("probe image", SIDE, SIDE, format, usage)?;
    let view = image.create_view(&Default::default());
    let raster = raster(&gpu, Some(format), None)?;
    let iterations = gpu.upload("iterations", &[1u32])?;
    let result =
        gpu.create("workload", u64::from(WORKERS) * 4, wgpu::BufferUsages::STORAGE, false)?;
    let pipeline = gpu.compute("gpu/work.wgsl", "work", &[])?;
    let group = gpu.bind(&pipeline, 0, &[&iterations, &result]);
    let once = || -> Result<TimestampReading, GpuError> {
        let mut frame = gpu.frame();
        let colour = [Targets::cleared(&view, wgpu::Color::BLACK)];
        frame.raster("raster", Targets { colour: &colour, ..Default::default() }, |pass| {
            pass.set_pipeline(&raster);
            pass.draw(0..3, 0..1);
        });
        frame.compute("compute", |pass| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(WORKERS / 64, 1, 1);
        });
        let (stamps, wall_ns) = frame.finish_stamps()?;
        let [a, b, c, d] = first(stamps);
        Ok(TimestampReading { raster: [a, b], compute: [c, d], wall_ns })
    };
    // Compilation on first use is in nobody's time.
    once()?;
    let mut length = 256u32;
    loop {
        gpu.queue.write_buffer(&iterations, 0, bytemuck::bytes_of(&length));
        if once()?.wall_ns >= WORKLOAD_NS || length >= 1 << 28 {
            break;
        }
        length *= 2;
    }
    (0..TIMESTAMP_RUNS).map(|_| once()).collect()
}

/// A pipeline that draws the triangle over all of clip space.
fn raster(
    gpu: &Gpu,
    colour: Option<wgpu::TextureFormat>,
    depth: Option<wgpu::TextureFormat>,
) -> Result<wgpu::RenderPipeline, GpuError> {
    let module = gpu.module("gpu/triangle.wgsl")?;
    let targets = colour.map(|format| [Some(format.into())]);
    gpu.raster(
        "probe triangle",
        &wgpu::RenderPipelineDescriptor {
            label: Some("probe triangle"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("full"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: depth.map(|format| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: targets.as_ref().map(|targets| wgpu::FragmentState {
                module: &module,
                entry_point: Some("red"),
                compilation_options: Default::default(),
                targets,
            }),
            multiview_mask: None,
            cache: None,
        },
    )
}

/// The first `N` values; absent ones are 0, which no probe takes for a sound reading.
fn first<T: Copy + Default, const N: usize>(values: Vec<T>) -> [T; N] {
    std::array::from_fn(|i| values.get(i).copied().unwrap_or_default())
}
