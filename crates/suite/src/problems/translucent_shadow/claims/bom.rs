//! H5.1 to H5.3: layers between both ends of each ray, against layers that begin at one.

use super::{
    osm_packing::timed,
    support::{Method, SCENES, Still, bom, bom_split, dom, still, thesis_bins},
    verdict::{GREY_LEVEL, all_of, count, figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
};
use dapple_opacity_maps::{Lookup, Receiver, SplitKind, layered::placement::THINNEST, taps};

/// Layers in the source's figures.
const LAYERS: u32 = 16;

/// Span of the first published deep opacity maps of the author, of the light's depth range.
const PUBLISHED_SPAN: f32 = 1.0 / 9.36;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H5.1",
            statement: "Bounding opacity maps use the whole length: every ray reaches the last \
                        layer; deep opacity maps do not",
            place: "Voicu 2011, section 5, figure 5.4",
            method: "16 layers on ten scenes; rays that meet surfaces at two depths or more. Reaches: \
                     the last layer holds a fragment. Reproduced if with K bins all rays of all \
                     scenes reach it, and with deep opacity maps over the deepest ray in no scene \
                     all do; refuted if some ray does not with bounds, or all do with deep maps \
                     everywhere. The printed K - 1 bins with biased fragments are shown",
            judge: Box::new(whole_length),
        },
        Claim {
            id: "voicu-H5.2",
            statement: "Deep opacity maps falsely shadow what lies in their last layer, bounding \
                        opacity maps do not",
            place: "Voicu 2011, section 5, figure 5.5",
            method: "16 layers, one tap, interpolated; translucent receivers that the deep maps put \
                     in their last layer, with the author's first published span (1/9.36 of the \
                     range) and half the deepest ray; cases with fewer than 100 of them are left \
                     out. False shadow: mean of the light that is missing against the deep shadow \
                     map of the same texels. A case agrees if deep maps miss more than a grey level \
                     (1/255) and bounds at most half as much, contradicts if bounds miss as much or \
                     more, else is open. The own layer's sum, the literal form, is shown; so is \
                     light too much, which a last layer that is read in part lets in",
            judge: Box::new(false_shadow),
        },
        Claim {
            id: "voicu-H5.3",
            statement: "For equal error bounding opacity maps need fewer layers than deep ones, \
                        enough to pay for their extra pass",
            place: "Voicu 2011, section 5.1",
            method: "seven scenes, error against the deep shadow map of the same texels, 3 x 3 taps, \
                     own best lookup. Deep maps of 4 and 16 layers over the deepest ray against \
                     even bounding maps (what a program can know), and at their best of eight spans \
                     against bounding maps at their best of five lambdas. Least K of 1, 2, 3, 4, 6, \
                     8, 12, 16 whose error is no greater; fewer: below the deep maps'. Voted over \
                     scenes and settings. Pays: on hardware, bounding maps of that many layers take \
                     less time than the deep maps of 16 on grass, by three median deviations. The \
                     printed bins are shown",
            judge: Box::new(fewer_layers),
        },
    ]
}

/// Shares of rays that reach the last layer, scene by scene: bounding and deep.
fn reached(rows: &[(f64, f64)]) -> (Verdict, String) {
    let all: Vec<bool> = rows.iter().map(|(bounding, _)| *bounding == 1.0).collect();
    let short: Vec<bool> = rows.iter().map(|(_, deep)| *deep < 1.0).collect();
    let because = format!(
        "all rays reach the last layer in {} scenes with bounds; in {} some do not with deep maps",
        count(&all),
        count(&short)
    );
    let bounding = if all.contains(&false) { Verdict::Refuted } else { vote(&all) };
    (all_of(&[bounding, vote(&short)]), because)
}

/// Share of rays of some depth whose last layer holds a fragment.
fn share_reached(still: &Still, method: &Method) -> Result<f64, SuiteError> {
    let (maps, exact) = (still.maps(method)?, still.exact(method)?);
    let (mut deep, mut reached) = (0_u64, 0_u64);
    for texel in 0..maps.texels() {
        if !exact.ends(texel).is_some_and(|(near, far)| far - near >= THINNEST) {
            continue;
        }
        let words = maps.texel(texel);
        deep += 1;
        reached += u64::from(words[words.len() - 1] > words[words.len() - 2]);
    }
    Ok(reached as f64 / deep.max(1) as f64)
}

