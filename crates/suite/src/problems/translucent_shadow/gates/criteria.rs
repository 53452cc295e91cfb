//! What searches judge maps by: correlation and its forms, differences that telescope.

use super::{
    About, gate, input,
    search::{SIDE, stand},
};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Code, Criterion,
    search::{
        Layers, Precision, Scorer, Scoring,
        correlation::{bytes, one_pass, one_pass_cancelling, two_pass},
    },
};
use rand::RngExt;
use rand_pcg::Pcg64;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: "bom-search", name, statement, fault };
    vec![
        gate(
            about(
                "P11 correlation",
                "correlation is within -1..=1, symmetric, 1 of a series with itself, and the sign \
                 of the slope along a line",
                "the square of it",
            ),
            is_a_cosine,
        ),
        gate(
            about(
                "P11 one pass",
                "one pass over shifted sums, or over bytes in integers, is two passes",
                "sums that are not shifted, in 32 bits",
            ),
            passes_agree,
        ),
        gate(
            about(
                "row 28 telescopes",
                "absolute differences of maps that never fall are the last map less the first, to \
                 the bit in bytes",
                "one map falls",
            ),
            telescopes,
        ),
    ]
}

fn series(rng: &mut Pcg64) -> Vec<f64> {
    let scale = 10_f64.powf(rng.random_range(-2.0..3.0));
    (0..40).map(|_| scale * rng.random_range(-1.0..1.0)).collect()
}

fn is_a_cosine(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let of = |a: &[f64], b: &[f64]| {
        let c = two_pass(a, b);
        if faulty { c * c } else { c }
    };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "cosine", case);
        let (a, b) = (series(&mut rng), series(&mut rng));
        let c = of(&a, &b);
        let what = || format!("{a:?} {b:?}: {c}");
        tally.within(c.abs(), 1.0 + 1e-9, what);
        tally.within((c - of(&b, &a)).abs(), 1e-9, what);
        tally.within((of(&a, &a) - 1.0).abs(), 1e-9, what);
        let slope = rng.random_range(0.1..50.0) * if case % 2 == 0 { 1.0 } else { -1.0_f64 };
        let shift = rng.random_range(-1e3..1e3);
        let line: Vec<f64> = a.iter().map(|x| slope * x + shift).collect();
        tally.within((of(&a, &line) - slope.signum()).abs(), 1e-6, what);
        tally.within((of(&line, &b) - slope.signum() * c).abs(), 1e-6, what);
    }
    // Two constants tell nothing new; a constant tells nothing of what varies.
    let (constant, varied) = (vec![2.0; 5], vec![0.0, 1.0, 2.0, 3.0, 4.0]);
    tally.check(of(&constant, &constant) == 1.0, || "two constants".into());
    tally.check(of(&constant, &varied) == 0.0, || "one constant".into());
    Ok(tally)
}

fn passes_agree(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "passes", case);
        // Far from 0, where sums that are not shifted cancel.
        let a: Vec<f32> = (0..500).map(|_| 1000.0 + rng.random_range(0.0..1.0_f32)).collect();
        let b: Vec<f32> = a.iter().map(|x| 0.5 * x + rng.random_range(0.0..0.5_f32)).collect();
        let wide = |s: &[f32]| s.iter().map(|&x| f64::from(x)).collect::<Vec<f64>>();
        let truth = two_pass(&wide(&a), &wide(&b));
        let found = if faulty {
            f64::from(one_pass_cancelling(&a, &b))
        } else {
            one_pass(&wide(&a), &wide(&b))
        };
        tally.within((found - truth).abs(), 1e-9, || format!("{found}, two passes {truth}"));
        let mut bytes_of = || (0..80).map(|_| rng.random_range(0..=255_u8)).collect();
        let [x, y]: [Vec<u8>; 2] = [bytes_of(), bytes_of()];
        let wide = |s: &[u8]| s.iter().map(|&x| f64::from(x)).collect::<Vec<f64>>();
        let off = (bytes(&x, &y) - two_pass(&wide(&x), &wide(&y))).abs();
        tally.within(off, 1e-9, || format!("bytes {x:?} {y:?}"));
    }
    Ok(tally)
}

fn telescopes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(16) {
        let mut rng = input::rng(context.seed, "telescopes", case);
        let fragments = stand(&mut rng);
        let layers = rng.random_range(3..=16_u32);
        let layered = input::layered(input::bounded(rng.random_range(0.0..1.0)), layers);
        let maps = input::build(&input::plain(Code::Layered(layered.clone())), &fragments)?;
        let mut sums: Vec<f32> = (0..fragments.texels())
            .flat_map(|t| input::sums(&maps, &layered, t).to_vec())
            .collect();
        let k = layers as usize;
        if faulty {
            sums.chunks_mut(k).for_each(|texel| texel[1] = 0.0);
        }
        let all = Layers::new((SIDE, SIDE), k, k, 0, &sums)?;
        let byte = |x: f32| f64::from(Precision::Bytes.value(x));
        let ends: f64 = sums.chunks(k).map(|t| byte(t[k - 1]) - byte(t[0])).sum();
        let found = Scorer::new(Scoring::thesis(Criterion::Sad)).score(&all)?;
        tally.check(found == ends, || format!("{layers} layers: {found}, ends {ends}"));
        let ends: f64 = sums.chunks(k).map(|t| f64::from(t[k - 1]) - f64::from(t[0])).sum();
        let found = Scorer::new(Scoring::plain(Criterion::Sad)).score(&all)?;
        tally.within((found / ends - 1.0).abs(), 1e-9, || format!("floats: {found}, ends {ends}"));
    }
    Ok(tally)
}
