//! H7.2 and H7.7: what the methods cost.

use super::{
    scenes::{SPHERES_COARSE, SPHERES_FINE},
    still::{RESOLUTION, Recipe, VSM},
    timing,
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::{Counters, Estimator, Format, Settings};

/// Slack of a time ratio that is said to be at most 1.
const SAME: f64 = 1.05;

/// Bounds of power f32 over Chebyshev f32 in table 7.1, 1.15 to 1.73, rounded outwards.
const SLOWER: std::ops::RangeInclusive<f64> = 1.1..=1.8;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H7.2",
            statement: "The power CDF in 16 bits costs no more than Chebyshev in 32 from 1024 \
                        texels up; in 32 bits it is 1.1 to 1.7 times slower",
            place: "Gumbau 2011, section 7.3, table 7.1",
            method: "filter and shade of the car at 1920 columns and maps of 512, 1024 and 2048, \
                     the same window of 7 texels (none is given), device clock, median of 31 \
                     interleaved pairs, depth pass excluded. Reproduced if power f16 takes at most \
                     1.05 of Chebyshev's time (noise of a few per cent) at 1024 and 2048 and power \
                     f32 1.1 to 1.8 (table 7.1: 1.15 to 1.73) at all three; refuted if f16 is \
                     slower at both or f32 is not slower anywhere; else open. Judged on hardware \
                     only: the cpu form keeps 16-bit channels in f32",
            judge: Box::new(power_cost),
        },
        Claim {
            id: "gumbau-H7.7",
            statement: "Cost does not depend on the geometry, only on the sizes of screen and map",
            place: "Gumbau 2011, section 7.3 (L1947)",
            method: "the 16 spheres of 80 triangles each against the same of 20,480 each, 256 px, \
                     map 512, cpu form, Chebyshev and power: texels read and bytes moved by the \
                     pre-filter must be equal and so must the texels a receiver reads; the median \
                     of 31 paired time ratios must lie within 10 % of 1 (the triangles differ \
                     256-fold), and is open where three times its median absolute deviation \
                     exceeds that 10 %, as on a busy machine. \
                     The depth pass, which does depend on geometry, is no part of the methods",
            judge: Box::new(geometry),
        },
    ]
}

