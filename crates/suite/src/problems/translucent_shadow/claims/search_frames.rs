//! H7.5 and H7.6: how correlation is summed, and what a search costs in frames and time.

use super::{
    bench_times::{SIDE, timed},
    search_trials::Form,
    support::{frame_ns, still},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_metrics::stats;
use dapple_opacity_maps::{
    Criterion,
    search::{
        Plan, Precision, Search, Shown, Steps,
        correlation::{bytes, one_pass, one_pass_cancelling, two_pass},
    },
};
use std::time::Instant;

/// Layers of both.
const LAYERS: u32 = 16;

/// Largest difference of sums in 64 bits that rounding explains: C itself is of order 1 and is made
/// of some 65,000 terms.
const ROUNDING: f64 = 1e-9;

/// Milliseconds of a frame that is still in real time: 30 frames a second (thesis, section 7).
const REAL_TIME: f64 = 1000.0 / 30.0;

/// What `a couple of seconds` may mean.
const A_COUPLE: std::ops::RangeInclusive<f64> = 1.0..=4.0;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H7.5",
            statement: "Correlation summed in one pass is that of two passes",
            place: "Voicu 2011, section 5.2.4, appendix 12",
            method: "15 pairs of neighbouring maps of dense grass (16 layers, 256 texels a side, \
                     lambda 0), as printed in bytes and repaired in floats: one pass against means \
                     first, then deviations, all in 64 bits. Equal: within 1e-9. The same sums in \
                     32 bits, not taken about a point near the mean, beside",
            judge: Box::new(passes),
        },
        Claim {
            id: "voicu-H7.6",
            statement: "A search takes eleven frames and turns a program in real time into an \
                        interactive one for a couple of seconds",
            place: "Voicu 2011, algorithm 5.2.3.1 and section 5.4",
            method: "grass at the thesis's size (512 texels, 16 layers, as printed): frames from \
                     the start until a split is adopted must be eleven, and so must each search \
                     after. Read-back of all maps, their correlation on the processor and a frame \
                     are timed (medians of eleven). Judged on graphics hardware alone: a frame \
                     below 1/30 s that read-back and scoring take above it, eleven of which take 1 \
                     to 4 s. A search on the processor, where nothing is read back, beside",
            judge: Box::new(frames),
        },
    ]
}

