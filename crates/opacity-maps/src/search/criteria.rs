//! What maps are judged by when λ is chosen.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, section 5.2.3.
//!
//! Cumulative maps never fall from layer to layer, so the thesis's sum of absolute differences
//! telescopes to Σ (A_{K-1} - A_0): it asks for a thin first layer and for nothing else. It is kept
//! because the thesis measures it. Correlation of unclipped sums does not change when all opacities
//! are scaled: only the clipping of bytes lets it tell dense from sparse. Layers of equal opacity
//! spend as much on what is dark already as on the lit side; layers of equal steps of transmittance
//! ([`Criterion::EqualTransmittance`]) do not, and what is drawn is transmittance.

use super::{
    correlation::ByteSums,
    correlation::Sums,
    information::{self, CELLS},
    layers::{Layers, Region},
};
use crate::{Criterion, OpacityError};
use rayon::prelude::*;

/// Rows that one task looks at.
const BAND: usize = 16;

/// Pairs of maps that one task fills histograms of: their values share cache lines.
const PAIRS: usize = 8;

/// Most layers of any maps.
pub(super) const MOST: usize = 256;

/// The numbers a criterion sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Sums as they are.
    #[default]
    Float,
    /// The thesis's read-back: min(Ω, 1) in 8 bits, here as integers 0..=255.
    Bytes,
}

impl Precision {
    /// A sum as it is scored; a negative one or NaN counts as 0 in bytes.
    #[inline]
    pub fn value(self, sum: f32) -> f32 {
        match self {
            Self::Float => sum,
            // The cast clips at 0 and 255.
            Self::Bytes => f32::from((sum * 255.0 + 0.5) as u8),
        }
    }
}

/// How maps are scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scoring {
    /// By what.
    pub criterion: Criterion,
    /// As floats or as the thesis's bytes.
    pub precision: Precision,
    /// Whether texels without any opacity are left out.
    pub mask: bool,
    /// Most texels a side that are looked at, spread evenly; 0: all.
    pub side: u32,
}

impl Scoring {
    /// All texels, in floats.
    #[must_use]
    pub fn plain(criterion: Criterion) -> Self {
        Self { criterion, precision: Precision::Float, mask: false, side: 0 }
    }

    /// The thesis's: all texels, in bytes.
    #[must_use]
    pub fn thesis(criterion: Criterion) -> Self {
        Self { precision: Precision::Bytes, ..Self::plain(criterion) }
    }
}

/// Whether a score is better than the best so far. Equal ones are not: the first wins. NaN never
/// is.
pub fn is_better(criterion: Criterion, score: f64, best: f64) -> bool {
    match criterion {
        Criterion::Sad => score > best,
        _ => score < best,
    }
}

/// Scores maps; what it needs is allocated by the first call.
#[derive(Clone, Debug)]
pub struct Scorer {
    scoring: Scoring,
    bands: Vec<f64>,
    terms: Vec<f64>,
    histograms: Vec<u32>,
}

impl Scorer {
    /// A scorer that has seen nothing.
    #[must_use]
    pub fn new(scoring: Scoring) -> Self {
        Self { scoring, bands: Vec::new(), terms: Vec::new(), histograms: Vec::new() }
    }

    /// What it scores by.
    pub fn scoring(&self) -> Scoring {
        self.scoring
    }

    /// The score: the sum of [`Scorer::terms`]. 0 without neighbours (K = 1), but for equal
    /// opacity and transmittance. Sums are taken in a fixed order: the same maps give the same bits.
    ///
    /// # Errors
    /// [`Criterion::Oracle`], which needs fragments: see [`super::oracle`].
    pub fn score(&mut self, layers: &Layers) -> Result<f64, OpacityError> {
        let Scoring { criterion, precision, side, .. } = self.scoring;
        let region = Region::whole(layers, side as usize);
        let k = layers.layers();
        self.terms.clear();
        match criterion {
            Criterion::Oracle => return Err(needs_fragments()),
            Criterion::Sad | Criterion::EqualOpacity | Criterion::EqualTransmittance => {
                let scoring = self.scoring;
                self.sum_bands(region, k, |band, out| {
                    differences(&scoring, layers, band, out);
                    0.0
                });
                let terms = if criterion == Criterion::Sad { k - 1 } else { k };
                self.terms.extend_from_slice(&self.bands[..terms]);
            }
            Criterion::Correlation => {
                let mut shifts = [0.0; MOST];
                if precision == Precision::Float {
                    sampled_means(&self.scoring, layers, region, &mut shifts);
                }
                let (scoring, shifts) = (self.scoring, &shifts);
                self.sum_bands(region, 3 * k + 1, |band, out| {
                    products(&scoring, layers, band, shifts, out)
                });
                let sums = &self.bands[..=3 * k];
                self.terms.extend((0..k - 1).map(|pair| pair_correlation(precision, sums, pair)));
            }
            Criterion::MutualInformation => self.histogram(layers, region),
        }
        Ok(self.terms.iter().sum())
    }

