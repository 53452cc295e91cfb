//! H5.1 and H5.3: triangles in the potentially visible set, by view and by technique.

use super::{
    support::{THESIS_SIZE, Way, asks, chc_plus_plus, path_of, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::Technique;

/// The four points of view and the triangles that table 5.I has of them.
pub const VIEWS: [(&str, f64); 4] =
    [("facade", 160.0), ("close_ended", 1156.0), ("street", 14_260.0), ("birds_eye", 100_112.0)];

/// Frames of a still view until what is remembered has settled.
const SETTLED: u32 = 8;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H5.1",
            statement: "From each of the four points of view to the next, the triangles in the \
                        potentially visible set grow tenfold (7.2, 12.3 and 7.0 times)",
            place: "Conte 2018, section 5.1.1 and table 5.I",
            method: "the generated city of 6 x 6 blocks, 1200 x 900, triangles that CHC++ draws in \
                     the eighth frame of each still view; what owns a pixel stands beside it. The \
                     source does not say where its cameras stand, so its own numbers are no aim. \
                     Tenfold: every step within a factor of 1.5 of ten, which holds the source's \
                     own steps. Contradicted only where a view shows no more than the one before",
            judge: Box::new(steps),
        },
        Claim {
            id: "conte-H5.3",
            statement: "At the close-ended street, frustum culling leaves 1/23 of the triangles, \
                        and occlusion queries 1/423",
            place: "Conte 2018, section 5.3 and table 5.III",
            method: "the generated city of 6 x 6 blocks, 1200 x 900, triangles drawn in the eighth \
                     frame of the still view, as ratios. Met where both ratios are within a factor \
                     of 1.5 of the table's; contradicted where culling by the frustum saves \
                     nothing, or queries save nothing beyond it. Between these the unknown place \
                     of the source's camera decides, not the technique",
            judge: Box::new(culling),
        },
    ]
}

/// Growth from each view to the next.
fn tenfold(steps: &[f64]) -> Verdict {
    let tenfold = |step: &f64| (10.0 / 1.5..=10.0 * 1.5).contains(step);
    if steps.is_empty() {
        Verdict::Open
    } else if steps.iter().all(tenfold) {
        Verdict::Reproduced
    } else if steps.iter().all(|step| *step > 1.0) {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

/// Triangles drawn in the last frame of a still view, and those that own a pixel.
pub fn settled(view: &str, way: &Way) -> Result<[f64; 2], SuiteError> {
    let path = path_of(&town("city", &[])?, view, SETTLED, 1, THESIS_SIZE)?;
    let shown = path.shown(way)?;
    let drawn = shown.last().map_or(0, |s| s.work.triangles);
    let owning = path.full.last().map_or(0, super::support::Full::owning);
    Ok([drawn as f64, owning as f64])
}

fn steps(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut drawn) = (Vec::new(), Vec::new());
    for (view, theirs) in VIEWS {
        let [triangles, owning] = settled(view, &chc_plus_plus(|_| {}))?;
        figures.push(figure(format!("{view}: triangles drawn"), triangles, ""));
        figures.push(figure(format!("{view}: triangles that own a pixel"), owning, ""));
        figures.push(figure(format!("{view}: the table's"), theirs, ""));
        drawn.push(triangles);
    }
    let steps: Vec<f64> = drawn.windows(2).map(|w| w[1] / w[0].max(1.0)).collect();
    let because = format!("they grow {steps:.1?} times");
    Ok(judged(tenfold(&steps), because, figures))
}

/// Triangles of all over what the frustum leaves, and over what queries leave; the table's.
const REDUCED: [f64; 2] = [978_652.0 / 41_664.0, 978_652.0 / 2_312.0];

fn reduced([frustum, queries]: [f64; 2]) -> Verdict {
    let near = |got: f64, theirs: f64| (theirs / 1.5..=theirs * 1.5).contains(&got);
    if near(frustum, REDUCED[0]) && near(queries, REDUCED[1]) {
        Verdict::Reproduced
    } else if frustum > 1.0 && queries > frustum {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn culling(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let all = town("city", &[])?.triangles() as f64;
    let [frustum, owning] = settled("close_ended", &asks(Technique::Frustum))?;
    let [queries, _] = settled("close_ended", &chc_plus_plus(|_| {}))?;
    let ratios = [all / frustum.max(1.0), all / queries.max(1.0)];
    let figures = vec![
        figure("triangles of the city", all, ""),
        figure("left by the frustum", frustum, ""),
        figure("left by CHC++", queries, ""),
        figure("that own a pixel", owning, ""),
        figure("all over the frustum's", ratios[0], ""),
        figure("the table's", REDUCED[0], ""),
        figure("all over CHC++'s", ratios[1], ""),
        figure("the table's by queries", REDUCED[1], ""),
        figure("the frustum's over CHC++'s", frustum / queries.max(1.0), ""),
    ];
    let because = format!(
        "the frustum leaves 1/{:.0} of the triangles, queries 1/{:.0}",
        ratios[0], ratios[1]
    );
    Ok(judged(reduced(ratios), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn steps_are_tenfold_or_not() {
        assert_eq!(tenfold(&[7.2, 12.3, 7.0]), Reproduced);
        assert_eq!(tenfold(&[7.2, 20.0, 7.0]), Open);
        assert_eq!(tenfold(&[7.2, 0.9, 7.0]), Refuted);
        assert_eq!(tenfold(&[7.2, f64::NAN, 7.0]), Refuted);
        assert_eq!(tenfold(&[]), Open);
    }

    #[test]
    fn culling_saves_as_much_or_at_all() {
        assert_eq!(reduced([23.5, 423.3]), Reproduced);
        assert_eq!(reduced([5.0, 423.3]), Open);
        assert_eq!(reduced([30.0, 30.0]), Refuted);
        assert_eq!(reduced([1.0, 400.0]), Refuted);
        assert_eq!(reduced([f64::NAN, 400.0]), Refuted);
    }
}
