//! The packings behind one face, and their measurement.
//!
//! The clock is the wall's for all of them: some work on the host, some on the device, and only
//! the wall sees both. The device's passes are recorded beside it.

use super::case::Crown;
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Setting, Subject},
};
use dapple_foliage::partition::{
    Cells, Counters, Ranges,
    cpu::{self, Threads},
    gpu::{CpuUpload, Extractor, Mapping},
};
use dapple_gpu::Gpu;
use std::{collections::BTreeMap, time::Instant};

/// Any packing.
pub enum Packer {
    /// On the processor.
    Cpu(cpu::Extractor),
    /// On the device.
    Gpu(Box<Extractor>),
    /// On the processor, then uploaded.
    Upload(CpuUpload),
}

/// The packing of that technique, its buffers allocated.
pub fn packer(technique: &str, gpu: Option<&Gpu>, cells: &Cells) -> Result<Packer, SuiteError> {
    let device = |mapping| Ok(Packer::Gpu(Box::new(Extractor::new(need(gpu)?, cells, mapping)?)));
    match technique {
        "thread-per-cell" => device(Mapping::ThreadPerCell),
        "workgroup-per-cell" => device(Mapping::WorkgroupPerCell),
        "thread-per-leaf" => device(Mapping::ThreadPerLeaf),
        "multi-draw" => device(Mapping::MultiDraw),
        "cpu-upload" => Ok(Packer::Upload(CpuUpload::new(need(gpu)?, cells, Threads::Single)?)),
        "cpu-thread" => Ok(Packer::Cpu(cpu::Extractor::new(cells, Threads::Single)?)),
        "cpu-threads" => Ok(Packer::Cpu(cpu::Extractor::new(cells, Threads::Pool)?)),
        other => Err(SuiteError::Internal(format!("no packing for technique `{other}`"))),
    }
}

fn need(gpu: Option<&Gpu>) -> Result<&Gpu, SuiteError> {
    gpu.ok_or_else(|| SuiteError::Internal("a gpu form was made without a device".into()))
}

impl Packer {
    /// Forgets every earlier frame.
    pub fn reset(&mut self, gpu: Option<&Gpu>) -> Result<(), SuiteError> {
        match self {
            Self::Cpu(packer) => packer.reset(),
            Self::Gpu(packer) => packer.reset(need(gpu)?)?,
            Self::Upload(packer) => packer.reset(need(gpu)?)?,
        }
        Ok(())
    }

    /// One frame at the quantised factors `q`.
    pub fn frame(
        &mut self,
        gpu: Option<&Gpu>,
        cells: &Cells,
        q: &[u32],
    ) -> Result<FrameTime, SuiteError> {
        let start = Instant::now();
        let mut passes = Vec::new();
        match self {
            Self::Cpu(packer) => {
                packer.extract(cells, q)?;
            }
            Self::Gpu(packer) => {
                let gpu = need(gpu)?;
                packer.set_factors(gpu, q)?;
                let mut frame = gpu.frame();
                packer.record(&mut frame);
                passes = frame.finish()?.passes;
            }
            Self::Upload(packer) => {
                let gpu = need(gpu)?;
                packer.extract(gpu, cells, q)?;
                // An empty frame waits for the upload.
                gpu.frame().finish()?;
            }
        }
        Ok(FrameTime { wall_ns: start.elapsed().as_nanos() as u64, gpu_ns: None, passes })
    }

    /// Runs a frame and reads its result back, guards included.
    pub fn ranges(
        &mut self,
        gpu: Option<&Gpu>,
        cells: &Cells,
        q: &[u32],
    ) -> Result<Ranges, SuiteError> {
        self.frame(gpu, cells, q)?;
        Ok(match self {
            Self::Cpu(packer) => packer.view().to_ranges(),
            Self::Gpu(packer) => packer.read(need(gpu)?)?,
            Self::Upload(packer) => packer.read(need(gpu)?)?,
        })
    }

    /// Work of the last frame.
    pub fn counters(&self) -> Counters {
        match self {
            Self::Cpu(packer) => packer.counters(),
            Self::Gpu(packer) => packer.counters(),
            Self::Upload(packer) => packer.counters(),
        }
    }

    /// Bytes of the output buffers: offsets and the indices of every leaf; the multi-draw has
    /// draw arguments in place of both.
    fn memory_bytes(&self, cells: &Cells) -> u64 {
        let (leaves, n_cells) = (cells.leaf_ids.len() as u64, cells.len() as u64);
        let copied = 24 * leaves + 4 * (n_cells + 1);
        match self {
            Self::Cpu(_) => copied,
            Self::Gpu(packer) if packer.mapping() == Mapping::MultiDraw => {
                24 * leaves + 20 * n_cells
            }
            Self::Gpu(_) => copied + 4 * leaves,
            Self::Upload(_) => 2 * copied,
        }
    }
}

/// A packing on a case.
struct Packing<'a> {
    crown: &'a Crown<'a>,
    packer: Packer,
}

/// The subject of a setting.
pub fn make<'a>(
    crown: &'a Crown<'_>,
    setting: &Setting,
) -> Result<Box<dyn Subject + 'a>, SuiteError> {
    let packer = packer(&setting.technique, crown.gpu, &crown.cells)?;
    Ok(Box::new(Packing { crown, packer }))
}

impl Subject for Packing<'_> {
    fn frames(&self) -> usize {
        self.crown.factors.len()
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        self.packer.reset(self.crown.gpu)
    }

    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError> {
        self.packer.frame(self.crown.gpu, &self.crown.cells, &self.crown.factors[index])
    }

    /// The whole path, then a reset and its first half again: what an earlier frame left behind
    /// must not show.
    fn check(&mut self) -> Result<Checked, SuiteError> {
        let mut checked = Checked::default();
        let frames = self.frames();
        let mut sum = BTreeMap::<&str, u64>::new();
        self.reset()?;
        for (i, frame) in (0..frames).chain(0..frames.div_ceil(2)).enumerate() {
            if i == frames {
                self.reset()?;
            }
            checked.violations.extend(self.crown.judge(&mut self.packer, frame)?);
            if i < frames {
                let c = self.packer.counters();
                for (name, value) in [
                    ("bytes_read", c.bytes_read),
                    ("bytes_written", c.bytes_written),
                    ("bytes_uploaded", c.bytes_uploaded),
                    ("leaves_kept", c.leaves_kept),
                    ("dispatches", c.dispatches),
                    ("draws", c.draws),
                ] {
                    *sum.entry(name).or_default() += value;
                }
            }
        }
        let bytes = (sum["bytes_read"] + sum["bytes_written"]) as f64;
        // A crown of no leaves moves bytes for none: the metric has no value, and 0 would lie.
        if sum["leaves_kept"] > 0 {
            let per_leaf = bytes / sum["leaves_kept"] as f64;
            checked.errors.insert("bytes_per_leaf".into(), per_leaf);
        }
        checked.errors.insert("wrong_frames".into(), checked.violations.len() as f64);
        checked.counters = sum.into_iter().map(|(name, n)| (name.to_string(), n)).collect();
        checked.memory_bytes = self.packer.memory_bytes(&self.crown.cells);
        Ok(checked)
    }
}
