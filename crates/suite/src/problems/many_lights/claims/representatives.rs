//! What stands for a cluster: its weighted middle, or one of its lights by chance.

use super::super::LightsCase;
use super::{
    precuts::lighting,
    support::{COARSE, RGB, prepared, run_of},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    problem::Form,
};
use dapple_many_lights::{
    BoundForm, LightTree, Shaded,
    cut::{Method, Rule},
    luminance,
    tree::{Build, Representative},
};
use glam::DVec3;
use std::sync::Arc;

/// Trees by chance.
const SEEDS: u64 = 64;

/// Standard errors within which a mean is the truth's.
const MOST_Z: f64 = 4.0;

/// Share of the truth beyond which a mean is off whatever its standard error.
const MOST_BIAS: f64 = 0.01;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H3.11",
        statement: "A weighted mean as representative is the same every time; one drawn by intensity \
                    varies, and its mean over the image is unbiased",
        place: "Conte 2018, section 3.3, after Paquette et al. 1998 and Walter et al. 2005",
        method: "the small city, close-ended street, Walter's metric among neighbours, R4 at \
                 T = 1/1020: 64 seeds each, mean luminance at 256 pixels. Met if the weighted one \
                 gives one image, the drawn one varies by 1/255 or more at some pixel (standard \
                 deviation), and its mean is within 4 standard errors of all lights. Contradicted if \
                 the weighted one varies, the drawn one does not, or its mean is beyond both 4 \
                 standard errors and 1 %",
        judge: Box::new(representatives),
    }]
}

/// What images of many seeds show.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// The greatest difference of any seed's image from the first's, deterministic.
    fixed: f64,
    /// The greatest standard deviation of a pixel, by chance, linear.
    varies: f64,
    /// Standard errors between the mean by chance and the truth.
    z: f64,
    /// That distance over the truth.
    bias: f64,
}

fn as_said(seen: Seen) -> Verdict {
    let fixed = if seen.fixed == 0.0 { Verdict::Reproduced } else { Verdict::Refuted };
    let varies = if seen.varies >= RGB {
        Verdict::Reproduced
    } else if seen.varies > 0.0 {
        Verdict::Open
    } else {
        Verdict::Refuted
    };
    // Written so that a NaN contradicts.
    let unbiased = if seen.z.abs() <= MOST_Z {
        Verdict::Reproduced
    } else if seen.bias.abs() <= MOST_BIAS {
        Verdict::Open
    } else {
        Verdict::Refuted
    };
    all_of(&[fixed, varies, unbiased])
}

/// Luminance at the truth's pixels.
fn luminances(
    case: &LightsCase<'_>,
    representative: Representative,
) -> Result<(Vec<f64>, Shaded), SuiteError> {
    let world = case.world();
    let build = Build::LocallyOrdered { spread: 1.0 };
    let tree = Arc::new(LightTree::build(&world.lights, build, representative)?);
    let method = Method::Rule(Rule::Absolute(COARSE), BoundForm::Cheap);
    let mut cut = lighting(Form::Cpu, world, &tree, None, method, None)?;
    let mut run = run_of(case, &mut *cut, 0)?;
    let shaded = run.frames.swap_remove(0);
    let of = |(pixel, _): (u32, DVec3)| luminance(shaded.radiance[pixel as usize].as_dvec3());
    Ok((case.truth().frame(0).map(of).collect(), shaded))
}

/// Mean and standard deviation, of a sample.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, variance.sqrt())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn representatives(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared("city_small", "close_ended", &[])?;
    let truth: Vec<f64> = case.truth().frame(0).map(|(_, exact)| luminance(exact)).collect();
    let (weighted, first) = luminances(&case, Representative::Weighted)?;
    let again = luminances(&case, Representative::Weighted)?.1;
    let differ = first.radiance.iter().zip(&again.radiance);
    let fixed = differ.map(|(a, b)| f64::from((*a - *b).abs().max_element())).fold(0.0, f64::max);
    let mut by_seed = Vec::new();
    for seed in 0..SEEDS {
        by_seed.push(luminances(&case, Representative::Random { seed })?.0);
    }
    let means: Vec<f64> = by_seed.iter().map(|pixels| mean(pixels)).collect();
    let (at, deviation) = moments(&means);
    let (exact, count) = (mean(&truth), SEEDS as f64);
    let pixel =
        |index: usize| moments(&by_seed.iter().map(|pixels| pixels[index]).collect::<Vec<_>>()).1;
    let varies = (0..truth.len()).map(pixel).fold(0.0, f64::max);
    let bias = (at - exact) / exact;
    let seen = Seen { fixed, varies, z: (at - exact) / (deviation / count.sqrt()), bias };
    let figures = vec![
        figure("mean luminance of all lights", exact, ""),
        figure("weighted: greatest difference between builds", fixed, ""),
        figure(
            "weighted: mean luminance over that of all lights, less one",
            mean(&weighted) / exact - 1.0,
            "",
        ),
        figure("by chance: mean luminance over that of all lights, less one", bias, ""),
        figure("by chance: the same in standard errors", seen.z, ""),
        figure("by chance: greatest standard deviation of a pixel", varies / RGB, "1/255"),
        figure("by chance: standard deviation of an image's mean, over it", deviation / at, ""),
    ];
    let because = format!(
        "by chance the mean is {:.2} % off, {:.1} standard errors; a pixel varies by up to {:.1} / \
         255",
        100.0 * bias,
        seen.z,
        varies / RGB
    );
    Ok(judged(as_said(seen), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn chance_varies_and_is_unbiased_or_not() {
        let seen = Seen { fixed: 0.0, varies: 0.1, z: 1.0, bias: 0.001 };
        assert_eq!(as_said(seen), Reproduced);
        assert_eq!(as_said(Seen { z: 9.0, ..seen }), Open);
        assert_eq!(as_said(Seen { z: 9.0, bias: 0.1, ..seen }), Refuted);
        assert_eq!(as_said(Seen { z: f64::NAN, bias: f64::NAN, ..seen }), Refuted);
        assert_eq!(as_said(Seen { varies: 1e-5, ..seen }), Open);
        assert_eq!(as_said(Seen { varies: 0.0, ..seen }), Refuted);
        assert_eq!(as_said(Seen { fixed: 1e-9, ..seen }), Refuted);
    }

    #[test]
    fn moments_are_those_of_a_sample() {
        assert_eq!(moments(&[1.0, 3.0]), (2.0, 2.0_f64.sqrt()));
        assert_eq!(mean(&[]), 0.0);
    }
}
