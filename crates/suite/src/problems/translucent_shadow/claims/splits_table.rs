//! H6.4 and H6.5: the split as a function, looked up or worked out.

use super::{
    support::{bom_split, still},
    verdict::{all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_metrics::stats::Ratio;
use dapple_opacity_maps::{
    Split, SplitKind,
    layered::{
        split::SplitFunction,
        split_reference::{hybrid, slope},
    },
};

/// Depths that functions are compared at.
const DEPTHS: u32 = 20_000;

/// Medians of paired times are told apart from 1 by this many of their median absolute deviations:
/// about two standard errors of a median of eleven.
const CLEAR: f64 = 1.5;

/// Boundaries are alike if neither lies more than this many times as deep as the other.
const ALIKE: f64 = 2.0;

/// Layers of a logarithmic split, and of the even one that is said to begin like it: at most 32,
/// as in the thesis.
const PAIRS: [[u32; 2]; 4] = [[4, 8], [4, 16], [4, 32], [8, 32]];

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H6.4",
            statement: "A lookup texture gives the split to 1/255 and its interpolation, faster \
                        than arithmetic",
            place: "Voicu 2011, section 5.2.2",
            method: "512 texels of bytes, lambda 0 to 1 in tenths, 20,001 depths: no difference \
                     from arithmetic may exceed 1/255 plus the steepest slope of the depth's texel \
                     times its width. The listing's own table is shown beside. Speed: a whole \
                     frame of 16 layers of grass_dense with the table over one with arithmetic, \
                     median of 11 interleaved pairs, judged on graphics hardware alone: there \
                     faster or slower if the median lies 1.5 of its deviations beyond 1",
            judge: Box::new(table),
        },
        Claim {
            id: "voicu-H6.5",
            statement: "An even split of more layers has its first boundaries where a logarithmic \
                        one of fewer has them",
            place: "Voicu 2011, section 5.2.3, figure 5.2.3.7",
            method: "the first two boundaries of logarithmic splits of 4 and 8 layers (normalised, \
                     and the listing's table) against even ones of 8 to 32, the most that the \
                     thesis uses. Alike: within a factor of two of each other, both of them. Voted \
                     over four pairs and two logarithms",
            judge: Box::new(boundaries),
        },
    ]
}

fn function(kind: SplitKind, lambda: f32) -> (Split, SplitFunction) {
    let split = Split { lambda, kind, width: 512 };
    (split, SplitFunction::new(&split))
}

fn depths() -> impl Iterator<Item = f64> {
    (0..=DEPTHS).map(|i| f64::from(i) / f64::from(DEPTHS))
}

/// Largest difference of a table from arithmetic, and largest part of what it may be.
fn differs(kind: SplitKind, lambda: f32) -> (f64, f64) {
    let (split, table) = function(kind, lambda);
    let texel = 1.0 / f64::from(split.width - 1);
    depths().fold((0.0, 0.0), |(most, part): (f64, f64), t| {
        let off = (f64::from(table.coordinate(t as f32)) - hybrid(&split, t)).abs();
        // The curve is concave: steepest at the left end of the depth's texel. Rounding is 1e-6.
        let bound = 1.0 / 255.0 + slope(&split, (t - texel).max(0.0)) * texel + 1e-6;
        (most.max(off), part.max(off / bound))
    })
}

/// Equal to what a table can hold, and faster; a time of hardware, where there is any.
fn equal_and_faster(part_of_bound: f64, time: Option<Ratio>) -> Verdict {
    let equal = vote(&[part_of_bound <= 1.0]);
    let faster = time.map_or(Verdict::NeedsHardware, |time| {
        let slack = CLEAR * time.mad;
        match (time.median + slack < 1.0, time.median - slack >= 1.0) {
            (true, _) => Verdict::Reproduced,
            (_, true) => Verdict::Refuted,
            _ => Verdict::Open,
        }
    });
    all_of(&[equal, faster])
}

