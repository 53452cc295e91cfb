//! H7.8: how many layers it takes to be rid of leaks.

use super::{
    still::{STILLS, Score},
    verdict::{GREY_LEVEL, count, figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_shadows::filtering::{Estimator, Settings, Splits};

/// Numbers of layers there are.
const LAYERS: [u32; 4] = [1, 2, 4, 8];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "gumbau-H7.8",
        statement: "Layered Gaussian and power CDFs reach zero leak with far fewer layers than \
                    layered variance maps, hence with less memory",
        place: "Gumbau 2011, abstract of chapter 7 and section 7.1 (L1848); no numbers are given",
        method: "scenes and settings of H7.1, bias 1e-3, layers of 1, 2, 4 and 8, split evenly and \
                 by Lloyd relaxation: the fewest with a bleed of at most one grey level (1/255; \
                 exactly zero is out of reach of estimators that are positive everywhere). Far \
                 fewer: at most half the layers of LVSM and fewer bytes, for both new methods; \
                 where LVSM needs more than 8, 16 are assumed, the next number. Voted over scenes \
                 and splits where one layer of LVSM bleeds more than that and one of the three \
                 arrives at all: all reproduced, none refuted, else open",
        judge: Box::new(fewer_layers),
    }]
}

/// Fewest layers without a leak: `None` if more than [`LAYERS`] has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Needed {
    lvsm: Option<u32>,
    gaussian: Option<u32>,
    power: Option<u32>,
}

/// Channels of one layer: bytes of a texel are these times layers times the channel's.
const MOMENTS: u32 = 2;
const EXTREMES: u32 = 3;

/// Whether both new methods need at most half; `None` where nothing is to be decided.
fn far_fewer(n: &Needed) -> Option<bool> {
    if n.lvsm == Some(1) || (n.lvsm.is_none() && n.gaussian.is_none() && n.power.is_none()) {
        return None;
    }
    let lvsm = n.lvsm.unwrap_or(16);
    let fewer = |needed: Option<u32>, channels: u32| {
        needed.is_some_and(|layers| 2 * layers <= lvsm && layers * channels < lvsm * MOMENTS)
    };
    Some(fewer(n.gaussian, MOMENTS) && fewer(n.power, EXTREMES))
}

fn decide(all: &[Needed]) -> (Verdict, String) {
    let holds: Vec<bool> = all.iter().filter_map(far_fewer).collect();
    let because = format!(
        "both layered methods need at most half of LVSM's layers in {} cases where LVSM needs more \
         than one",
        count(&holds)
    );
    (vote(&holds), because)
}

fn fewest(bleeds: &[(u32, f64)]) -> Option<u32> {
    bleeds.iter().find(|(_, bleed)| *bleed <= GREY_LEVEL).map(|(layers, _)| *layers)
}

fn fewer_layers(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for recipe in STILLS {
        let still = recipe.still()?;
        for (by, splits) in [("uniform", Splits::Uniform), ("lloyd", Splits::Lloyd)] {
            let mut needed = |name: &str, estimator| -> Result<Option<u32>, SuiteError> {
                let mut bleeds = Vec::new();
                for layers in LAYERS {
                    let s = Settings { layers, ..still.settings(estimator, 1e-3) };
                    let Score { bleed, .. } = still.score(&s)?;
                    let what = format!("{}, {by}: bleed, {name}, {layers} layers", still.name);
                    figures.push(figure(what, bleed, ""));
                    bleeds.push((layers, bleed));
                }
                Ok(fewest(&bleeds))
            };
            all.push(Needed {
                lvsm: needed("LVSM", Estimator::LayeredVsm { splits })?,
                gaussian: needed("layered Gaussian", Estimator::LayeredGaussian { splits })?,
                power: needed("layered power", Estimator::LayeredPower { splits })?,
            });
        }
    }
    let (verdict, because) = decide(&all);
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn needed(lvsm: Option<u32>, gaussian: Option<u32>, power: Option<u32>) -> Needed {
        Needed { lvsm, gaussian, power }
    }

    #[test]
    fn the_first_layer_count_below_the_threshold_counts() {
        assert_eq!(fewest(&[(1, 0.1), (2, 0.003), (4, 0.1)]), Some(2));
        assert_eq!(fewest(&[(1, 0.1), (2, 0.004)]), None);
    }

    #[test]
    fn half_the_layers_and_less_memory() {
        assert_eq!(far_fewer(&needed(Some(4), Some(2), Some(2))), Some(true));
        assert_eq!(far_fewer(&needed(Some(4), Some(4), Some(1))), Some(false));
        assert_eq!(far_fewer(&needed(None, Some(8), Some(8))), Some(true));
        assert_eq!(far_fewer(&needed(None, Some(8), None)), Some(false));
        assert_eq!(far_fewer(&needed(Some(8), None, Some(1))), Some(false));
        // Nothing to decide: no leak to begin with, or nobody arrives.
        assert_eq!(far_fewer(&needed(Some(1), Some(1), Some(1))), None);
        assert_eq!(far_fewer(&needed(None, None, None)), None);
    }

    #[test]
    fn each_verdict_comes_out() {
        let (yes, no) = (needed(Some(8), Some(2), Some(1)), needed(Some(2), Some(2), Some(1)));
        assert_eq!(decide(&[yes]).0, Verdict::Reproduced);
        assert_eq!(decide(&[no]).0, Verdict::Refuted);
        assert_eq!(decide(&[yes, no]).0, Verdict::Open);
        assert_eq!(decide(&[needed(Some(1), Some(1), Some(1))]).0, Verdict::Open);
    }
}
