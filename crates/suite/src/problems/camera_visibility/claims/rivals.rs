//! Other techniques against CHC++, by what they draw for nothing.

use super::{
    coherence::paths,
    support::{Path, Way, asks, chc_plus_plus, hierarchical, lost, masked, mean},
    verdict::{figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{
    Technique,
    masked::{Occluders, Settings},
};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "haar-1",
            statement: "Two passes by hierarchical depth cull what occlusion queries cull, without \
                        a word between host and device",
            place: "Haar and Aaltonen 2015; not in Conte 2018",
            method: "triangles drawn that own no pixel, over those that own one, along three paths \
                     through the generated city, 36 frames each, 256 x 144. Met on a path if no \
                     more than CHC++ draws; a pixel lost contradicts. The frustum alone stands \
                     beside it",
            judge: Box::new(|_| rival("two passes", &hierarchical())),
        },
        Claim {
            id: "hasselgren-1",
            statement: "Culling on the processor by masked buffers culls what occlusion queries cull",
            place: "Hasselgren et al. 2016; not in Conte 2018",
            method: "the same of masked buffers of 256 columns, with boxes inscribed in buildings, \
                     8,192 triangles of them at most",
            judge: Box::new(|_| rival("masked, boxes", &masked(Occluders::InnerBoxes))),
        },
        Claim {
            id: "hasselgren-2",
            statement: "Boxes inscribed in buildings hide as much as the buildings' own triangles",
            place: "goal of this project, after Hasselgren et al. 2016",
            method: "triangles drawn by masked culling on the same paths, boxes against meshes, at \
                     most 512, 8,192 and 131,072 triangles of occluders. Met in a case if boxes \
                     leave at most 5 % more; a facade and a roof are missing from neither",
            judge: Box::new(boxes_and_meshes),
        },
        Claim {
            id: "hasselgren-4",
            statement: "More occluders never make masked buffers cull less",
            place: "what a depth for each pixel grants; Hasselgren et al. 2016 do not",
            method: "triangles drawn by masked culling on the same paths with boxes of at most 512, \
                     2,048, 8,192, 32,768 and 131,072 triangles, largest first: met on a path if no \
                     step draws more. Two depths and a mask for 8 x 4 pixels may forget the nearer one \
                     where a third comes",
            judge: Box::new(more),
        },
    ]
}

/// Overdraw of the rival and of CHC++, one pair a path, and the rival's lost pixels.
fn no_more(pairs: &[[f64; 2]], lost: u64) -> Verdict {
    if lost > 0 {
        return Verdict::Refuted;
    }
    vote(&pairs.iter().map(|[rival, queries]| rival <= queries).collect::<Vec<_>>())
}

fn rival(name: &str, way: &Way) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs, mut gone) = (Vec::new(), Vec::new(), 0);
    for (view, path) in paths()? {
        let mut overdraw = |what: &str, way: &Way| -> Result<f64, SuiteError> {
            let shown = path.shown(way)?;
            gone += lost(&shown);
            let overdraw = path.overdraw(&shown);
            figures.push(figure(format!("{view}, {what}: drawn for nothing"), overdraw, ""));
            Ok(overdraw)
        };
        overdraw("frustum", &asks(Technique::Frustum))?;
        overdraw("CHC", &asks(Technique::Chc))?;
        let queries = overdraw("CHC++", &chc_plus_plus(|_| {}))?;
        pairs.push([overdraw(name, way)?, queries]);
    }
    let told: Vec<String> = pairs.iter().map(|[a, b]| format!("{a:.2} against {b:.2}")).collect();
    let because = format!("drawn for nothing, {name} against CHC++: {}", told.join(", "));
    Ok(judged(no_more(&pairs, gone), because, figures))
}

