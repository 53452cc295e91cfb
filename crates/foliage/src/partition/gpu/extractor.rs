//! The device forms: prefix sum and index generation, or draw arguments alone.
//!
//! Based on: J. Gumbau Portalés, PhD thesis, Universitat Jaume I, 2011, §3.5, Algorithm 2.
//!
//! Deviations: the thesis has one mapping, a thread for each cell; the others are ours. No buffer
//! is mapped between two programming interfaces: one buffer is storage and index buffer at once.

use dapple_gpu::{Frame, Gpu, wgpu};

use super::super::counters::{self, Counters, DRAW_BYTES, LANES, TILE, tiles};
use super::super::ranges::leaf_indices;
use super::super::{Cells, DrawArgs, PartitionError, Ranges, check_factors, expand_draws, kept};
use super::stage::Stage;
use super::{Guarded, Params, check_draw};

/// How index generation is mapped to threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mapping {
    /// One thread copies the prefix of one cell (the thesis).
    ThreadPerCell,
    /// The threads of one workgroup copy the prefix of one cell.
    WorkgroupPerCell,
    /// One thread finds the leaf of one place in the output by binary search.
    ThreadPerLeaf,
    /// Nothing is copied: one indirect draw a cell over a fixed index buffer.
    MultiDraw,
}

impl Mapping {
    /// All mappings.
    pub const ALL: [Self; 4] =
        [Self::ThreadPerCell, Self::WorkgroupPerCell, Self::ThreadPerLeaf, Self::MultiDraw];

    /// Short name: `thread-per-cell` and so on.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ThreadPerCell => "thread-per-cell",
            Self::WorkgroupPerCell => "workgroup-per-cell",
            Self::ThreadPerLeaf => "thread-per-leaf",
            Self::MultiDraw => "multi-draw",
        }
    }
}

/// What a mapping writes, and the stages that write it.
enum Work {
    Copy {
        /// Only with more than one tile of cells.
        reduce: Option<Stage>,
        scan: Stage,
        emit: Stage,
        tile_sums: Guarded,
        offsets: Guarded,
        arguments: Guarded,
        indices: Guarded,
    },
    MultiDraw {
        write: Stage,
        draws: Guarded,
        /// Six indices of every leaf, in the order of the cells' list.
        indices: Guarded,
    },
}

/// Extracts on the device, frame after frame.
pub struct Extractor {
    mapping: Mapping,
    cells: usize,
    leaves: usize,
    /// Sizes of the cells, for the counters.
    sizes: Vec<u32>,
    /// Kept leaves of each cell at the factors that are set, likewise.
    counts: Vec<u32>,
    factors_q: wgpu::Buffer,
    work: Work,
}

impl Extractor {
    /// Uploads the cells and allocates for the worst case, every leaf kept. Factors are 0 until
    /// [`Extractor::set_factors`].
    ///
    /// # Errors
    /// Cells that do not validate; [`PartitionError::Gpu`] naming the limit for more leaves or
    /// cells than the device binds, or what the device says.
    pub fn new(gpu: &Gpu, cells: &Cells, mapping: Mapping) -> Result<Self, PartitionError> {
        cells.validate()?;
        let params = gpu.uniform("partition params", &Params::new(gpu, cells))?;
        let starts = gpu.upload("cell starts", &cells.starts)?;
        let factors_q = gpu.upload("factors", &vec![0_u32; cells.len()])?;
        let inputs = [&params, &starts, &factors_q];
        let work = match mapping {
            Mapping::MultiDraw => multi_draw(gpu, cells, inputs)?,
            _ => copy(gpu, cells, mapping, inputs)?,
        };
        Ok(Self {
            mapping,
            cells: cells.len(),
            leaves: cells.leaf_ids.len(),
            sizes: cells.sizes().collect(),
            counts: vec![0; cells.len()],
            factors_q,
            work,
        })
    }

    /// The mapping of this extractor.
    #[must_use]
    pub fn mapping(&self) -> Mapping {
        self.mapping
    }

