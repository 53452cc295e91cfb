//! Split functions: from the depth within a ray's bounds to a layer coordinate.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Split, SplitKind,
    faults::wrapping_table,
    layered::{
        split::{POSITIONS_PRECISION, PRECISION, SplitFunction, listing_table},
        split_reference::{SplitReference, hybrid, slope},
    },
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Depths that a function is looked at.
const STEPS: u32 = 500;

pub fn gates() -> Vec<Gate> {
    let bom = |name, statement, fault| About { technique: "bom", name, statement, fault };
    vec![
        gate(
            bom(
                "P1 split",
                "a split goes from 0 to 1, never falls, and but for the listing its boundaries \
                 rise strictly",
                "the printed table: bytes wrap before they are scaled",
            ),
            joins_ends,
        ),
        gate(
            bom(
                "split port",
                "a split in f32 lies within its stated precision of the f64 reference",
                "lambda is off by 0.001",
            ),
            port,
        ),
        gate(
            bom(
                "P8 pure splits",
                "lambda 0 is even and lambda 1 the logarithm to the bit, mixed coordinates or \
                 positions",
                "the table of bytes",
            ),
            pure_ends,
        ),
        gate(
            bom(
                "P15 table",
                "a table lies within 1/255 (bytes) and a texel's slope of arithmetic",
                "the listing, whose exponent is cut off",
            ),
            table,
        ),
        gate(
            bom(
                "row 24 listing",
                "the thesis's table of the logarithm has reached its end half way, as every other \
                 kind has not",
                "the normalised logarithm",
            ),
            saturates,
        ),
        gate(
            bom(
                "row 26 hybrid",
                "a mixture lies between the even and the logarithmic coordinate, mixed positions \
                 between those boundaries",
                "lambda beyond 1",
            ),
            between,
        ),
    ]
}

fn any(rng: &mut Pcg64) -> Split {
    let width = [3, 16, 64, 512, 1024][rng.random_range(0..5_usize)];
    let lambda = [0.0, 1.0, rng.random_range(0.0..1.0_f32)][rng.random_range(0..3_usize)];
    Split { lambda, kind: input::SPLITS[rng.random_range(0..input::SPLITS.len())], width }
}

/// Every depth that is looked at, 0 and 1 among them.
fn depths() -> impl Iterator<Item = f32> {
    (0..=STEPS).map(|i| i as f32 / STEPS as f32)
}

fn joins_ends(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "ends", case);
        let split = any(&mut rng);
        let function = if faulty {
            let table = wrapping_table(split.width).into_iter().map(|b| f32::from(b) / 255.0);
            let listing = Split { kind: SplitKind::Listing, ..split };
            SplitFunction::with_table(&listing, table.collect())
        } else {
            SplitFunction::new(&split)
        };
        let values: Vec<f32> = depths().map(|t| function.coordinate(t)).collect();
        let what = || format!("{split:?}");
        tally.check(values.first() == Some(&0.0) && values.last() == Some(&1.0), what);
        tally.check(values.windows(2).all(|w| w[0] <= w[1]), what);
        let outside = [-1.0, 2.0, f32::NAN].map(|t| function.coordinate(t));
        tally.check(outside == [0.0, 1.0, 0.0], || format!("{split:?}: outside {outside:?}"));
        // Bytes have steps of their own.
        if !matches!(split.kind, SplitKind::Listing | SplitKind::Table8) {
            let reference = SplitReference::new(&split);
            let layers = [1, 2, 3, 5, 32, 33, 256][rng.random_range(0..7_usize)];
            let at = |k: u32| reference.position(f64::from(k) / f64::from(layers));
            let boundaries: Vec<f64> = (0..=layers).map(at).collect();
            tally.check(boundaries.windows(2).all(|w| w[0] < w[1]), what);
            tally.within((boundaries[layers as usize] - 1.0).abs(), 1e-12, what);
        }
    }
    Ok(tally)
}

fn port(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let split = any(&mut input::rng(context.seed, "split port", case));
        let given = if faulty {
            let off = if split.lambda > 0.5 { -0.001 } else { 0.001 };
            Split { lambda: split.lambda + off, ..split }
        } else {
            split
        };
        let (function, reference) = (SplitFunction::new(&given), SplitReference::new(&split));
        let positions = split.kind == SplitKind::Positions;
        let bound = if positions { POSITIONS_PRECISION } else { PRECISION };
        for t in depths() {
            let off = f64::from(function.coordinate(t)) - reference.coordinate(t.into());
            tally.within(off.abs(), bound.into(), || format!("{split:?} at {t}"));
        }
    }
    Ok(tally)
}