fn whole_length(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows, mut printed) = (Vec::new(), Vec::new(), 0.0_f64);
    for scene in SCENES {
        let still = still(scene)?;
        let deep = dom(LAYERS, still.deepest()?);
        let mut shares = [0.0; 3];
        let forms =
            [("bounding", bom(LAYERS)), ("deep", deep), ("printed", thesis_bins(bom(LAYERS)))];
        for (slot, (name, method)) in shares.iter_mut().zip(forms) {
            *slot = share_reached(&still, &method)?;
            figures.push(figure(format!("{scene}, {name}: rays in the last layer"), *slot, ""));
            let idle = still.score(&method)?.idle;
            figures.push(figure(format!("{scene}, {name}: empty cells"), idle, ""));
        }
        rows.push((shares[0], shares[1]));
        printed = printed.max(shares[2]);
    }
    let (verdict, because) = reached(&rows);
    let because = format!("{because}; with the printed bins at most {printed:.2} of the rays do");
    Ok(judged(verdict, because, figures))
}

/// Light missing in a case: with deep and with bounding maps.
fn falsely(cases: &[(f64, f64)]) -> (Verdict, String) {
    let one = |(deep, bounding): &(f64, f64)| {
        if *deep > GREY_LEVEL && *bounding <= 0.5 * deep {
            Some(true)
        } else {
            (bounding >= deep).then_some(false)
        }
    };
    let found: Vec<Option<bool>> = cases.iter().map(one).collect();
    let agree: Vec<bool> = found.iter().map(|f| *f == Some(true)).collect();
    let less: Vec<bool> = cases.iter().map(|(deep, bounding)| bounding < deep).collect();
    let because = format!(
        "bounds miss at most half the light that deep maps miss in {} cases, and less in {}",
        count(&agree),
        count(&less)
    );
    (vote_open(&found), because)
}

/// Mean light missing and too much over some receivers.
fn missing(still: &Still, method: &Method, chosen: &[usize]) -> Result<(f64, f64), SuiteError> {
    let (result, deep) = (still.shade(&still.maps(method)?)?, still.deep(method)?);
    let sum = |sign: f64| {
        let one = |i: &usize| (sign * (f64::from(deep[*i]) - f64::from(result[*i]))).max(0.0);
        chosen.iter().map(one).sum::<f64>() / chosen.len().max(1) as f64
    };
    Ok((sum(1.0), sum(-1.0)))
}

/// Translucent receivers in the last layer of deep maps of a span.
fn in_last_layer(still: &Still, method: &Method, span: f32) -> Result<Vec<usize>, SuiteError> {
    let exact = still.exact(method)?;
    let receivers = still.receivers();
    let begins = span * (LAYERS - 1) as f32 / LAYERS as f32;
    let is_last = |receiver: &Receiver| {
        if !receiver.in_map() || receiver.flags & Receiver::OPAQUE != 0 {
            return false;
        }
        let texel = taps::own(receiver, method.resolution, method.resolution);
        let depth = receiver.depth - method.settings.bias;
        exact.ends(texel).is_some_and(|(first, _)| depth >= first + begins)
    };
    Ok((0..receivers.len()).filter(|i| is_last(&receivers[*i])).collect())
}

fn false_shadow(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    for scene in ["grass", "grass_sparse", "grass_dense", "tree", "willow", "hair", "mixed"] {
        let still = still(scene)?;
        for (name, span) in
            [("published span", PUBLISHED_SPAN), ("half the deepest", 0.5 * still.deepest()?)]
        {
            let deep = dom(LAYERS, span).one_tap();
            let bounding = bom(LAYERS).one_tap();
            let chosen = in_last_layer(&still, &deep, span)?;
            let what = format!("{scene}, {name}");
            let n = chosen.len() as f64;
            figures.push(figure(format!("{what}: receivers in the last layer"), n, ""));
            if chosen.len() < 100 {
                continue;
            }
            let mut case = [0.0; 2];
            for (slot, (form, method)) in
                case.iter_mut().zip([("deep", deep), ("bounding", bounding)])
            {
                let literal = method.clone().lookup(Lookup::Nearest);
                for (reading, method) in [("", method), (", literal", literal)] {
                    let (dark, leak) = missing(&still, &method, &chosen)?;
                    let told = format!("{what}, {form}{reading}");
                    figures.push(figure(format!("{told}: light missing"), dark, ""));
                    figures.push(figure(format!("{told}: light too much"), leak, ""));
                    if reading.is_empty() {
                        *slot = dark;
                    }
                }
            }
            cases.push((case[0], case[1]));
        }
    }
    let (verdict, because) = falsely(&cases);
    Ok(judged(verdict, because, figures))
}

/// Layers tried.
const TRIED: [u32; 8] = [1, 2, 3, 4, 6, 8, 12, 16];

/// Deep layers, and the least number of bounding ones as good: none if no tried number is.
type Needed = (u32, Option<u32>);

