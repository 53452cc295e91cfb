//! λ by texel: the split texture, and the code that reads and writes maps through it.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, section 7, algorithm 7.1.

use super::state::Steps;
use crate::{
    Fragment, Fragments, Layout, OpacityError, Settings,
    code::{self, TexelCode},
};
use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering::Relaxed},
};

/// λ of square tiles of texels, as steps of a search. Shared by the maps that are written and the
/// receivers that read them: whoever changes it builds the maps anew.
#[derive(Debug)]
pub struct SplitTexture {
    steps: Steps,
    tile: u32,
    width: u32,
    height: u32,
    tiles: Vec<AtomicU8>,
}

impl SplitTexture {
    /// λ = 0 in tiles of `tile` x `tile` texels (1: by texel; 0: one tile for the whole map).
    ///
    /// # Errors
    /// An empty map.
    pub fn new(width: u32, height: u32, tile: u32, steps: Steps) -> Result<Self, OpacityError> {
        if width == 0 || height == 0 {
            return Err(OpacityError::EmptyMap { width, height });
        }
        let tile = if tile == 0 { width.max(height) } else { tile };
        let count = width.div_ceil(tile) as usize * height.div_ceil(tile) as usize;
        let tiles = (0..count).map(|_| AtomicU8::new(0)).collect();
        Ok(Self { steps, tile, width, height, tiles })
    }

    /// Number of tiles.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Never: a map has a texel.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Texels of a tile's side.
    pub fn tile(&self) -> u32 {
        self.tile
    }

    /// Columns and rows of texels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The texels of a tile.
    pub fn region(&self, tile: usize) -> super::Region {
        let across = self.width.div_ceil(self.tile) as usize;
        let side = self.tile as usize;
        let span = |at: usize, end: u32| (at * side, ((at + 1) * side).min(end as usize));
        super::Region {
            columns: span(tile % across, self.width),
            rows: span(tile / across, self.height),
            step: 1,
        }
    }

    /// λ of a texel.
    pub fn lambda(&self, texel: usize) -> f32 {
        self.steps.lambda(self.step(texel))
    }

    /// λ of each texel, row-major: a picture.
    pub fn lambdas(&self) -> Vec<f32> {
        (0..self.width as usize * self.height as usize).map(|t| self.lambda(t)).collect()
    }

    /// Sets a tile's step.
    pub(super) fn set(&self, tile: usize, step: u32) {
        self.tiles[tile].store(step.min(self.steps.values() - 1) as u8, Relaxed);
    }

    /// Sets every tile's step.
    pub(super) fn fill(&self, step: u32) {
        (0..self.tiles.len()).for_each(|tile| self.set(tile, step));
    }

    /// The tile of a texel.
    pub fn tile_of(&self, texel: usize) -> usize {
        let (x, y) = (texel as u32 % self.width, texel as u32 / self.width);
        (y / self.tile * self.width.div_ceil(self.tile) + x / self.tile) as usize
    }

    fn step(&self, texel: usize) -> u32 {
        u32::from(self.tiles[self.tile_of(texel)].load(Relaxed))
    }
}

/// Bounding opacity maps whose λ is each texel's own: one code a step, the texture says which.
pub struct SplitCode {
    codes: Vec<Box<dyn TexelCode>>,
    texture: Arc<SplitTexture>,
}

impl SplitCode {
    /// The layered code of `settings` at every step of `texture`.
    ///
    /// # Errors
    /// Settings out of range, or without a split (planes, deep opacity maps, other techniques).
    pub fn new(settings: &Settings, texture: Arc<SplitTexture>) -> Result<Self, OpacityError> {
        let mut codes = Vec::new();
        for step in 0..texture.steps.values() {
            let settings = with_lambda(settings, texture.steps.lambda(step))?;
            settings.check()?;
            codes.push(code::of(&settings));
        }
        Ok(Self { codes, texture })
    }

    fn at(&self, texel: usize) -> &dyn TexelCode {
        self.codes[self.texture.step(texel) as usize].as_ref()
    }
}

/// The same settings with another λ.
///
/// # Errors
/// Settings without a split.
pub fn with_lambda(settings: &Settings, lambda: f32) -> Result<Settings, OpacityError> {
    let mut settings = settings.clone();
    if let crate::Code::Layered(layered) = &mut settings.code
        && let Layout::Bounded { split, .. } = &mut layered.layout
    {
        split.lambda = lambda;
        return Ok(settings);
    }
    Err(OpacityError::setting("lambda", lambda, "only bounding opacity maps have a split"))
}

impl TexelCode for SplitCode {
    fn words(&self) -> usize {
        self.codes[0].words()
    }

    fn prepare(&mut self, fragments: &Fragments) {
        self.codes.iter_mut().for_each(|code| code.prepare(fragments));
    }

    fn encode(
        &self,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        self.at(texel).encode(texel, fragments, opaque, scratch, words);
    }

    fn decode(&self, texel: usize, words: &[f32], depth: f32) -> f32 {
        self.at(texel).decode(texel, words, depth)
    }

    /// Sums of neighbours of another λ are averaged with the receiver's own as if they had its
    /// layers: where stored numbers are blurred, tiles show at their borders.
    fn decode_mean(&self, own: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        self.at(own.0).decode_mean(own, taps, depth)
    }

    fn bytes_per_texel(&self) -> u64 {
        self.codes[0].bytes_per_texel()
    }

    fn geometry_passes(&self) -> u64 {
        self.codes[0].geometry_passes()
    }
}
