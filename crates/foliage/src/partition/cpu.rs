//! Extraction on the CPU: one thread, or all of rayon's.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, Algorithm 2 (and its
//! "same algorithm on one CPU core").
//!
//! Deviations: with several threads the output is cut into chunks of equal length, and each
//! chunk finds its first cell by binary search in the offsets; cells differ too much in size to
//! be handed out whole. Chunks are disjoint slices, so the result does not depend on threads.

use rayon::prelude::*;

use super::counters::{self, CHUNK_LEAVES};
use super::ranges::leaf_indices;
use super::{
    Cells, Counters, GUARD_WORDS, MAX_LEAVES, POISON, PartitionError, RangesView, check_factors,
    kept,
};

/// Who works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    /// The calling thread.
    Single,
    /// The rayon pool of the caller.
    Pool,
}

/// Extracts frame after frame into the same buffers.
#[derive(Debug)]
pub struct Extractor {
    threads: Threads,
    leaves: usize,
    kept: u32,
    /// Cells + 1 offsets, then guard words.
    offsets: Vec<u32>,
    /// Six indices for each leaf there is, then guard words.
    indices: Vec<u32>,
}

impl Extractor {
    /// Allocates for the worst case, every leaf kept: 24 bytes a leaf and 4 a cell.
    ///
    /// # Errors
    /// Cells that do not validate.
    pub fn new(cells: &Cells, threads: Threads) -> Result<Self, PartitionError> {
        cells.validate()?;
        let leaves = cells.leaf_ids.len();
        let mut new = Self {
            threads,
            leaves,
            kept: 0,
            offsets: vec![POISON; cells.starts.len() + GUARD_WORDS],
            indices: vec![POISON; 6 * leaves + GUARD_WORDS],
        };
        new.reset();
        Ok(new)
    }

    /// Forgets the last frame: offsets and indices are poison again, the result is empty.
    pub fn reset(&mut self) {
        self.kept = 0;
        self.offsets.fill(POISON);
        self.indices.fill(POISON);
    }

    /// Ranges and indices at the quantised factors. Allocates nothing.
    ///
    /// # Errors
    /// Cells of another shape than those of [`Extractor::new`], or whose starts do not ascend
    /// within the leaves; factors that do not fit. The ids are not checked again.
    pub fn extract(
        &mut self,
        cells: &Cells,
        factors_q: &[u32],
    ) -> Result<RangesView<'_>, PartitionError> {
        let n_cells = self.offsets.len() - GUARD_WORDS - 1;
        for (what, found, expected) in [
            ("cells", cells.starts.len().wrapping_sub(1), n_cells),
            ("leaves", cells.leaf_ids.len(), self.leaves),
        ] {
            if found != expected {
                return Err(PartitionError::Shape { what, found, expected });
            }
        }
        check_factors(n_cells, factors_q)?;
        match self.threads {
            Threads::Single => self.extract_single(cells, factors_q)?,
            Threads::Pool => self.extract_parallel(cells, factors_q)?,
        }
        Ok(self.view())
    }

    /// The last frame's result; empty before the first and after [`Extractor::reset`].
    #[must_use]
    pub fn view(&self) -> RangesView<'_> {
        let (offsets, offset_guard) = self.offsets.split_at(self.offsets.len() - GUARD_WORDS);
        let guard = &self.indices[6 * self.leaves..];
        let indices = &self.indices[..6 * self.kept as usize];
        RangesView { offsets, indices, guards: [offset_guard, guard] }
    }

    /// Work of the last frame; the result needs one draw.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let cells = (self.offsets.len() - GUARD_WORDS - 1) as u64;
        let kept = u64::from(self.kept);
        let work = match self.threads {
            Threads::Single => counters::cpu_single(cells, kept),
            Threads::Pool => counters::cpu_parallel(cells, kept, self.visits()),
        };
        work.shows(kept, 1)
    }

    /// Cells walked by the chunks of the last frame, a cell once for each chunk that meets it.
    fn visits(&self) -> u64 {
        let offsets = self.view().offsets;
        let walked = |first: usize| {
            let last = (first + CHUNK_LEAVES).min(self.kept as usize) - 1;
            cell_of(offsets, last as u32) - cell_of(offsets, first as u32) + 1
        };
        (0..self.kept as usize).step_by(CHUNK_LEAVES).map(|first| walked(first) as u64).sum()
    }

    fn extract_single(&mut self, cells: &Cells, factors_q: &[u32]) -> Result<(), PartitionError> {
        let mut out = &mut self.indices[..6 * self.leaves];
        let mut offset = 0;
        for (c, &q) in factors_q.iter().enumerate() {
            let n = size(cells, c)?;
            let count = kept(n, q) as usize;
            self.offsets[c] = offset;
            let start = cells.starts[c] as usize;
            let ids = cells.leaf_ids.get(start..start + count).ok_or_else(|| bad(cells, c))?;
            let (here, rest) = out.split_at_mut_checked(6 * count).ok_or_else(|| bad(cells, c))?;
            emit(ids, here);
            out = rest;
            offset += count as u32;
        }
        self.offsets[factors_q.len()] = offset;
        self.kept = offset;
        Ok(())
    }

    fn extract_parallel(&mut self, cells: &Cells, factors_q: &[u32]) -> Result<(), PartitionError> {
        let mut offset: u32 = 0;
        for (c, &q) in factors_q.iter().enumerate() {
            self.offsets[c] = offset;
            let count = kept(size(cells, c)?, q);
            // Both terms are at most MAX_LEAVES, so that the sum is below 2^32.
            offset += count;
            if offset as usize > self.leaves {
                return Err(bad(cells, c));
            }
        }
        self.offsets[factors_q.len()] = offset;
        let offsets = &self.offsets[..=factors_q.len()];
        self.indices[..6 * offset as usize]
            .par_chunks_mut(6 * CHUNK_LEAVES)
            .enumerate()
            .try_for_each(|(chunk, out)| copy_chunk(cells, offsets, chunk * CHUNK_LEAVES, out))?;
        self.kept = offset;
        Ok(())
    }
}

