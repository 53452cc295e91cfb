//! The oracle: one loop over the cells, written for reading.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, eq. 3.6 and Algorithm 2.
//!
//! Deviations: the text asks for "the sum of the offsets of previous cells"; what tiles the
//! output is the sum of their *counts*.

use super::ranges::leaf_indices;
use super::{Cells, PartitionError, Ranges, check_factors, kept};

/// Ranges and indices of the leaves kept at the quantised factors, one for each cell.
///
/// # Errors
/// Cells that do not validate, or factors that do not fit them.
pub fn extract(cells: &Cells, factors_q: &[u32]) -> Result<Ranges, PartitionError> {
    cells.validate()?;
    check_factors(cells.len(), factors_q)?;
    let mut out = Ranges { offsets: vec![0], ..Ranges::default() };
    let mut offset = 0;
    for (c, &q) in factors_q.iter().enumerate() {
        let leaves = &cells.leaf_ids[cells.starts[c] as usize..cells.starts[c + 1] as usize];
        let count = kept(leaves.len() as u32, q);
        for &id in &leaves[..count as usize] {
            out.indices.extend(leaf_indices(id));
        }
        offset += count;
        out.offsets.push(offset);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_cells_by_hand() {
        let cells = Cells { starts: vec![0, 2, 2, 5], leaf_ids: vec![3, 1, 4, 0, 2] };
        // Half of two is one, nothing of nothing, two thirds of three is two.
        let r = extract(&cells, &[32_768, 65_535, 43_690]).unwrap();
        assert_eq!(r.offsets, [0, 1, 1, 3]);
        assert_eq!(r.indices, [12, 13, 14, 12, 14, 15, 16, 17, 18, 16, 18, 19, 0, 1, 2, 0, 2, 3]);
        assert_eq!(extract(&cells, &[0; 3]).unwrap().offsets, [0; 4]);
        assert_eq!(extract(&cells, &[65_535; 3]).unwrap().offsets, [0, 2, 2, 5]);
    }

    #[test]
    fn no_cells_give_one_offset_and_no_index() {
        let cells = Cells { starts: vec![0], leaf_ids: vec![] };
        assert_eq!(extract(&cells, &[]).unwrap(), Ranges { offsets: vec![0], ..Ranges::default() });
    }
}