    /// Uploads the quantised factors of the next frame: 4 bytes a cell, all that crosses.
    ///
    /// # Errors
    /// Factors that do not fit the cells.
    pub fn set_factors(&mut self, gpu: &Gpu, factors_q: &[u32]) -> Result<(), PartitionError> {
        check_factors(self.cells, factors_q)?;
        for ((count, &n), &q) in self.counts.iter_mut().zip(&self.sizes).zip(factors_q) {
            *count = kept(n, q);
        }
        gpu.queue.write_buffer(&self.factors_q, 0, bytemuck::cast_slice(factors_q));
        Ok(())
    }

    /// Records the passes "scan" and "emit", or "draws" for multi-draw. Output beyond the total
    /// keeps what earlier frames left there.
    pub fn record(&self, frame: &mut Frame<'_>) {
        match &self.work {
            Work::Copy { reduce, scan, emit, .. } => {
                frame.compute("scan", |pass| {
                    if let Some(reduce) = reduce {
                        reduce.record(pass);
                    }
                    scan.record(pass);
                });
                frame.compute("emit", |pass| emit.record(pass));
            }
            Work::MultiDraw { write, .. } => frame.compute("draws", |pass| write.record(pass)),
        }
    }

    /// Draws the result of the last frame with the pass's pipeline: one indirect draw, or one a
    /// cell in one call.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let format = wgpu::IndexFormat::Uint32;
        match &self.work {
            Work::Copy { arguments, indices, .. } => {
                pass.set_index_buffer(indices.buffer.slice(..), format);
                pass.draw_indexed_indirect(&arguments.buffer, 0);
            }
            Work::MultiDraw { draws, indices, .. } => {
                pass.set_index_buffer(indices.buffer.slice(..), format);
                if self.cells > 0 {
                    pass.multi_draw_indexed_indirect(&draws.buffer, 0, self.cells as u32);
                }
            }
        }
    }

    /// Poisons every output and sets all factors to 0.
    ///
    /// # Errors
    /// What the device says.
    pub fn reset(&mut self, gpu: &Gpu) -> Result<(), PartitionError> {
        match &self.work {
            Work::Copy { tile_sums, offsets, arguments, indices, .. } => {
                for output in [tile_sums, offsets, arguments, indices] {
                    gpu.poison(&output.buffer);
                }
            }
            Work::MultiDraw { draws, .. } => gpu.poison(&draws.buffer),
        }
        self.set_factors(gpu, &vec![0; self.cells])?;
        gpu.check()?;
        Ok(())
    }

    /// Reads the last frame's result back, with the guard words of all output buffers; for
    /// multi-draw, what the draws show ([`expand_draws`] over the index buffer as it is on the
    /// device). Not part of a frame.
    ///
    /// # Errors
    /// Draw arguments that do not fit the total, or what the device says.
    pub fn read(&self, gpu: &Gpu) -> Result<Ranges, PartitionError> {
        self.read_back(gpu, false)
    }

    /// As [`Extractor::read`], with every word beyond the total counted as guard: right after
    /// [`Extractor::reset`] and one frame, all of them must still be poison.
    ///
    /// # Errors
    /// As [`Extractor::read`].
    pub fn read_after_reset(&self, gpu: &Gpu) -> Result<Ranges, PartitionError> {
        self.read_back(gpu, true)
    }

    fn read_back(&self, gpu: &Gpu, fresh: bool) -> Result<Ranges, PartitionError> {
        let mut guard = Vec::new();
        match &self.work {
            Work::Copy { tile_sums, offsets, arguments, indices, .. } => {
                for output in [tile_sums, offsets, arguments] {
                    output.read_rest(gpu, output.words, &mut guard)?;
                }
                let offsets = offsets.read(gpu, self.cells + 1)?;
                let total = offsets.last().copied().unwrap_or(0);
                let words = arguments.read(gpu, 5)?;
                check_draw(bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words)), total)?;
                // A wrong total may be anything; the buffer's end is the end.
                let count = 6 * (total as usize).min(self.leaves);
                let rest = if fresh { count } else { indices.words };
                indices.read_rest(gpu, rest, &mut guard)?;
                Ok(Ranges { offsets, indices: indices.read(gpu, count)?, guard })
            }
            Work::MultiDraw { draws, indices, .. } => {
                draws.read_rest(gpu, draws.words, &mut guard)?;
                indices.read_rest(gpu, indices.words, &mut guard)?;
                let args: Vec<DrawArgs> = gpu.read(&draws.buffer, 0, self.cells)?;
                let shown = expand_draws(&args, &indices.read(gpu, 6 * self.leaves)?)?;
                Ok(Ranges { guard, ..shown })
            }
        }
    }

    /// Work of a frame at the factors that are set, upload included.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let cells = self.cells as u64;
        let kept = self.counts.iter().map(|&u| u64::from(u)).sum();
        let (work, draws) = match self.mapping {
            Mapping::ThreadPerCell => (counters::thread_per_cell(cells, kept), 1),
            Mapping::WorkgroupPerCell => (counters::workgroup_per_cell(cells, kept), 1),
            Mapping::ThreadPerLeaf => (counters::thread_per_leaf(&self.counts), 1),
            Mapping::MultiDraw => (counters::multi_draw(cells), cells),
        };
        let scan = match self.mapping {
            Mapping::MultiDraw => Counters::default(),
            _ => counters::device_scan(cells),
        };
        Counters::uploaded(4 * cells).plus(scan).plus(work).shows(kept, draws)
    }
}

