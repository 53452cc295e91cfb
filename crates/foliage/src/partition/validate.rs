//! Judges a result without the code that made it.

use super::kept::kept_oracle;
use super::{Cells, POISON, PartitionError, RangesView, check_factors};

/// What a valid result holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stats {
    /// Cells.
    pub cells: usize,
    /// Cells without a leaf.
    pub cells_without_leaves: usize,
    /// Cells with leaves of which none is kept.
    pub cells_pruned: usize,
    /// Cells with leaves of which all are kept.
    pub cells_full: usize,
    /// Leaves in all cells.
    pub leaves: usize,
    /// Leaves kept.
    pub leaves_kept: usize,
    /// Guard words found intact; 0 where the form has no buffers to guard.
    pub guard_words: usize,
    /// Comparisons made: guard words, ranges, and each kept leaf.
    pub checked: usize,
}

/// Checks that guard words are intact, that the ranges tile `0..total` with the right count for
/// each cell, that there are six well-formed indices for each kept leaf, that each emitted leaf
/// exists and is emitted once, and that those in a cell's range are that cell's kept prefix (in
/// any order; being as many and distinct, they are all of it).
///
/// Kept counts are computed in 64 bits, not by [`super::kept`].
///
/// # Errors
/// Bad cells or factors; else the first check that fails, naming the element.
pub fn validate<'a>(
    ranges: impl Into<RangesView<'a>>,
    cells: &Cells,
    factors_q: &[u32],
) -> Result<Stats, PartitionError> {
    let ranges: RangesView<'a> = ranges.into();
    cells.validate()?;
    check_factors(cells.len(), factors_q)?;
    let mut stats = Stats {
        cells: cells.len(),
        cells_without_leaves: 0,
        cells_pruned: 0,
        cells_full: 0,
        leaves: cells.leaf_ids.len(),
        leaves_kept: 0,
        guard_words: 0,
        checked: 0,
    };
    for (word, &found) in ranges.guards.into_iter().flatten().enumerate() {
        if found != POISON {
            return Err(PartitionError::Guard { word, found });
        }
        stats.guard_words += 1;
    }
    check_ranges(&ranges, cells, factors_q, &mut stats)?;
    check_leaves(&ranges, cells)?;
    stats.checked = stats.guard_words + stats.cells + stats.leaves_kept;
    Ok(stats)
}

fn check_ranges(
    ranges: &RangesView<'_>,
    cells: &Cells,
    factors_q: &[u32],
    stats: &mut Stats,
) -> Result<(), PartitionError> {
    let (found, expected) = (ranges.offsets.len(), cells.len() + 1);
    if found != expected {
        return Err(PartitionError::OffsetCount { found, expected });
    }
    if ranges.offsets[0] != 0 {
        return Err(PartitionError::FirstOffset { found: ranges.offsets[0] });
    }
    for (cell, (n, &q)) in cells.sizes().zip(factors_q).enumerate() {
        let (start, end) = (ranges.offsets[cell], ranges.offsets[cell + 1]);
        let expected = kept_oracle(n, q);
        if end.checked_sub(start) != Some(expected) || expected > n {
            return Err(PartitionError::Count { cell, start, end, expected });
        }
        stats.leaves_kept += expected as usize;
        stats.cells_without_leaves += usize::from(n == 0);
        stats.cells_pruned += usize::from(n > 0 && expected == 0);
        stats.cells_full += usize::from(n > 0 && expected == n);
    }
    let (found, expected) = (ranges.indices.len(), 6 * stats.leaves_kept);
    if found != expected {
        return Err(PartitionError::IndexCount { found, expected });
    }
    Ok(())
}

