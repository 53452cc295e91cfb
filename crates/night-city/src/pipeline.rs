//! Whole frames.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 3 and 5.2.3 (what is
//! seen, its cells, their precuts, cuts of these a pixel; the device lights a frame while the
//! processor goes about the next).
//! Deviations: what pixels show is given, by rays, and so the same for all techniques: what is drawn
//! says what is seen, and how much of it.

use crate::{Device, Drawer, Front, Night, NightError, Prepared, Town};
use dapple_many_lights::{
    Form, Light, LightTree, Lighting, Shaded, Technique, Times,
    cut::{self, Given, Starting, Starts},
};
use std::{ops::Range, sync::Arc, time::Instant};

/// How much of everything a frame had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Objects drawn.
    pub drawn: u64,
    /// Those of them that have a list of their own; the others start at the roots.
    pub listed: u64,
    /// View cells.
    pub cells: u64,
    /// Cells and directions whose precuts were found anew.
    pub evaluations: u64,
    /// Cells that had to do with precuts of a cell above them, or with none.
    pub late: u64,
    /// Lists: one for all objects of a cell whose surfaces face the same directions.
    pub lists: u64,
    /// Nodes of all lists.
    pub list_nodes: u64,
    /// Bytes of ranges and lists, as a device holds them.
    pub list_bytes: u64,
    /// Precuts that are kept for later frames.
    pub kept: u64,
    /// Their bytes.
    pub kept_bytes: u64,
}

/// How long a frame took, by stages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameTimes {
    /// What is seen.
    pub visibility_ns: u64,
    /// Its cells.
    pub cells_ns: u64,
    /// Their precuts and lists.
    pub region_ns: u64,
    /// Lists to where pixels are lit.
    pub upload_ns: u64,
    /// Lighting pixels, by the wall's clock.
    pub shading_ns: u64,
    /// The whole frame: less than the sum where stages overlap.
    pub wall_ns: u64,
    /// Lighting pixels, by the device's clock.
    pub passes: Times,
    /// Bytes sent to a device.
    pub uploaded: u64,
    /// How much of everything there was.
    pub counts: Counts,
}

impl FrameTimes {
    /// All stages, one after the other.
    pub fn stages_ns(&self) -> u64 {
        self.visibility_ns + self.cells_ns + self.region_ns + self.upload_ns + self.shading_ns
    }

    fn prepared(&mut self, prepared: Prepared) {
        self.visibility_ns = prepared.visibility_ns;
        self.cells_ns = prepared.cells_ns;
        self.region_ns = prepared.region_ns;
        self.counts = prepared.counts;
    }
}

/// Frames of a town by one setting.
pub struct Pipeline<'g> {
    town: Arc<Town>,
    front: Front<'g>,
    shading: Box<dyn Starting + 'g>,
}

impl<'g> Pipeline<'g> {
    /// Made ready: on a device, or on the processor.
    ///
    /// # Errors
    /// Settings that are refused, a device that is too small or that holds another world.
    pub fn new(
        town: &Arc<Town>,
        night: &Night,
        device: Option<&Device<'g>>,
    ) -> Result<Self, NightError> {
        let front = Front::new(town, night, Drawer::new(&town.objects, device)?)?;
        let world = town.world(night.shadow_rays);
        let given = Given::new(&Technique::Absolute(night.cut), world, &town.lights)?;
        let form = if device.is_some() { Form::Gpu } else { Form::Cpu };
        let shading = cut::starting(form, &given, device.map(|device| &device.lights))?;
        Ok(Self { town: Arc::clone(town), front, shading })
    }

    /// Forgets every earlier frame.
    ///
    /// # Errors
    /// The device's.
    pub fn reset(&mut self) -> Result<(), NightError> {
        self.front.reset()?;
        Ok(self.shading.reset(0)?)
    }