    /// The terms of the last score: of each pair of neighbouring maps, or of each layer
    /// (equal opacity and transmittance).
    pub fn terms(&self) -> &[f64] {
        &self.terms
    }

    /// Fills each band's `length` numbers in parallel, then adds them up, band after band, in the
    /// first's place. What `fill` returns goes to a band's last number.
    fn sum_bands(
        &mut self,
        region: Region,
        length: usize,
        fill: impl Fn(Region, &mut [f64]) -> f64 + Sync,
    ) {
        let bands = region.scored_rows().div_ceil(BAND);
        self.bands.clear();
        self.bands.resize(bands * length, 0.0);
        self.bands.par_chunks_mut(length).enumerate().for_each(|(band, out)| {
            let last = fill(region.band(band, BAND), out);
            out[length - 1] += last;
        });
        let (sums, rest) = self.bands.split_at_mut(length);
        for band in rest.chunks(length) {
            for (sum, x) in sums.iter_mut().zip(band) {
                *sum += x;
            }
        }
    }

    fn histogram(&mut self, layers: &Layers, region: Region) {
        let Scoring { precision, mask, .. } = self.scoring;
        let pairs = layers.layers() - 1;
        let width = layers.size().0;
        let most = match precision {
            Precision::Bytes => 256.0,
            // The total does not depend on λ, so neither do the levels.
            Precision::Float => {
                let totals = region.texels(width).map(|t| total(layers.texel(t)));
                layers.value(precision, totals.fold(0.0, f32::max))
            }
        };
        self.histograms.clear();
        self.histograms.resize(pairs * CELLS, 0);
        self.histograms.par_chunks_mut(PAIRS * CELLS).enumerate().for_each(|(group, joint)| {
            let first = group * PAIRS;
            let used = joint.len() / CELLS;
            for texel in region.texels(width) {
                let sums = layers.texel(texel);
                if mask && total(sums) <= 0.0 {
                    continue;
                }
                let level = |sum: f32| information::level(layers.value(precision, sum), most);
                let mut before = level(sums[first]);
                for (pair, cells) in joint.chunks_exact_mut(CELLS).enumerate().take(used) {
                    let next = level(sums[first + pair + 1]);
                    cells[before * information::LEVELS + next] += 1;
                    before = next;
                }
            }
        });
        let joints = self.histograms.chunks_exact(CELLS);
        self.terms.extend(joints.map(information::mutual_information));
    }
}

/// Score of a part of the maps by sums over its texels, without tasks or allocations: a tile's.
///
/// # Errors
/// Criteria that a few texels say nothing of ([`Criterion::MutualInformation`]) or that need
/// fragments.
pub fn score_region(
    scoring: &Scoring,
    layers: &Layers,
    region: Region,
) -> Result<f64, OpacityError> {
    let k = layers.layers();
    match scoring.criterion {
        Criterion::Sad | Criterion::EqualOpacity | Criterion::EqualTransmittance => {
            Ok(texel_differences(scoring, layers, region, |_, _| {}))
        }
        Criterion::Correlation => {
            let (mut shifts, mut sums) = ([0.0; MOST], [0.0; 3 * MOST + 1]);
            if scoring.precision == Precision::Float {
                sampled_means(scoring, layers, region, &mut shifts);
            }
            let sums = &mut sums[..=3 * k];
            sums[3 * k] = products(scoring, layers, region, &shifts, sums);
            Ok((0..k - 1).map(|pair| pair_correlation(scoring.precision, sums, pair)).sum())
        }
        Criterion::MutualInformation => Err(OpacityError::setting(
            "criterion of tiles",
            "mutual information",
            "needs more texels than a tile has; use correlation or equal transmittance",
        )),
        Criterion::Oracle => Err(needs_fragments()),
    }
}

pub(super) fn needs_fragments() -> OpacityError {
    OpacityError::setting("criterion", "oracle", "maps alone do not tell the true transmittance")
}

fn total(sums: &[f32]) -> f32 {
    sums.last().copied().unwrap_or(0.0)
}

