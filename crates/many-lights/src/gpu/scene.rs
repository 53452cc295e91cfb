//! What all techniques share on a device, uploaded once.

use super::occluders::Occluders;
use crate::{Frame, Light, LightsError, World, bound::packed::clamp_squared, cut::tile};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::{Gpu, GpuError, wgpu};
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// Pixels a side of a tile: a workgroup is one tile.
pub const TILE: u32 = tile::SIDE;

/// Pixels of a tile: invocations of a workgroup.
pub(super) const LANES: u64 = tile::LANES as u64;

/// What a kernel is told of a frame; `FrameParams` of `common/lights_frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Lights of the world.
    pub lights: u32,
    /// The frame's index.
    pub frame: u32,
    /// What squared distances are not below, square metres.
    pub clamp_squared: f32,
    /// Unused.
    pub pad: [u32; 3],
}

/// Points of every frame, the lights, and what casts shadows.
pub struct Scene<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// What was uploaded.
    pub world: Arc<World>,
    lights: wgpu::Buffer,
    occluders: Occluders,
    frames: Vec<(wgpu::Buffer, wgpu::Buffer)>,
    greatest: u64,
}

/// What one technique writes: every technique has its own, so that none overwrites another's.
#[derive(Debug)]
pub struct Output {
    /// `array<vec4<f32>>`: radiance, one a pixel of the largest frame.
    pub radiance: wgpu::Buffer,
    /// `array<vec4<u32>>`: what was counted, one a pixel.
    pub counts: wgpu::Buffer,
}

impl<'g> Scene<'g> {
    /// Uploads the frames' points and the lights.
    ///
    /// # Errors
    /// A buffer or a dispatch over a limit of the device, by name; occluders that are not traced on
    /// a device ([`Occluders::new`]).
    pub fn new(gpu: &'g Gpu, world: &Arc<World>) -> Result<Self, LightsError> {
        let count = u32::try_from(world.lights.len())
            .map_err(|_| LightsError::value("lights", "more than 2^32 - 1 are not supported"))?;
        let lights: Vec<_> = world.lights.iter().map(Light::pack).collect();
        let lights = storage(gpu, "lights", &lights)?;
        let occluders = Occluders::new(gpu, world)?;
        let mut frames = Vec::with_capacity(world.frames.len());
        for (index, frame) in world.frames.iter().enumerate() {
            check_tiles(gpu, index, frame)?;
            let points = storage(gpu, &format!("points of frame {index}"), &frame.points)?;
            let params = FrameParams {
                width: frame.width,
                height: frame.height,
                lights: count,
                frame: index as u32,
                clamp_squared: clamp_squared(world.clamp_m),
                pad: [0; 3],
            };
            frames.push((points, gpu.uniform("frame", &params)?));
        }
        let greatest = world.frames.iter().map(|frame| frame.points.len() as u64).max();
        let (world, greatest) = (Arc::clone(world), greatest.unwrap_or(0));
        Ok(Self { gpu, world, lights, occluders, frames, greatest })
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Points of a frame: `array<Point>`, one a pixel.
    ///
    /// # Errors
    /// A frame that there is not.
    pub fn points(&self, frame: usize) -> Result<&wgpu::Buffer, LightsError> {
        Ok(&self.of(frame)?.0)
    }

    /// Uniform [`FrameParams`] of a frame.
    ///
    /// # Errors
    /// A frame that there is not.
    pub fn params(&self, frame: usize) -> Result<&wgpu::Buffer, LightsError> {
        Ok(&self.of(frame)?.1)
    }

    /// All lights: `array<Light>`, at least one element.
    pub fn lights(&self) -> &wgpu::Buffer {
        &self.lights
    }

    /// What casts shadows.
    pub fn occluders(&self) -> &Occluders {
        &self.occluders
    }

    /// Group 2 of `common/lights_shadow.wgsl`, for a pipeline whose entry point calls `sees`;
    /// `lights` begins with [`Scene::lights`].
    pub fn bind_shadows(
        &self,
        pipeline: &wgpu::ComputePipeline,
        lights: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let [params, nodes, triangles] = self.occluders.buffers();
        self.gpu.bind(pipeline, 2, &[params, nodes, triangles, lights])
    }

    /// Pixels of the largest frame.
    pub fn greatest_pixels(&self) -> u64 {
        self.greatest
    }

    /// Workgroups of 8 x 8 that cover a frame.
    ///
    /// # Errors
    /// A frame that there is not.
    pub fn tiles(&self, frame: usize) -> Result<[u32; 2], LightsError> {
        let frame = self.frame(frame)?;
        Ok(tile::tiles(frame.width, frame.height).into())
    }

    /// Workgroups that cover the frame of most tiles.
    pub(super) fn most_tiles(&self) -> u64 {
        let tiles = self.world.frames.iter().map(|frame| tile::tiles(frame.width, frame.height));
        tiles.map(|(columns, rows)| u64::from(columns) * u64::from(rows)).max().unwrap_or(0)
    }

    /// A frame of the world.
    ///
    /// # Errors
    /// A frame that there is not.
    pub fn frame(&self, frame: usize) -> Result<&Frame, LightsError> {
        self.world.frame(frame)
    }

    /// New buffers for what a technique gives and counts.
    ///
    /// # Errors
    /// A buffer over a limit of the device, by name.
    pub fn output(&self) -> Result<Output, LightsError> {
        let bytes = 16 * self.greatest;
        let radiance = self.gpu.buffer("radiance", bytes)?;
        Ok(Output { radiance, counts: self.gpu.buffer("counts", bytes)? })
    }

    /// Group 0 of `common/lights_frame.wgsl`, one a frame, for a pipeline whose entry point uses
    /// all four bindings: parameters, points, radiance, counts.
    pub fn bind(&self, pipeline: &wgpu::ComputePipeline, output: &Output) -> Vec<wgpu::BindGroup> {
        let one = |(points, params): &(wgpu::Buffer, wgpu::Buffer)| {
            self.gpu.bind(pipeline, 0, &[params, points, &output.radiance, &output.counts])
        };
        self.frames.iter().map(one).collect()
    }

    /// Radiance of frame `frame`, which was the last that wrote to `output`.
    ///
    /// # Errors
    /// A frame that there is not, or the device's.
    pub fn read(
        &self,
        output: &Output,
        frame: usize,
        radiance: &mut Vec<Vec3>,
    ) -> Result<(), LightsError> {
        let count = self.frame(frame)?.points.len();
        let read: Vec<Vec4> = self.gpu.read(&output.radiance, 0, count)?;
        radiance.clear();
        radiance.extend(read.iter().map(|texel| texel.truncate()));
        Ok(())
    }

    /// Shadow rays of frame `frame`, by kernels that count them in the fourth number of each
    /// pixel's radiance: exact below 2^24 a pixel.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_rays(&self, output: &Output, frame: usize) -> Result<u64, LightsError> {
        if !self.occluders.are_there() {
            return Ok(0);
        }
        let count = self.frame(frame)?.points.len();
        let read: Vec<Vec4> = self.gpu.read(&output.radiance, 0, count)?;
        Ok(read.iter().map(|texel| texel.w as u64).sum())
    }

