//! The problem's extremes: sizes at which blocks of work, rounding and limits change, uneven cells,
//! factors at and beyond their ends, and cells that are none.
//!
//! The criterion is the same everywhere: not one frame may be wrong.

use super::{
    PartitionOffsets,
    case::Crown,
    spec::{CROWN, SPEC},
};
use crate::{
    SuiteError,
    case::Case,
    knob::Get,
    problem::Facts,
    stress::{
        Axis, Criterion, Prepare, Values,
        settings::{Usual, never, words},
    },
};
use dapple_foliage::partition::{Cells, FactorPath};
use dapple_gpu::Gpu;

/// The first frame keeps all, the second nothing, the third some.
const FRAMES: u32 = 3;

/// A path of three frames: at ten million leaves the truth of one alone takes 240 MB.
const SHORT: &[(&str, &str)] = &[("frames", "3")];

const EXACT: Criterion = Criterion { metric: "wrong_frames", times: 1.0, plus: 0.0 };

/// The extremes.
pub fn axes() -> Vec<Axis> {
    vec![leaves(), cells(), one_cell(), skew(), factors(), bad_cells()]
}

const USUAL: Usual = Usual { problem: &PartitionOffsets, parameters: SHORT, criterion: EXACT };

fn axis(
    id: &'static str,
    unit: &'static str,
    help: &'static str,
    (values, home): (Values, f64),
    must_refuse: fn(f64) -> bool,
    prepare: Prepare,
) -> Axis {
    Axis { unit, must_refuse, prepare, ..USUAL.axis(id, help, values, home) }
}

/// Other words of the same axis than the first few: bad input.
fn from(word: f64, first_bad: usize) -> bool {
    word >= first_bad as f64
}

fn leaves() -> Axis {
    let values = Values::Whole { least: 0, greatest: 10_000_000, per_decade: 1 };
    let help = "leaves of the crown, from none";
    Axis { unit: "leaves", ..USUAL.of_parameter("leaves", "leaves", help, values, 131_042.0) }
}

fn cells() -> Axis {
    let values = Values::Whole { least: 1, greatest: 100_000, per_decade: 1 };
    let help = "cells that the leaves are sorted into";
    Axis { unit: "cells", ..USUAL.of_parameter("cells", "cells", help, values, 512.0) }
}

/// Leaves of one cell: blocks of work end at 512, the 16-bit factor at 65535, and what can be
/// counted at all at 1048831.
const SIZES: &[&str] =
    &["512", "0", "1", "511", "513", "65535", "65536", "1048831", "1048832", "4294967295"];
const FIRST_SIZE_TOO_LARGE: usize = 8;

fn one_cell() -> Axis {
    axis(
        "one-cell",
        "leaves",
        "leaves of one cell among small ones, where blocks, rounding and limits change",
        (Values::Words(SIZES), 0.0),
        |value| from(value, FIRST_SIZE_TOO_LARGE),
        Box::new(|case, value, gpu| {
            let size = SIZES.get(value as usize).and_then(|size| size.parse::<u32>().ok());
            let size = size.ok_or_else(|| not_on("one-cell", value))?;
            crown(case, Cells::with_sizes(case.seed, &[3, size, 5])?, gpu, |_| None)
        }),
    )
}

fn skew() -> Axis {
    let values = Values::Linear { least: 0.0, greatest: 1.0, steps: 8 };
    axis(
        "skew",
        "",
        "share of the leaves that stand in one cell in the middle, the others even",
        (values, 0.0),
        never,
        Box::new(|case, value, gpu| {
            let (leaves, n) = (case.parameters.int("leaves")?, case.parameters.int("cells")?);
            let even = (leaves as f64 * (1.0 - value) / n as f64).floor() as i64;
            let mut sizes = vec![even as u32; n as usize];
            // Whatever the rounding leaves over is in the middle too.
            sizes[n as usize / 2] += (leaves - even * n) as u32;
            crown(case, Cells::with_sizes(case.seed, &sizes)?, gpu, |_| None)
        }),
    )
}

/// What one cell's factor, or every cell's, becomes in the last frame.
const FACTORS: &[(&str, f32)] = &[
    ("path", 0.5),
    ("zero", 0.0),
    ("minus-zero", -0.0),
    ("least", f32::from_bits(1)),
    ("below-one", 1.0 - f32::EPSILON / 2.0),
    ("one", 1.0),
    ("above-one", 1.0 + f32::EPSILON),
    ("negative", -1e-6),
    ("nan", f32::NAN),
    ("infinite", f32::INFINITY),
];
const FACTOR_WORDS: [&str; FACTORS.len()] = words(FACTORS);
const FIRST_BAD_FACTOR: usize = 6;

fn factors() -> Axis {
    axis(
        "factors",
        "",
        "the keep factor of every second cell, at the ends of 0..=1 and beyond",
        (Values::Words(&FACTOR_WORDS), 0.0),
        |value| from(value, FIRST_BAD_FACTOR),
        Box::new(|case, value, gpu| {
            let position = value as usize;
            let (_, factor) = FACTORS.get(position).ok_or_else(|| not_on("factors", value))?;
            let n_cells = case.parameters.int("cells")? as usize;
            let leaves = case.parameters.int("leaves")? as usize;
            let cells = Cells::generate(case.seed, leaves, n_cells)?;
            let factor = (position > 0).then_some(*factor);
            crown(case, cells, gpu, move |cell| factor.filter(|_| cell % 2 == 1))
        }),
    )
}

