//! Device forms against the reference, bit for bit, over paths of frames.

#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use dapple_foliage::partition::cpu::Threads;
use dapple_foliage::partition::gpu::{CpuUpload, Extractor, Mapping};
use dapple_foliage::partition::{
    Cells, FULL, FactorPath, GUARD_WORDS, POISON, PartitionError, Ranges, quantise_all, reference,
    validate,
};
use dapple_gpu::testing::test_gpu;
use dapple_gpu::{Gpu, GpuError};

/// One frame of one mapping, read back and judged.
fn frame(gpu: &Gpu, extractor: &mut Extractor, cells: &Cells, q: &[u32], fresh: bool) -> Ranges {
    extractor.set_factors(gpu, q).unwrap();
    let mut frame = gpu.frame();
    extractor.record(&mut frame);
    frame.finish().unwrap();
    let ranges = if fresh { extractor.read_after_reset(gpu) } else { extractor.read(gpu) }.unwrap();
    let stats = validate(&ranges, cells, q).unwrap();
    assert!(stats.guard_words >= 2 * GUARD_WORDS);
    assert_eq!(extractor.counters().leaves_kept, stats.leaves_kept as u64);
    ranges
}

/// Every mapping over `path`, with a reset in its middle, equals the reference.
fn follow(gpu: &Gpu, cells: &Cells, path: FactorPath) {
    for mapping in Mapping::ALL {
        let mut extractor = Extractor::new(gpu, cells, mapping).unwrap();
        for i in 0..path.frames {
            let q = quantise_all(&path.factors(cells, i)).unwrap();
            let reset = i == path.frames / 2 + 1;
            if reset {
                extractor.reset(gpu).unwrap();
            }
            // Words beyond the total are unwritten in the first frame and after the reset.
            let ranges = frame(gpu, &mut extractor, cells, &q, i == 0 || reset);
            let expected = reference::extract(cells, &q).unwrap();
            let at = format!("{} frame {i} of {} cells", mapping.name(), cells.len());
            assert_eq!(ranges.offsets, expected.offsets, "{at}");
            assert!(ranges.indices == expected.indices, "{at}");
        }
    }
}

#[test]
fn mappings_equal_the_reference_over_a_path_with_a_reset() {
    let Some(gpu) = test_gpu() else { return };
    for (leaves, n) in [
        (0, 0),
        (0, 1),
        (1, 1),
        (1, 2),
        (511, 511),
        (511, 512),
        (513, 513),
        (16_107, 512),
        (70_000, 1),
    ] {
        let cells = Cells::generate(leaves as u64 + 1, leaves, n).unwrap();
        follow(gpu, &cells, FactorPath { seed: 3, frames: 12 });
    }
}

#[test]
fn cells_around_the_limit_of_16_bit_factors() {
    let Some(gpu) = test_gpu() else { return };
    let cells = Cells::with_sizes(2, &[65_535, 0, 65_536, 1, 65_537, 0]).unwrap();
    follow(gpu, &cells, FactorPath { seed: 8, frames: 6 });
}

/// Cells at the borders of tiles (2048) and of rows and lanes within them, and 49 tiles.
#[test]
fn scans_of_one_and_many_tiles() {
    let Some(gpu) = test_gpu() else { return };
    for n in [2_047, 2_048, 2_049, 4_097, 100_000] {
        let cells = Cells::generate(n as u64, 30_000, n).unwrap();
        follow(gpu, &cells, FactorPath { seed: 1, frames: 4 });
    }
}

#[test]
fn a_million_leaves() {
    let Some(gpu) = test_gpu() else { return };
    let cells = Cells::generate(6, 1_000_000, 512).unwrap();
    let path = FactorPath { seed: 2, frames: 12 };
    for mapping in Mapping::ALL {
        let mut extractor = Extractor::new(gpu, &cells, mapping).unwrap();
        for i in [0, 2] {
            let q = quantise_all(&path.factors(&cells, i)).unwrap();
            let ranges = frame(gpu, &mut extractor, &cells, &q, false);
            assert!(ranges.indices == reference::extract(&cells, &q).unwrap().indices);
        }
    }
}

/// More than 65,535 workgroups (one a cell) do not fit one dimension of a dispatch.
#[test]
fn more_cells_than_one_dimension_of_workgroups() {
    let Some(gpu) = test_gpu() else { return };
    let n = gpu.limits().max_compute_workgroups_per_dimension as usize + 3;
    let cells = Cells::generate(5, 4 * n, n).unwrap();
    let mut extractor = Extractor::new(gpu, &cells, Mapping::WorkgroupPerCell).unwrap();
    let q: Vec<u32> = (0..n as u32).map(|c| c.wrapping_mul(48_271) % (FULL + 1)).collect();
    let ranges = frame(gpu, &mut extractor, &cells, &q, true);
    assert!(
        ranges == Ranges { guard: ranges.guard.clone(), ..reference::extract(&cells, &q).unwrap() }
    );
}

