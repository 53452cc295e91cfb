//! The pyramid of farthest depths over a depth buffer, and the question asked of it.
//!
//! Based on: Greene, Kass and Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.2.
//! Deviations: depth is reversed, so the farthest is the smallest; and the image may have any size.
//! Level `k` has `ceil(size / 2^k)` texels a side, so that texel (x, y) holds exactly the pixels
//! from `(x, y) 2^k` on, and no texel has more than four children. (Halving downwards, as mip maps
//! do, leaves odd columns without a parent.)

use rayon::prelude::*;

/// Texels a job of the build: below this, starting a job costs more than its work.
const TEXELS_A_JOB: usize = 1 << 14;

/// One level of a pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Index of its first texel among those of all levels.
    pub start: u32,
}

/// The levels over an image, the image itself first, one texel last; none for no pixels.
pub fn levels(width: u32, height: u32) -> Vec<Level> {
    let mut levels = Vec::new();
    if width == 0 || height == 0 {
        return levels;
    }
    let mut level = Level { width, height, start: 0 };
    loop {
        levels.push(level);
        if level.width == 1 && level.height == 1 {
            return levels;
        }
        level = Level {
            width: level.width.div_ceil(2),
            height: level.height.div_ceil(2),
            start: level.start + level.width * level.height,
        };
    }
}

/// A rectangle of pixels, both ends inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// First column and row.
    pub min: [u32; 2],
    /// Last column and row.
    pub max: [u32; 2],
}

impl Pixels {
    /// The pixels whose centres lie in `rect` (left, top, right, bottom; pixels) and in the image;
    /// `None` where there are none: nothing inside can be drawn.
    pub fn within(rect: [f32; 4], width: u32, height: u32) -> Option<Self> {
        let range = |low: f32, high: f32, size: u32| {
            let first = (low - 0.5).ceil().max(0.0);
            let last = (high - 0.5).floor().min(size as f32 - 1.0);
            (first <= last).then_some((first as u32, last as u32))
        };
        let (left, right) = range(rect[0], rect[2], width)?;
        let (top, bottom) = range(rect[1], rect[3], height)?;
        Some(Self { min: [left, top], max: [right, bottom] })
    }
}

/// The farthest depth under every texel of every level.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    levels: Vec<Level>,
    texels: Vec<f32>,
}

impl Pyramid {
    /// Replaces the pyramid by that over `depth` (reversed, rows top to bottom, `width` x `height`
    /// values, none of them NaN). Allocates only where the image has grown.
    pub fn build(&mut self, width: u32, height: u32, depth: &[f32]) {
        self.build_by(width, height, depth, |a, b| if a < b { a } else { b });
    }

    /// The build with another way to join two children.
    pub(super) fn build_by(
        &mut self,
        width: u32,
        height: u32,
        depth: &[f32],
        join: impl Fn(f32, f32) -> f32 + Copy + Send + Sync,
    ) {
        debug_assert_eq!(depth.len(), width as usize * height as usize);
        if self.levels.first().is_none_or(|l| (l.width, l.height) != (width, height)) {
            self.levels = levels(width, height);
        }
        let Some(top) = self.levels.last() else {
            self.texels.clear();
            return;
        };
        self.texels.resize(top.start as usize + 1, 0.0);
        self.texels[..depth.len()].copy_from_slice(depth);
        for pair in self.levels.windows(2) {
            let (below, above) = (pair[0], pair[1]);
            let (rest, parents) = self.texels.split_at_mut(above.start as usize);
            let children = &rest[below.start as usize..];
            let parents = &mut parents[..(above.width * above.height) as usize];
            let (from, to) = (below.width as usize, above.width as usize);
            parents
                .par_chunks_mut(to)
                .zip(children.par_chunks(2 * from))
                .with_min_len(TEXELS_A_JOB.div_ceil(to))
                .for_each(|(parents, rows)| join_rows(parents, rows, from, join));
        }
    }

    /// The farthest depth drawn in `pixels`, or a farther one: of the lowest level at which the
    /// rectangle is at most `across` (at least 1) texels wide and high, the farthest of its texels.
    /// 0 where nothing was built or the rectangle leaves the image.
    pub fn farthest(&self, pixels: Pixels, across: u32) -> f32 {
        let inside = self
            .levels
            .first()
            .is_some_and(|l| pixels.max[0] < l.width && pixels.max[1] < l.height);
        if !inside {
            return 0.0;
        }
        let k = level_of(pixels, across);
        let Some(level) = self.levels.get(k as usize) else { return 0.0 };
        let (left, right) = (pixels.min[0] >> k, pixels.max[0] >> k);
        let mut farthest = f32::INFINITY;
        for y in pixels.min[1] >> k..=pixels.max[1] >> k {
            let row = (level.start + y * level.width) as usize;
            for &texel in &self.texels[row + left as usize..=row + right as usize] {
                farthest = farthest.min(texel);
            }
        }
        farthest
    }

