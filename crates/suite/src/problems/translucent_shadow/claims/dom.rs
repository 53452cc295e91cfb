//! H4.1 to H4.4: layers that begin where the light meets something.

use super::{
    support::{Method, SCENES, SPANS, dom, osm, still},
    verdict::{all_of, count, figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_opacity_maps::{Code, Layered, Layout, Lookup, cpu::Maps};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H4.1",
            statement: "16 deep opacity maps show no layers where 64 opacity maps do",
            place: "Voicu 2011, section 4, figure 4.3",
            method: "the three grass scenes, 128 px, map 256, one tap, each method at its own best \
                     lookup, deep maps at their best of eight spans. Error: rms against the deep \
                     shadow map of the same texels; banding: rms step of it along light rays. A \
                     scene agrees if both are at most half of those of 64 opacity maps, less than \
                     which no one would set two pictures side by side for; it contradicts if the \
                     error is no smaller at all; else it is open. Deep maps as deep as the deepest \
                     ray, and the literal form (printed masks, the own layer's sum), are shown",
            judge: Box::new(no_layers),
        },
        Claim {
            id: "voicu-H4.2",
            statement: "4 deep opacity maps beat 16 opacity maps and are like 128",
            place: "Voicu 2011, section 4, figure 4.1 (from Yuksel and Keyser 2008)",
            method: "ten scenes, error against the deep shadow map of the same texels, one tap, each \
                     method at its own best lookup, deep maps at their best of eight spans. Beats: \
                     less error than 16; like: at most 1.25 times that of 128, a quarter being \
                     hard to see between two pictures. Each part is voted over the scenes, and \
                     both must hold",
            judge: Box::new(four_maps),
        },
        Claim {
            id: "voicu-H4.3",
            statement: "3 layers fail on clustered geometry; 7 layers, or a larger map, mend it",
            place: "Voicu 2011, section 4.1, figure 4.1.1 (from Yuksel and Keyser 2008)",
            method: "clusters: tree, willow, trees, two_far and mixed, at 128 texels a side, 3 x 3 \
                     taps; interpolated over the span of the deepest ray, and at the best span and \
                     lookup, as the figure's are not given. Fails: the error that 3 layers add \
                     (against the deep shadow map) exceeds the error of that deep shadow map \
                     itself, so that layers and not texels limit. Mended by 7: they add no more \
                     than that. Mended by the map: 3 layers at 256 are no worse against light rays \
                     than 7 at 128, the other mending. Three parts, each voted over scenes and both \
                     settings",
            judge: Box::new(clusters),
        },
        Claim {
            id: "voicu-H4.4",
            statement: "Too short a span overloads the last layer, too long a one leaves layers \
                        empty: the error has a minimum between",
            place: "Voicu 2011, section 4.1, figure 4.1.2",
            method: "16 layers over 0.03 to 3 times the deepest ray of ten scenes, error against \
                     the deep shadow map of the same texels, interpolated, 3 x 3 taps. Agrees if \
                     the least error lies inside and both ends exceed it by 5 % (less is no \
                     valley), the share of opacity in the last layer never rises with the span, and \
                     that of empty cells never falls once that is below a thousandth (each by more than a \
                     thousandth; a short span leaves cells empty too, as all lies in the last). \
                     Voted over the scenes",
            judge: Box::new(spans),
        },
    ]
}

/// Error and banding of a scene: 16 deep maps, 64 opacity maps.
fn clear(rows: &[[(f64, f64); 2]]) -> (Verdict, String) {
    let one = |[deep, planes]: &[(f64, f64); 2]| {
        if deep.0 <= 0.5 * planes.0 && deep.1 <= 0.5 * planes.1 {
            Some(true)
        } else {
            (deep.0 >= planes.0).then_some(false)
        }
    };
    let cases: Vec<Option<bool>> = rows.iter().map(one).collect();
    let less: Vec<bool> = rows.iter().map(|[deep, planes]| deep.0 < planes.0).collect();
    let clear: Vec<bool> = cases.iter().map(|c| *c == Some(true)).collect();
    let because = format!(
        "16 deep maps err less than 64 opacity maps in {} scenes, by half and with half the \
         banding in {}",
        count(&less),
        count(&clear)
    );
    (vote_open(&cases), because)
}

fn no_layers(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in ["grass", "grass_sparse", "grass_dense"] {
        let still = still(scene)?;
        let best = still.best_dom(16, Method::one_tap)?.0;
        let planes = still.best_lookup(&osm(64).one_tap())?.0;
        let deepest = dom(16, still.deepest()?).one_tap();
        let literal = listing(deepest.clone()).lookup(Lookup::Nearest);
        let mut pair = [(0.0, 0.0); 4];
        let forms = [
            ("16 deep", best),
            ("64 planes", planes),
            ("16 of the deepest ray", deepest),
            ("16 literal", literal),
        ];
        for (slot, (name, method)) in pair.iter_mut().zip(forms) {
            let score = still.score(&method)?;
            *slot = (score.layering, score.banding);
            figures.push(figure(format!("{scene}, {name}: error"), score.layering, ""));
            figures.push(figure(format!("{scene}, {name}: banding"), score.banding, ""));
        }
        rows.push([pair[0], pair[1]]);
    }
    let (verdict, because) = clear(&rows);
    Ok(judged(verdict, because, figures))
}