    /// What was counted at each pixel of frame `frame`; what the four are is the technique's.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_counts(&self, output: &Output, frame: usize) -> Result<Vec<[u32; 4]>, LightsError> {
        let count = self.frame(frame)?.points.len();
        Ok(self.gpu.read(&output.counts, 0, count)?)
    }

    fn of(&self, frame: usize) -> Result<&(wgpu::Buffer, wgpu::Buffer), LightsError> {
        // As many as the world has.
        self.world.frame(frame).map(|_| &self.frames[frame])
    }
}

/// A storage buffer of at least one element: kernels bind arrays that are never empty.
pub(super) fn storage<T: Pod>(
    gpu: &Gpu,
    label: &str,
    data: &[T],
) -> Result<wgpu::Buffer, GpuError> {
    if data.is_empty() { gpu.upload(label, &[T::zeroed()]) } else { gpu.upload(label, data) }
}

/// Refuses frames of more tiles in a row or column than a dispatch may have.
fn check_tiles(gpu: &Gpu, index: usize, frame: &Frame) -> Result<(), GpuError> {
    let max = gpu.limits().max_compute_workgroups_per_dimension;
    let asked = frame.width.max(frame.height).div_ceil(TILE);
    if asked <= max {
        return Ok(());
    }
    Err(GpuError::TooLarge {
        what: format!("tiles of frame {index}"),
        asked: asked.into(),
        limit: "max_compute_workgroups_per_dimension",
        max: max.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_and_lights_have_the_layout_of_the_shaders() {
        let path = "many-lights/brute_force.wgsl";
        let fields = [
            ("width", 0),
            ("height", 4),
            ("lights", 8),
            ("frame", 12),
            ("clamp_squared", 16),
            ("pad0", 20),
            ("pad1", 24),
            ("pad2", 28),
        ];
        crate::gpu::mirror::<FrameParams>(path, "FrameParams", &fields);
        let fields = [
            ("position", 0),
            ("half_angle_rad", 12),
            ("intensity", 16),
            ("kind", 28),
            ("axis", 32),
            ("pad", 44),
        ];
        crate::gpu::mirror::<crate::light::PackedLight>(path, "Light", &fields);
    }
}
