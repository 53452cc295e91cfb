//! Work done by one frame of an extraction, as exact formulas.
//!
//! The axis metric is [`Counters::bytes_per_kept_leaf`]: bytes moved through memory for each leaf
//! kept. What counts:
//!
//! - A word read or written in a buffer counts 4 bytes, once for each workgroup (on the CPU: each
//!   chunk of work) that uses it; reading it again in the same workgroup is served on chip.
//! - The reads of a binary search count in full, for each search.
//! - Six indices of a kept leaf are 24 bytes written, its id 4 bytes read.
//! - An upload of `b` bytes counts `b` in `bytes_uploaded`; in memory it is read from the source,
//!   written to staging memory, read by the device and written by the device: `2 b` read and
//!   `2 b` written.
//! - The draw itself (index fetch, vertices) is not counted: it is the same for all variants.

/// Cells that one workgroup of the prefix sum handles (`TILE` in `common/kept_counts.wgsl`).
pub(super) const TILE: u64 = 2_048;

/// Invocations a workgroup of thread per cell, thread per leaf and multi-draw.
pub(super) const LANES: u64 = 256;

/// Leaves in one chunk of parallel CPU work.
pub(super) const CHUNK_LEAVES: usize = 4_096;

/// Bytes of one indirect draw.
pub(super) const DRAW_BYTES: u64 = 20;

/// Bytes of one indirect dispatch.
pub(super) const DISPATCH_BYTES: u64 = 12;

/// Hardware-independent work of one frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Bytes read from memory.
    pub bytes_read: u64,
    /// Bytes written to memory.
    pub bytes_written: u64,
    /// Bytes that crossed from host to device.
    pub bytes_uploaded: u64,
    /// Leaves kept, over all cells.
    pub leaves_kept: u64,
    /// Compute dispatches.
    pub dispatches: u64,
    /// Draws that show the result; the entries of a multi-draw count one each.
    pub draws: u64,
}

impl Counters {
    /// Bytes read and written for each kept leaf; none where no leaf is kept.
    #[must_use]
    pub fn bytes_per_kept_leaf(&self) -> Option<f64> {
        let bytes = self.bytes_read + self.bytes_written;
        (self.leaves_kept > 0).then(|| bytes as f64 / self.leaves_kept as f64)
    }

    pub(super) fn moved(read: u64, written: u64) -> Self {
        Self { bytes_read: read, bytes_written: written, ..Self::default() }
    }

    pub(super) fn uploaded(bytes: u64) -> Self {
        Self { bytes_uploaded: bytes, ..Self::moved(2 * bytes, 2 * bytes) }
    }

    pub(super) fn dispatched(self, dispatches: u64) -> Self {
        Self { dispatches, ..self }
    }

    pub(super) fn shows(self, leaves_kept: u64, draws: u64) -> Self {
        Self { leaves_kept, draws, ..self }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            bytes_read: self.bytes_read + other.bytes_read,
            bytes_written: self.bytes_written + other.bytes_written,
            bytes_uploaded: self.bytes_uploaded + other.bytes_uploaded,
            leaves_kept: self.leaves_kept + other.leaves_kept,
            dispatches: self.dispatches + other.dispatches,
            draws: self.draws + other.draws,
        }
    }
}

/// Reads of one binary search among `cells` cells: `ceil(log2(cells))`.
pub(super) fn search_steps(cells: u64) -> u64 {
    if cells <= 1 { 0 } else { u64::from((cells - 1).ilog2()) + 1 }
}

/// Workgroups of the prefix sum; one even with no cell, to write the total.
pub(super) fn tiles(cells: u64) -> u64 {
    cells.div_ceil(TILE).max(1)
}

/// Words of `starts` that the `groups` workgroups read to know their cells' sizes: one for each
/// cell and one more for each workgroup that has a cell.
fn size_words(cells: u64, per_group: u64) -> u64 {
    cells + cells.div_ceil(per_group)
}

/// Reduce (only with more than one tile) and scan on the device.
pub(super) fn device_scan(cells: u64) -> Counters {
    let tiles = tiles(cells);
    let counts = 4 * (cells + size_words(cells, TILE));
    // Tile t adds up the sums of the t tiles before it.
    let scan = Counters::moved(
        counts + 4 * (tiles * (tiles - 1) / 2),
        4 * (cells + 1) + DRAW_BYTES + DISPATCH_BYTES,
    );
    if tiles == 1 {
        return scan.dispatched(1);
    }
    scan.plus(Counters::moved(counts, 4 * tiles)).dispatched(2)
}

/// Index generation, one thread a cell: start, offset and next offset of each cell.
pub(super) fn thread_per_cell(cells: u64, kept: u64) -> Counters {
    let offsets = size_words(cells, LANES);
    Counters::moved(4 * (cells + offsets) + 4 * kept, 24 * kept).dispatched(1)
}

/// Index generation, one workgroup a cell: start and two offsets for each.
pub(super) fn workgroup_per_cell(cells: u64, kept: u64) -> Counters {
    Counters::moved(12 * cells + 4 * kept, 24 * kept).dispatched(1)
}

