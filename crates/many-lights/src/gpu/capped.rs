//! The cap on a device.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 1.1.
//! Deviations: as [`crate::capped`]. The processor chooses the lights, and uploads them in every
//! frame: choices that begin at those of the tile before are one after another, which lanes in step
//! have no use for, and so all forms choose alike. Its time is one of the frame's.

use super::{
    kernel::{Kernel, Parts},
    scene::Scene,
};
use crate::{
    Capped, LightTree, Lighting, LightsError, Shaded, Times,
    bound::packed::clamp_squared,
    capped::{Groups, Lists},
};
use dapple_gpu::wgpu;
use std::{sync::Arc, time::Instant};

/// The cap on a device.
pub(crate) struct OnDevice<'g> {
    scene: Arc<Scene<'g>>,
    kernel: Kernel<'g>,
    groups: Groups,
    most: usize,
    lists: Lists,
    /// First entry and number of a tile's lights.
    heads: Vec<[u32; 2]>,
    on_device: [wgpu::Buffer; 2],
    counted: bool,
}

impl<'g> OnDevice<'g> {
    /// Ready for all frames of a scene.
    ///
    /// # Errors
    /// A tree of other lights; lists over a limit of the device, by name.
    pub fn new(
        scene: &Arc<Scene<'g>>,
        tree: &LightTree,
        settings: &Capped,
    ) -> Result<Self, LightsError> {
        tree.check_number(&scene.world.lights)?;
        let tiles = scene.most_tiles();
        let most = (settings.most as usize).min(scene.world.lights.len());
        let entries = tiles.saturating_mul(most as u64);
        let heads = scene.gpu.buffer("lists of tiles", 8 * tiles)?;
        let list = scene.gpu.buffer("chosen lights", entries.saturating_mul(4))?;
        let parts = Parts {
            pass: "light",
            path: "many-lights/capped.wgsl",
            constants: &[],
            buffers: &[scene.lights(), &heads, &list],
            evaluates_all: false,
            most_groups: None,
        };
        Ok(Self {
            scene: Arc::clone(scene),
            kernel: Kernel::new(scene, &parts)?,
            groups: Groups::new(&tree.pack()),
            most,
            lists: Lists::default(),
            heads: Vec::new(),
            on_device: [heads, list],
            counted: false,
        })
    }

    /// Chooses a frame's lights and uploads them.
    fn choose(&mut self, index: usize) -> Result<(), LightsError> {
        let frame = self.scene.frame(index)?;
        let clamp_squared = clamp_squared(self.scene.world.clamp_m);
        self.lists.fill(&self.groups, frame, self.most, clamp_squared);
        let queue = &self.scene.gpu.queue;
        self.heads.clear();
        let mut before = 0;
        for row in self.lists.rows() {
            let tiles = row.first.windows(2);
            // Below 2^32: the buffer has a word for each.
            let heads = tiles.map(|ends| [(before + ends[0]) as u32, (ends[1] - ends[0]) as u32]);
            self.heads.extend(heads);
            let bytes = bytemuck::cast_slice(&row.lights);
            queue.write_buffer(&self.on_device[1], 4 * before as u64, bytes);
            before += row.lights.len();
        }
        queue.write_buffer(&self.on_device[0], 0, bytemuck::cast_slice(&self.heads));
        Ok(())
    }
}

impl Lighting for OnDevice<'_> {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.kernel.reset(seed)
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let start = Instant::now();
        self.choose(index)?;
        let chosen = start.elapsed().as_nanos() as u64;
        self.counted = count;
        let mut times = self.kernel.shade(index, count)?;
        times.insert(0, ("choose", chosen));
        Ok(times)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        self.kernel.read(shaded)?;
        // No pixel walks a tree.
        shaded.visits.clear();
        if self.counted {
            shaded.work += self.lists.work();
        }
        Ok(())
    }

    fn bytes(&self) -> u64 {
        self.kernel.bytes() + self.groups.bytes() + self.lists.bytes()
    }
}