/// Adds each layer's term of every texel to `out`.
fn differences(scoring: &Scoring, layers: &Layers, region: Region, out: &mut [f64]) {
    texel_differences(scoring, layers, region, |layer, term| out[layer] += term);
}

/// Calls `each` with every layer and its term, texel after texel, and returns the sum of all:
/// |A_{k+1} - A_k| of k < K - 1, or (A_k - A_{k-1})² or (T_k - T_{k-1})² of k < K.
#[inline]
fn texel_differences(
    scoring: &Scoring,
    layers: &Layers,
    region: Region,
    mut each: impl FnMut(usize, f64),
) -> f64 {
    let Scoring { criterion, precision, mask, .. } = *scoring;
    // Light that is let through; bytes hold min(Ω, 1) in 255 parts.
    let unit = if precision == Precision::Bytes { 1.0 / 255.0 } else { 1.0 };
    let through = criterion == Criterion::EqualTransmittance;
    let mut sum = 0.0;
    for texel in region.texels(layers.size().0) {
        let sums = layers.texel(texel);
        if mask && total(sums) <= 0.0 {
            continue;
        }
        let mut before = if through { 1.0 } else { 0.0 };
        for (k, &x) in sums.iter().enumerate() {
            let x = layers.value(precision, x);
            let x = f64::from(if through { (-unit * x).exp() } else { x });
            let step = x - before;
            before = x;
            let (layer, term) = match criterion {
                Criterion::Sad if k == 0 => continue,
                Criterion::Sad => (k - 1, step.abs()),
                _ => (k, step * step),
            };
            each(layer, term);
            sum += term;
        }
    }
    sum
}

/// Adds Σd, Σd² and Σd d' of every layer to `out` (K numbers each, then one to spare), d being a
/// value less its layer's shift and d' the next layer's. Returns the number of texels.
fn products(
    scoring: &Scoring,
    layers: &Layers,
    region: Region,
    shifts: &[f64; MOST],
    out: &mut [f64],
) -> f64 {
    let k = layers.layers();
    let (x, rest) = out.split_at_mut(k);
    let (xx, rest) = rest.split_at_mut(k);
    let xy = &mut rest[..k - 1];
    let mut values = [0.0f64; MOST];
    let values = &mut values[..k];
    let mut n = 0.0;
    for texel in region.texels(layers.size().0) {
        let sums = layers.texel(texel);
        if scoring.mask && total(sums) <= 0.0 {
            continue;
        }
        n += 1.0;
        for ((d, &sum), shift) in values.iter_mut().zip(sums).zip(shifts) {
            *d = f64::from(layers.value(scoring.precision, sum)) - shift;
        }
        for ((&d, x), xx) in values.iter().zip(&mut *x).zip(&mut *xx) {
            *x += d;
            *xx += d * d;
        }
        for ((&d, &next), xy) in values.iter().zip(&values[1..]).zip(&mut *xy) {
            *xy += d * next;
        }
    }
    n
}

/// Means over a few texels: points near the true means. Equal values give exactly that value.
fn sampled_means(scoring: &Scoring, layers: &Layers, region: Region, out: &mut [f64; MOST]) {
    let width = layers.size().0;
    let texels = region.texels(width).count();
    let mut n = 0.0;
    for texel in region.texels(width).step_by(texels.div_ceil(64).max(1)) {
        let sums = layers.texel(texel);
        if scoring.mask && total(sums) <= 0.0 {
            continue;
        }
        n += 1.0;
        for (mean, &sum) in out.iter_mut().zip(sums) {
            *mean += f64::from(layers.value(scoring.precision, sum));
        }
    }
    if n > 0.0 {
        out.iter_mut().for_each(|mean| *mean /= n);
    }
}

/// C of maps `pair` and `pair + 1` from [`products`] with the number of texels at its end.
fn pair_correlation(precision: Precision, sums: &[f64], pair: usize) -> f64 {
    let k = sums.len() / 3;
    let n = sums[3 * k];
    let of = |map: usize| (sums[map], sums[k + map]);
    let ((x, xx), (y, yy), xy) = (of(pair), of(pair + 1), sums[2 * k + pair]);
    match precision {
        Precision::Float => Sums { n, x, xx, y, yy, xy }.correlation(),
        // Sums of bytes are integers far below 2^53: nothing was rounded.
        Precision::Bytes => {
            let [n, x, xx, y, yy, xy] = [n, x, xx, y, yy, xy].map(|sum| sum as u64);
            ByteSums { n, x, xx, y, yy, xy }.correlation()
        }
    }
}
