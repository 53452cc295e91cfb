//! Based on: Andrew Lauritzen and Michael McCool, "Layered variance shadow maps", Graphics
//! Interface 2008, section 4 (warps, overlap, Lloyd relaxation of the splits); Jesus Gumbau,
//! "Techniques for improving the visualization of natural scenes", 2011, section 7.1 (the same
//! layers under other estimators).
//!
//! Deviations: Lloyd relaxation runs over a 256-bin histogram of the covered texels' depths until
//! it settles or 64 rounds have passed, from equal shares of the histogram; layers keep a width
//! of at least 1/1024. A layer is chosen by `z_r` within `p..q` but its warp begins 5 % of its
//! width before `p`: at `p` itself every nearer occluder would be warped onto the receiver, and
//! each split would leak a band of light.

use super::super::{DepthMap, Splits};
use super::Real;

/// Most layers.
pub const MAX_LAYERS: usize = 8;
/// Share of a layer's width by which its warp begins early.
pub const OVERLAP: f32 = 0.05;

const BINS: usize = 256;
const ROUNDS: usize = 64;
const MIN_WIDTH: f64 = 1.0 / 1024.0;

/// One layer's place in depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layer {
    /// Receivers from here on use the layer.
    pub first: f32,
    /// Depth that the warp maps to 0; `first` less the overlap.
    pub start: f32,
    /// Depth that the warp maps to 1; the next layer's `first`.
    pub end: f32,
}

impl Layer {
    /// An occluder's depth, warped to 0..=1.
    #[inline]
    pub fn occluder<R: Real>(&self, z: R) -> R {
        self.receiver(z).at_least(R::of(0.0)).at_most(R::of(1.0))
    }

    /// A receiver's depth in the layer's units, beyond 0..=1 only in front of the first layer and
    /// behind the last.
    #[inline]
    pub fn receiver<R: Real>(&self, z: R) -> R {
        let start = R::of(f64::from(self.start));
        let end = R::of(f64::from(self.end));
        (z - start) / (end - start)
    }
}

/// The layers of a map, near to far, without gaps over 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layers {
    count: usize,
    layers: [Layer; MAX_LAYERS],
}

impl Layers {
    /// `count` (1..=8) layers. `map` is looked at for [`Splits::Lloyd`] only.
    #[must_use]
    pub fn new(splits: Splits, count: u32, map: &DepthMap) -> Self {
        let count = (count as usize).clamp(1, MAX_LAYERS);
        let mut bounds = [0.0; MAX_LAYERS + 1];
        for (i, bound) in bounds.iter_mut().enumerate().take(count + 1) {
            *bound = i as f64 / count as f64;
        }
        if splits == Splits::Lloyd {
            relax(&histogram(map), &mut bounds[..=count]);
        }
        let mut layers = [Layer::default(); MAX_LAYERS];
        for (i, layer) in layers.iter_mut().enumerate().take(count) {
            let (first, end) = (bounds[i] as f32, bounds[i + 1] as f32);
            let start = if i == 0 { 0.0 } else { (first - OVERLAP * (end - first)).max(0.0) };
            *layer = Layer { first, start, end };
        }
        Self { count, layers }
    }

    /// The layers, near to far.
    #[must_use]
    pub fn as_slice(&self) -> &[Layer] {
        &self.layers[..self.count]
    }

    /// Index of the layer for a receiver depth: the last that begins at or before it.
    #[inline]
    pub fn select<R: Real>(&self, z: R) -> usize {
        let later = &self.as_slice()[1..];
        later.iter().take_while(|layer| z >= R::of(f64::from(layer.first))).count()
    }
}

/// Depths of the covered texels (those below 1).
fn histogram(map: &DepthMap) -> [u32; BINS] {
    let mut bins = [0; BINS];
    for &z in map.depths.iter().filter(|&&z| z < 1.0) {
        // A float-to-integer cast saturates: NaN and negative depths fall into the first bin.
        bins[((z * BINS as f32) as usize).min(BINS - 1)] += 1;
    }
    bins
}