/// Writes the output leaves from `first` on that fit `out`.
fn copy_chunk(
    cells: &Cells,
    offsets: &[u32],
    first: usize,
    mut out: &mut [u32],
) -> Result<(), PartitionError> {
    let mut leaf = first as u32;
    let mut c = cell_of(offsets, leaf);
    while !out.is_empty() {
        let wanted = ((offsets[c + 1] - leaf) as usize).min(out.len() / 6);
        let start = (cells.starts[c] + (leaf - offsets[c])) as usize;
        let ids = cells.leaf_ids.get(start..start + wanted).ok_or_else(|| bad(cells, c))?;
        let (here, rest) = out.split_at_mut(6 * wanted);
        emit(ids, here);
        out = rest;
        leaf += wanted as u32;
        c += 1;
    }
    Ok(())
}

#[inline]
fn emit(ids: &[u32], out: &mut [u32]) {
    for (six, &id) in out.as_chunks_mut::<6>().0.iter_mut().zip(ids) {
        *six = leaf_indices(id);
    }
}

/// Leaves of cell `c`; the cells may have changed since they were validated.
fn size(cells: &Cells, c: usize) -> Result<u32, PartitionError> {
    let (start, end) = (cells.starts[c], cells.starts[c + 1]);
    match end.checked_sub(start) {
        Some(n) if end as usize <= cells.leaf_ids.len() && n as usize <= MAX_LEAVES => Ok(n),
        _ => Err(bad(cells, c)),
    }
}

fn bad(cells: &Cells, cell: usize) -> PartitionError {
    let (start, end) = (cells.starts[cell], cells.starts[cell + 1]);
    PartitionError::StartsOrder { cell, start, end, leaves: cells.leaf_ids.len() }
}

/// The cell whose range holds output leaf `leaf`: the last with `offsets[c] <= leaf`. Takes
/// `ceil(log2(cells))` steps whatever it finds, as the kernel does.
fn cell_of(offsets: &[u32], leaf: u32) -> usize {
    let mut first = 0;
    let mut length = offsets.len() - 1;
    while length > 1 {
        let half = length / 2;
        if offsets[first + half] <= leaf {
            first += half;
        }
        length -= half;
    }
    first
}

#[cfg(test)]
mod tests {
    use super::super::{FULL, FactorPath, quantise_all, reference, validate};
    use super::*;

    /// Sizes and cell counts at which something changes.
    const SHAPES: [(usize, usize); 15] = [
        (0, 0),
        (0, 1),
        (0, 513),
        (1, 1),
        (1, 2),
        (511, 511),
        (513, 2),
        (513, 513),
        (5_000, 512),
        (65_535, 1),
        (65_536, 1),
        (200_000, 3_000),
        (511, 512),
        (50_000, 100_000),
        (1_000_000, 512),
    ];

    #[test]
    fn the_cell_of_a_leaf_is_the_last_that_begins_at_or_before_it() {
        // Cells 0, 2, 3 and 5 are empty.
        let offsets = [0, 0, 3, 3, 3, 4, 4];
        for (leaf, cell) in [(0, 1), (2, 1), (3, 4)] {
            assert_eq!(cell_of(&offsets, leaf), cell);
            let expected = offsets[..6].partition_point(|&o| o <= leaf) - 1;
            // Trailing empty cells begin at the total, which no leaf reaches.
            assert_eq!(expected, cell);
        }
        assert_eq!(cell_of(&[0, 5], 4), 0);
    }

