//! Extraction on the device, in four mappings of work to threads, and its rival, extraction on
//! the CPU with a full upload.
//!
//! Per frame only the quantised factors cross to the device, 4 bytes a cell (the upload variant:
//! all indices). All buffers are made at construction, large enough for every leaf kept.

mod extractor;
mod stage;
mod upload;

pub use extractor::{Extractor, Mapping};
pub use upload::CpuUpload;

use bytemuck::{Pod, Zeroable};
use dapple_gpu::{Gpu, wgpu};

use super::counters::tiles;
use super::{Cells, DrawArgs, GUARD_WORDS, PartitionError};

/// Mirrors `Params` in `common/partition.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Params {
    n_cells: u32,
    n_tiles: u32,
    max_groups: u32,
    unused: u32,
}

impl Params {
    fn new(gpu: &Gpu, cells: &Cells) -> Self {
        Self {
            n_cells: cells.len() as u32,
            n_tiles: tiles(cells.len() as u64) as u32,
            max_groups: gpu.limits().max_compute_workgroups_per_dimension.max(1),
            unused: 0,
        }
    }
}

/// A poisoned output buffer of `words` and a guard after them.
struct Guarded {
    buffer: wgpu::Buffer,
    words: usize,
}

impl Guarded {
    fn new(gpu: &Gpu, label: &str, words: usize) -> Result<Self, PartitionError> {
        let bytes = 4 * (words as u64 + GUARD_WORDS as u64);
        Ok(Self { buffer: gpu.buffer(label, bytes)?, words })
    }

    /// With `data` before the guard.
    fn filled(gpu: &Gpu, label: &str, data: &[u32]) -> Result<Self, PartitionError> {
        let new = Self::new(gpu, label, data.len())?;
        gpu.queue.write_buffer(&new.buffer, 0, bytemuck::cast_slice(data));
        Ok(new)
    }

    /// The first `count` words.
    fn read(&self, gpu: &Gpu, count: usize) -> Result<Vec<u32>, PartitionError> {
        Ok(gpu.read(&self.buffer, 0, count.min(self.words))?)
    }

    /// Appends the words from `first` on, guard included, to `guard`.
    fn read_rest(
        &self,
        gpu: &Gpu,
        first: usize,
        guard: &mut Vec<u32>,
    ) -> Result<(), PartitionError> {
        let first = first.min(self.words);
        let count = self.words - first + GUARD_WORDS;
        guard.extend(gpu.read::<u32>(&self.buffer, 4 * first as u64, count)?);
        Ok(())
    }
}

/// Refuses a draw of anything but the first `total` leaves.
fn check_draw(found: DrawArgs, total: u32) -> Result<(), PartitionError> {
    let expected = DrawArgs::of_leaves(0, total);
    if found == expected {
        return Ok(());
    }
    Err(found.error(0, format!("one instance of the first {} indices", expected.index_count)))
}

#[cfg(test)]
mod tests {
    use super::super::counters::{LANES, TILE};
    use super::*;

    fn fields<const N: usize>(fields: [(&str, u32); N]) -> Vec<(String, u32)> {
        fields.map(|(name, offset)| (name.to_string(), offset)).to_vec()
    }

    #[test]
    fn structs_and_constants_are_those_of_the_shaders() {
        let scan = dapple_shaders::source("foliage/scan.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&scan, "Params").unwrap();
        assert_eq!(layout.size as usize, size_of::<Params>());
        let expected = [("n_cells", 0), ("n_tiles", 4), ("max_groups", 8), ("unused", 12)];
        assert_eq!(layout.fields, fields(expected));
        assert!(scan.contains(&format!("const TILE = {TILE}u;")));
        assert!(scan.contains(&format!("const LANES = {LANES}u;")));
        let items = TILE / LANES;
        assert!(scan.contains(&format!("const ITEMS = {items}u;")) && items * LANES == TILE);
        assert!(scan.contains("const ROW = 16u;") && LANES == 16 * 16);

        let draws = dapple_shaders::source("foliage/multi_draw.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&draws, "DrawArgs").unwrap();
        assert_eq!(layout.size as usize, size_of::<DrawArgs>());
        let expected = [
            ("index_count", 0),
            ("instance_count", 4),
            ("first_index", 8),
            ("base_vertex", 12),
            ("first_instance", 16),
        ];
        assert_eq!(layout.fields, fields(expected));
    }

    #[test]
    fn a_draw_of_another_total_is_refused() {
        check_draw(DrawArgs::of_leaves(0, 7), 7).unwrap();
        assert!(check_draw(DrawArgs::of_leaves(0, 6), 7).is_err());
        assert!(check_draw(DrawArgs::of_leaves(1, 7), 7).is_err());
    }
}
