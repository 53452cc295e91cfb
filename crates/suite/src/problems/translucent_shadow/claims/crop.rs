//! H1.1: a map's texels spent on what casts.

use super::{
    support::still,
    verdict::{all_of, count, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_scene::{Crop, LightView};
use dapple_trace::{Ray, Tracer};
use glam::DVec2;

/// Texels on a side of the maps that coverage is counted on.
const SIDE: u32 = 256;

/// Distances of the light in figure 3.1.2.
const DISTANCES: [f64; 2] = [10.0, 20.0];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "voicu-H1.1",
        statement: "Without cropping ever fewer texels see a caster as the light moves away; with \
                    it their share stays the same and near the greatest",
        place: "Voicu 2011, section 3.1, figure 3.1.2",
        method: "grass, tree and hair under their own light at distances in the ratio 10 to 20: \
                 parallel light with a window that grows with the distance, as the source's, and a \
                 spot of the same opening. Covered: share of 256 x 256 texels whose ray meets a \
                 caster. Agrees if the uncropped share falls to at most a half (areas predict a \
                 quarter), the cropped one changes by at most 5 % (thin blades sampled at other \
                 points), and the covered texels' rectangle fills at least 0.9 of the cropped \
                 map's sides. All scenes under parallel light must; a spot, whose rays change \
                 direction, is shown beside and does not vote",
        judge: Box::new(crop),
    }]
}

/// What a map sees of casters.
#[derive(Clone, Copy, Debug)]
struct Covered {
    /// Share of texels.
    share: f64,
    /// Sides of the covered rectangle, the lesser of both, of the map's.
    fills: f64,
}

/// Casters are what lies above `level`, metres.
fn covered(tracer: &Tracer, level: f64, view: &LightView, crop: &Crop) -> Covered {
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let (mut count, mut low, mut high) = (0_u32, [SIDE; 2], [0; 2]);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let at = crop.min + (crop.max - crop.min) * DVec2::new(centre(x), centre(y));
            let [u, v] = [0.5 + 0.5 * at.x, 0.5 + 0.5 * at.y];
            let (origin, direction) = view.ray(u, v);
            let hit = tracer.closest(&Ray { origin, direction, t_min: 0.0, t_max: 1.0 });
            if hit.is_some_and(|hit| (origin + direction * hit.t).y > level) {
                count += 1;
                low = [low[0].min(x), low[1].min(y)];
                high = [high[0].max(x + 1), high[1].max(y + 1)];
            }
        }
    }
    let side = |i: usize| f64::from(high[i].saturating_sub(low[i])) / f64::from(SIDE);
    Covered { share: f64::from(count) / f64::from(SIDE * SIDE), fills: side(0).min(side(1)) }
}

/// Coverage of one light at both distances, uncropped and cropped.
struct Pair {
    uncropped: [Covered; 2],
    cropped: [Covered; 2],
}

fn kept(pair: &Pair) -> Verdict {
    let [near, far] = pair.uncropped.map(|c| c.share);
    let [before, after] = pair.cropped.map(|c| c.share);
    let falls = far <= 0.5 * near;
    let same = (after - before).abs() <= 0.05 * before;
    let fills = pair.cropped.iter().all(|c| c.fills >= 0.9);
    match (falls, same && fills) {
        (true, true) => Verdict::Reproduced,
        (false, false) => Verdict::Refuted,
        _ => Verdict::Open,
    }
}

fn crop(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut parts, mut spots) = (Vec::new(), Vec::new(), Vec::new());
    for scene in ["grass", "tree", "hair"] {
        let still = still(scene)?;
        let casters = still.case.casters().subject_bounds();
        let whole = *still.case.view(false);
        let tracer = still.case.tracer();
        // The ground only receives.
        let level = casters.min.y + 0.02 * (casters.max.y - casters.min.y);
        let radius = casters.radius().max(f64::MIN_POSITIVE);
        // At the nearer distance the window is twice as wide as the casters' sphere.
        let opening = 2.0 * radius;
        for kind in ["parallel", "spot"] {
            let mut views = Vec::new();
            for distance in DISTANCES {
                let away = distance / DISTANCES[0];
                views.push(if kind == "parallel" {
                    let origin = casters.centre() - whole.forward * (2.0 * radius);
                    let (half_extent, far_m) = (opening * away, 4.0 * radius);
                    LightView { origin, half_extent, near_m: 0.0, far_m, ..whole }
                } else {
                    let from = casters.centre() - whole.forward * (4.0 * radius * away);
                    let half_angle = (opening / (4.0 * radius)).atan();
                    LightView::fit_spot(from, whole.forward, half_angle, &casters)?
                });
            }
            let cropped = |view: &LightView| -> Result<Covered, SuiteError> {
                let (low, high) = view.clip_rectangle(&casters);
                Ok(covered(tracer, level, view, &Crop::to(low, high)?))
            };
            let pair = Pair {
                uncropped: [0, 1].map(|i| covered(tracer, level, &views[i], &Crop::FULL)),
                cropped: [cropped(&views[0])?, cropped(&views[1])?],
            };
            for (i, distance) in DISTANCES.iter().enumerate() {
                let what = format!("{scene}, {kind} light at {distance}");
                figures.push(figure(format!("{what}: covered"), pair.uncropped[i].share, ""));
                let share = pair.cropped[i].share;
                figures.push(figure(format!("{what}, cropped: covered"), share, ""));
                let fills = pair.cropped[i].fills;
                figures.push(figure(format!("{what}, cropped: sides filled"), fills, ""));
            }
            if kind == "parallel" { &mut parts } else { &mut spots }.push(kept(&pair));
        }
    }
    let agree = |verdicts: &[Verdict]| {
        let agree: Vec<bool> = verdicts.iter().map(|v| *v == Verdict::Reproduced).collect();
        count(&agree)
    };
    let because = format!(
        "so it is in {} scenes under parallel light; a spot's map, cropped to the casters' box, is \
         in {}",
        agree(&parts),
        agree(&spots)
    );
    Ok(judged(all_of(&parts), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn uncropped_must_fall_and_cropped_must_stay_and_fill() {
        let of = |shares: [f64; 2], fills| shares.map(|share| Covered { share, fills });
        let judge = |uncropped, cropped, fills| {
            kept(&Pair { uncropped: of(uncropped, 0.5), cropped: of(cropped, fills) })
        };
        assert_eq!(judge([0.2, 0.05], [0.7, 0.71], 0.95), Reproduced);
        assert_eq!(judge([0.2, 0.05], [0.7, 0.5], 0.95), Open);
        assert_eq!(judge([0.2, 0.05], [0.7, 0.7], 0.5), Open);
        assert_eq!(judge([0.2, 0.15], [0.7, 0.5], 0.95), Refuted);
    }
}
