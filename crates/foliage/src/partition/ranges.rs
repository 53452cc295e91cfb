//! The result of an extraction, owned or borrowed, and indirect draw arguments.

use bytemuck::{Pod, Zeroable};

use super::PartitionError;

/// Every byte of a poisoned buffer is 0xA5.
pub const POISON: u32 = 0xA5A5_A5A5;

/// Poisoned words after the end of each output buffer.
pub const GUARD_WORDS: usize = 64;

/// The indices of one leaf: its quad as two triangles.
#[inline]
#[must_use]
pub(super) fn leaf_indices(id: u32) -> [u32; 6] {
    let v = id.wrapping_mul(4);
    [v, v.wrapping_add(1), v.wrapping_add(2), v, v.wrapping_add(2), v.wrapping_add(3)]
}

/// What an extraction emits.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Ranges {
    /// Exclusive prefix sum of the kept counts, leaves; cells + 1 entries, the last the total.
    pub offsets: Vec<u32>,
    /// Six for each kept leaf: `4 id + [0, 1, 2, 0, 2, 3]`.
    pub indices: Vec<u32>,
    /// Words found after the end of the output buffers; all [`POISON`] when nothing overran.
    /// Empty where the form has no such buffers.
    pub guard: Vec<u32>,
}

/// A [`Ranges`] that lives in an extractor's buffers.
#[derive(Debug, Clone, Copy)]
pub struct RangesView<'a> {
    /// As [`Ranges::offsets`].
    pub offsets: &'a [u32],
    /// As [`Ranges::indices`].
    pub indices: &'a [u32],
    /// As [`Ranges::guard`], one slice for each output buffer.
    pub guards: [&'a [u32]; 2],
}

impl<'a> From<&'a Ranges> for RangesView<'a> {
    fn from(r: &'a Ranges) -> Self {
        Self { offsets: &r.offsets, indices: &r.indices, guards: [&r.guard, &[]] }
    }
}

impl RangesView<'_> {
    /// Copies the ranges out of the buffers.
    #[must_use]
    pub fn to_ranges(self) -> Ranges {
        Ranges {
            offsets: self.offsets.to_vec(),
            indices: self.indices.to_vec(),
            guard: self.guards.concat(),
        }
    }
}

/// Arguments of one indexed indirect draw, as the device reads them (20 bytes).
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct DrawArgs {
    /// Indices to draw.
    pub index_count: u32,
    /// Instances; always 1 here.
    pub instance_count: u32,
    /// First index in the index buffer.
    pub first_index: u32,
    /// Added to each index; always 0 here.
    pub base_vertex: i32,
    /// First instance; always 0 here.
    pub first_instance: u32,
}

impl DrawArgs {
    /// One instance of `leaves` leaves from leaf `first` of the index buffer.
    #[must_use]
    pub fn of_leaves(first: u32, leaves: u32) -> Self {
        Self {
            index_count: leaves.wrapping_mul(6),
            instance_count: 1,
            first_index: first.wrapping_mul(6),
            base_vertex: 0,
            first_instance: 0,
        }
    }

    pub(super) fn error(&self, draw: usize, expected: String) -> PartitionError {
        let found = [
            self.index_count,
            self.instance_count,
            self.first_index,
            self.base_vertex as u32,
            self.first_instance,
        ];
        PartitionError::Draw { draw, found, expected }
    }
}

/// What a multi-draw with one entry for each cell shows, as if it had been copied: the form in
/// which it is compared with the variants that copy.
///
/// # Errors
/// [`PartitionError::Draw`] for an entry that draws anything but one instance of whole leaves
/// inside `indices`.
pub fn expand_draws(draws: &[DrawArgs], indices: &[u32]) -> Result<Ranges, PartitionError> {
    let mut out = Ranges { offsets: vec![0], ..Ranges::default() };
    for (draw, args) in draws.iter().enumerate() {
        let plain = args.instance_count == 1 && args.base_vertex == 0 && args.first_instance == 0;
        let whole = args.index_count % 6 == 0 && args.first_index % 6 == 0;
        let first = args.first_index as usize;
        let slice = indices.get(first..first.saturating_add(args.index_count as usize));
        let (true, true, Some(slice)) = (plain, whole, slice) else {
            let expected = format!("one instance of whole leaves in {} indices", indices.len());
            return Err(args.error(draw, expected));
        };
        // Entries that overlap could add up beyond the buffer without end.
        if out.indices.len() + slice.len() > indices.len() {
            return Err(args.error(draw, format!("at most {} indices in all", indices.len())));
        }
        out.indices.extend_from_slice(slice);
        out.offsets.push((out.indices.len() / 6) as u32);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_expand_to_the_ranges_they_show() {
        let indices: Vec<u32> = [4, 2, 9].into_iter().flat_map(leaf_indices).collect();
        let draws =
            [DrawArgs::of_leaves(0, 1), DrawArgs::of_leaves(1, 0), DrawArgs::of_leaves(1, 2)];
        let r = expand_draws(&draws, &indices).unwrap();
        assert_eq!(r.offsets, [0, 1, 1, 3]);
        assert_eq!(r.indices, indices);
        assert_eq!(r.indices[..6], [16, 17, 18, 16, 18, 19]);
        assert_eq!(expand_draws(&[], &[]).unwrap().offsets, [0]);
    }

    #[test]
    fn draws_that_show_anything_else_are_refused() {
        let indices = vec![0; 12];
        let good = DrawArgs::of_leaves(0, 2);
        expand_draws(&[good], &indices).unwrap();
        for bad in [
            DrawArgs { index_count: 11, ..good },
            DrawArgs { index_count: 18, ..good },
            DrawArgs { index_count: u32::MAX - 3, ..good },
            DrawArgs { first_index: 6, ..good },
            DrawArgs { first_index: 3, index_count: 6, ..good },
            DrawArgs { instance_count: 0, ..good },
            DrawArgs { instance_count: 2, ..good },
            DrawArgs { base_vertex: -4, ..good },
            DrawArgs { first_instance: 1, ..good },
        ] {
            let e = expand_draws(&[DrawArgs::of_leaves(0, 0), bad], &indices).unwrap_err();
            assert!(matches!(e, PartitionError::Draw { draw: 1, .. }), "{bad:?}: {e}");
        }
        let e = expand_draws(&[good, good], &indices).unwrap_err();
        assert!(matches!(e, PartitionError::Draw { draw: 1, .. }));
    }
}
