//! What rivals promise of their own: closed sums, bounds from both sides, estimates without bias.

use super::{About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Code, Format, Fourier, Fragments, Moments, Stochastic, cpu::Maps, fourier, moments, reference,
};
use rand::RngExt;
use std::f64::consts::{PI, TAU};

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about("unshadowed", "row 1 lit", "every receiver is lit in full", "a binary map"),
            lit,
        ),
        gate(
            about(
                "fourier",
                "closed sum",
                "the series of one fragment is the sum that can be written down",
                "the signs of the sines: the fragment is mirrored",
            ),
            closed_sum,
        ),
        gate(
            about(
                "fourier",
                "converges",
                "fifteen pairs err less than half as much as one",
                "one pair is kept",
            ),
            converges,
        ),
        gate(
            about(
                "moments",
                "both bounds",
                "the least and the greatest transmittance that moments allow hold the truth \
                 between them",
                "the least and the greatest are exchanged",
            ),
            both_bounds,
        ),
        gate(
            about(
                "moments",
                "few depths",
                "m moments meet m/2 depths exactly, but for the bias",
                "one depth more",
            ),
            few_depths,
        ),
        gate(
            about(
                "stochastic",
                "no bias",
                "over many texels the share of lit samples is e to the minus thickness within five \
                 standard errors, and its variance T(1 - T)/S within a third",
                "every texel draws the same samples",
            ),
            no_bias,
        ),
    ]
}

/// Maps of a code without a bias.
pub fn build(code: Code, fragments: &Fragments) -> Result<Maps, SuiteError> {
    input::build(&input::plain(code), fragments)
}

fn lit(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "lit", case);
        let fragments = input::fragments(&mut rng);
        let fragments = input::with_opaque(&mut rng, fragments);
        let mut settings = input::settings_of(&mut rng, "unshadowed")?;
        if faulty {
            settings.code = Code::Binary;
        }
        let maps = input::build(&settings, &fragments)?;
        for receiver in input::receivers(&mut rng, 20) {
            let t = f64::from(maps.transmittance(&receiver));
            tally.within((t - 1.0).abs(), 0.0, || format!("{receiver:?}: {t}"));
        }
    }
    Ok(tally)
}

fn closed_sum(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "closed", case);
        let pairs = rng.random_range(1..=15);
        let (depth, omega) = (rng.random_range(0.05..0.95_f32), rng.random_range(0.1..3.0_f32));
        let stored = if faulty { 1.0 - depth } else { depth };
        let settings = Fourier { pairs, bounded: false, format: Format::F32 };
        let fragments = input::map(1, &[vec![(stored, omega)]]);
        let code = fourier::Code { settings, opaque_in_bounds: false };
        let maps =
            input::build_with(&input::plain(Code::Fourier(settings)), &fragments, Box::new(code))?;
        for i in 1..20_u8 {
            let (x, y) = (f64::from(i) / 20.0, f64::from(depth));
            let term = |k: f64| ((TAU * k * (x - y)).sin() + (TAU * k * y).sin()) / (PI * k);
            let series: f64 = (1..=pairs).map(|k| term(f64::from(k))).sum();
            let expected = (-(f64::from(omega) * (x + series)).max(0.0)).exp();
            let t = input::at(&maps, 0, x as f32);
            let what = || format!("{pairs} pairs, {omega} at {depth}, read at {x}: {t} {expected}");
            tally.within((t - expected).abs(), 1e-5, what);
        }
    }
    Ok(tally)
}

fn converges(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for bounded in [false, true] {
        let mut squares = [0.0; 2];
        for case in 0..context.cases {
            let fragments = input::fragments(&mut input::rng(context.seed, "converges", case));
            for (sum, pairs) in squares.iter_mut().zip([1, if faulty { 1 } else { 15 }]) {
                let code = Code::Fourier(Fourier { pairs, bounded, format: Format::F32 });
                let maps = build(code, &fragments)?;
                for texel in 0..fragments.texels() {
                    let error = |i: u8| {
                        let depth = f32::from(i) / 60.0;
                        let exact = reference::exact(fragments.texel(texel), depth);
                        (input::at(&maps, texel, depth) - exact).powi(2)
                    };
                    *sum += (0..60).map(error).sum::<f64>();
                }
            }
        }
        let [one, fifteen] = squares.map(f64::sqrt);
        tally.within(fifteen, 0.5 * one, || format!("ray bounds: {bounded}"));
    }
    Ok(tally)
}

