//! H7.6 and H7.9: many occluders in line, and very complex casters.

use super::{
    scenes::SLATS,
    still::{ESM, Recipe, SPOT, STILLS, VSM},
    timing::on_hardware,
    verdict::{GREY_LEVEL, all_of, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::{EsmSpace, Estimator, Format, Settings};

/// Share of fully shadowed receivers that a visible leak must reach to count as one: below it a
/// picture of 256 columns has a handful of bright pixels.
const FEW: f64 = 1e-3;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "gumbau-H7.6",
            statement: "Exponential shadow maps are fastest but leak on multiple occluders; the \
                        new methods do not leak",
            place: "Gumbau 2011, section 7.3 (L1957 to 1961), figure 7.6, table 7.1",
            method: "bleed (see H7.1) at bias 1e-3 on the scenes of H7.1; to leak is a bleed above \
                     one grey level (1/255): the mean of a full shadow then turns brighter in an \
                     8-bit image. ESM must leak at each exponent of 11, 40 and 80 (none is given), \
                     Gaussian and power must not, each voted over the scenes. Speed on hardware \
                     only: ESM's time at most that of Chebyshev, Gaussian, power f32 and power \
                     f16 at 1024 texels",
            judge: Box::new(esm_leaks),
        },
        Claim {
            id: "gumbau-H7.9",
            statement: "Not all leaks vanish for very complex casters",
            place: "Gumbau 2011, section 7.1 (L1848) and 8.2 (L2087)",
            method: "three scenes of 700 random thin slats, bias 1e-3, settings as H7.1. A leak \
                     remains where at least 0.1 % of the receivers in full shadow exceed the exact \
                     share of their window by more than 0.05: existence is claimed, so visible \
                     spots suffice. Reproduced if leaks remain for both new methods in all scenes, \
                     refuted if for neither in any, else open",
            judge: Box::new(complex_casters),
        },
    ]
}

/// Bleed of one scene: ESM by exponent, then the new methods.
struct Bleeds {
    esm: Vec<f64>,
    gaussian: f64,
    power: f64,
}

/// Whether ESM leaks and the new methods do not.
fn esm_alone_leaks(all: &[Bleeds]) -> (Verdict, String) {
    let old: Vec<bool> = all.iter().map(|b| b.esm.iter().all(|e| *e > GREY_LEVEL)).collect();
    let gaussian: Vec<bool> = all.iter().map(|b| b.gaussian <= GREY_LEVEL).collect();
    let power: Vec<bool> = all.iter().map(|b| b.power <= GREY_LEVEL).collect();
    let because = format!(
        "ESM leaks at every exponent on {} scenes; free of leaks are the Gaussian on {} and the \
         power CDF on {}",
        count(&old),
        count(&gaussian),
        count(&power)
    );
    (all_of(&[vote(&old), vote(&gaussian), vote(&power)]), because)
}

const EXPONENTS: [f32; 3] = [11.0, 40.0, 80.0];

fn esm_leaks(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for recipe in STILLS {
        let still = recipe.still()?;
        let mut bleed = |what: &str, s: Settings| -> Result<f64, SuiteError> {
            let bleed = still.score(&s)?.bleed;
            figures.push(figure(format!("{}: bleed, {what}", still.name), bleed, ""));
            Ok(bleed)
        };
        let mut esm = Vec::new();
        for exponent in EXPONENTS {
            let s = Settings { exponent, ..still.settings(ESM, 1e-3) };
            esm.push(bleed(&format!("ESM, c = {exponent}"), s)?);
        }
        all.push(Bleeds {
            esm,
            gaussian: bleed("Gaussian", still.settings(Estimator::GaussianCdf, 1e-3))?,
            power: bleed("power", still.settings(Estimator::PowerCdf, 1e-3))?,
        });
    }
    let (quality, because) = esm_alone_leaks(&all);
    let still = STILLS[0].still()?;
    let esm = still.settings(Estimator::Esm { space: EsmSpace::Linear }, 1e-3);
    let mut slower = Vec::new();
    for (name, estimator, format) in [
        ("Chebyshev", VSM, Format::F32),
        ("Gaussian", Estimator::GaussianCdf, Format::F32),
        ("power f32", Estimator::PowerCdf, Format::F32),
        ("power f16", Estimator::PowerCdf, Format::F16),
    ] {
        let other = still.settings(estimator, 1e-3).with_format(format);
        let bytes = f64::from(other.bytes_per_texel()) / f64::from(esm.bytes_per_texel());
        figures.push(figure(format!("bytes a texel, {name}/ESM"), bytes, ""));
        if let Some(ratio) = on_hardware(context, &other, &esm)? {
            figures.push(figure(format!("time ratio {name}/ESM, device, 1024"), ratio, ""));
            slower.push(ratio >= 1.0);
        }
    }
    let speed = fastest(&slower);
    Ok(judged(all_of(&[quality, speed]), because, figures))
}