    /// The levels, the image first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// All texels; see [`Level::start`].
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// Bytes of all levels.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.texels[..]) as u64
    }
}

/// The lowest level at which a rectangle is at most `across` texels wide and high.
pub(crate) fn level_of(pixels: Pixels, across: u32) -> u32 {
    let wider = |k: u32| {
        (0..2).any(|axis| (pixels.max[axis] >> k) - (pixels.min[axis] >> k) >= across.max(1))
    };
    // A side of n texels spans at least n / 2 at the next level: the answer is near the logarithm.
    let side = (pixels.max[0] - pixels.min[0]).max(pixels.max[1] - pixels.min[1]).saturating_add(1);
    let mut k = (side / across.max(1)).checked_ilog2().unwrap_or(0);
    while k < 31 && wider(k) {
        k += 1;
    }
    k
}

/// One row of parents from its one or two rows of children of `width` texels.
fn join_rows(parents: &mut [f32], rows: &[f32], width: usize, join: impl Fn(f32, f32) -> f32) {
    let (upper, lower) = rows.split_at(width);
    // The last row of an odd image has no second one.
    let lower = if lower.is_empty() { upper } else { lower };
    let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2));
    for (parent, (u, l)) in parents.iter_mut().zip(pairs) {
        *parent = join(join(u[0], u[1]), join(l[0], l[1]));
    }
    let ends = (parents.last_mut(), upper.last(), lower.last());
    if let (1, (Some(parent), Some(&u), Some(&l))) = (width % 2, ends) {
        *parent = join(u, l);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};

    /// Reversed depths with much empty sky and few equal values.
    fn depths(width: u32, height: u32, seed: u64) -> Vec<f32> {
        let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
        let one = |_| if random.random_bool(0.2) { 0.0 } else { random.random_range(0.0..1.0) };
        (0..width * height).map(one).collect()
    }

    /// The farthest depth of a rectangle, by looking at all of it.
    fn brute(width: u32, depth: &[f32], p: Pixels) -> f32 {
        let rows = p.min[1]..=p.max[1];
        rows.flat_map(|y| (p.min[0]..=p.max[0]).map(move |x| depth[(y * width + x) as usize]))
            .fold(f32::INFINITY, f32::min)
    }

    /// What is wrong with a pyramid over `depth`: a texel that is not the farthest of its pixels,
    /// or a pixel that has no texel.
    fn fault(pyramid: &Pyramid, width: u32, height: u32, depth: &[f32]) -> Option<String> {
        let mut checked = 0;
        for (k, level) in pyramid.levels().iter().enumerate() {
            if (level.width << k) < width || (level.height << k) < height {
                return Some(format!("level {k} does not cover the image"));
            }
            for y in 0..level.height {
                for x in 0..level.width {
                    let min = [x << k, y << k];
                    let max =
                        [(((x + 1) << k) - 1).min(width - 1), (((y + 1) << k) - 1).min(height - 1)];
                    let expected = brute(width, depth, Pixels { min, max });
                    let found = pyramid.texels()[(level.start + y * level.width + x) as usize];
                    if found != expected {
                        return Some(format!("level {k} at {x}, {y}: {found}, not {expected}"));
                    }
                    checked += 1;
                }
            }
        }
        (checked != pyramid.texels().len()).then(|| "texels of no level".into())
    }

    /// Corners and a strip of every parity; 257 x 129 has an odd side at every level.
    const SIZES: [(u32, u32); 10] =
        [(1, 1), (2, 1), (1, 3), (2, 2), (3, 3), (5, 7), (64, 64), (33, 9), (257, 129), (129, 257)];

    #[test]
    fn a_texel_is_the_farthest_of_its_pixels_at_any_size() {
        let mut pyramid = Pyramid::default();
        for (seed, (width, height)) in (0..).zip(SIZES) {
            let depth = depths(width, height, seed);
            pyramid.build(width, height, &depth);
            assert_eq!(fault(&pyramid, width, height, &depth), None, "{width} x {height}");
        }
    }

    #[test]
    fn a_large_image_is_the_same_by_jobs() {
        let (width, height) = (1021, 517);
        let depth = depths(width, height, 5);
        let mut pyramid = Pyramid::default();
        pyramid.build(width, height, &depth);
        assert_eq!(fault(&pyramid, width, height, &depth), None);
    }

    /// Negative control: the nearest of the children, as a pyramid for standard depth would take.
    #[test]
    fn a_pyramid_of_the_nearest_is_caught() {
        let depth = depths(16, 9, 1);
        let mut pyramid = Pyramid::default();
        pyramid.build_by(16, 9, &depth, f32::max);
        assert!(fault(&pyramid, 16, 9, &depth).is_some());
        let all = Pixels { min: [0, 0], max: [15, 8] };
        assert!(pyramid.farthest(all, 2) > brute(16, &depth, all));
    }

    /// Halving downwards, as mip maps do, would lose the last pixel of an odd image.
    #[test]
    fn the_last_pixel_of_an_odd_image_reaches_the_top() {
        let mut depth = vec![1.0; 9];
        depth[8] = 0.0;
        let mut pyramid = Pyramid::default();
        pyramid.build(3, 3, &depth);
        assert_eq!(pyramid.farthest(Pixels { min: [0, 0], max: [2, 2] }, 1), 0.0);
        depth[8] = 1.0;
        assert!(fault(&pyramid, 3, 3, &depth).is_some(), "a pyramid over other depths is caught");
    }

    #[test]
    fn nothing_is_built_for_no_pixels_and_nothing_is_hidden_there() {
        let mut pyramid = Pyramid::default();
        let one = Pixels { min: [0, 0], max: [0, 0] };
        assert_eq!(pyramid.farthest(one, 2), 0.0);
        pyramid.build(0, 5, &[]);
        assert_eq!((pyramid.levels().len(), pyramid.bytes()), (0, 0));
        pyramid.build(2, 2, &[1.0; 4]);
        assert_eq!(pyramid.farthest(one, 2), 1.0);
        // Smaller than before: nothing of the old levels is left.
        pyramid.build(1, 1, &[0.25]);
        assert_eq!((pyramid.farthest(one, 2), pyramid.bytes()), (0.25, 4));
        assert_eq!(pyramid.farthest(Pixels { min: [0, 0], max: [1, 0] }, 2), 0.0);
    }

    #[test]
    fn pixels_are_those_whose_centres_are_inside() {
        let at = |rect| Pixels::within(rect, 10, 5);
        let some = |min, max| Some(Pixels { min, max });
        assert_eq!(at([0.0, 0.0, 10.0, 5.0]), some([0, 0], [9, 4]));
        assert_eq!(at([0.5, 0.5, 0.5, 0.5]), some([0, 0], [0, 0]));
        assert_eq!(at([0.6, 0.0, 1.4, 5.0]), None, "between two centres");
        assert_eq!(at([0.6, 0.0, 1.5, 0.5]), some([1, 0], [1, 0]));
        assert_eq!(at([-9.0, -9.0, -0.1, 9.0]), None, "left of the image");
        assert_eq!(at([9.6, 0.0, 99.0, 9.0]), None, "right of the last centre");
        assert_eq!(at([9.5, 4.5, 1e30, f32::INFINITY]), some([9, 4], [9, 4]));
        assert_eq!(at([f32::NEG_INFINITY, -1e30, 0.5, 0.5]), some([0, 0], [0, 0]));
        // Slits along the edges of the image.
        assert_eq!(at([9.5, 0.0, 9.6, 5.0]), some([9, 0], [9, 4]));
        assert_eq!(at([0.0, 4.4, 10.0, 4.6]), some([0, 4], [9, 4]));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Never nearer than the farthest pixel; that pixel's own depth where the rectangle's
        /// pixels are texels of the level asked.
        #[test]
        fn a_rectangle_is_answered_conservatively(
            width in 1u32..80,
            height in 1u32..60,
            across in 1u32..20,
            seed in any::<u64>(),
            ends in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0), 16),
        ) {
            let depth = depths(width, height, seed);
            let mut pyramid = Pyramid::default();
            pyramid.build(width, height, &depth);
            for (a, b, c, d) in ends {
                let pick = |t: f64, size: u32| ((t * f64::from(size)) as u32).min(size - 1);
                let (x, y) = ([pick(a, width), pick(b, width)], [pick(c, height), pick(d, height)]);
                let pixels = Pixels {
                    min: [x[0].min(x[1]), y[0].min(y[1])],
                    max: [x[0].max(x[1]), y[0].max(y[1])],
                };
                let (found, exact) =
                    (pyramid.farthest(pixels, across), brute(width, &depth, pixels));
                prop_assert!(found <= exact);
                let k = level_of(pixels, across);
                let span = |axis: usize, k: u32| (pixels.max[axis] >> k) - (pixels.min[axis] >> k);
                prop_assert!(span(0, k) < across && span(1, k) < across);
                // The lowest such level.
                prop_assert!(k == 0 || span(0, k - 1) >= across || span(1, k - 1) >= across);
                if k == 0 {
                    prop_assert_eq!(found, exact);
                }
            }
        }
    }
}
