//! A search on the processor: maps at the λ on trial, their score, and maps to draw with.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, algorithms 5.2.3.1 and 7.1.
//!
//! Deviations: the split texture is published after a whole cycle and read by receivers too; tiles
//! are scored by equal transmittance, equal opacity, correlation or the oracle (absolute differences
//! are kept, though they telescope: see [`super::criteria`]).

use super::{
    Layers, Scorer, Scoring, SplitCode, SplitTexture,
    criteria::{self, is_better},
    oracle,
    state::{Cycle, Shown, Steps},
};
use crate::{
    Blend, Code, Criterion, Format, Fragments, OpacityError, Packing, Settings, cpu::Maps,
    exact::Exact,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Tiles that one task scores at least.
const TILES: usize = 64;

/// What is searched for, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Bounding opacity maps; their λ is ignored.
    pub settings: Settings,
    /// What maps are judged by.
    pub scoring: Scoring,
    /// The values of λ.
    pub steps: Steps,
    /// Side of the tiles that have a λ of their own, texels; 1: every texel, 0: one for all.
    pub tile: u32,
    /// What is drawn meanwhile; tiles are always drawn as adopted.
    pub shown: Shown,
    /// Whether a search follows the other for ever, as algorithm 7.1 has it.
    pub repeat: bool,
}

impl Plan {
    /// One λ for all, the thesis's eleven values, drawn as adopted.
    #[must_use]
    pub fn plain(settings: Settings, criterion: Criterion) -> Self {
        let scoring = Scoring::plain(criterion);
        let (steps, shown) = (Steps::THESIS, Shown::Adopted);
        Self { settings, scoring, steps, tile: 0, shown, repeat: false }
    }
}

/// What a frame did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// λ tried and the score of its maps (of all tiles together), if a search is on.
    pub trial: Option<(f32, f64)>,
    /// Sets of opacity maps built: 1, or 2 while trial maps are not drawn.
    pub map_sets: u32,
    /// Whether this frame's score was a search's last.
    pub adopted: bool,
}

/// A tile's score in this frame, and the best of its cycle.
#[derive(Clone, Copy, Debug, Default)]
struct Tile {
    score: f64,
    best: f64,
    step: u32,
}

/// A search with all it needs, allocated once (but for [`Criterion::Oracle`], which sorts the
/// fragments of every frame it scores).
pub struct Search {
    plan: Plan,
    layers: usize,
    stored: (Blend, Format),
    cycle: Cycle,
    scorer: Scorer,
    tiles: Vec<Tile>,
    trial_split: Arc<SplitTexture>,
    trial: Maps,
    drawn_split: Arc<SplitTexture>,
    /// None: the trial maps are drawn.
    drawn: Option<Maps>,
}

impl Search {
    /// Allocates the maps of `width` x `height` texels.
    ///
    /// # Errors
    /// Settings without a split or out of range, an empty map, a criterion that says nothing of a
    /// tile that small.
    pub fn new(width: u32, height: u32, plan: Plan) -> Result<Self, OpacityError> {
        let Code::Layered(layered) = &plan.settings.code else {
            return Err(OpacityError::setting("code", "other", "a search needs layered maps"));
        };
        let (layers, stored) = (layered.layers as usize, (layered.blend, layered.format));
        let criterion = plan.scoring.criterion;
        let few = plan.tile > 0 && criterion == Criterion::MutualInformation;
        if few || plan.tile == 1 && criterion == Criterion::Correlation {
            let limit = "this criterion needs more texels; use equal transmittance";
            return Err(OpacityError::setting("tile", plan.tile, limit));
        }
        if plan.repeat && plan.tile == 0 && plan.shown == Shown::Trial {
            let limit = "must be the adopted where searches never end";
            return Err(OpacityError::setting("shown", "trial", limit));
        }
        let settings = cumulative(&plan.settings);
        let maps = |tile: u32| {
            let texture = Arc::new(SplitTexture::new(width, height, tile, plan.steps)?);
            let code = SplitCode::new(&settings, Arc::clone(&texture))?;
            let maps = Maps::with_code(width, height, &settings, Box::new(code))?;
            Ok::<_, OpacityError>((texture, maps))
        };
        let (trial_split, trial) = maps(0)?;
        let (drawn_split, drawn) = if plan.tile == 0 && plan.shown == Shown::Trial {
            (Arc::clone(&trial_split), None)
        } else {
            let (texture, maps) = maps(plan.tile)?;
            (texture, Some(maps))
        };
        Ok(Self {
            layers,
            stored,
            cycle: Cycle::new(criterion, plan.steps, plan.shown),
            scorer: Scorer::new(plan.scoring),
            tiles: vec![Tile::default(); drawn_split.len()],
            trial_split,
            trial,
            drawn_split,
            drawn,
            plan,
        })
    }