fn pure_ends(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let Split { width, .. } = any(&mut input::rng(context.seed, "pure", case));
        for kind in [SplitKind::Normalised, SplitKind::Positions] {
            let kind = if faulty { SplitKind::Table8 } else { kind };
            let even = SplitFunction::new(&Split { lambda: 0.0, kind, width });
            let log = SplitFunction::new(&Split { lambda: 1.0, kind, width });
            for t in depths() {
                let n = width as f32;
                let logarithm = (1.0 + (n - 2.0) * t).log2() / (n - 1.0).log2();
                let expected = [t, if t < 1.0 { logarithm.min(1.0) } else { 1.0 }];
                let found = [even.coordinate(t), log.coordinate(t)];
                let same = found.map(f32::to_bits) == expected.map(f32::to_bits);
                tally.check(same, || format!("{kind:?} {width} at {t}: {found:?} {expected:?}"));
            }
        }
    }
    Ok(tally)
}

fn table(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let split = any(&mut input::rng(context.seed, "table", case));
        for (kind, byte) in [(SplitKind::Table8, 1.0 / 255.0), (SplitKind::Table32, 0.0)] {
            let kind = if faulty { SplitKind::Listing } else { kind };
            let function = SplitFunction::new(&Split { kind, ..split });
            let texel = 1.0 / f64::from(split.width - 1);
            for t in depths() {
                let off = f64::from(function.coordinate(t)) - hybrid(&split, t.into());
                // The curve is concave: steepest at the left end of the depth's texel.
                let steepest = slope(&split, (f64::from(t) - texel).max(0.0));
                let bound = byte + steepest * texel + 1e-6;
                tally.within(off.abs(), bound, || format!("{kind:?} {split:?} at {t}"));
            }
        }
    }
    Ok(tally)
}

fn saturates(_: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let log = |kind| SplitFunction::new(&Split { lambda: 1.0, kind, width: 512 });
    let listing = log(if faulty { SplitKind::Normalised } else { SplitKind::Listing });
    tally.within(1.0 - f64::from(listing.coordinate(0.502)), 0.0, || "behind the middle".into());
    tally.check(listing.coordinate(0.49) < 1.0, || "in front of the middle".into());
    for kind in [SplitKind::Normalised, SplitKind::Table8, SplitKind::Table32] {
        let u = log(kind).coordinate(0.502);
        tally.check(u < 0.9, || format!("{kind:?}: {u} half way"));
    }
    // Where mixtures reach the end, and the first texels, as worked out by hand.
    let table = |lambda| listing_table(&Split { lambda, kind: SplitKind::Listing, width: 512 });
    tally.check(table(1.0)[..6] == [0, 0, 31, 50, 63, 74], || format!("{:?}", &table(1.0)[..6]));
    for (lambda, end) in [(0.75, 0.77), (0.5, 0.89), (0.25, 0.96)] {
        let first = table(lambda).iter().position(|&b| b == 255).unwrap_or_default();
        let off = (first as f64 / 511.0 - end).abs();
        tally.within(off, 0.01, || format!("lambda {lambda}: texel {first}"));
    }
    Ok(tally)
}

fn between(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "between", case);
        let split = Split { lambda: rng.random_range(0.05..0.95), ..any(&mut rng) };
        for kind in [SplitKind::Normalised, SplitKind::Positions] {
            let of = |lambda| SplitFunction::new(&Split { lambda, kind, ..split });
            let mixed = of(if faulty { split.lambda + 1.0 } else { split.lambda });
            let (even, log) = (of(0.0), of(1.0));
            for t in depths().step_by(10) {
                let [low, at, high] = [&even, &mixed, &log].map(|f| f64::from(f.coordinate(t)));
                let bound = f64::from(POSITIONS_PRECISION);
                let off = (low - at).max(at - high);
                tally.within(off, bound, || format!("{kind:?} {split:?} at {t}: {at}"));
            }
        }
    }
    Ok(tally)
}