const CELLS: &[&str] = &[
    "good",
    "no-starts",
    "first-not-zero",
    "descending",
    "beyond-leaves",
    "short",
    "unknown-leaf",
    "leaf-twice",
];

fn bad_cells() -> Axis {
    axis(
        "bad-cells",
        "",
        "cells that are no partition of the leaves",
        (Values::Words(CELLS), 0.0),
        |value| from(value, 1),
        Box::new(|case, value, gpu| {
            let mut cells = Cells { starts: vec![0, 2, 2, 5], leaf_ids: vec![3, 1, 4, 0, 2] };
            match CELLS.get(value as usize).copied() {
                Some("good") => {}
                Some("no-starts") => cells.starts.clear(),
                Some("first-not-zero") => cells.starts[0] = 1,
                Some("descending") => cells.starts[1] = 3,
                Some("beyond-leaves") => cells.starts[3] = 6,
                Some("short") => cells.starts[3] = 4,
                Some("unknown-leaf") => cells.leaf_ids[2] = u32::MAX,
                Some("leaf-twice") => cells.leaf_ids[2] = 3,
                _ => return Err(not_on("bad-cells", value)),
            }
            crown(case, cells, gpu, |_| None)
        }),
    )
}

/// A crown of these cells on the short path; in its last frame a cell's factor may be another.
fn crown<'g>(
    case: &Case,
    cells: Cells,
    gpu: Option<&'g Gpu>,
    factor: impl Fn(usize) -> Option<f32>,
) -> Result<Box<dyn crate::problem::Prepared + 'g>, SuiteError> {
    if case.scene != CROWN {
        // The cells are made here, whatever the scene.
        return Err(SuiteError::unknown("scene", &case.scene, [CROWN]));
    }
    let path = FactorPath { seed: case.seed, frames: FRAMES };
    let factors = |cells: &Cells, frame: u32, out: &mut Vec<f32>| {
        path.factors_into(cells, frame, out);
        if frame + 1 == FRAMES {
            for (cell, value) in out.iter_mut().enumerate() {
                *value = factor(cell).unwrap_or(*value);
            }
        }
    };
    let facts = Facts { scene: case.scene.clone(), ..Facts::default() };
    Ok(Box::new(Crown::of(cells, FRAMES, factors, facts, gpu)?))
}

fn not_on(axis: &str, value: f64) -> SuiteError {
    SuiteError::Internal(format!("{} has no value {value} on the axis {axis}", SPEC.id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        knob::Knobs,
        problem::{Form, Prepared, Setting},
        stress::{find_axis, search::grid},
    };

    fn prepare(axis: &Axis, value: f64) -> Result<Box<dyn Prepared>, SuiteError> {
        let case = Case {
            problem: SPEC.id.into(),
            scene: CROWN.into(),
            view: String::new(),
            seed: 3,
            parameters: axis.case_parameters(&SPEC, &Knobs::new()).unwrap(),
        };
        (axis.prepare)(&case, value, None)
    }

    fn checked(axis: &Axis, value: f64) -> f64 {
        let setting = Setting {
            technique: "cpu-thread".into(),
            variant: "plain".into(),
            form: Form::Cpu,
            knobs: Knobs::new(),
        };
        let prepared = prepare(axis, value).unwrap();
        let checked = prepared.subject(&setting).unwrap().check().unwrap();
        assert!(checked.violations.is_empty(), "{} {value}: {:?}", axis.id, checked.violations);
        checked.errors["wrong_frames"]
    }

    #[test]
    fn good_values_are_exact_and_bad_ones_are_refused_by_name() {
        for axis in axes() {
            for value in grid(axis.values, axis.home) {
                // Larger crowns are for `dapple stress`.
                if axis.id == "leaves" && value > 1e6 {
                    continue;
                }
                if !(axis.must_refuse)(value) {
                    assert_eq!(checked(&axis, value), 0.0, "{} {value}", axis.id);
                    continue;
                }
                let Err(error) = prepare(&axis, value) else { panic!("{} {value}", axis.id) };
                assert_eq!(error.exit_code(), 2, "{error}");
                let text = error.to_string();
                assert!(text.contains("cell") || text.contains("leaves"), "{text}");
            }
        }
    }

    #[test]
    fn what_is_pushed_arrives() {
        let size = |id: &str, value| {
            let axis = axes().into_iter().find(|axis| axis.id == id).unwrap();
            prepare(&axis, value).unwrap().facts().size
        };
        assert_eq!(size("leaves", 7.0), "7 leaves in 512 cells");
        assert_eq!(size("cells", 9.0), "131042 leaves in 9 cells");
        assert_eq!(size("one-cell", 2.0), "9 leaves in 3 cells");
        assert_eq!(size("skew", 1.0), "131042 leaves in 512 cells");
        let problem = crate::problems::find(SPEC.id).unwrap();
        assert!(find_axis(problem, "factors").is_ok());
    }
}