/// With the masks as printed.
pub fn listing(method: Method) -> Method {
    method.with(|layered| {
        if let Layout::Deep { listing, .. } = &mut layered.layout {
            *listing = true;
        }
    })
}

/// Depth of a deep map's layers.
fn span_of(method: &Method) -> Option<f32> {
    match &method.settings.code {
        Code::Layered(Layered { layout: Layout::Deep { span, .. }, .. }) => Some(*span),
        _ => None,
    }
}

/// Errors of a scene: 4 deep maps, 16 and 128 opacity maps.
fn beats_and_like(rows: &[[f64; 3]]) -> (Verdict, String) {
    let beats: Vec<bool> = rows.iter().map(|[deep, few, _]| deep < few).collect();
    let like: Vec<bool> = rows.iter().map(|[deep, _, many]| *deep <= 1.25 * many).collect();
    let because = format!(
        "4 deep maps beat 16 opacity maps in {} scenes and are like 128 in {}",
        count(&beats),
        count(&like)
    );
    (all_of(&[vote(&beats), vote(&like)]), because)
}

fn four_maps(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let still = still(scene)?;
        let (best, error) = still.best_dom(4, Method::one_tap)?;
        let planes = |layers| still.best_lookup(&osm(layers).one_tap()).map(|b| b.1);
        let row = [error, planes(16)?, planes(128)?];
        for (name, value) in ["4 deep", "16 planes", "128 planes"].iter().zip(row) {
            figures.push(figure(format!("{scene}, {name}: error"), value, ""));
        }
        if let Some(span) = span_of(&best) {
            let share = f64::from(span / still.deepest()?);
            figures.push(figure(format!("{scene}: best span over the deepest ray"), share, ""));
        }
        rows.push(row);
    }
    let (verdict, because) = beats_and_like(&rows);
    Ok(judged(verdict, because, figures))
}

/// A clustered scene: what 3 and 7 layers add, the map's own error, and errors against truth of
/// 3 layers on the larger map and 7 on the smaller.
struct Mended {
    added: [f64; 2],
    map: f64,
    larger: f64,
    more: f64,
}

fn mended(rows: &[Mended]) -> (Verdict, String) {
    let fails: Vec<bool> = rows.iter().map(|r| r.added[0] > r.map).collect();
    let by_layers: Vec<bool> = rows.iter().map(|r| r.added[1] <= r.map).collect();
    let by_map: Vec<bool> = rows.iter().map(|r| r.larger <= r.more).collect();
    let because = format!(
        "3 layers limit in {} scenes and settings; 7 layers no longer do in {}, and a larger map is as good as \
         they in {}",
        count(&fails),
        count(&by_layers),
        count(&by_map)
    );
    (all_of(&[vote(&fails), vote(&by_layers), vote(&by_map)]), because)
}

fn clusters(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in ["tree", "willow", "trees", "two_far", "mixed"] {
        let still = still(scene)?;
        // With the same taps: that of one tap says what aliasing is, not what such a map can do.
        let map = dapple_metrics::rmse(
            &still.deep(&osm(1).at(128))?,
            still.case.truth(),
            Some(still.case.mask()),
        )?;
        figures.push(figure(format!("{scene}: error of the deep shadow map, 128"), map, ""));
        let deepest = still.deepest()?;
        for tuned in [false, true] {
            let score = |layers, side| {
                let method = if tuned {
                    still.best_dom(layers, |method| method.at(side))?.0
                } else {
                    dom(layers, deepest).at(side)
                };
                still.score(&method)
            };
            let (few, more, larger) = (score(3, 128)?, score(7, 128)?, score(3, 256)?);
            let how = if tuned { "tuned" } else { "deepest ray" };
            for (name, s) in [("3 layers, 128", few), ("7, 128", more), ("3, 256", larger)] {
                let what = format!("{scene}, {how}, {name}");
                figures.push(figure(format!("{what}: error added by layers"), s.layering, ""));
                figures.push(figure(format!("{what}: error"), s.rmse, ""));
            }
            let added = [few.layering, more.layering];
            rows.push(Mended { added, map, larger: larger.rmse, more: more.rmse });
        }
    }
    let (verdict, because) = mended(&rows);
    Ok(judged(verdict, because, figures))
}

/// A span's error, share of opacity in the last layer, share of empty cells.
type Tried = (f64, f64, f64);