/// Whether every other method is slower; unknown without a timing.
fn fastest(slower: &[bool]) -> Verdict {
    match slower {
        [] => Verdict::NeedsHardware,
        all if all.iter().all(|s| *s) => Verdict::Reproduced,
        _ => Verdict::Refuted,
    }
}

/// Shares of leaking receivers by scene: Gaussian, power.
fn leaks_remain(shares: &[(f64, f64)]) -> (Verdict, String) {
    let all: Vec<bool> = shares.iter().flat_map(|(g, p)| [*g >= FEW, *p >= FEW]).collect();
    let of = |pick: fn(&(f64, f64)) -> f64| {
        count(&shares.iter().map(|s| pick(s) >= FEW).collect::<Vec<_>>())
    };
    let because = format!(
        "leaks remain for the Gaussian in {} scenes and for the power CDF in {}",
        of(|s| s.0),
        of(|s| s.1)
    );
    (vote(&all), because)
}

fn complex_casters(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut shares) = (Vec::new(), Vec::new());
    for seed in 0..3 {
        let still = Recipe::of(SLATS, "", seed).still()?;
        let mut spots = |name: &str, estimator| -> Result<f64, SuiteError> {
            let score = still.score(&still.settings(estimator, 1e-3))?;
            let scene = &still.name;
            let what = format!("{scene}: share of full shadow {SPOT} too bright, {name}");
            figures.push(figure(what, score.spots, ""));
            figures.push(figure(format!("{scene}: bleed, {name}"), score.bleed, ""));
            figures.push(figure(format!("{scene}: leak, {name}"), score.leak, ""));
            Ok(score.spots)
        };
        spots("Chebyshev", VSM)?;
        shares.push((
            spots("Gaussian", Estimator::GaussianCdf)?,
            spots("power", Estimator::PowerCdf)?,
        ));
        let floor = still.exact_leak(&still.settings(VSM, 1e-3))?;
        figures.push(figure(format!("{}: leak of the exact share", still.name), floor, ""));
    }
    let (verdict, because) = leaks_remain(&shares);
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    fn bleeds(esm: f64, gaussian: f64, power: f64) -> Bleeds {
        Bleeds { esm: vec![0.1, esm], gaussian, power }
    }

    #[test]
    fn esm_must_leak_and_the_others_must_not() {
        assert_eq!(esm_alone_leaks(&[bleeds(0.1, 0.001, 0.0)]).0, Reproduced);
        assert_eq!(esm_alone_leaks(&[bleeds(0.1, 0.05, 0.0)]).0, Refuted);
        assert_eq!(esm_alone_leaks(&[bleeds(0.001, 0.001, 0.0)]).0, Refuted);
        let mixed = [bleeds(0.1, 0.001, 0.0), bleeds(0.1, 0.05, 0.0)];
        assert_eq!(esm_alone_leaks(&mixed).0, Open);
        assert_eq!(fastest(&[]), NeedsHardware);
        assert_eq!(fastest(&[true, true]), Reproduced);
        assert_eq!(fastest(&[true, false]), Refuted);
    }

    #[test]
    fn leaks_remain_for_both_one_or_none() {
        assert_eq!(leaks_remain(&[(0.01, 0.001)]).0, Reproduced);
        assert_eq!(leaks_remain(&[(0.01, 0.0)]).0, Open);
        assert_eq!(leaks_remain(&[(0.0009, 0.0)]).0, Refuted);
    }
}
