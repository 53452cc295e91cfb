//! Whether lights that are seen are culled, and by what occluders.

use super::{
    support::{OURS, THESIS, VIEW, agreement, never, prepared},
    verdict::{figure, judged, vote},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::region::{
    Edge, FacadeCluster, Fusion, OccluderMode, Occluders, RegionTechnique, truth::Agreement,
};
use std::sync::Arc;

/// Views of the city, and faces whose truth is known in each.
const VIEWS: [&str; 3] = [VIEW, "street", "birds_eye"];
const FACES: u32 = 12;

/// Share of what is culled that may be lost before a small part of the occluders matters.
const SMALL: f64 = 0.05;

/// Lights lost that still count as few.
const FEW: f64 = 0.01;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-H4.1",
            statement: "No light that a view cell sees is culled",
            place: "Conte 2018, sections 4.2.3 and 6.1",
            method: "three views of the city, 12 faces each by chance, at most 512 lights a face: rays \
                     from corners, silhouettes and random points to lights that could matter. Buildings \
                     and gap-free runs of them as occluders, three ways of joining, three edges. Met \
                     without a light that a ray brings at the threshold and that is left out; one \
                     contradicts",
            judge: Box::new(sound),
        },
        Claim {
            id: "conte-H4.1-nodes",
            statement: "The box of a node of the buildings' hierarchy may count as fully occluding: \
                        contiguous buildings are joined first, so errors are few",
            place: "Conte 2018, section 4.2.3",
            method: "the same faces and rays, boxes around clusters of buildings. Met without a light \
                     that is seen and left out, contradicted if it is more than 1 in 100 of those seen: \
                     then images miss lights",
            judge: Box::new(nodes),
        },
        Claim {
            id: "conte-H4.5",
            statement: "Buildings give most of the occlusion: less than 5 % is lost without other objects",
            place: "Conte 2018, section 4.2.3, after Coorg and Teller 1997",
            method: "share of the hidden lights that are culled, by buildings, over that by buildings \
                     and every storey of every facade, two views: less than 5 % lost in all is met, in \
                     none contradicts",
            judge: Box::new(buildings),
        },
    ]
}

fn of(settings: FacadeCluster) -> RegionTechnique {
    RegionTechnique::FacadeCluster(settings)
}

fn sound(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Agreement::default());
    for view in VIEWS {
        let case = prepared("city", view, FACES)?;
        for occluders in [OccluderMode::Leaf, OccluderMode::ContiguousMin] {
            let mut here = Agreement::default();
            for fusion in [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered] {
                for edge in [Edge::Flat, Edge::Sloped, Edge::Hull] {
                    let settings = FacadeCluster { fusion, edge, occluders, ..THESIS };
                    here += agreement(&case, &of(settings), None)?;
                }
            }
            let what = format!("{view}, {occluders:?}");
            figures.extend([
                figure(
                    format!("{what}: lights seen"),
                    (here.seen_kept + here.seen_culled) as f64,
                    "",
                ),
                figure(format!("{what}: of these left out"), here.seen_culled as f64, ""),
                figure(format!("{what}: share of the hidden culled"), here.tightness(), ""),
            ]);
            all += here;
        }
    }
    let seen = all.seen_kept + all.seen_culled;
    let because = format!("{} of {seen} lights that are seen were left out", all.seen_culled);
    Ok(judged(never(all.seen_culled, seen), because, figures))
}

/// Share of the lights seen that is left out.
fn few(share: f64) -> Verdict {
    if share == 0.0 {
        Verdict::Reproduced
    } else if share <= FEW {
        Verdict::Open
    } else {
        Verdict::Refuted
    }
}

fn nodes(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut all) = (Vec::new(), Agreement::default());
    for view in VIEWS {
        let case = prepared("city", view, FACES)?;
        for (name, settings) in [("thesis", THESIS), ("tallest first", OURS)] {
            let settings = FacadeCluster { occluders: OccluderMode::BoundingBoxes, ..settings };
            let here = agreement(&case, &of(settings), None)?;
            let culled = (here.seen_culled + here.hidden_culled).max(1) as f64;
            figures.extend([
                figure(
                    format!("{view}, {name}: share of the seen left out"),
                    here.false_hidden(),
                    "",
                ),
                figure(
                    format!("{view}, {name}: share of the culls that is false"),
                    here.seen_culled as f64 / culled,
                    "",
                ),
            ]);
            if settings.fusion == THESIS.fusion {
                all += here;
            }
        }
    }
    let share = all.false_hidden();
    let because = format!("{:.1} % of the lights that are seen are left out", 100.0 * share);
    Ok(judged(few(share), because, figures))
}

/// Shares that are lost, view by view.
fn most_of_it(lost: &[f64]) -> Verdict {
    vote(&lost.iter().map(|lost| *lost < SMALL).collect::<Vec<_>>())
}

fn buildings(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut lost) = (Vec::new(), Vec::new());
    for view in &VIEWS[..2] {
        let case = prepared("city", view, FACES)?;
        let night = case.night();
        let objects = Arc::new(Occluders::of_objects(&night.city, night.town.objects.origin));
        let tight = |occluders| agreement(&case, &of(OURS), occluders);
        let [few, all] = [tight(None)?.tightness(), tight(Some(&objects))?.tightness()];
        let share = 1.0 - few / all.max(f64::MIN_POSITIVE);
        figures.extend([
            figure(
                format!("{view}: occluders, buildings"),
                night.town.occluders.count() as f64,
                "",
            ),
            figure(format!("{view}: occluders, all objects"), objects.count() as f64, ""),
            figure(format!("{view}: share of the hidden culled, buildings"), few, ""),
            figure(format!("{view}: share of the hidden culled, all objects"), all, ""),
            figure(format!("{view}: lost without other objects"), share, ""),
        ]);
        lost.push(share);
    }
    let told: Vec<String> = lost.iter().map(|lost| format!("{:.1} %", 100.0 * lost)).collect();
    Ok(judged(most_of_it(&lost), format!("{} lost", told.join(", ")), figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn few_is_next_to_none() {
        assert_eq!([0.0, 0.005, 0.2, f64::NAN].map(few), [Reproduced, Open, Refuted, Refuted]);
    }

    #[test]
    fn buildings_are_enough_or_not() {
        assert_eq!(most_of_it(&[0.01, -0.01]), Reproduced);
        assert_eq!(most_of_it(&[0.01, 0.3]), Open);
        assert_eq!(most_of_it(&[0.3, f64::NAN]), Refuted);
    }
}