fn check_leaves(ranges: &RangesView<'_>, cells: &Cells) -> Result<(), PartitionError> {
    let leaves = cells.leaf_ids.len();
    // Where each leaf stands in the cells' list.
    let mut position = vec![0; leaves];
    for (place, &id) in cells.leaf_ids.iter().enumerate() {
        position[id as usize] = place as u32;
    }
    let mut emitted = vec![false; leaves];
    let sixes = ranges.indices.as_chunks::<6>().0;
    for cell in 0..cells.len() {
        let (begin, end) = (ranges.offsets[cell], ranges.offsets[cell + 1]);
        let start = cells.starts[cell];
        let range = begin as usize..end as usize;
        for (slot, &found) in range.clone().zip(&sixes[range]) {
            let v = found[0];
            let pattern = [0, 1, 2, 0, 2, 3].map(|corner: u32| u64::from(v) + u64::from(corner));
            if v % 4 != 0 || found.map(u64::from) != pattern {
                return Err(PartitionError::Pattern { slot, found });
            }
            let id = v / 4;
            match emitted.get_mut(id as usize) {
                None => return Err(PartitionError::UnknownLeaf { slot, id, leaves }),
                Some(true) => return Err(PartitionError::Twice { slot, id }),
                Some(free) => *free = true,
            }
            let kept = end - begin;
            if !(start..start + kept).contains(&position[id as usize]) {
                return Err(PartitionError::NotInPrefix { cell, slot, id, kept });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{FULL, Ranges, reference};
    use super::*;

    fn case() -> (Cells, [u32; 4], Ranges) {
        let cells = Cells::with_sizes(1, &[6, 0, 4, 2]).unwrap();
        let q = [FULL / 2 + 1, FULL, FULL, 0];
        let mut ranges = reference::extract(&cells, &q).unwrap();
        ranges.guard = vec![POISON; 3];
        (cells, q, ranges)
    }

    #[test]
    fn a_right_result_is_described() {
        let (cells, q, ranges) = case();
        let expected = Stats {
            cells: 4,
            cells_without_leaves: 1,
            cells_pruned: 1,
            cells_full: 1,
            leaves: 12,
            leaves_kept: 7,
            guard_words: 3,
            checked: 3 + 4 + 7,
        };
        assert_eq!(validate(&ranges, &cells, &q).unwrap(), expected);
    }

    /// Leaves of a cell may stand in any order inside its range.
    #[test]
    fn the_order_inside_a_range_is_free() {
        let (cells, q, mut ranges) = case();
        for i in 0..6 {
            ranges.indices.swap(i, 6 + i);
        }
        validate(&ranges, &cells, &q).unwrap();
    }

    #[test]
    fn each_kind_of_damage_is_named() {
        use PartitionError as E;
        let (cells, q, good) = case();
        let after = |damage: &dyn Fn(&mut Ranges)| {
            let mut bad = good.clone();
            damage(&mut bad);
            validate(&bad, &cells, &q).unwrap_err()
        };
        assert!(matches!(after(&|r| r.guard[2] = 0), E::Guard { word: 2, found: 0 }));
        assert!(matches!(after(&|r| r.offsets.truncate(4)), E::OffsetCount { .. }));
        assert!(matches!(after(&|r| r.offsets.clear()), E::OffsetCount { found: 0, .. }));
        assert!(matches!(after(&|r| r.offsets[0] = 1), E::FirstOffset { found: 1 }));
        assert!(matches!(after(&|r| r.offsets[1] = 4), E::Count { cell: 0, .. }));
        assert!(matches!(after(&|r| r.offsets[3] = 2), E::Count { cell: 2, .. }));
        assert!(matches!(after(&|r| r.offsets[4] = 8), E::Count { cell: 3, .. }));
        assert!(matches!(after(&|r| r.indices.truncate(41)), E::IndexCount { .. }));
        assert!(matches!(after(&|r| r.indices.push(0)), E::IndexCount { .. }));
        assert!(matches!(after(&|r| r.indices[3] ^= 1), E::Pattern { slot: 0, .. }));
        assert!(matches!(after(&|r| r.indices[6] += 1), E::Pattern { slot: 1, .. }));
        assert!(matches!(after(&|r| r.indices.fill(POISON)), E::Pattern { slot: 0, .. }));
        let leaf = |r: &mut Ranges, slot: usize, id: u32| {
            for (k, corner) in [0, 1, 2, 0, 2, 3].into_iter().enumerate() {
                r.indices[6 * slot + k] = 4 * id + corner;
            }
        };
        assert!(matches!(after(&|r| leaf(r, 2, 12)), E::UnknownLeaf { id: 12, .. }));
        let first = good.indices[0] / 4;
        assert!(matches!(after(&|r| leaf(r, 2, first)), E::Twice { slot: 2, .. }));
        // A leaf of the right cell, but pruned; then one of another cell.
        let pruned = cells.leaf_ids[3];
        assert!(matches!(after(&|r| leaf(r, 2, pruned)), E::NotInPrefix { cell: 0, .. }));
        let foreign = cells.leaf_ids[11];
        assert!(matches!(after(&|r| leaf(r, 6, foreign)), E::NotInPrefix { cell: 2, .. }));
        // Two leaves exchanged between cells.
        assert!(matches!(
            after(&|r| (0..6).for_each(|i| r.indices.swap(i, 36 + i))),
            E::NotInPrefix { cell: 0, slot: 0, .. }
        ));
    }
}