/// Moments over the whole range with next to no bias.
fn unbiased(moments: u32, overestimation: f32, bias: f32) -> Moments {
    Moments { moments, bias, overestimation, bounded: false, format: Format::F32 }
}

fn both_bounds(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "both bounds", case);
        // Depths enough that the matrix of moments is far from singular.
        let count = rng.random_range(12..24);
        let one = |_| (rng.random_range(0.02..0.98_f32), rng.random_range(0.05..0.5_f32));
        let texel = input::map(1, &[(0..count).map(one).collect()]);
        let fragments = texel.texel(0);
        for moments in [4, 6] {
            let t = |overestimation, depth| {
                let settings = unbiased(moments, overestimation, 1e-9);
                moments::reference(&settings, fragments, None, false, depth)
            };
            for i in 1..20_u8 {
                let depth = f32::from(i) / 20.0;
                let truth = reference::exact(fragments, depth);
                let [least, most] = [t(0.0, depth), t(1.0, depth)];
                let [least, most] = if faulty { [most, least] } else { [least, most] };
                let off = (least - truth).max(truth - most);
                let what = || format!("{moments} at {depth}: {least} {truth} {most}");
                tally.within(off, 1e-5, what);
            }
        }
    }
    Ok(tally)
}

fn few_depths(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "few depths", case);
        for moments in [4_u32, 6] {
            let count = moments / 2 + u32::from(faulty);
            // A quarter of the range apart, but for a tenth either way.
            let depth = |i: u32, by: f32| 0.1 + 0.8 * (i as f32 + by) / count as f32;
            let one = |i| (depth(i, rng.random_range(0.3..0.7)), rng.random_range(0.2..0.8));
            let texel = input::map(1, &[(0..count).map(one).collect()]);
            let fragments = texel.texel(0);
            for i in 0..=count {
                let probe = depth(i, 0.0);
                let truth = reference::exact(fragments, probe);
                let settings = unbiased(moments, 0.5, 1e-10);
                let t = moments::reference(&settings, fragments, None, false, probe);
                tally.within((t - truth).abs(), 1e-3, || format!("{moments} at {probe}"));
            }
        }
    }
    Ok(tally)
}

fn no_bias(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let side = 64_usize;
    for case in 0..context.cases.min(8) {
        let mut rng = input::rng(context.seed, "no bias", case);
        let count = rng.random_range(1..8);
        // The same ray in every texel.
        let one = |_| (rng.random_range(0.1..0.9_f32), rng.random_range(0.05..0.6_f32));
        let ray: Vec<_> = (0..count).map(one).collect();
        let texels = if faulty { 1 } else { side * side };
        let fragments = input::map(1, &vec![ray.clone(); texels]);
        let samples = rng.random_range(1..=32);
        let seed = rng.random_range(0..1000);
        let maps = build(Code::Stochastic(Stochastic { samples, seed }), &fragments)?;
        for depth in [0.5, 1.0] {
            let truth = reference::exact(fragments.texel(0), depth);
            if !(0.02..=0.98).contains(&truth) {
                continue;
            }
            let n = (side * side) as f64;
            let values = || (0..side * side).map(|t| input::at(&maps, t % texels, depth));
            let mean = values().sum::<f64>() / n;
            let variance = values().map(|t| (t - truth).powi(2)).sum::<f64>() / n;
            let expected = truth * (1.0 - truth) / f64::from(samples);
            let what = || format!("{samples} samples of {ray:?} at {depth}: {mean}, not {truth}");
            tally.within((mean - truth).abs(), 5.0 * (expected / n).sqrt(), what);
            tally.within((variance / expected - 1.0).abs(), 1.0 / 3.0, what);
        }
    }
    Ok(tally)
}
