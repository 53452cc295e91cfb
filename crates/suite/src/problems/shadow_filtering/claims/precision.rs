//! H7.3 and D7.4: what 16 bits do to each estimator.

use super::{
    still::{BIASES, SPOT, STILLS, VSM},
    verdict::{all_of, figure, judged, near, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged},
};
use dapple_metrics::{rmse, stats};
use dapple_shadows::filtering::{Estimator, Format, Settings};

/// Root mean squared difference of 30 dB: compression at this ratio shows.
const SHOWS: f64 = 0.031_622_8;
/// Of 40 dB: two and a half grey levels, taken for equal.
const HIDDEN: f64 = 0.01;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H7.3",
            statement: "With 16 bits a channel Chebyshev and the Gaussian break, the power CDF \
                        does not",
            place: "Gumbau 2011, section 7.3, figure 7.2",
            method: "half floats against floats, all else equal, no least variance (none is \
                     given), settings and scenes of H7.1, cpu form: root mean squared difference \
                     of the two images, median over the ten stills. Broken: 0.032 and more (30 \
                     dB); unbroken: 0.01 and less (40 dB, two and a half grey levels). A bias \
                     agrees if Chebyshev and the Gaussian are broken and the power CDF is \
                     unbroken, contradicts if one of the two is unbroken or the power CDF broken, \
                     else it is open. The bias is not given: reproduced if those of 5e-4, 1e-3, \
                     2e-3 and 5e-3 all agree, refuted if all contradict, else open. With the least \
                     variance that half floats get by default the differences are printed beside \
                     it. The map's depth range fits the scene: the kindest case for 16 bits",
            judge: Box::new(half_floats),
        },
        Claim {
            id: "gumbau-D7.4",
            statement: "Near a depth of 0.9 the noise of M2 - M1^2 reaches a deviation of 0.026 in \
                        half floats and 3e-4 in floats",
            place: "Follows from Gumbau 2011, eq. 2.1, and the formats' rounding",
            method: "windows of one depth, 200,000 depths from 0.89 to 0.91: the largest \
                     sqrt(|M2 - M1^2|) with both moments rounded to the format, the difference in \
                     f64; within 10 % of 0.026 and 2.9e-4: the derivation rounds to two digits",
            judge: Box::new(moment_noise),
        },
    ]
}

/// Differences at one bias: Chebyshev, Gaussian, power. `None` where one of them neither shows nor
/// hides.
fn breaks_as_stated([vsm, gaussian, power]: [f64; 3]) -> Option<bool> {
    if vsm <= HIDDEN || gaussian <= HIDDEN || power >= SHOWS {
        Some(false)
    } else if vsm >= SHOWS && gaussian >= SHOWS && power <= HIDDEN {
        Some(true)
    } else {
        None
    }
}

fn half_floats(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let methods =
        [("Chebyshev", VSM), ("Gaussian", Estimator::GaussianCdf), ("power", Estimator::PowerCdf)];
    let (mut figures, mut cases, mut words) = (Vec::new(), Vec::new(), Vec::new());
    for bias in BIASES {
        let mut differences = [0.0; 3];
        for (difference, (name, estimator)) in differences.iter_mut().zip(methods) {
            let (mut plain, mut eased) = (Vec::new(), Vec::new());
            let (mut added, mut seen) = (Vec::new(), Vec::new());
            for recipe in STILLS {
                let still = recipe.still()?;
                let mask = Some(still.mask.as_slice());
                let full = Settings { min_variance: 0.0, ..still.settings(estimator, bias) };
                let half = Settings { format: Format::F16, ..full };
                let (full, half) = (still.shade(&full)?, still.shade(&half)?);
                plain.push(rmse(&full, &half, mask)?);
                added.push(rmse(&half, &still.truth, mask)? - rmse(&full, &still.truth, mask)?);
                let receivers = still.mask.iter().filter(|m| **m).count() as f64;
                let pairs = full.iter().zip(&half).zip(&still.mask);
                let off = pairs.filter(|((a, b), m)| **m && (**a - **b).abs() > SPOT).count();
                seen.push(off as f64 / receivers);
                let full = still.settings(estimator, bias);
                let half = full.with_format(Format::F16);
                eased.push(rmse(&still.shade(&full)?, &still.shade(&half)?, mask)?);
            }
            *difference = stats::median(&plain)?;
            let mut add = |what: &str, value: f64| {
                figures.push(figure(format!("{name}, bias {bias}: {what}"), value, ""));
            };
            add("difference f16 to f32", *difference);
            add("share of receivers off by more than 0.05", stats::median(&seen)?);
            add("the same with default least variances", stats::median(&eased)?);
            add("rmse against truth, f16 less f32", stats::median(&added)?);
        }
        cases.push(breaks_as_stated(differences));
        let [vsm, gaussian, power] = differences.map(|d| -20.0 * d.max(1e-9).log10());
        words.push(format!("{vsm:.0}, {gaussian:.0} and {power:.0}"));
    }
    let because = format!(
        "f16 is {} dB from f32 for Chebyshev, Gaussian and power at the four biases; broken is 30, \
         unbroken 40",
        words.join("; ")
    );
    Ok(judged(vote_open(&cases), because, figures))
}

/// Largest deviation that rounding feigns in windows of one depth near `centre`.
fn feigned_deviation(format: Format, centre: f64) -> f64 {
    let steps = 200_000;
    let variance = |i: i32| {
        let z = centre - 0.01 + 0.02 * f64::from(i) / f64::from(steps);
        let m1 = format.round(z);
        (format.round(z * z) - m1 * m1).abs()
    };
    (0..=steps).map(variance).fold(0.0, f64::max).sqrt()
}

fn moment_noise(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (half, full) = (feigned_deviation(Format::F16, 0.9), feigned_deviation(Format::F32, 0.9));
    let verdicts = [near(&[(half, 0.026, 0.0026)]), near(&[(full, 2.9e-4, 2.9e-5)])];
    let figures = vec![
        figure("half floats, depths 0.89 to 0.91: largest feigned deviation", half, "depth"),
        figure("floats, the same", full, "depth"),
        figure("half floats: step of a stored depth there", 2.0_f64.powi(-11), "depth"),
    ];
    let because = format!("{half:.4} in half floats and {full:.2e} in floats");
    Ok(judged(all_of(&verdicts), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Verdict;

    #[test]
    fn broken_means_both_and_not_the_third() {
        assert_eq!(breaks_as_stated([0.1, 0.1, 0.005]), Some(true));
        assert_eq!(breaks_as_stated([0.1, 0.1, 0.05]), Some(false));
        assert_eq!(breaks_as_stated([0.1, 0.005, 0.005]), Some(false));
        assert_eq!(breaks_as_stated([0.005, 0.1, 0.005]), Some(false));
        // Neither broken nor unbroken.
        assert_eq!(breaks_as_stated([0.1, 0.1, 0.02]), None);
        assert_eq!(breaks_as_stated([0.02, 0.1, 0.005]), None);
    }

    #[test]
    fn noise_by_hand() {
        // Half a step of 2^-11 on M2, and 2 z times that on M1: 2^-12 (1 + 1.8) squared depth.
        let expected = (2.8 * 2.0_f64.powi(-12)).sqrt();
        let got = feigned_deviation(Format::F16, 0.9);
        assert!((got / expected - 1.0).abs() < 0.05, "{got} {expected}");
        // At small depths the formats are finer.
        assert!(feigned_deviation(Format::F16, 0.1) < 0.2 * got);
        assert_eq!(near(&[(0.5 * got, 0.026, 0.0026)]), Verdict::Refuted);
    }
}
