//! What can be wrong with cells, factors, buffers and results.

use dapple_gpu::GpuError;
use thiserror::Error;

/// Every refusal of the partition module. Indices count from 0.
#[derive(Debug, Error)]
pub enum PartitionError {
    /// `starts` has no entry; an empty crown has one, 0.
    #[error("cells: starts is empty, it needs one entry more than there are cells")]
    StartsEmpty,
    /// The first cell does not begin at leaf 0.
    #[error("cells: starts[0] is {found}, expected 0")]
    StartsFirst {
        /// The value found.
        found: u32,
    },
    /// A cell ends before it begins, or outside the leaf list.
    #[error("cells: cell {cell} runs from {start} to {end} in a list of {leaves} leaves")]
    StartsOrder {
        /// The cell.
        cell: usize,
        /// Its first leaf.
        start: u32,
        /// One past its last leaf.
        end: u32,
        /// Length of the leaf list.
        leaves: usize,
    },
    /// The last cell does not end at the last leaf.
    #[error("cells: the last cell ends at {found}, expected {leaves} (the number of leaves)")]
    StartsEnd {
        /// The value found.
        found: u32,
        /// Length of the leaf list.
        leaves: usize,
    },
    /// A leaf id is not below the number of leaves.
    #[error("cells: leaf_ids[{position}] is {id}, expected less than {leaves}")]
    LeafId {
        /// Place in the list.
        position: usize,
        /// The id found there.
        id: u32,
        /// Number of leaves.
        leaves: usize,
    },
    /// A leaf stands in the list twice.
    #[error("cells: leaf_ids[{position}] is {id}, which an earlier entry has already")]
    LeafTwice {
        /// Place in the list.
        position: usize,
        /// The id found there.
        id: u32,
    },
    /// A cell has more leaves than the 12-bit kept count can scale without overflow.
    #[error("cells: cell {cell} has {leaves} leaves, the limit is {limit}")]
    CellTooLarge {
        /// The cell.
        cell: usize,
        /// Its leaves.
        leaves: u32,
        /// The limit, [`super::MAX_CELL`].
        limit: u32,
    },
    /// More leaves than 32-bit index counts can hold.
    #[error("cells: {leaves} leaves, the limit is {limit}")]
    TooManyLeaves {
        /// Leaves asked for.
        leaves: usize,
        /// The limit, [`super::MAX_LEAVES`].
        limit: usize,
    },
    /// Leaves were to be generated with no cell to hold them.
    #[error("cells: {leaves} leaves cannot be put into 0 cells")]
    NoCells {
        /// Leaves asked for.
        leaves: usize,
    },
    /// Another number of cells or leaves than the buffers were made for.
    #[error("cells: {what} is {found}, the extractor was made for {expected}")]
    Shape {
        /// "cells" or "leaves".
        what: &'static str,
        /// Now.
        found: usize,
        /// At construction.
        expected: usize,
    },
    /// A different number of factors than cells.
    #[error("factors: {found} factors for {expected} cells")]
    FactorCount {
        /// Factors given.
        found: usize,
        /// Cells.
        expected: usize,
    },
    /// A factor is NaN or outside 0..=1.
    #[error("factors: cell {cell} has factor {value}, expected 0..=1")]
    Factor {
        /// The cell.
        cell: usize,
        /// Its factor.
        value: f32,
    },
    /// A quantised factor is above 65535.
    #[error("factors: cell {cell} has quantised factor {value}, expected 0..=65535")]
    QuantisedFactor {
        /// The cell.
        cell: usize,
        /// Its quantised factor.
        value: u32,
    },
    /// A word past the end of an output buffer was written.
    #[error("result: guard word {word} is {found:#010x}, expected 0xa5a5a5a5")]
    Guard {
        /// Which guard word.
        word: usize,
        /// What it holds.
        found: u32,
    },
    /// The offsets are not one more than the cells.
    #[error("result: {found} offsets, expected {expected} (cells + 1)")]
    OffsetCount {
        /// Offsets found.
        found: usize,
        /// Cells + 1.
        expected: usize,
    },
    /// The ranges do not begin at 0: a gap before the first cell.
    #[error("result: the first offset is {found}, expected 0")]
    FirstOffset {
        /// The offset found.
        found: u32,
    },
    /// A cell's range is not the number of leaves it keeps: a gap or an overlap.
    #[error("result: cell {cell} has the range {start}..{end}, expected {expected} leaves")]
    Count {
        /// The cell.
        cell: usize,
        /// Its offset.
        start: u32,
        /// The next cell's offset.
        end: u32,
        /// Leaves it must keep.
        expected: u32,
    },
    /// The indices are not six for each kept leaf.
    #[error("result: {found} indices, expected {expected} (6 for each kept leaf)")]
    IndexCount {
        /// Indices found.
        found: usize,
        /// Indices expected.
        expected: usize,
    },
    /// Six indices that are not the two triangles of one leaf.
    #[error("result: indices of output leaf {slot} are {found:?}, not 4 id + [0, 1, 2, 0, 2, 3]")]
    Pattern {
        /// Place among the kept leaves.
        slot: usize,
        /// The six indices.
        found: [u32; 6],
    },
    /// An emitted leaf that does not exist.
    #[error("result: output leaf {slot} is leaf {id} of {leaves}")]
    UnknownLeaf {
        /// Place among the kept leaves.
        slot: usize,
        /// The id emitted.
        id: u32,
        /// Number of leaves.
        leaves: usize,
    },
    /// A leaf emitted twice.
    #[error("result: output leaf {slot} is leaf {id}, which was emitted before")]
    Twice {
        /// Place among the kept leaves.
        slot: usize,
        /// The id emitted.
        id: u32,
    },
    /// A leaf in the range of a cell that is not in the kept prefix of that cell.
    #[error(
        "result: output leaf {slot}, in the range of cell {cell}, is leaf {id}, which is not \
         among the first {kept} leaves of that cell"
    )]
    NotInPrefix {
        /// The cell.
        cell: usize,
        /// Place among the kept leaves.
        slot: usize,
        /// The id emitted.
        id: u32,
        /// Length of the prefix.
        kept: u32,
    },
    /// Indirect draw arguments that do not fit the result.
    #[error("result: draw {draw} has arguments {found:?}, expected {expected}")]
    Draw {
        /// Which draw.
        draw: usize,
        /// `index_count, instance_count, first_index, base_vertex, first_instance`.
        found: [u32; 5],
        /// What they should be.
        expected: String,
    },
    /// The device or its driver failed, or a buffer or dispatch is beyond a limit it names.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
