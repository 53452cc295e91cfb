//! Pipelines of the kernels, and what they are bound to.

use dapple_gpu::bindings::whole;
use dapple_gpu::{Gpu, GpuError, wgpu};

const CULL: &str = "occlusion/hierarchical_cull.wgsl";
const LIST: &str = "occlusion/hierarchical_list.wgsl";
const PYRAMID: &str = "occlusion/hierarchical_pyramid.wgsl";

/// Items of a workgroup; mirrors `ITEMS` of `common/occlusion_cull.wgsl`.
pub(super) const ITEMS: u32 = 256;

/// Levels that a dispatch of the pyramid writes, and texels of the level below that a workgroup of
/// it takes a side.
const LEVELS_A_DISPATCH: u32 = 5;
const TILE: u32 = 1 << LEVELS_A_DISPATCH;

/// A kernel with its bindings and its grid.
#[derive(Debug)]
pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    grid: [u32; 3],
}

impl Kernel {
    fn new(
        gpu: &Gpu,
        pipeline: &wgpu::ComputePipeline,
        resources: &[(u32, wgpu::BindingResource<'_>)],
        grid: [u32; 3],
    ) -> Self {
        let entries: Vec<_> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        Self { pipeline: pipeline.clone(), group, grid }
    }

    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        let [x, y, z] = self.grid;
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(x, y, z);
    }
}

/// Buffers that live as long as the objects.
#[derive(Debug)]
pub(super) struct Buffers {
    pub params: wgpu::Buffer,
    /// Boxes of the items.
    pub boxes: wgpu::Buffer,
    /// What is known of the items.
    pub state: wgpu::Buffer,
    /// Listed items of each workgroup.
    pub sums: wgpu::Buffer,
    /// Length of the list after the first and after the second pass.
    pub totals: wgpu::Buffer,
    /// The object of each item.
    pub order: wgpu::Buffer,
    /// Objects drawn.
    pub list: wgpu::Buffer,
    /// Places of the list before each item.
    pub offsets: wgpu::Buffer,
    /// Items and vertices of each template.
    pub slots: wgpu::Buffer,
    /// An indirect draw a template.
    pub draws: wgpu::Buffer,
}

impl Buffers {
    pub fn bytes(&self) -> u64 {
        let Self { params, boxes, state, sums, totals, order, list, offsets, slots, draws } = self;
        [params, boxes, state, sums, totals, order, list, offsets, slots, draws]
            .map(wgpu::Buffer::size)
            .iter()
            .sum()
    }
}

/// Turns the flags of a pass into its draws.
#[derive(Debug)]
pub(super) struct Listing(pub [Kernel; 3]);

impl Listing {
    pub fn new(
        gpu: &Gpu,
        buffers: &Buffers,
        second: bool,
        items: u32,
        slots: u32,
    ) -> Result<Self, GpuError> {
        let b = buffers;
        let constants = [("second", f64::from(u8::from(second)))];
        let scan = gpu.compute(LIST, "scan", &constants)?;
        let scatter = gpu.compute(LIST, "scatter", &[])?;
        let arguments = gpu.compute(LIST, "arguments", &[])?;
        let at = |binding: u32, buffer| (binding, whole(buffer));
        let params = || at(0, &b.params);
        Ok(Self([
            Kernel::new(gpu, &scan, &[params(), at(1, &b.sums), at(2, &b.totals)], [1; 3]),
            Kernel::new(
                gpu,
                &scatter,
                &[
                    params(),
                    at(1, &b.sums),
                    at(3, &b.state),
                    at(4, &b.order),
                    at(5, &b.list),
                    at(6, &b.offsets),
                ],
                gpu.workgroups(items.into(), ITEMS)?,
            ),
            Kernel::new(
                gpu,
                &arguments,
                &[params(), at(6, &b.offsets), at(7, &b.slots), at(8, &b.draws)],
                gpu.workgroups(slots.into(), ITEMS)?,
            ),
        ]))
    }
}

/// Which of its three questions a pass asks of the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Question {
    /// Seen in the last frame, and on the screen.
    First,
    /// Not drawn, and not hidden.
    Second,
    /// Not hidden.
    Last,
}

pub(super) fn cull(
    gpu: &Gpu,
    buffers: &Buffers,
    question: Question,
    texels: &wgpu::Buffer,
    depth: &wgpu::TextureView,
    items: u32,
) -> Result<Kernel, GpuError> {
    let entry = match question {
        Question::First => "first",
        Question::Second => "second",
        Question::Last => "last",
    };
    let pipeline = gpu.compute(CULL, entry, &[])?;
    let b = buffers;
    let mut resources = vec![
        (0, whole(&b.params)),
        (1, whole(&b.boxes)),
        (2, whole(&b.state)),
        (3, whole(&b.sums)),
    ];
    if question != Question::First {
        resources.push((4, whole(texels)));
        resources.push((5, wgpu::BindingResource::TextureView(depth)));
    }
    Ok(Kernel::new(gpu, &pipeline, &resources, gpu.workgroups(items.into(), ITEMS)?))
}

/// The dispatches that build a pyramid over a `width` x `height` image.
pub(super) fn pyramid(
    gpu: &Gpu,
    params: &wgpu::Buffer,
    texels: &wgpu::Buffer,
    depth: &wgpu::TextureView,
    [width, height]: [u32; 2],
    nearest: bool,
) -> Result<Vec<Kernel>, GpuError> {
    let mut kernels = Vec::new();
    let (mut base, mut size) = (0, [width, height]);
    while size != [1, 1] {
        let constants = [("base", f64::from(base)), ("nearest", f64::from(u8::from(nearest)))];
        let entry = if base == 0 { "from_image" } else { "from_level" };
        let pipeline = gpu.compute(PYRAMID, entry, &constants)?;
        let mut resources = vec![(0, whole(params)), (1, whole(texels))];
        if base == 0 {
            resources.push((2, wgpu::BindingResource::TextureView(depth)));
        }
        size = size.map(|side| side.div_ceil(TILE));
        kernels.push(Kernel::new(gpu, &pipeline, &resources, [size[0], size[1], 1]));
        base += LEVELS_A_DISPATCH;
    }
    Ok(kernels)
}