/// Triangles drawn by boxes and by meshes.
fn as_much(pairs: &[[f64; 2]], lost: u64) -> Verdict {
    let near: Vec<[f64; 2]> = pairs.iter().map(|[boxes, meshes]| [*boxes, 1.05 * meshes]).collect();
    no_more(&near, lost)
}

/// Triangles that masked culling draws a frame, and pixels lost.
fn drawn(path: &Path, occluders: Occluders, most_triangles: u64) -> Result<(f64, u64), SuiteError> {
    let way = match masked(occluders) {
        Way::Masked(settings) => Way::Masked(Settings { most_triangles, ..settings }),
        other => other,
    };
    let shown = path.shown(&way)?;
    Ok((mean(&shown, |w| w.triangles), lost(&shown)))
}

fn boxes_and_meshes(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs, mut gone) = (Vec::new(), Vec::new(), 0);
    for (view, path) in paths()? {
        for most in [512, 8192, 131_072] {
            let mut of = |name: &str, occluders| -> Result<f64, SuiteError> {
                let (drawn, lost) = drawn(&path, occluders, most)?;
                let what = format!("{view}, {name} of {most} triangles: drawn a frame");
                figures.push(figure(what, drawn, ""));
                gone += lost;
                Ok(drawn)
            };
            pairs.push([of("boxes", Occluders::InnerBoxes)?, of("meshes", Occluders::Meshes)?]);
        }
    }
    let ratios: Vec<f64> = pairs.iter().map(|[a, b]| a / b.max(1.0)).collect();
    let because = format!("boxes leave {ratios:.2?} of what meshes leave, path by path");
    Ok(judged(as_much(&pairs, gone), because, figures))
}

/// Triangles drawn with more and more occluders, one list a path.
fn falls(paths: &[Vec<f64>]) -> Verdict {
    let steady = |drawn: &Vec<f64>| drawn.windows(2).all(|w| w[1] <= w[0]);
    vote(&paths.iter().map(steady).collect::<Vec<_>>())
}

fn more(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Vec::new());
    for (view, path) in paths()? {
        let mut list = Vec::new();
        for most in [512, 2048, 8192, 32_768, 131_072] {
            let (drawn, _) = drawn(&path, Occluders::InnerBoxes, most)?;
            figures.push(figure(format!("{view}, {most} triangles: drawn a frame"), drawn, ""));
            list.push(drawn);
        }
        all.push(list);
    }
    let ends: Vec<f64> = all
        .iter()
        .filter_map(|list| {
            let least = list.iter().copied().fold(f64::INFINITY, f64::min);
            list.last().map(|last| last / least.max(1.0))
        })
        .collect();
    let because =
        format!("with the most occluders {ends:.2?} of the least are drawn, path by path");
    Ok(judged(falls(&all), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn a_rival_draws_no_more_everywhere_or_not() {
        assert_eq!(no_more(&[[1.0, 1.0], [0.5, 1.0]], 0), Reproduced);
        assert_eq!(no_more(&[[1.0, 1.0], [1.5, 1.0]], 0), Open);
        assert_eq!(no_more(&[[1.5, 1.0]], 0), Refuted);
        assert_eq!(no_more(&[[0.5, 1.0]], 1), Refuted);
        assert_eq!(no_more(&[[f64::NAN, 1.0]], 0), Refuted);
    }

    #[test]
    fn more_occluders_cull_more_everywhere_or_not() {
        assert_eq!(falls(&[vec![9.0, 8.0, 8.0], vec![3.0, 2.0]]), Reproduced);
        assert_eq!(falls(&[vec![9.0, 8.0, 8.5], vec![3.0, 2.0]]), Open);
        assert_eq!(falls(&[vec![9.0, 8.0, 8.5]]), Refuted);
    }

    #[test]
    fn boxes_may_leave_a_twentieth_more() {
        assert_eq!(as_much(&[[1.04, 1.0]], 0), Reproduced);
        assert_eq!(as_much(&[[1.06, 1.0]], 0), Refuted);
    }
}