#[test]
fn cpu_upload_equals_the_reference_over_a_path_with_a_reset() {
    let Some(gpu) = test_gpu() else { return };
    for (leaves, n) in [(0, 0), (1, 1), (513, 511), (50_000, 512)] {
        let cells = Cells::generate(9, leaves, n).unwrap();
        let path = FactorPath { seed: 3, frames: 12 };
        for threads in [Threads::Single, Threads::Pool] {
            let mut upload = CpuUpload::new(gpu, &cells, threads).unwrap();
            for i in 0..path.frames {
                if i == 7 {
                    upload.reset(gpu).unwrap();
                }
                let q = quantise_all(&path.factors(&cells, i)).unwrap();
                upload.extract(gpu, &cells, &q).unwrap();
                let ranges = upload.read(gpu).unwrap();
                let stats = validate(&ranges, &cells, &q).unwrap();
                assert_eq!(stats.guard_words, 4 * GUARD_WORDS);
                let expected = reference::extract(&cells, &q).unwrap();
                assert_eq!(ranges.offsets, expected.offsets);
                assert!(ranges.indices == expected.indices);
                let bytes = 24 * stats.leaves_kept as u64 + 20;
                assert_eq!(upload.counters().bytes_uploaded, bytes);
            }
        }
    }
}

/// Only factors cross to the device, 4 bytes a cell, whatever is kept.
#[test]
fn device_mappings_upload_factors_alone() {
    let Some(gpu) = test_gpu() else { return };
    let cells = Cells::generate(6, 20_000, 512).unwrap();
    for mapping in Mapping::ALL {
        let mut extractor = Extractor::new(gpu, &cells, mapping).unwrap();
        for q in [0, 9_000, FULL] {
            extractor.set_factors(gpu, &[q; 512]).unwrap();
            let counters = extractor.counters();
            assert_eq!(counters.bytes_uploaded, 2_048, "{}", mapping.name());
            let draws = if mapping == Mapping::MultiDraw { 512 } else { 1 };
            assert_eq!(counters.draws, draws);
        }
    }
}

#[test]
fn a_frame_before_any_factor_keeps_nothing() {
    let Some(gpu) = test_gpu() else { return };
    let cells = Cells::generate(6, 2_000, 50).unwrap();
    for mapping in Mapping::ALL {
        let extractor = Extractor::new(gpu, &cells, mapping).unwrap();
        // Outputs are poison before the first frame, and no result.
        assert!(extractor.read(gpu).is_err());
        let mut frame = gpu.frame();
        extractor.record(&mut frame);
        frame.finish().unwrap();
        let ranges = extractor.read_after_reset(gpu).unwrap();
        validate(&ranges, &cells, &[0; 50]).unwrap();
        assert!(ranges.indices.is_empty() && ranges.guard.iter().all(|&w| w == POISON));
    }
}

/// Bad input leaves the extractor as it was.
#[test]
fn bad_input_is_refused() {
    let Some(gpu) = test_gpu() else { return };
    let cells = Cells::generate(6, 2_000, 50).unwrap();
    let bad = Cells { starts: vec![0, 1], leaf_ids: vec![7] };
    for mapping in Mapping::ALL {
        let refused = Extractor::new(gpu, &bad, mapping).err().unwrap();
        assert!(matches!(refused, PartitionError::LeafId { position: 0, id: 7, .. }));
        let mut extractor = Extractor::new(gpu, &cells, mapping).unwrap();
        let good = vec![20_000; 50];
        let before = frame(gpu, &mut extractor, &cells, &good, false);
        assert!(matches!(
            extractor.set_factors(gpu, &[1; 49]),
            Err(PartitionError::FactorCount { found: 49, expected: 50 })
        ));
        let mut q = good.clone();
        q[31] = FULL + 1;
        assert!(matches!(
            extractor.set_factors(gpu, &q),
            Err(PartitionError::QuantisedFactor { cell: 31, value: 65_536 })
        ));
        let mut again = gpu.frame();
        extractor.record(&mut again);
        again.finish().unwrap();
        assert!(extractor.read(gpu).unwrap() == before);
    }
}

/// Index buffers that the device cannot bind are refused by the limit's name.
#[test]
fn more_leaves_than_a_binding_holds_are_refused_by_name() {
    let Some(gpu) = test_gpu() else { return };
    let limits = gpu.limits();
    let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let leaves = (bytes / 24 + 1) as usize;
    if leaves > 20_000_000 {
        // Such a crown would need gigabytes of host memory to state.
        dapple_gpu::testing::say_not_run(&format!("this device binds {bytes} bytes"));
        return;
    }
    let cells = Cells::generate(1, leaves, 512).unwrap();
    for mapping in Mapping::ALL {
        let error = Extractor::new(gpu, &cells, mapping).err().unwrap();
        assert!(
            matches!(&error, PartitionError::Gpu(GpuError::TooLarge { limit, .. })
                if limit.starts_with("max_")),
            "{error}"
        );
    }
}