/// Largest differences of one pass from two.
fn equal(differences: &[f64]) -> Verdict {
    match differences {
        [] => Verdict::Open,
        all if all.iter().all(|d| *d <= ROUNDING) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

fn passes(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let still = still("grass_dense")?;
    let (mut in_bytes, mut in_floats, mut cancelling) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (printed, repaired) =
        (Form::Printed.method(LAYERS, 0.0), Form::Repaired.method(LAYERS, 0.0));
    let maps = [still.maps(&printed)?, still.maps(&repaired)?];
    let column = |form: usize, layer: usize| -> Vec<f32> {
        let words = maps[form].code().words();
        let first = words - LAYERS as usize + layer;
        maps[form].words().chunks_exact(words).map(|texel| texel[first]).collect()
    };
    let wide = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect::<Vec<f64>>();
    for layer in 0..LAYERS as usize - 1 {
        let [a, b] = [layer, layer + 1].map(|l| {
            let byte = |v: &f32| Precision::Bytes.value(*v) as u8;
            column(0, l).iter().map(byte).collect::<Vec<u8>>()
        });
        let [c, d] = [&a, &b].map(|s| s.iter().map(|&v| f64::from(v)).collect::<Vec<f64>>());
        in_bytes = in_bytes.max((bytes(&a, &b) - two_pass(&c, &d)).abs());
        let [a, b] = [layer, layer + 1].map(|l| column(1, l));
        let (c, d) = (wide(&a), wide(&b));
        let truth = two_pass(&c, &d);
        in_floats = in_floats.max((one_pass(&c, &d) - truth).abs());
        cancelling = cancelling.max((f64::from(one_pass_cancelling(&a, &b)) - truth).abs());
    }
    let figures = vec![
        figure("largest difference, bytes", in_bytes, ""),
        figure("largest difference, floats", in_floats, ""),
        figure("the same in 32 bits, not shifted", cancelling, ""),
    ];
    let because = format!("one pass differs from two by at most {:.1e}", in_bytes.max(in_floats));
    Ok(judged(equal(&[in_bytes, in_floats]), because, figures))
}

/// Milliseconds on graphics hardware.
#[derive(Clone, Copy, Debug)]
struct Cost {
    frame: f64,
    read_back: f64,
    scoring: f64,
}

impl Cost {
    fn searching(self) -> f64 {
        self.frame + self.read_back + self.scoring
    }
}

/// Frames of each search, and what they cost where that is judged.
fn eleven_and_slow(searches: &[u32], cost: Option<Cost>) -> Verdict {
    let frames = match searches {
        [] => Verdict::Open,
        all if all.iter().all(|n| *n == 11) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    };
    let slow = cost.map_or(Verdict::NeedsHardware, |cost| {
        let all = 11.0 * cost.searching() / 1000.0;
        let slow = cost.frame <= REAL_TIME && cost.searching() > REAL_TIME;
        if slow && A_COUPLE.contains(&all) { Verdict::Reproduced } else { Verdict::Refuted }
    });
    all_of(&[frames, slow])
}

fn median_of(
    times: usize,
    mut ms: impl FnMut() -> Result<f64, SuiteError>,
) -> Result<f64, SuiteError> {
    let samples: Result<Vec<f64>, _> = (0..times).map(|_| ms()).collect();
    Ok(stats::median(&samples?)?)
}

fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn frames(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let still = timed("grass")?;
    let method = Form::Printed.method(LAYERS, 0.0).at(SIDE);
    let plan = Plan {
        scoring: Form::Printed.scoring(Criterion::Correlation),
        shown: Shown::Trial,
        ..Plan::plain(method.settings.clone(), Criterion::Correlation)
    };
    let fragments = still.fragments(&method)?;
    let mut search = Search::new(SIDE, SIDE, plan)?;
    let (mut searches, mut searching) = (Vec::new(), Vec::new());
    for _ in 0..2 {
        let mut frames = 0;
        while search.is_searching() && frames < 3 * Steps::THESIS.values() {
            let start = Instant::now();
            search.frame(&fragments)?;
            searching.push(since(start));
            frames += 1;
        }
        searches.push(frames);
        search.needs_recompute();
    }
    // To its end, then at rest.
    while search.is_searching() {
        search.frame(&fragments)?;
    }
    let at_rest = median_of(11, || {
        let start = Instant::now();
        search.frame(&fragments)?;
        Ok(since(start))
    })?;
    let searching = stats::median(&searching)?;
    let mut figures = vec![
        figure("frames of the first search", f64::from(searches[0]), ""),
        figure("frames of the second", f64::from(searches[1]), ""),
        figure("processor: maps and score while searching", searching, "ms"),
        figure("processor: maps at rest", at_rest, "ms"),
        figure("processor: what a whole search adds", 11.0 * (searching - at_rest) / 1e3, "s"),
    ];
    let scoring = (searching - at_rest).max(0.0);
    let mut judged_cost = None;
    if let Some(gpu) = context.gpu {
        let renderer = still.renderer(gpu, &method)?;
        frame_ns(gpu, &renderer)?;
        let times = if context.hardware { 11 } else { 3 };
        let frame = median_of(times, || Ok(frame_ns(gpu, &renderer)? / 1e6))?;
        let read_back = median_of(times, || {
            let start = Instant::now();
            renderer
                .read_maps(gpu)
                .map_err(crate::problems::translucent_shadow::subject_gpu::refused)?;
            Ok(since(start))
        })?;
        let cost = Cost { frame, read_back, scoring };
        let device = if context.hardware { "graphics hardware" } else { "software adapter" };
        figures.push(figure(format!("{device}: frame"), frame, "ms"));
        figures.push(figure(format!("{device}: read-back of all maps"), read_back, "ms"));
        figures.push(figure(
            format!("{device}: eleven frames with read-back and scoring"),
            11.0 * cost.searching() / 1e3,
            "s",
        ));
        judged_cost = context.hardware.then_some(cost);
    }
    let because = format!(
        "a split is adopted after {} and {} frames; on the processor a search adds {:.2} s",
        searches[0],
        searches[1],
        11.0 * scoring / 1e3
    );
    Ok(judged(eleven_and_slow(&searches, judged_cost), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn one_pass_is_two_to_rounding() {
        assert_eq!(equal(&[0.0, 1e-12]), Reproduced);
        assert_eq!(equal(&[0.0, 1e-6]), Refuted);
        assert_eq!(equal(&[f64::NAN]), Refuted);
        assert_eq!(equal(&[]), Open);
    }

    #[test]
    fn a_search_takes_eleven_frames_and_hardware_says_how_long() {
        let cost = |frame, read_back| Some(Cost { frame, read_back, scoring: 50.0 });
        assert_eq!(eleven_and_slow(&[11, 11], None), NeedsHardware);
        assert_eq!(eleven_and_slow(&[11, 12], None), Refuted);
        assert_eq!(eleven_and_slow(&[11], cost(10.0, 60.0)), Reproduced);
        assert_eq!(eleven_and_slow(&[11], cost(1.0, 1.0)), Refuted);
        assert_eq!(eleven_and_slow(&[11], cost(50.0, 60.0)), Refuted);
        assert_eq!(eleven_and_slow(&[], None), Open);
    }
}
