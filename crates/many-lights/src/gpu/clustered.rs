//! Clustered shading on a device: cells, lists and shading are passes of every frame.
//!
//! Based on: O. Olsson, M. Billeter and U. Assarsson, "Clustered deferred and forward shading", 2012.
//! Deviations: as [`crate::clustered`]. Lists are made on the device, where the points are: a
//! processor would have to read them back. They are measured once for every frame, lights and
//! frames being known, and so are never too small.

use super::{
    cells::{BOX_WORDS, cells_of, params},
    scene::{Output, Scene, storage},
};
use crate::{
    Clustered, Lighting, LightsError, Shaded, Times, Work,
    clustered::{Grid, Hierarchy},
    light::PackedLight,
};
use dapple_gpu::{Gpu, wgpu};
use std::sync::Arc;

/// Clustered shading on a device.
pub(crate) struct OnDevice<'g> {
    scene: Arc<Scene<'g>>,
    output: Output,
    passes: Passes,
    frames: Vec<OneFrame>,
    total: wgpu::Buffer,
    capacity: u32,
    bytes: u64,
    last: Option<(usize, bool)>,
}

struct Passes {
    clear: wgpu::ComputePipeline,
    cells: wgpu::ComputePipeline,
    lists: wgpu::ComputePipeline,
    /// The one that is timed, and the one that counts.
    light: [wgpu::ComputePipeline; 2],
}

/// What belongs to a frame.
struct OneFrame {
    /// Workgroups: one a cell, and one for 64 cells.
    by_cell: [u32; 3],
    by_64: [u32; 3],
    clear: wgpu::BindGroup,
    points: [wgpu::BindGroup; 2],
    lists: wgpu::BindGroup,
    /// Groups 0, 1 and 2 of each of the two pipelines.
    light: [[wgpu::BindGroup; 3]; 2],
}

/// What all frames share.
struct Shared {
    lights: wgpu::Buffer,
    groups: wgpu::Buffer,
    boxes: wgpu::Buffer,
    heads: wgpu::Buffer,
    list: wgpu::Buffer,
}

impl<'g> OnDevice<'g> {
    /// Ready for all frames of a scene.
    ///
    /// # Errors
    /// Too many cells, or the device's.
    pub fn new(scene: &Arc<Scene<'g>>, settings: &Clustered) -> Result<Self, LightsError> {
        let (gpu, world) = (scene.gpu, &scene.world);
        let hierarchy = Hierarchy::new(&world.lights, settings.cutoff);
        let grids = world.frames.iter().map(|frame| Grid::of(frame, settings));
        let grids = grids.collect::<Result<Vec<_>, _>>()?;
        let most = grids.iter().map(cells_of).max().unwrap_or(0);
        let lit = |count: f64| {
            let faded = f64::from(u8::from(settings.window));
            let path = "many-lights/clustered_light.wgsl";
            let shadows = scene.occluders().constant();
            gpu.compute(path, "light", &[("COUNT", count), ("FADED", faded), shadows])
        };
        let passes = Passes {
            clear: gpu.compute("many-lights/clustered_clear.wgsl", "clear", &[])?,
            cells: gpu.compute("many-lights/clustered_cells.wgsl", "cells", &[])?,
            lists: gpu.compute("many-lights/clustered_list.wgsl", "lists", &[])?,
            light: [lit(0.0)?, lit(1.0)?],
        };
        let lights = hierarchy.lights.iter().zip(&hierarchy.reaches).map(|(node, reach)| {
            let light = world.lights[node.light as usize].pack();
            PackedLight { pad: reach.squared.to_bits(), ..light }
        });
        let lights: Vec<_> = lights.collect();
        let groups = hierarchy.levels.first().map_or(&[][..], |level| level);
        let mut shared = Shared {
            lights: storage(gpu, "lights with a reach", &lights)?,
            groups: storage(gpu, "groups of lights", groups)?,
            boxes: gpu.buffer("boxes of cells", 4 * BOX_WORDS * most)?,
            heads: gpu.buffer("lists of cells", 8 * most)?,
            list: gpu.buffer("listed lights", 4)?,
        };
        let mut new = Self {
            scene: Arc::clone(scene),
            output: scene.output()?,
            passes,
            frames: Vec::new(),
            total: gpu.buffer("entries of lists", 4)?,
            capacity: 0,
            bytes: 0,
            last: None,
        };
        new.prepare(&grids, &hierarchy, &shared)?;
        for (frame, grid) in grids.iter().enumerate() {
            new.list(frame)?;
            new.capacity = new.capacity.max(measured(gpu, &shared.heads, cells_of(grid))?);
        }
        shared.list = gpu.buffer("listed lights", 4 * u64::from(new.capacity))?;
        new.prepare(&grids, &hierarchy, &shared)?;
        let Shared { lights, groups, boxes, heads, list } = shared;
        new.bytes = [&lights, &groups, &boxes, &heads, &list].map(wgpu::Buffer::size).iter().sum();
        gpu.check()?;
        Ok(new)
    }