/// Moves the inner `bounds` (ascending, 0 to 1) to half way between the means of the depths on
/// either side until they settle.
fn relax(bins: &[u32; BINS], bounds: &mut [f64]) {
    let total: u64 = bins.iter().map(|&n| u64::from(n)).sum();
    let count = bounds.len() - 1;
    if total == 0 || count < 2 {
        return;
    }
    let centre = |bin: usize| (bin as f64 + 0.5) / BINS as f64;
    // Start: equal shares of the covered texels.
    let (mut below, mut next) = (0u64, 1);
    for (bin, &n) in bins.iter().enumerate() {
        below += u64::from(n);
        while next < count && below * count as u64 >= total * next as u64 {
            bounds[next] = (bin as f64 + 1.0) / BINS as f64;
            next += 1;
        }
    }
    for _ in 0..ROUNDS {
        let before: [f64; MAX_LAYERS + 1] =
            std::array::from_fn(|i| bounds.get(i).copied().unwrap_or(1.0));
        let (mut weight, mut sum) = ([0.0; MAX_LAYERS], [0.0; MAX_LAYERS]);
        for (bin, &n) in bins.iter().enumerate() {
            let layer = before[1..count].iter().take_while(|&&b| centre(bin) >= b).count();
            weight[layer] += f64::from(n);
            sum[layer] += f64::from(n) * centre(bin);
        }
        let mean = |i: usize| {
            if weight[i] > 0.0 { sum[i] / weight[i] } else { 0.5 * (before[i] + before[i + 1]) }
        };
        for (i, bound) in bounds.iter_mut().enumerate().take(count).skip(1) {
            *bound = 0.5 * (mean(i - 1) + mean(i));
        }
        if bounds.iter().zip(before).all(|(a, b)| (*a - b).abs() < 1e-12) {
            break;
        }
    }
    for i in 1..count {
        bounds[i] = bounds[i].max(bounds[i - 1] + MIN_WIDTH);
    }
    for i in (1..count).rev() {
        bounds[i] = bounds[i].min(bounds[i + 1] - MIN_WIDTH);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(depths: Vec<f32>) -> DepthMap {
        DepthMap { width: depths.len() as u32, height: 1, depths }
    }

    #[test]
    fn uniform_layers_tile_the_range() {
        let layers = Layers::new(Splits::Uniform, 4, &map(vec![0.5]));
        let firsts: Vec<f32> = layers.as_slice().iter().map(|l| l.first).collect();
        assert_eq!(firsts, [0.0, 0.25, 0.5, 0.75]);
        assert_eq!(layers.as_slice()[1].start, 0.25 - 0.05 * 0.25);
        for (z, layer) in [(-1.0, 0), (0.0, 0), (0.2499, 0), (0.25, 1), (0.9, 3), (2.0, 3)] {
            assert_eq!(layers.select(z), layer, "{z}");
        }
    }

    #[test]
    fn one_layer_does_not_warp() {
        let layer = Layers::new(Splits::Lloyd, 1, &map(vec![0.3, 0.6])).as_slice()[0];
        assert_eq!(layer, Layer { first: 0.0, start: 0.0, end: 1.0 });
        assert_eq!(layer.occluder(0.37), 0.37);
    }

    #[test]
    fn lloyd_splits_two_clusters_half_way() {
        // Bins of 0.2 and 0.6 have centres 51.5/256 and 153.5/256: half way 102.5/256.
        let layers = Layers::new(Splits::Lloyd, 2, &map(vec![0.2, 0.2, 0.2, 0.6, 1.0]));
        assert!((f64::from(layers.as_slice()[1].first) - 102.5 / 256.0).abs() < 1e-6);
    }

    #[test]
    fn lloyd_layers_ascend_on_any_map() {
        for depths in [vec![1.0; 4], vec![0.0; 4], vec![0.5; 9], vec![0.999; 3], vec![0.0, 0.999]] {
            for count in [1, 2, 4, 8] {
                let layers = Layers::new(Splits::Lloyd, count, &map(depths.clone()));
                let slice = layers.as_slice();
                assert_eq!(slice.len(), count as usize);
                assert_eq!((slice[0].first, slice[slice.len() - 1].end), (0.0, 1.0));
                for pair in slice.windows(2) {
                    assert!(pair[0].end == pair[1].first && pair[0].first < pair[1].first);
                }
            }
        }
    }
}