/// Reduce and scan, and the emission that `mapping` names.
fn copy(
    gpu: &Gpu,
    cells: &Cells,
    mapping: Mapping,
    [params, starts, factors_q]: [&wgpu::Buffer; 3],
) -> Result<Work, PartitionError> {
    let n_cells = cells.len() as u64;
    let n_tiles = tiles(n_cells);
    let leaf_ids = gpu.upload("leaf ids", &cells.leaf_ids)?;
    let tile_sums = Guarded::new(gpu, "tile sums", n_tiles as usize)?;
    let offsets = Guarded::new(gpu, "offsets", cells.starts.len())?;
    let arguments = Guarded::new(gpu, "indirect arguments", 8)?;
    let indices = Guarded::new(gpu, "indices", 6 * cells.leaf_ids.len())?;

    let counts = [params, starts, factors_q, &tile_sums.buffer];
    let reduce = (n_tiles > 1)
        .then(|| Stage::over(gpu, "foliage/reduce.wgsl", "reduce", &counts, n_cells, TILE))
        .transpose()?;
    let [a, b, c, d] = counts;
    let all = [a, b, c, d, &offsets.buffer, &arguments.buffer];
    let scan = Stage::over(gpu, "foliage/scan.wgsl", "scan", &all, n_cells, TILE)?;
    let buffers = [params, starts, &offsets.buffer, &leaf_ids, &indices.buffer];
    let emit = match mapping {
        Mapping::ThreadPerCell => {
            let path = "foliage/thread_per_cell.wgsl";
            Stage::over(gpu, path, "emit", &buffers, n_cells, LANES)?
        }
        Mapping::WorkgroupPerCell => {
            let path = "foliage/workgroup_per_cell.wgsl";
            Stage::over(gpu, path, "emit", &buffers, n_cells, 1)?
        }
        _ => {
            let path = "foliage/thread_per_leaf.wgsl";
            Stage::indirect(gpu, path, "emit", &buffers, (&arguments.buffer, DRAW_BYTES))?
        }
    };
    Ok(Work::Copy { reduce, scan, emit, tile_sums, offsets, arguments, indices })
}

fn multi_draw(
    gpu: &Gpu,
    cells: &Cells,
    [params, starts, factors_q]: [&wgpu::Buffer; 3],
) -> Result<Work, PartitionError> {
    let n_cells = cells.len();
    let fixed: Vec<u32> = cells.leaf_ids.iter().flat_map(|&id| leaf_indices(id)).collect();
    let indices = Guarded::filled(gpu, "indices of all leaves", &fixed)?;
    let draws = Guarded::new(gpu, "draws", 5 * n_cells)?;
    let buffers = [params, starts, factors_q, &draws.buffer];
    let path = "foliage/multi_draw.wgsl";
    let write = Stage::over(gpu, path, "write_draws", &buffers, n_cells as u64, LANES)?;
    Ok(Work::MultiDraw { write, draws, indices })
}