    #[test]
    fn both_forms_equal_the_reference_over_a_path_with_a_reset() {
        for (leaves, n) in SHAPES {
            let cells = Cells::generate(11, leaves, n).unwrap();
            let path = FactorPath { seed: 5, frames: 12 };
            for threads in [Threads::Single, Threads::Pool] {
                let mut extractor = Extractor::new(&cells, threads).unwrap();
                for frame in 0..path.frames {
                    if frame == 6 {
                        extractor.reset();
                        assert!(extractor.view().indices.is_empty());
                    }
                    let q = quantise_all(&path.factors(&cells, frame)).unwrap();
                    let expected = reference::extract(&cells, &q).unwrap();
                    let view = extractor.extract(&cells, &q).unwrap();
                    let stats = validate(view, &cells, &q).unwrap();
                    assert_eq!(stats.guard_words, 2 * GUARD_WORDS);
                    assert_eq!(view.offsets, expected.offsets, "{leaves} {n} frame {frame}");
                    assert_eq!(view.indices, expected.indices, "{leaves} {n} frame {frame}");
                    let kept = extractor.counters().leaves_kept;
                    assert_eq!(kept, stats.leaves_kept as u64);
                }
            }
        }
    }

    #[test]
    fn one_and_two_threads_agree() {
        let cells = Cells::generate(3, 100_000, 700).unwrap();
        let path = FactorPath { seed: 9, frames: 8 };
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut extractor = Extractor::new(&cells, Threads::Pool).unwrap();
                let q = quantise_all(&path.factors(&cells, 1)).unwrap();
                extractor.extract(&cells, &q).unwrap().to_ranges()
            })
        };
        assert!(!with(1).indices.is_empty());
        assert_eq!(with(1), with(2));
    }

    #[test]
    fn after_a_reset_words_beyond_the_total_stay_poison() {
        let cells = Cells::generate(3, 9_000, 100).unwrap();
        for threads in [Threads::Single, Threads::Pool] {
            let mut extractor = Extractor::new(&cells, threads).unwrap();
            extractor.extract(&cells, &[FULL; 100]).unwrap();
            extractor.reset();
            let total = extractor.extract(&cells, &[20_000; 100]).unwrap().indices.len();
            assert!(total > 0 && extractor.indices[..total].iter().all(|&w| w != POISON));
            assert!(extractor.indices[total..].iter().all(|&w| w == POISON));
        }
    }

    #[test]
    fn cells_changed_behind_the_back_are_refused_without_panic() {
        let good = Cells::with_sizes(1, &[4, 4, 4]).unwrap();
        let mut extractors =
            [Threads::Single, Threads::Pool].map(|threads| Extractor::new(&good, threads).unwrap());
        for extractor in &mut extractors {
            for starts in [
                vec![0, 9, 4, 12],
                vec![0, 4, 90, 12],
                vec![0, 12, 0, 12],
                vec![0, u32::MAX, 0, 12],
                vec![0, 0, u32::MAX, 12],
            ] {
                let bad = Cells { starts, ..good.clone() };
                let error = extractor.extract(&bad, &[FULL; 3]).unwrap_err();
                assert!(matches!(error, PartitionError::StartsOrder { .. }), "{error}");
            }
            for bad in [
                Cells { starts: vec![], leaf_ids: good.leaf_ids.clone() },
                Cells { starts: vec![0, 12], leaf_ids: good.leaf_ids.clone() },
                Cells { starts: good.starts.clone(), leaf_ids: vec![0] },
            ] {
                let error = extractor.extract(&bad, &[FULL; 3]).unwrap_err();
                assert!(matches!(error, PartitionError::Shape { .. }), "{error}");
            }
            assert!(extractor.extract(&good, &[FULL; 2]).is_err());
            assert!(extractor.extract(&good, &[FULL, FULL + 1, 0]).is_err());
            assert_eq!(extractor.extract(&good, &[FULL; 3]).unwrap().offsets, [0, 4, 8, 12]);
        }
    }

    /// 3 cells of 5000 kept leaves: chunks 0..4096, ..8192, ..12288, ..15000 meet 1, 2, 2, 1.
    #[test]
    fn parallel_counters_by_hand() {
        let cells = Cells::with_sizes(1, &[5_000; 3]).unwrap();
        let mut extractor = Extractor::new(&cells, Threads::Pool).unwrap();
        extractor.extract(&cells, &[FULL; 3]).unwrap();
        let c = extractor.counters();
        let walk = 4 * 2 * 4 + 4 * (2 * 6 + 4);
        assert_eq!(c.bytes_read, 12 + 16 + walk + 4 * 15_000);
        assert_eq!(c.bytes_written, 16 + 24 * 15_000);
        assert_eq!((c.leaves_kept, c.draws, c.dispatches, c.bytes_uploaded), (15_000, 1, 0, 0));
    }
}