fn between(scenes: &[Vec<Tried>]) -> (Verdict, String) {
    let one = |row: &Vec<Tried>| {
        let ends = row.first().zip(row.last());
        let Some((short, long)) = ends.filter(|_| row.len() > 2) else { return (false, false) };
        let least = row.iter().map(|t| t.0).fold(f64::INFINITY, f64::min);
        let valley = short.0 > 1.05 * least && long.0 > 1.05 * least;
        let empties = row.windows(2).all(|w| w[1].1 <= w[0].1 + 1e-3);
        // Spans with an empty last layer are too long.
        let long = row.iter().skip_while(|t| t.1 > 1e-3).map(|t| t.2);
        let loads = empties && long.clone().zip(long.skip(1)).all(|(a, b)| b >= a - 1e-3);
        (valley, loads)
    };
    let found: Vec<(bool, bool)> = scenes.iter().map(one).collect();
    let valleys: Vec<bool> = found.iter().map(|f| f.0).collect();
    let loads: Vec<bool> = found.iter().map(|f| f.1).collect();
    let holds: Vec<bool> = found.iter().map(|f| f.0 && f.1).collect();
    let because = format!(
        "the error has its minimum inside in {} scenes; the last layer empties and cells go idle \
         with the span in {}",
        count(&valleys),
        count(&loads)
    );
    (vote(&holds), because)
}

/// Share of all opacity that lies in the last of a built map's layers.
fn last_share(maps: &Maps, layers: usize) -> f64 {
    let (mut last, mut all) = (0.0, 0.0);
    for texel in 0..maps.texels() {
        let words = maps.texel(texel);
        let total = f64::from(words[words.len() - 1]);
        last += total - f64::from(words[words.len() - 2]);
        all += total;
    }
    if layers < 2 || all == 0.0 { 0.0 } else { last / all }
}

fn spans(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let still = still(scene)?;
        let deepest = still.deepest()?;
        let mut row = Vec::new();
        for share in SPANS {
            let method = dom(16, share * deepest);
            let maps = still.maps(&method)?;
            let score = still.score_of(&method, &maps, &still.shade(&maps)?)?;
            let tried = (score.layering, last_share(&maps, 16), score.idle);
            let what = format!("{scene}, span {share}");
            figures.push(figure(format!("{what}: error"), tried.0, ""));
            figures.push(figure(format!("{what}: opacity in the last layer"), tried.1, ""));
            figures.push(figure(format!("{what}: empty cells"), tried.2, ""));
            row.push(tried);
        }
        rows.push(row);
    }
    let (verdict, because) = between(&rows);
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn half_of_both_is_clear_and_no_less_contradicts() {
        let planes = (0.1, 0.1);
        assert_eq!(clear(&[[(0.05, 0.05), planes]]).0, Reproduced);
        assert_eq!(clear(&[[(0.05, 0.05), planes], [(0.05, 0.06), planes]]).0, Open);
        assert_eq!(clear(&[[(0.1, 0.05), planes]]).0, Refuted);
    }

    #[test]
    fn four_must_beat_and_be_like() {
        assert_eq!(beats_and_like(&[[0.1, 0.2, 0.08]]).0, Reproduced);
        assert_eq!(beats_and_like(&[[0.1, 0.2, 0.07]]).0, Refuted);
        assert_eq!(beats_and_like(&[[0.1, 0.2, 0.08], [0.2, 0.1, 0.2]]).0, Open);
    }

    #[test]
    fn failing_and_both_ways_of_mending_are_needed() {
        let row = |few, seven, map, larger, more| Mended { added: [few, seven], map, larger, more };
        assert_eq!(mended(&[row(0.2, 0.1, 0.1, 0.1, 0.1)]).0, Reproduced);
        assert_eq!(mended(&[row(0.1, 0.1, 0.1, 0.1, 0.1)]).0, Refuted);
        assert_eq!(mended(&[row(0.2, 0.15, 0.1, 0.1, 0.1)]).0, Refuted);
        assert_eq!(mended(&[row(0.2, 0.1, 0.1, 0.2, 0.1)]).0, Refuted);
        let some = [row(0.2, 0.1, 0.1, 0.1, 0.1), row(0.2, 0.1, 0.1, 0.2, 0.1)];
        assert_eq!(mended(&some).0, Open);
    }

    #[test]
    fn a_valley_with_loads_that_move_agrees() {
        let good = vec![(0.2, 0.5, 0.1), (0.1, 0.1, 0.3), (0.2, 0.0, 0.6)];
        let flat = vec![(0.2, 0.5, 0.1), (0.1, 0.1, 0.3), (0.1, 0.0, 0.6)];
        let loaded = vec![(0.2, 0.1, 0.1), (0.1, 0.5, 0.3), (0.2, 0.0, 0.6)];
        let idle = vec![(0.2, 0.5, 0.1), (0.1, 0.0, 0.3), (0.2, 0.0, 0.2)];
        assert_eq!(between(std::slice::from_ref(&good)).0, Reproduced);
        assert_eq!(between(&[good, flat.clone()]).0, Open);
        assert_eq!(between(&[flat, loaded, idle, Vec::new()]).0, Refuted);
    }
}
