//! A search for λ on the device: a frame fills trial maps and scores them, the last one's adopts the
//! best, for the whole map or tile by tile. Nothing is read back: the host only counts frames.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, algorithms 5.2.3.1 and 7.1.
//!
//! Deviations: those of [`crate::search::Search`], frame for frame; trial maps are never drawn. The
//! thesis reads maps back and scores them on the processor.

use super::{
    Counters, OpacityGpuError,
    layered::{LayeredMaps, no_form},
    raster::Raster,
    score::Score,
    shade::{Decoder, Shade},
    tiled::Tiles,
};
use crate::{
    Blur, Code, Model, OpacityError, Receiver,
    layered::unit,
    search::{self, Plan, Shown, Steps},
};
use dapple_gpu::light_space::LightSpaceMesh;
use dapple_gpu::{Frame, Gpu};
use std::cell::Cell;

/// What a search costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchCounters {
    /// A frame that tries nothing.
    pub settled: Counters,
    /// Further passes over the translucent geometry of a frame that tries a λ.
    pub trial_passes: u64,
    /// Bytes of trial maps that are looked at for a score.
    pub scored_bytes: u64,
    /// Tiles with a λ of their own.
    pub tiles: u64,
}

/// Bounding opacity maps whose split is searched for, over one mesh, one map size and one set of
/// receivers.
#[derive(Debug)]
pub struct SearchRenderer {
    raster: Raster,
    drawn: LayeredMaps,
    trial: LayeredMaps,
    score: Score,
    shade: Shade,
    steps: Steps,
    repeat: bool,
    /// The step that the next frame tries; beyond the last none.
    next: u32,
    tiles: usize,
    counters: SearchCounters,
    read_backs: Cell<u64>,
}

impl SearchRenderer {
    /// Uploads mesh and receivers and makes everything a frame of maps of `size` (width, height)
    /// needs. λ = 0 is drawn until one is adopted.
    ///
    /// # Errors
    /// Settings out of range or without a split, an empty map, an unsound mesh; a criterion that
    /// says nothing of a tile that small; [`OpacityGpuError::NoForm`] for criteria other than sums
    /// over maps, splits by lookup textures, trial maps that are drawn; a limit or feature of the
    /// device, by name.
    pub fn new(
        gpu: &Gpu,
        mesh: &LightSpaceMesh,
        model: Model,
        receivers: &[Receiver],
        size: [u32; 2],
        plan: &Plan,
    ) -> Result<Self, OpacityGpuError> {
        let settings = search::cumulative(&plan.settings);
        settings.check()?;
        let Code::Layered(layered) = &settings.code else {
            return Err(
                OpacityError::setting("code", "other", "a search needs layered maps").into()
            );
        };
        if plan.tile == 1 && plan.scoring.criterion == crate::Criterion::Correlation {
            let limit = "this criterion needs more texels; use equal transmittance";
            return Err(OpacityError::setting("tile", plan.tile, limit).into());
        }
        if plan.shown == Shown::Trial {
            return Err(no_form("drawing trial maps", "they are kept apart from what is drawn"));
        }
        let raster = Raster::new(gpu, mesh, model, size, settings.opaque)?;
        let (tiles, one) = (Tiles::new(size, plan.tile), Tiles::new(size, 0));
        let drawn = LayeredMaps::tiled(gpu, &raster, layered, &settings, tiles, None)?;
        let trial = LayeredMaps::tiled(gpu, &raster, layered, &settings, one, Some(&drawn))?;
        let trial_of = (layered, &trial);
        let splits = drawn.table();
        let score = Score::new(gpu, &raster, trial_of, plan.scoring, plan.steps, tiles, splits)?;
        let shade = drawn.with_decoder(|decoder: &Decoder<'_>| {
            Shade::new(gpu, receivers, &settings, size, raster.opaque_view(), decoder)
        })?;
        gpu.check()?;
        let cost = |taps| drawn.cost(taps, settings.blur);
        let settled = super::counters(&raster, cost, receivers, &settings);
        let channel = unit::bytes(layered.format);
        let counters = SearchCounters {
            settled,
            trial_passes: trial.map_passes(),
            scored_bytes: score.texels() * u64::from(layered.layers) * channel,
            tiles: tiles.all.into(),
        };
        let (steps, repeat, tiles) = (plan.steps, plan.repeat, tiles.all as usize);
        Ok(Self {
            raster,
            drawn,
            trial,
            score,
            shade,
            steps,
            repeat,
            next: 0,
            tiles,
            counters,
            read_backs: Cell::new(0),
        })
    }

    /// Records a frame's passes; a frame that is recorded must be submitted, in order. Returns the
    /// λ that it tries, if any: the last of them is adopted before the frame's own maps are filled.
    pub fn record(&mut self, frame: &mut Frame<'_>) -> Option<f32> {
        self.raster.record_opaque(frame);
        if let Some(bounds) = self.drawn.bounds() {
            bounds.record(frame, &self.raster);
        }
        let step = self.next;
        let tried = (step < self.steps.values()).then(|| self.steps.lambda(step));
        if tried.is_some() {
            self.score.record_step(frame, step, &self.trial);
            self.trial.record_maps(frame, &self.raster, "search-opacity");
            self.score.record(frame, step);
            let is_last = step + 1 == self.steps.values();
            self.next = if self.repeat && is_last { 0 } else { step + 1 };
        }
        self.drawn.record_maps(frame, &self.raster, "opacity");
        self.shade.record(frame);
        tried
    }

    /// Starts anew: densities, models or the light's direction have changed.
    pub fn needs_recompute(&mut self) {
        self.next = 0;
    }

    /// Whether the next frame tries a λ.
    #[must_use]
    pub fn is_searching(&self) -> bool {
        self.next < self.steps.values()
    }

    /// Transmittances of the last frame, one a receiver.
    ///
    /// # Errors
    /// A lost device, or one that does not finish.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, OpacityGpuError> {
        self.count_read_back();
        Ok(self.shade.read(gpu)?)
    }

    /// λ of each tile as drawn, row-major.
    ///
    /// # Errors
    /// As [`SearchRenderer::read`].
    pub fn read_lambdas(&self, gpu: &Gpu) -> Result<Vec<f32>, OpacityGpuError> {
        self.count_read_back();
        Ok(gpu.read(self.drawn.table(), 0, self.tiles)?)
    }

    /// Scores of each step's maps in every tile; of steps not yet tried, what was there before.
    ///
    /// # Errors
    /// As [`SearchRenderer::read`].
    pub fn read_scores(&self, gpu: &Gpu) -> Result<Vec<Vec<f32>>, OpacityGpuError> {
        self.count_read_back();
        Ok(self.score.read(gpu)?)
    }

    /// How often anything was read from the device since the renderer was made: by the three
    /// above, never by a frame.
    #[must_use]
    pub fn read_backs(&self) -> u64 {
        self.read_backs.get()
    }

    fn count_read_back(&self) {
        self.read_backs.set(self.read_backs.get() + 1);
    }

    /// What a search costs.
    #[must_use]
    pub fn counters(&self) -> SearchCounters {
        self.counters
    }

    /// Bytes on the device: both sets of maps, scores, mesh, receivers and results.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let all = |maps: &LayeredMaps| {
            let cost = maps.cost(1, Blur::Transmittance);
            cost.map_bytes + cost.other_bytes
        };
        // They share their bounds.
        let shared = self.drawn.bounds().map_or(0, super::bounds::Bounds::bytes);
        let maps = (all(&self.drawn) + all(&self.trial)).saturating_sub(shared);
        maps + self.score.bytes() + self.raster.bytes() + self.shade.bytes()
    }
}