fn table(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut most, mut part, mut listing) = (0.0_f64, 0.0_f64, 0.0_f64);
    for step in 0..=10_u8 {
        let lambda = f32::from(step) / 10.0;
        let (off, of_bound) = differs(SplitKind::Table8, lambda);
        (most, part) = (most.max(off), part.max(of_bound));
        listing = listing.max(differs(SplitKind::Listing, lambda).0);
    }
    let mut figures = vec![
        figure("largest difference of the table", most, ""),
        figure("largest part of what it may differ by", part, ""),
        figure("largest difference of the listing's table", listing, ""),
    ];
    let still = still("grass_dense")?;
    let (looked_up, worked_out) =
        (bom_split(16, 0.5, SplitKind::Table8), bom_split(16, 0.5, SplitKind::Normalised));
    let cpu = still.cpu_ratio(11, &looked_up, &worked_out)?;
    figures.push(figure("processor: time of the table over arithmetic", cpu.median, ""));
    figures.push(figure("the same, median absolute deviation", cpu.mad, ""));
    let mut time = None;
    if let Some(gpu) = context.gpu {
        let ratio = still.gpu_ratio(gpu, 11, &looked_up, &worked_out)?;
        let device = if context.hardware { "graphics hardware" } else { "software adapter" };
        figures.push(figure(format!("{device}: the same ratio"), ratio.median, ""));
        figures.push(figure("the same, median absolute deviation", ratio.mad, ""));
        time = context.hardware.then_some(ratio);
    }
    let because = format!(
        "the table stays within {part:.2} of its bound; a frame takes {:.2} of arithmetic's time \
         on the processor{}",
        cpu.median,
        time.map_or(String::new(), |t| format!(", {:.2} on graphics hardware", t.median)),
    );
    Ok(judged(equal_and_faster(part, time), because, figures))
}

/// Depth at which a split reaches a coordinate.
fn boundary(function: &SplitFunction, u: f32) -> f64 {
    let (mut low, mut high) = (0.0_f32, 1.0_f32);
    for _ in 0..40 {
        let t = 0.5 * (low + high);
        if function.coordinate(t) >= u {
            high = t;
        } else {
            low = t;
        }
    }
    f64::from(high)
}

/// Whether pairs of depths are within a factor of each other.
fn alike(pairs: &[[f64; 2]]) -> bool {
    pairs.iter().all(|[a, b]| *a <= ALIKE * b && *b <= ALIKE * a)
}

fn boundaries(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut holds) = (Vec::new(), Vec::new());
    for (name, kind) in [("normalised", SplitKind::Normalised), ("listing", SplitKind::Listing)] {
        let logarithm = function(kind, 1.0).1;
        for [few, many] in PAIRS {
            let pair = |k: u8| {
                let k = f32::from(k);
                [boundary(&logarithm, k / few as f32), f64::from(k) / f64::from(many)]
            };
            let pairs = [pair(1), pair(2)];
            holds.push(alike(&pairs));
            for (k, [log, even]) in (1..).zip(pairs) {
                let what = format!("{name}: boundary {k} of {many} even over {few} logarithmic");
                figures.push(figure(what, even / log, ""));
            }
        }
    }
    let because = format!("the first two boundaries are alike in {} pairs", count(&holds));
    Ok(judged(vote(&holds), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn a_table_must_be_equal_and_faster_on_hardware() {
        let time = |median, mad| Some(Ratio { median, mad });
        assert_eq!(equal_and_faster(0.9, None), NeedsHardware);
        assert_eq!(equal_and_faster(1.1, None), Refuted);
        assert_eq!(equal_and_faster(0.9, time(0.8, 0.02)), Reproduced);
        assert_eq!(equal_and_faster(0.9, time(1.1, 0.02)), Refuted);
        assert_eq!(equal_and_faster(0.9, time(0.99, 0.02)), Open);
        assert_eq!(equal_and_faster(f64::NAN, None), Refuted);
    }

    #[test]
    fn the_listing_is_not_the_function_it_stands_for() {
        assert!(differs(SplitKind::Table8, 1.0).1 <= 1.0);
        assert!(differs(SplitKind::Listing, 1.0).1 > 1.0);
    }

    #[test]
    fn boundaries_are_where_the_function_says() {
        let logarithm = function(SplitKind::Normalised, 1.0).1;
        let expected = (511_f64.powf(0.25) - 1.0) / 510.0;
        assert!((boundary(&logarithm, 0.25) - expected).abs() < 1e-6);
        assert!(alike(&[[0.1, 0.2], [0.3, 0.2]]) && !alike(&[[0.1, 0.2], [0.3, 0.1]]));
    }
}
