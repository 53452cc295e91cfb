//! Cells: which leaves stand where, and in which order they are pruned.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, §3.3 (leaves of a cell in
//! random order, after Cook & Halstead 2005) and §3.5 (the buffer `cells`).

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{MAX_CELL, PartitionError};

/// Most leaves a crown may have: six indices of each must be countable in `u32`.
pub const MAX_LEAVES: usize = (u32::MAX / 6) as usize;

/// Leaves of a crown sorted into cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells {
    /// Cell `c` holds `leaf_ids[starts[c]..starts[c + 1]]`; cells + 1 entries, the first 0.
    pub starts: Vec<u32>,
    /// Every leaf id once, in stochastic order inside each cell.
    pub leaf_ids: Vec<u32>,
}

impl Cells {
    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Leaves in each cell, in order.
    pub fn sizes(&self) -> impl Iterator<Item = u32> + '_ {
        self.starts.windows(2).map(|w| w[1].wrapping_sub(w[0]))
    }

    /// Checks that the cells partition the leaves: starts ascend from 0 to the number of leaves,
    /// no cell is larger than [`MAX_CELL`], and the ids are a permutation.
    ///
    /// # Errors
    /// The first of these that does not hold, naming the element.
    pub fn validate(&self) -> Result<(), PartitionError> {
        let leaves = self.leaf_ids.len();
        if leaves > MAX_LEAVES {
            return Err(PartitionError::TooManyLeaves { leaves, limit: MAX_LEAVES });
        }
        let (Some(&first), Some(&last)) = (self.starts.first(), self.starts.last()) else {
            return Err(PartitionError::StartsEmpty);
        };
        if first != 0 {
            return Err(PartitionError::StartsFirst { found: first });
        }
        for (cell, w) in self.starts.windows(2).enumerate() {
            let (start, end) = (w[0], w[1]);
            if end < start || end as usize > leaves {
                return Err(PartitionError::StartsOrder { cell, start, end, leaves });
            }
            if end - start > MAX_CELL {
                return Err(PartitionError::CellTooLarge {
                    cell,
                    leaves: end - start,
                    limit: MAX_CELL,
                });
            }
        }
        if last as usize != leaves {
            return Err(PartitionError::StartsEnd { found: last, leaves });
        }
        let mut seen = vec![false; leaves];
        for (position, &id) in self.leaf_ids.iter().enumerate() {
            match seen.get_mut(id as usize) {
                None => return Err(PartitionError::LeafId { position, id, leaves }),
                Some(true) => return Err(PartitionError::LeafTwice { position, id }),
                Some(free) => *free = true,
            }
        }
        Ok(())
    }

    /// Cells with uneven numbers of leaves: about one in eight is empty, the others weigh
    /// `0.1 + Exp(1)`; leaf ids are a random permutation. The same arguments give the same cells.
    ///
    /// # Errors
    /// Leaves without a cell, more than [`MAX_LEAVES`], or a cell above [`MAX_CELL`].
    pub fn generate(seed: u64, n_leaves: usize, n_cells: usize) -> Result<Self, PartitionError> {
        if n_leaves > MAX_LEAVES {
            return Err(PartitionError::TooManyLeaves { leaves: n_leaves, limit: MAX_LEAVES });
        }
        if n_cells == 0 && n_leaves > 0 {
            return Err(PartitionError::NoCells { leaves: n_leaves });
        }
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut cumulative = Vec::with_capacity(n_cells + 1);
        cumulative.push(0.0_f64);
        let mut sum = 0.0;
        for _ in 0..n_cells {
            let empty = rng.random_range(0..8) == 0;
            let weight = 0.1 - (1.0 - rng.random::<f64>()).ln();
            sum += if empty { 0.0 } else { weight };
            cumulative.push(sum);
        }
        // All weights may be zero when there are few cells: then the last holds everything.
        let share = |w: f64| if sum > 0.0 { w / sum } else { 0.0 };
        let mut starts: Vec<u32> =
            cumulative.iter().map(|&w| (share(w) * n_leaves as f64).floor() as u32).collect();
        if let Some(last) = starts.last_mut() {
            *last = n_leaves as u32;
        }
        let mut leaf_ids: Vec<u32> = (0..n_leaves as u32).collect();
        leaf_ids.shuffle(&mut rng);
        let cells = Self { starts, leaf_ids };
        cells.validate()?;
        Ok(cells)
    }

    /// Cells of the given sizes with leaf ids in a random permutation.
    ///
    /// # Errors
    /// More than [`MAX_LEAVES`] leaves, or a cell above [`MAX_CELL`].
    pub fn with_sizes(seed: u64, sizes: &[u32]) -> Result<Self, PartitionError> {
        let leaves = sizes.iter().map(|&n| n as usize).sum();
        if leaves > MAX_LEAVES {
            return Err(PartitionError::TooManyLeaves { leaves, limit: MAX_LEAVES });
        }
        let mut starts = Vec::with_capacity(sizes.len() + 1);
        let mut end = 0;
        starts.push(end);
        for n in sizes {
            end += n;
            starts.push(end);
        }
        let mut leaf_ids: Vec<u32> = (0..end).collect();
        leaf_ids.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
        let cells = Self { starts, leaf_ids };
        cells.validate()?;
        Ok(cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(starts: &[u32], ids: &[u32]) -> Cells {
        Cells { starts: starts.to_vec(), leaf_ids: ids.to_vec() }
    }

    #[test]
    fn validate_names_what_is_wrong() {
        use PartitionError as E;
        cells(&[0], &[]).validate().unwrap();
        cells(&[0, 2, 2, 3], &[2, 0, 1]).validate().unwrap();
        let refused = |starts: &[u32], ids: &[u32]| cells(starts, ids).validate().unwrap_err();
        assert!(matches!(refused(&[], &[]), E::StartsEmpty));
        assert!(matches!(refused(&[1, 2], &[0, 1]), E::StartsFirst { found: 1 }));
        assert!(matches!(refused(&[0, 2, 1, 3], &[0, 1, 2]), E::StartsOrder { cell: 1, .. }));
        assert!(matches!(refused(&[0, 9], &[0]), E::StartsOrder { cell: 0, end: 9, .. }));
        assert!(matches!(refused(&[0, 1], &[0, 1]), E::StartsEnd { found: 1, leaves: 2 }));
        assert!(matches!(refused(&[0], &[0]), E::StartsEnd { found: 0, leaves: 1 }));
        assert!(matches!(refused(&[0, 2], &[0, 2]), E::LeafId { position: 1, id: 2, .. }));
        assert!(matches!(refused(&[0, 2], &[1, 1]), E::LeafTwice { position: 1, id: 1 }));
    }

    #[test]
    fn a_cell_above_the_limit_is_refused() {
        Cells::with_sizes(1, &[MAX_CELL]).unwrap();
        assert!(matches!(
            Cells::with_sizes(1, &[3, MAX_CELL + 1]),
            Err(PartitionError::CellTooLarge { cell: 1, leaves: 1_048_832, limit: 1_048_831 })
        ));
        assert!(matches!(
            Cells::with_sizes(1, &[u32::MAX, u32::MAX]),
            Err(PartitionError::TooManyLeaves { .. })
        ));
        assert!(matches!(
            Cells::generate(1, MAX_LEAVES + 1, 4),
            Err(PartitionError::TooManyLeaves { .. })
        ));
    }

    #[test]
    fn generated_cells_are_uneven_repeatable_and_partly_empty() {
        let a = Cells::generate(7, 16_107, 512).unwrap();
        assert_eq!(a, Cells::generate(7, 16_107, 512).unwrap());
        assert_ne!(a, Cells::generate(8, 16_107, 512).unwrap());
        assert_eq!((a.len(), a.leaf_ids.len()), (512, 16_107));
        let empty = a.sizes().filter(|&n| n == 0).count();
        assert!((30..110).contains(&empty), "{empty} of 512 empty");
        assert!(a.sizes().max().unwrap() > 3 * 16_107 / 512);
        for (leaves, n) in [(0, 0), (0, 1), (1, 1), (1, 512), (5, 3)] {
            let c = Cells::generate(3, leaves, n).unwrap();
            assert_eq!((c.len(), c.leaf_ids.len(), c.is_empty()), (n, leaves, n == 0));
        }
        assert!(matches!(Cells::generate(1, 5, 0), Err(PartitionError::NoCells { leaves: 5 })));
    }
}
