//! Other techniques against CHC++, by what they draw for nothing.

use super::{
    coherence::paths,
    support::{Way, asks, chc_plus_plus, hierarchical, lost, masked, sum},
    verdict::{figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{Technique, masked::Occluders};

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

fn boxes_and_meshes(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut pairs, mut gone) = (Vec::new(), Vec::new(), 0);
    for (view, path) in paths()? {
        for most_triangles in [512, 8192, 131_072] {
            let mut drawn = [0.0; 2];
            for (i, occluders) in [Occluders::InnerBoxes, Occluders::Meshes].into_iter().enumerate()
            {
                let Way::Masked(settings) = masked(occluders) else { continue };
                let way = Way::Masked(dapple_occlusion::camera::masked::Settings {
                    most_triangles,
                    ..settings
                });
                let shown = path.shown(&way)?;
                gone += lost(&shown);
                drawn[i] = sum(&shown, |w| w.triangles) / shown.len().max(1) as f64;
                let what = ["boxes", "meshes"][i];
                figures.push(figure(
                    format!("{view}, {what} of {most_triangles} triangles: drawn a frame"),
                    drawn[i],
                    "",
                ));
            }
            pairs.push(drawn);
        }
    }
    let ratios: Vec<f64> = pairs.iter().map(|[a, b]| a / b.max(1.0)).collect();
    let because = format!("boxes leave {ratios:.2?} of what meshes leave, path by path");
    Ok(judged(as_much(&pairs, gone), because, figures))
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
    fn boxes_may_leave_a_twentieth_more() {
        assert_eq!(as_much(&[[1.04, 1.0]], 0), Reproduced);
        assert_eq!(as_much(&[[1.06, 1.0]], 0), Refuted);
    }
}