    /// Parameters and bindings of every frame, for lists of the present capacity.
    fn prepare(
        &mut self,
        grids: &[Grid],
        hierarchy: &Hierarchy,
        shared: &Shared,
    ) -> Result<(), LightsError> {
        let (scene, gpu) = (&self.scene, self.scene.gpu);
        self.frames.clear();
        let passes = &self.passes;
        let seen = passes.light.each_ref().map(|pipeline| scene.bind(pipeline, &self.output));
        for (index, grid) in grids.iter().enumerate() {
            let params = params(&scene.world.frames[index].eye, grid, hierarchy, self.capacity);
            let params = gpu.uniform("cells", &params)?;
            let cells = cells_of(grid);
            let light = |of: usize| {
                let buffers = [&params, &shared.lights, &shared.heads, &shared.list];
                let shadows = gpu.bind(&passes.light[of], 2, &scene.occluders().buffers());
                [seen[of][index].clone(), gpu.bind(&passes.light[of], 1, &buffers), shadows]
            };
            let lists = [
                &params,
                &shared.boxes,
                &shared.lights,
                &shared.groups,
                &self.total,
                &shared.heads,
                &shared.list,
            ];
            self.frames.push(OneFrame {
                by_cell: gpu.workgroups(cells.max(1), 1)?,
                by_64: gpu.workgroups(cells.max(1), 64)?,
                clear: gpu.bind(&passes.clear, 1, &[&params, &shared.boxes, &self.total]),
                points: [
                    gpu.bind(&passes.cells, 0, &[scene.params(index)?, scene.points(index)?]),
                    gpu.bind(&passes.cells, 1, &[&params, &shared.boxes]),
                ],
                lists: gpu.bind(&passes.lists, 1, &lists),
                light: [light(0), light(1)],
            });
        }
        Ok(())
    }

    /// Entries that the lists of the last frame have.
    fn entries(&self) -> Result<u32, LightsError> {
        Ok(self.scene.gpu.read::<u32>(&self.total, 0, 1)?.first().copied().unwrap_or(0))
    }

    fn list(&self, index: usize) -> Result<(), LightsError> {
        let mut frame = self.scene.gpu.frame();
        self.record_lists(&mut frame, index)?;
        frame.finish()?;
        Ok(())
    }

    fn record_lists(
        &self,
        frame: &mut dapple_gpu::Frame<'_>,
        index: usize,
    ) -> Result<(), LightsError> {
        let [columns, rows] = self.scene.tiles(index)?;
        let of = &self.frames[index];
        frame.compute("clear", |pass| {
            let [x, y, z] = of.by_64;
            pass.set_pipeline(&self.passes.clear);
            pass.set_bind_group(1, &of.clear, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
        frame.compute("cells", |pass| {
            pass.set_pipeline(&self.passes.cells);
            pass.set_bind_group(0, &of.points[0], &[]);
            pass.set_bind_group(1, &of.points[1], &[]);
            pass.dispatch_workgroups(columns, rows, 1);
        });
        frame.compute("lists", |pass| {
            let [x, y, z] = of.by_cell;
            pass.set_pipeline(&self.passes.lists);
            pass.set_bind_group(1, &of.lists, &[]);
            pass.dispatch_workgroups(x, y, z);
        });
        Ok(())
    }

    fn work(&self, index: usize) -> Result<Work, LightsError> {
        let counts = self.scene.read_counts(&self.output, index)?;
        let frame = self.scene.frame(index)?;
        let lit = frame.points.iter().zip(&counts).filter(|(point, _)| point.is_there());
        let rays = self.scene.read_rays(&self.output, index)?;
        let mut work = Work { entries: self.entries()?.into(), rays, ..Work::default() };
        for (_, count) in lit {
            work.pixels += 1;
            work.lights += u64::from(count[2]);
        }
        Ok(work)
    }
}

/// Entries of all lists of a frame: a sum on the device could pass 32 bits.
fn measured(gpu: &Gpu, heads: &wgpu::Buffer, cells: u64) -> Result<u32, LightsError> {
    let heads = gpu.read::<[u32; 2]>(heads, 0, cells as usize)?;
    let entries: u64 = heads.iter().map(|head| u64::from(head[1])).sum();
    u32::try_from(entries).map_err(|_| {
        let limit = format!("{entries} entries; at most {} are supported", u32::MAX);
        LightsError::value("lists of cells", limit)
    })
}

impl Lighting for OnDevice<'_> {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        self.last = None;
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let [columns, rows] = self.scene.tiles(index)?;
        let mut frame = self.scene.gpu.frame();
        self.record_lists(&mut frame, index)?;
        let which = usize::from(count);
        let [seen, own, shadows] = &self.frames[index].light[which];
        frame.compute("light", |pass| {
            pass.set_pipeline(&self.passes.light[which]);
            pass.set_bind_group(0, seen, &[]);
            pass.set_bind_group(1, own, &[]);
            pass.set_bind_group(2, shadows, &[]);
            pass.dispatch_workgroups(columns, rows, 1);
        });
        let times = frame.finish()?.passes;
        self.last = Some((index, count));
        Ok(times)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        let Some((index, counted)) = self.last else {
            return Err(LightsError::value("reading", "no frame has been lit yet"));
        };
        let entries = self.entries()?;
        if entries > self.capacity {
            let limit = format!("{entries} entries, with room for {}", self.capacity);
            return Err(LightsError::value("lists of cells", limit));
        }
        self.scene.read(&self.output, index, &mut shaded.radiance)?;
        shaded.visits.clear();
        shaded.work = if counted { self.work(index)? } else { Work::default() };
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }
}