    /// One frame: tries a λ while a search is on, then builds the maps to draw with.
    ///
    /// # Errors
    /// Fragments of another size than the maps.
    pub fn frame(&mut self, fragments: &Fragments) -> Result<Report, OpacityError> {
        let frame = self.cycle.frame();
        let mut report = Report { trial: None, map_sets: 0, adopted: false };
        if let Some(trial) = frame.trial {
            // A search that lacks a score could never end.
            let score = self.try_step(trial.step(), fragments).inspect_err(|_| {
                self.cycle.needs_recompute();
            })?;
            report.map_sets += 1;
            report.trial = Some((trial.lambda, score));
            report.adopted = self.cycle.scored(trial, score).is_some();
        }
        if report.adopted && self.drawn.is_some() {
            self.publish();
        }
        if report.adopted && self.plan.repeat {
            self.cycle.needs_recompute();
        }
        match &mut self.drawn {
            Some(drawn) => {
                drawn.build(fragments)?;
                report.map_sets += 1;
            }
            None if frame.trial.is_none() => {
                self.trial_split.fill(self.cycle.adopted_step());
                self.trial.build(fragments)?;
                report.map_sets += 1;
            }
            // The maps on trial are drawn, the last of a search too.
            None => {}
        }
        Ok(report)
    }

    /// Maps to draw this frame with.
    pub fn maps(&self) -> &Maps {
        self.drawn.as_ref().unwrap_or(&self.trial)
    }

    /// λ of every tile as drawn.
    pub fn texture(&self) -> &SplitTexture {
        &self.drawn_split
    }

    /// Starts anew: densities, models or the light's direction have changed.
    pub fn needs_recompute(&mut self) {
        self.cycle.needs_recompute();
    }

    /// Whether a score is still to come.
    pub fn is_searching(&self) -> bool {
        self.cycle.is_searching()
    }

    /// λ adopted last for the whole map (by the tiles' scores together, where there are tiles).
    pub fn lambda(&self) -> f32 {
        self.cycle.adopted()
    }

    fn try_step(&mut self, step: u32, fragments: &Fragments) -> Result<f64, OpacityError> {
        self.trial_split.fill(step);
        self.trial.build(fragments)?;
        let score = self.score(fragments)?;
        self.keep_best(step);
        Ok(score)
    }

    /// Scores the trial maps, and every tile of them.
    fn score(&mut self, fragments: &Fragments) -> Result<f64, OpacityError> {
        let scoring = self.plan.scoring;
        if scoring.criterion == Criterion::Oracle {
            let exact = Exact::of(fragments);
            return self.score_against(fragments, &exact);
        }
        let size = (fragments.width, fragments.height);
        let words = self.trial.code().words();
        let all = self.trial.words();
        let layers = Layers::new(size, self.layers, words, words - self.layers, all)?
            .stored_as(self.stored.0, self.stored.1);
        if self.plan.tile == 0 {
            let score = self.scorer.score(&layers)?;
            self.tiles[0].score = score;
            return Ok(score);
        }
        let texture = &self.drawn_split;
        let one = |(at, tile): (usize, &mut Tile)| {
            tile.score = criteria::score_region(&scoring, &layers, texture.region(at))?;
            Ok(())
        };
        self.tiles.par_iter_mut().with_min_len(TILES).enumerate().try_for_each(one)?;
        Ok(self.tiles.iter().map(|tile| tile.score).sum())
    }

    fn score_against(&mut self, fragments: &Fragments, exact: &Exact) -> Result<f64, OpacityError> {
        let (maps, texture) = (&self.trial, &self.drawn_split);
        if self.plan.tile == 0 {
            let score = oracle::rmse(maps, fragments, exact)?;
            self.tiles[0].score = score;
            return Ok(score);
        }
        let one = |(at, tile): (usize, &mut Tile)| {
            tile.score = oracle::squared_error(maps, fragments, exact, texture.region(at)).0;
        };
        self.tiles.par_iter_mut().with_min_len(TILES).enumerate().for_each(one);
        Ok(self.tiles.iter().map(|tile| tile.score).sum())
    }

    /// Keeps each tile's best; a cycle's first trial forgets the cycle before.
    fn keep_best(&mut self, step: u32) {
        let criterion = self.plan.scoring.criterion;
        for tile in &mut self.tiles {
            if step == 0 || is_better(criterion, tile.score, tile.best) {
                (tile.best, tile.step) = (tile.score, step);
            }
        }
    }

    fn publish(&mut self) {
        if self.plan.tile == 0 {
            self.drawn_split.fill(self.cycle.adopted_step());
        } else {
            for (at, tile) in self.tiles.iter().enumerate() {
                self.drawn_split.set(at, tile.step);
            }
        }
    }
}

/// The same maps, packed so that each holds all in front of its end: slabs of four hold their own
/// part alone, and criteria compare whole sums.
pub(crate) fn cumulative(settings: &Settings) -> Settings {
    let mut settings = settings.clone();
    if let Code::Layered(layered) = &mut settings.code
        && layered.packing == Packing::Slabs
    {
        layered.packing = Packing::Targets(1);
    }
    settings
}