/// Index generation, one thread a leaf. Each workgroup reads the total, searches the cells of its
/// first and last leaf among all, and those of its leaves among the cells between; it reads start
/// and offset of each cell that it finds leaves in, and the ids. The dispatch is indirect.
pub(super) fn thread_per_leaf(counts: &[u32]) -> Counters {
    let cells = counts.len() as u64;
    let kept: u64 = counts.iter().map(|&u| u64::from(u)).sum();
    let groups = kept.div_ceil(LANES).max(1);
    let mut read = DISPATCH_BYTES + 4 * groups + 4 * kept;
    // Walks cells and workgroups together: `offset` is where cell `c` begins.
    let (mut c, mut offset) = (0, 0);
    for first in (0..kept).step_by(LANES as usize) {
        let here = LANES.min(kept - first);
        while offset + u64::from(counts[c]) <= first {
            offset += u64::from(counts[c]);
            c += 1;
        }
        let low = c;
        let mut occupied = 1;
        while offset + u64::from(counts[c]) < first + here {
            offset += u64::from(counts[c]);
            c += 1;
            occupied += u64::from(counts[c] > 0);
        }
        let span = (c - low + 1) as u64;
        // With a single leaf its first end is its last.
        read += 4 * here.min(2) * search_steps(cells) + 4 * here * search_steps(span);
        read += 8 * occupied;
    }
    Counters::moved(read, 24 * kept).dispatched(1)
}

/// Draw arguments, one entry a cell.
pub(super) fn multi_draw(cells: u64) -> Counters {
    let counts = 4 * (cells + size_words(cells, LANES));
    Counters::moved(counts, DRAW_BYTES * cells).dispatched(1)
}

/// Offsets and indices in one loop on one CPU thread.
pub(super) fn cpu_single(cells: u64, kept: u64) -> Counters {
    Counters::moved(4 * cells + 4 * (cells + 1) + 4 * kept, 4 * (cells + 1) + 24 * kept)
}

/// Offsets in one loop, then chunks of leaves on all threads: each searches its first cell, and
/// reads start and end offset of each of the cells it walks (`visits`, over all chunks).
pub(super) fn cpu_parallel(cells: u64, kept: u64, visits: u64) -> Counters {
    let chunks = kept.div_ceil(CHUNK_LEAVES as u64);
    let scan = Counters::moved(4 * cells + 4 * (cells + 1), 4 * (cells + 1));
    let walk = 4 * search_steps(cells) * chunks + 4 * (2 * visits + chunks);
    scan.plus(Counters::moved(walk + 4 * kept, 24 * kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_steps_are_the_ceiling_of_the_logarithm() {
        let steps = [(0, 0), (1, 0), (2, 1), (3, 2), (4, 2), (5, 3), (512, 9), (513, 10)];
        for (cells, expected) in steps {
            assert_eq!(search_steps(cells), expected, "{cells} cells");
        }
    }

    /// 512 cells, 1000 leaves kept, counted by hand.
    #[test]
    fn counters_of_512_cells_by_hand() {
        // One tile: 512 factors, 513 starts; 513 offsets, 8 words of arguments.
        let scan = device_scan(512);
        assert_eq!((scan.bytes_read, scan.bytes_written, scan.dispatches), (4_100, 2_084, 1));
        // Two workgroups of 256 cells: 512 starts, 514 offsets.
        let emit = thread_per_cell(512, 1_000);
        assert_eq!((emit.bytes_read, emit.bytes_written), (4_104 + 4_000, 24_000));
        let emit = workgroup_per_cell(512, 1_000);
        assert_eq!((emit.bytes_read, emit.bytes_written), (6_144 + 4_000, 24_000));
        let draws = multi_draw(512);
        assert_eq!((draws.bytes_read, draws.bytes_written), (4 * (512 + 514), 10_240));
        let cpu = cpu_single(512, 1_000);
        assert_eq!((cpu.bytes_read, cpu.bytes_written), (4_100 + 4_000, 2_052 + 24_000));
    }

    /// Five cells with 300, 0, 0, 10 and 203 leaves kept are three workgroups: 256 leaves in cell
    /// 0; 256 from cell 0 to cell 4, 3 of 5 occupied; 1 in cell 4.
    #[test]
    fn counters_of_thread_per_leaf_by_hand() {
        let emit = thread_per_leaf(&[300, 0, 0, 10, 203]);
        let first = 4 * 2 * 3 + 8;
        let second = 4 * 2 * 3 + 4 * 256 * 3 + 3 * 8;
        let third = 4 * 3 + 8;
        let fixed = 12 + 3 * 4 + 4 * 513;
        assert_eq!(emit.bytes_read, fixed + first + second + third);
        assert_eq!((emit.bytes_written, emit.dispatches), (24 * 513, 1));
        // One workgroup runs even with nothing to do.
        assert_eq!(thread_per_leaf(&[0, 0]).bytes_read, 16);
        assert_eq!(thread_per_leaf(&[]).bytes_read, 16);
    }

    /// 5000 cells are 3 tiles: sums of 0, 1 and 2 earlier tiles are read.
    #[test]
    fn a_scan_of_several_tiles_reads_the_sums_before() {
        let scan = device_scan(5_000);
        let counts = 4 * (5_000 + 5_003);
        assert_eq!(scan.bytes_read, counts + counts + 12);
        assert_eq!(scan.bytes_written, 12 + 4 * 5_001 + 32);
        assert_eq!(scan.dispatches, 2);
        assert_eq!(device_scan(0).bytes_read, 0);
        assert_eq!(device_scan(0).bytes_written, 36);
    }

    #[test]
    fn no_leaf_has_no_ratio() {
        assert_eq!(Counters::moved(10, 10).bytes_per_kept_leaf(), None);
        assert_eq!(Counters::moved(10, 10).shows(4, 1).bytes_per_kept_leaf(), Some(5.0));
        let up = Counters::uploaded(100);
        assert_eq!((up.bytes_read, up.bytes_written, up.bytes_uploaded), (200, 200, 100));
    }
}
