//! Partition offsets: the share of leaves kept, one column a frame, one row a cell.

use dapple_foliage::partition::{
    Cells, FactorPath, Ranges,
    cpu::{self, Threads},
    gpu::{CpuUpload, Extractor, Mapping},
    quantise_all, reference,
};
use dapple_gpu::Gpu;
use dapple_suite::{
    problem::{Form, Technique},
    problems,
};
use dapple_tests::golden::{EXACT, Picture, assert_golden, assert_like_golden};

/// The golden's name.
pub const NAME: &str = "partition-offsets";

const CELLS: u32 = 64;
const FRAMES: u32 = 24;
const LEAVES: usize = 8192;
const SEED: u64 = 1;

/// The picture of every frame's ranges.
fn picture(cells: &Cells, mut ranges: impl FnMut(u32) -> Ranges) -> Picture {
    let mut values = vec![0.0; (CELLS * FRAMES) as usize];
    for frame in 0..FRAMES {
        let offsets = ranges(frame).offsets;
        assert_eq!(offsets.len(), CELLS as usize + 1, "frame {frame}");
        for (cell, (size, o)) in cells.sizes().zip(offsets.windows(2)).enumerate() {
            let share = if size == 0 { 0.0 } else { (o[1] - o[0]) as f32 / size as f32 };
            values[cell * FRAMES as usize + frame as usize] = share;
        }
    }
    Picture::from_values(FRAMES, CELLS, &values)
}

/// The ranges of a technique, frame by frame; none where it needs an adapter and there is none.
fn technique<'a>(
    technique: &Technique,
    cells: &'a Cells,
    factors: &'a [Vec<u32>],
    gpu: Option<&'a Gpu>,
) -> Option<Box<dyn FnMut(u32) -> Ranges + 'a>> {
    let on_cpu = |threads| -> Option<Box<dyn FnMut(u32) -> Ranges + 'a>> {
        let mut extractor = cpu::Extractor::new(cells, threads).unwrap();
        Some(Box::new(move |frame| {
            extractor.extract(cells, &factors[frame as usize]).unwrap().to_ranges()
        }))
    };
    let on_gpu = |mapping| -> Option<Box<dyn FnMut(u32) -> Ranges + 'a>> {
        let gpu = gpu?;
        let mut extractor = Extractor::new(gpu, cells, mapping).unwrap();
        Some(Box::new(move |index| {
            extractor.set_factors(gpu, &factors[index as usize]).unwrap();
            let mut frame = gpu.frame();
            extractor.record(&mut frame);
            frame.finish().unwrap();
            extractor.read(gpu).unwrap()
        }))
    };
    match technique.id {
        "cpu-thread" => on_cpu(Threads::Single),
        "cpu-threads" => on_cpu(Threads::Pool),
        "cpu-upload" => {
            let gpu = gpu?;
            let mut upload = CpuUpload::new(gpu, cells, Threads::Single).unwrap();
            Some(Box::new(move |frame| {
                upload.extract(gpu, cells, &factors[frame as usize]).unwrap();
                upload.read(gpu).unwrap()
            }))
        }
        id => {
            let mapping = Mapping::ALL.into_iter().find(|m| m.name() == id);
            on_gpu(mapping.unwrap_or_else(|| panic!("technique {id} is not in this test")))
        }
    }
}

#[test]
fn every_technique_keeps_the_leaves_of_the_picture() {
    let cells = Cells::generate(SEED, LEAVES, CELLS as usize).unwrap();
    let path = FactorPath { seed: SEED, frames: FRAMES };
    let raw: Vec<Vec<f32>> = (0..FRAMES).map(|frame| path.factors(&cells, frame)).collect();
    let factors: Vec<Vec<u32>> = raw.iter().map(|f| quantise_all(f).unwrap()).collect();
    let truth = |frame: u32| reference::extract(&cells, &factors[frame as usize]).unwrap();

    // Against the factors themselves: half a leaf and half a step of the factor, rounded.
    for frame in 0..FRAMES {
        let offsets = truth(frame).offsets;
        for (cell, (size, o)) in cells.sizes().zip(offsets.windows(2)).enumerate() {
            let (size, kept) = (f64::from(size), f64::from(o[1] - o[0]));
            let wanted = size * f64::from(raw[frame as usize][cell]);
            assert!((kept - wanted).abs() <= 0.5 + size * 1e-5, "{cell} {frame}: {kept} {wanted}");
        }
        let all = [(0, LEAVES), (FRAMES / 2, 0)].into_iter().find(|(f, _)| *f == frame);
        assert!(all.is_none_or(|(_, kept)| offsets[CELLS as usize] as usize == kept));
    }
    let golden = picture(&cells, truth);
    assert_golden(NAME, &golden, EXACT);

    let gpu = dapple_gpu::testing::test_gpu();
    let techniques = problems::find("partition-offsets").unwrap().spec().techniques;
    let (mut checked, mut needing_gpu) = (0, 0);
    for t in techniques {
        let on_gpu = t.forms == [Form::Gpu];
        needing_gpu += usize::from(on_gpu);
        let Some(mut ranges) = technique(t, &cells, &factors, gpu) else {
            assert!(on_gpu && gpu.is_none());
            continue;
        };
        assert_like_golden(NAME, t.id, &picture(&cells, &mut ranges), EXACT);
        checked += 1;
    }
    assert_eq!(techniques.len(), 7);
    assert_eq!(checked, if gpu.is_some() { 7 } else { 7 - needing_gpu });
}

/// Control: one leaf more in one cell of one frame is seen.
#[test]
fn one_leaf_too_many_is_another_picture() {
    let cells = Cells::generate(SEED, LEAVES, CELLS as usize).unwrap();
    let path = FactorPath { seed: SEED, frames: FRAMES };
    let truth = |frame| {
        let factors = quantise_all(&path.factors(&cells, frame)).unwrap();
        reference::extract(&cells, &factors).unwrap()
    };
    // The last cell that is not empty, at a frame that keeps some of it.
    let cell = cells.sizes().enumerate().filter(|(_, n)| (2..250).contains(n)).last().unwrap().0;
    let wrong = |frame| {
        let mut ranges = truth(frame);
        if frame == FRAMES / 2 {
            ranges.offsets[cell + 1..].iter_mut().for_each(|o| *o += 1);
        }
        ranges
    };
    let (right, wrong) = (picture(&cells, truth), picture(&cells, wrong));
    let differing = right.codes.iter().zip(&wrong.codes).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 1);
}
