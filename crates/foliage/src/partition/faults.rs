//! Deliberately wrong extractions: negative controls for [`super::validate`] and for the gates
//! built on it. A control that passes means that the gate cannot fail.

use super::ranges::leaf_indices;
use super::{Cells, FULL, GUARD_WORDS, POISON, PartitionError, Ranges, check_factors, kept};

/// A mistake to make on purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The scan is inclusive where it should be exclusive: every cell begins where it ends.
    OffByOneScan,
    /// The kept count is `floor(n q / 65535) + 1`: past the end of a cell that keeps everything.
    RoundUpPastN,
    /// The last cell has no thread; its range stays as it was.
    LostLastCell,
    /// The last leaves of a cell are kept, not the first: sets of two factors do not nest.
    Suffix,
    /// One leaf too many is written at the end of the output.
    Overrun,
}

impl Fault {
    /// All faults, with what each does.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::OffByOneScan, "off-by-one scan"),
        (Self::RoundUpPastN, "rounding up past n"),
        (Self::LostLastCell, "a lost last cell"),
        (Self::Suffix, "the last leaves kept in place of the first"),
        (Self::Overrun, "one leaf written past the end"),
    ];
}

/// Cells and factors in which every fault shows: full, half and empty factors, cells without
/// leaves, and a last cell that keeps some of its leaves.
///
/// # Errors
/// None on this input.
pub fn case() -> Result<(Cells, Vec<u32>), PartitionError> {
    let cells = Cells::with_sizes(17, &[40, 0, 7, 100, 3, 0, 31, 64])?;
    let q = vec![FULL, FULL, FULL / 2, 50_000, 0, 9, FULL, FULL / 3];
    Ok((cells, q))
}

/// The reference with one fault. Writes go to a poisoned buffer as long as all leaves and a
/// guard; where a fault would write beyond that, it does not.
///
/// # Errors
/// Cells or factors that [`super::reference::extract`] refuses.
pub fn extract(fault: Fault, cells: &Cells, factors_q: &[u32]) -> Result<Ranges, PartitionError> {
    cells.validate()?;
    check_factors(cells.len(), factors_q)?;
    let counts: Vec<u32> = cells.sizes().zip(factors_q).map(|(n, &q)| count(fault, n, q)).collect();
    let mut offsets = Vec::with_capacity(counts.len() + 1);
    let mut sum: u32 = 0;
    offsets.extend(counts.iter().map(|u| {
        let before = sum;
        sum += u;
        if fault == Fault::OffByOneScan { sum } else { before }
    }));
    offsets.push(sum);

    let leaves = cells.leaf_ids.len();
    let mut buffer = vec![POISON; 6 * leaves + GUARD_WORDS];
    let mut write = |slot: usize, id: u32| {
        if let Some(six) = buffer.get_mut(6 * slot..6 * slot + 6) {
            six.copy_from_slice(&leaf_indices(id));
        }
    };
    let threads = counts.len() - usize::from(fault == Fault::LostLastCell && !counts.is_empty());
    for c in 0..threads {
        let start = cells.starts[c] as usize;
        let skipped = match fault {
            Fault::Suffix => cells.starts[c + 1] as usize - start - counts[c] as usize,
            _ => 0,
        };
        for rank in 0..counts[c] as usize {
            // Past the last cell a device would read anything; here it is leaf 0.
            let id = cells.leaf_ids.get(start + skipped + rank).copied().unwrap_or(0);
            write(offsets[c] as usize + rank, id);
        }
    }
    if fault == Fault::Overrun {
        write(leaves, 0);
    }
    let guard = buffer.split_off(6 * leaves);
    buffer.truncate(6 * sum as usize);
    Ok(Ranges { offsets, indices: buffer, guard })
}

fn count(fault: Fault, n: u32, q: u32) -> u32 {
    match fault {
        Fault::RoundUpPastN => (u64::from(n) * u64::from(q) / u64::from(FULL)) as u32 + 1,
        _ => kept(n, q),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{reference, validate};
    use super::*;

    #[test]
    fn validate_refuses_every_fault() {
        let (cells, q) = case().unwrap();
        validate(&reference::extract(&cells, &q).unwrap(), &cells, &q).unwrap();
        for (fault, what) in Fault::ALL {
            let error = validate(&extract(fault, &cells, &q).unwrap(), &cells, &q).unwrap_err();
            use PartitionError as E;
            let expected = match fault {
                Fault::OffByOneScan => matches!(error, E::FirstOffset { found: 40 }),
                Fault::RoundUpPastN => matches!(error, E::Count { cell: 0, expected: 40, .. }),
                Fault::LostLastCell => matches!(error, E::Pattern { .. }),
                Fault::Suffix => matches!(error, E::NotInPrefix { cell: 2, .. }),
                Fault::Overrun => matches!(error, E::Guard { word: 0, .. }),
            };
            assert!(expected, "{what}: {error}");
        }
    }

    /// The faults are the reference but for the fault: with nothing to go wrong they pass.
    #[test]
    fn a_fault_that_does_not_show_passes() {
        let cells = Cells::with_sizes(2, &[5, 6]).unwrap();
        for fault in [Fault::LostLastCell, Fault::Suffix] {
            let ranges = extract(fault, &cells, &[FULL, 0]).unwrap();
            validate(&ranges, &cells, &[FULL, 0]).unwrap();
        }
        let none = Cells { starts: vec![0], leaf_ids: vec![] };
        for (fault, _) in Fault::ALL {
            extract(fault, &none, &[]).unwrap();
        }
    }
}