fn fewer(cases: &[Needed]) -> (Verdict, String) {
    let holds: Vec<bool> =
        cases.iter().map(|(deep, least)| least.is_some_and(|least| least < *deep)).collect();
    let because = format!("fewer layers are enough in {} cases", count(&holds));
    (vote(&holds), because)
}

/// The least K of bounding maps as good as an error; `lambdas` are tried at each.
fn least_layers(
    still: &Still,
    error: f64,
    most: u32,
    lambdas: &[f32],
    change: impl Fn(Method) -> Method,
) -> Result<Option<u32>, SuiteError> {
    for layers in TRIED.into_iter().filter(|k| *k <= most) {
        for lambda in lambdas {
            let method = change(bom_split(layers, *lambda, SplitKind::Normalised));
            if still.best_lookup(&method)?.1 <= error {
                return Ok(Some(layers));
            }
        }
    }
    Ok(None)
}

/// A number of layers as a figure: none is twice the most.
fn told(what: String, deep: u32, least: Option<u32>) -> Figure {
    figure(what, f64::from(least.unwrap_or(2 * deep)), "")
}

fn fewer_layers(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    const TUNED: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
    let (mut figures, mut cases) = (Vec::new(), Vec::new());
    let mut on_grass = None;
    for scene in ["grass", "grass_dense", "tree", "willow", "hair", "mixed", "two_far"] {
        let still = still(scene)?;
        for deep in [4, 16] {
            let plain = still.best_lookup(&dom(deep, still.deepest()?))?;
            let tuned = still.best_dom(deep, |method| method)?;
            for (name, (method, error), lambdas) in
                [("untuned", plain, &TUNED[..1]), ("tuned", tuned, &TUNED[..])]
            {
                let what = format!("{scene}, {name}");
                let least = least_layers(&still, error, deep, lambdas, |method| method)?;
                figures.push(figure(format!("{what}, {deep} deep: error"), error, ""));
                let as_good = format!("{what}: bounding layers as good as {deep} deep");
                figures.push(told(as_good.clone(), deep, least));
                if name == "untuned" {
                    let printed = least_layers(&still, error, deep, lambdas, |method| {
                        if method.layers() > 1 { thesis_bins(method) } else { method }
                    })?;
                    figures.push(told(format!("{as_good}, printed bins"), deep, printed));
                }
                if (scene, deep, name) == ("grass", 16, "untuned") {
                    on_grass = least.map(|layers| (method, bom(layers)));
                }
                cases.push((deep, least));
            }
        }
    }
    let (layers, mut because) = fewer(&cases);
    let grass = still("grass")?;
    let mut time = Verdict::Refuted;
    if let Some((deep, bounding)) = on_grass {
        let hardware = timed(
            context,
            &grass,
            "bounding over deep maps as good",
            (&bounding, &deep),
            &mut figures,
        )?;
        time = super::osm_packing::faster(hardware);
    }
    because += match time {
        Verdict::NeedsHardware => "; whether they pay needs hardware",
        Verdict::Reproduced => "; they pay for the pass",
        Verdict::Open => "; times do not tell whether they pay",
        Verdict::Refuted => "; they do not pay for the pass",
    };
    Ok(judged(all_of(&[layers, time]), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn every_ray_must_reach_the_last_layer_and_deep_maps_must_not() {
        assert_eq!(reached(&[(1.0, 0.2), (1.0, 0.0)]).0, Reproduced);
        assert_eq!(reached(&[(1.0, 0.2), (0.999, 0.0)]).0, Refuted);
        assert_eq!(reached(&[(1.0, 1.0), (1.0, 1.0)]).0, Refuted);
        assert_eq!(reached(&[(1.0, 1.0), (1.0, 0.5)]).0, Open);
    }

    #[test]
    fn shadow_must_be_false_and_halved() {
        assert_eq!(falsely(&[(0.1, 0.05)]).0, Reproduced);
        assert_eq!(falsely(&[(0.1, 0.06)]).0, Open);
        assert_eq!(falsely(&[(0.003, 0.001)]).0, Open);
        assert_eq!(falsely(&[(0.1, 0.1)]).0, Refuted);
        assert_eq!(falsely(&[]).0, Open);
    }

    #[test]
    fn as_many_layers_are_not_fewer() {
        assert_eq!(fewer(&[(4, Some(2)), (16, Some(12))]).0, Reproduced);
        assert_eq!(fewer(&[(4, Some(4)), (16, None)]).0, Refuted);
        assert_eq!(fewer(&[(4, Some(2)), (16, None)]).0, Open);
    }
}