/// Time ratios to Chebyshev f32 at 512, 1024 and 2048: power f16, power f32.
fn by_table(ratios: &[(f64, f64)]) -> Verdict {
    let [_, larger @ ..] = ratios else { return Verdict::NeedsHardware };
    let cheap = |(half, _): &(f64, f64)| *half <= SAME;
    let slower = |(_, full): &(f64, f64)| SLOWER.contains(full);
    if larger.iter().all(cheap) && ratios.iter().all(slower) {
        Verdict::Reproduced
    } else if !larger.iter().any(cheap) || ratios.iter().all(|(_, full)| *full <= 1.0) {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn power_cost(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let car = Recipe::of("car", "", 0);
    let settings = |estimator, format| {
        Settings { width_texels: 7, plane_bias: true, ..Settings::new(estimator) }
            .with_format(format)
    };
    let vsm = settings(VSM, Format::F32);
    let half = settings(Estimator::PowerCdf, Format::F16);
    let full = settings(Estimator::PowerCdf, Format::F32);
    let bytes = |s: &Settings| f64::from(s.bytes_per_texel()) / f64::from(vsm.bytes_per_texel());
    let mut figures = vec![
        figure("bytes a texel, power f16/Chebyshev f32", bytes(&half), ""),
        figure("bytes a texel, power f32/Chebyshev f32", bytes(&full), ""),
    ];
    let small = car.timed(256, RESOLUTION).still()?;
    let (cpu, [a, b]) = timing::cpu((&small, &full), (&small, &vsm))?;
    figures.push(figure("time ratio power f32/Chebyshev f32, cpu form, 512", cpu.median, ""));
    figures.push(figure("the same, median absolute deviation", cpu.mad, ""));
    let moved = |c: &Counters| (c.bytes_read + c.bytes_written) as f64;
    figures.push(figure("bytes moved, the same", moved(&a) / moved(&b), ""));
    let mut ratios = Vec::new();
    if let Some(gpu) = context.gpu {
        // A software adapter is timed small, for its figure alone.
        let (width, sizes): (u32, &[u32]) =
            if context.hardware { (1920, &[512, 1024, 2048]) } else { (256, &[512]) };
        for &size in sizes {
            let still = car.timed(width, size).still()?;
            let pair = (
                timing::gpu(gpu, &still, &half, &vsm)?.median,
                timing::gpu(gpu, &still, &full, &vsm)?.median,
            );
            let on = if context.hardware { "device" } else { "software adapter" };
            figures.push(figure(format!("time ratio power f16, {on}, {size}"), pair.0, ""));
            figures.push(figure(format!("time ratio power f32, {on}, {size}"), pair.1, ""));
            ratios.push(pair);
        }
    }
    let verdict = if context.hardware { by_table(&ratios) } else { Verdict::NeedsHardware };
    let because = match verdict {
        Verdict::NeedsHardware => "times are judged on hardware; bytes a texel are 0.75 and 1.5 \
                                   of Chebyshev's"
            .to_string(),
        _ => format!("power f16 and f32 over Chebyshev at 512, 1024, 2048: {ratios:.2?}"),
    };
    Ok(judged(verdict, because, figures))
}

/// Whether the work is the same: pre-filter texels and shade texels a receiver.
fn same_work([a, b]: [Counters; 2], [receivers_a, receivers_b]: [usize; 2]) -> Verdict {
    let prefilter = a.prefilter_texels == b.prefilter_texels && a.bytes_written == b.bytes_written;
    // Cross-multiplied: equal texels a receiver.
    let shade = u128::from(a.shade_texels) * receivers_b as u128
        == u128::from(b.shade_texels) * receivers_a as u128;
    if prefilter && shade { Verdict::Reproduced } else { Verdict::Refuted }
}

fn same_time(ratio: f64, mad: f64) -> Verdict {
    match (ratio - 1.0).abs() <= 0.1 {
        _ if 3.0 * mad > 0.1 => Verdict::Open,
        true => Verdict::Reproduced,
        false => Verdict::Refuted,
    }
}

fn geometry(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let small = |name| Recipe::of(name, "", 0).timed(256, RESOLUTION).still();
    let (coarse, fine) = (small(SPHERES_COARSE)?, small(SPHERES_FINE)?);
    let taking_part = |mask: &[bool]| mask.iter().filter(|m| **m).count();
    let receivers = [taking_part(&fine.mask), taking_part(&coarse.mask)];
    let mut figures = vec![
        figure("triangles, coarse", coarse.triangles as f64, ""),
        figure("triangles, fine", fine.triangles as f64, ""),
    ];
    let mut parts = Vec::new();
    for (name, estimator) in [("Chebyshev", VSM), ("power", Estimator::PowerCdf)] {
        let s = coarse.settings(estimator, 1e-3);
        let (ratio, counters) = timing::cpu((&fine, &s), (&coarse, &s))?;
        let prefilter = counters[0].prefilter_texels as f64 / counters[1].prefilter_texels as f64;
        let shade = |i: usize| counters[i].shade_texels as f64 / receivers[i] as f64;
        figures.push(figure(format!("{name}: pre-filter texels, fine/coarse"), prefilter, ""));
        figures.push(figure(format!("{name}: texels a receiver, fine"), shade(0), ""));
        figures.push(figure(format!("{name}: texels a receiver, coarse"), shade(1), ""));
        figures.push(figure(format!("{name}: time, fine/coarse, cpu form"), ratio.median, ""));
        figures.push(figure("the same, median absolute deviation", ratio.mad, ""));
        parts.extend([same_work(counters, receivers), same_time(ratio.median, ratio.mad)]);
    }
    let times = figures.iter().filter(|f| f.what.contains("time,")).map(|f| f.value);
    let because = format!(
        "256 times the triangles: time ratios {:.3?}, counters {}",
        times.collect::<Vec<_>>(),
        if parts.iter().step_by(2).all(|p| *p == Verdict::Reproduced) { "equal" } else { "differ" }
    );
    Ok(judged(all_of(&parts), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn the_tables_own_times_reproduce_it() {
        // Frames a second of table 7.1.
        let table = [
            (481.0 / 468.0, 481.0 / 420.0),
            (342.0 / 381.0, 342.0 / 243.0),
            (142.0 / 160.0, 142.0 / 82.0),
        ];
        assert_eq!(by_table(&table), Reproduced);
        assert_eq!(by_table(&[]), NeedsHardware);
        assert_eq!(by_table(&[(1.0, 1.2), (1.2, 1.4), (1.3, 1.6)]), Refuted);
        assert_eq!(by_table(&[(0.9, 0.9), (0.9, 1.0), (0.9, 0.8)]), Refuted);
        assert_eq!(by_table(&[(1.0, 1.2), (1.2, 1.4), (0.9, 1.6)]), Open);
        assert_eq!(by_table(&[(1.0, 1.0), (0.9, 1.4), (0.9, 1.6)]), Open);
    }

    #[test]
    fn a_software_adapter_gives_figures_but_no_verdict() {
        let Some(gpu) = dapple_gpu::testing::test_gpu() else { return };
        let context = ClaimContext { gpu: Some(gpu), hardware: false };
        let judged = power_cost(&context).unwrap();
        assert_eq!(judged.verdict, NeedsHardware);
        let timed = judged.figures.iter().filter(|f| f.what.contains("software adapter"));
        assert_eq!(timed.filter(|f| f.value > 0.0).count(), 2);
    }

    #[test]
    fn work_and_time_must_both_be_the_same() {
        let a = Counters { prefilter_texels: 100, shade_texels: 40, ..Counters::default() };
        let b = Counters { shade_texels: 80, ..a };
        assert_eq!(same_work([a, b], [10, 20]), Reproduced);
        assert_eq!(same_work([a, b], [10, 10]), Refuted);
        let more = Counters { prefilter_texels: 101, ..a };
        assert_eq!(same_work([a, more], [10, 10]), Refuted);
        assert_eq!(same_time(1.08, 0.0), Reproduced);
        assert_eq!(same_time(1.2, 0.01), Refuted);
        assert_eq!(same_time(1.2, 0.1), Open);
        assert_eq!(same_time(1.0, 0.1), Open);
    }
}