    /// One frame, one stage after the other. Counting costs time and changes nothing else.
    ///
    /// # Errors
    /// A frame that there is not, or the device's.
    pub fn frame(&mut self, index: usize, count: bool) -> Result<FrameTimes, NightError> {
        let begun = Instant::now();
        let mut times = FrameTimes::default();
        times.prepared(self.front.prepare(index)?);
        let prepared = Instant::now();
        times.uploaded = self.shading.start(self.front.starts())?;
        let uploaded = Instant::now();
        times.passes = self.shading.shade(index, count)?;
        times.upload_ns = (uploaded - prepared).as_nanos() as u64;
        times.shading_ns = uploaded.elapsed().as_nanos() as u64;
        times.wall_ns = begun.elapsed().as_nanos() as u64;
        Ok(times)
    }

    /// Frames in order: while one is lit, the next is prepared. `each` is told of every frame when it
    /// is lit, and may read it; that is not timed. A frame's wall time is that from one to the next;
    /// the first one's has its own preparation besides.
    ///
    /// # Errors
    /// A frame that there is not, the device's, or what `each` refuses.
    pub fn overlapped(
        &mut self,
        frames: Range<usize>,
        mut each: impl FnMut(usize, &FrameTimes, &mut dyn Lighting) -> Result<(), NightError>,
    ) -> Result<(), NightError> {
        if frames.is_empty() {
            return Ok(());
        }
        let mut begun = Instant::now();
        let mut prepared = self.front.prepare(frames.start)?;
        for index in frames.clone() {
            let mut times = FrameTimes::default();
            times.prepared(prepared);
            let before = Instant::now();
            times.uploaded = self.shading.start(self.front.starts())?;
            times.upload_ns = before.elapsed().as_nanos() as u64;
            let Self { front, shading, .. } = self;
            let next = (index + 1 < frames.end).then_some(index + 1);
            let (lit, found) = std::thread::scope(|scope| {
                let lit = scope.spawn(|| {
                    let begun = Instant::now();
                    let passes = shading.shade(index, false);
                    (passes, begun.elapsed().as_nanos() as u64)
                });
                let found = next.map(|next| front.prepare(next));
                (lit.join(), found)
            });
            let (passes, shading_ns) = match lit {
                Ok(lit) => lit,
                // It goes on as if there had been no thread.
                Err(panic) => std::panic::resume_unwind(panic),
            };
            times.passes = passes?;
            times.shading_ns = shading_ns;
            times.wall_ns = begun.elapsed().as_nanos() as u64;
            if let Some(found) = found {
                prepared = found?;
            }
            each(index, &times, &mut *self.shading)?;
            begun = Instant::now();
        }
        Ok(())
    }

    /// Other lights move from the next frame on, in the place of those that did; `tree` is over them
    /// alone. Whatever is seen is lit by all of them: they are in no precut. Bytes sent to a device.
    ///
    /// # Errors
    /// A tree of other lights, a light that is refused, or the device's.
    pub fn replace_moving(
        &mut self,
        lights: &[Light],
        tree: &LightTree,
    ) -> Result<u64, NightError> {
        Ok(self.shading.replace_moving(lights, tree)?)
    }

    /// Lights a frame with every object at the roots, as if nothing hid anything, and counts.
    ///
    /// # Errors
    /// A frame that there is not, or the device's.
    pub fn whole_tree(&mut self, index: usize) -> Result<Times, NightError> {
        self.shading.start(&Starts::roots(&self.town.lights.roots))?;
        Ok(self.shading.shade(index, true)?)
    }

    /// What the last frame came out as.
    ///
    /// # Errors
    /// The device's.
    pub fn read(&mut self, shaded: &mut Shaded) -> Result<(), NightError> {
        Ok(self.shading.read(shaded)?)
    }

    /// Cells and their precuts.
    pub fn front(&self) -> &Front<'g> {
        &self.front
    }

    /// Bytes of everything but frames, scene and lights.
    pub fn bytes(&self) -> u64 {
        self.front.bytes() + self.shading.bytes()
    }
}
