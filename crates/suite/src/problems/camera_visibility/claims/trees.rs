//! What has holes hides nothing.

use super::{
    support::{LATENCY, Path, Way, asks, chc_plus_plus, hierarchical, lost, masked, path, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{
    Frame, Objects, Technique,
    masked::{Culler, Occluders},
    software::Fast,
};
use std::{collections::BTreeSet, sync::Arc};

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "dapple-S5.5",
        statement: "Trees cut out by their alpha never hide what shows through them",
        place: "goal of this project",
        method: "the generated city with 12 trees a block, 256 x 144, street and turn, 30 frames \
                 each, every second: no technique loses a pixel, and masked culling by meshes draws \
                 the same walls as with the trees left out. The control takes the trees for solid \
                 and must lose pixels, or the paths show nothing and nothing is decided",
        judge: Box::new(trees),
    }]
}

/// Pixels lost by all techniques, frames in which trees change what else is drawn, and pixels lost
/// by the control.
fn harmless(lost: u64, changed: u64, control: u64) -> Verdict {
    match (lost, changed, control) {
        (0, 0, 1..) => Verdict::Reproduced,
        (0, 0, 0) => Verdict::Open,
        _ => Verdict::Refuted,
    }
}

/// Pixels lost where masked culling takes alpha-tested triangles for solid ones.
fn taken_for_solid(path: &Path) -> Result<u64, SuiteError> {
    let town = &path.town;
    let mut solid: Objects = (*town.objects).clone();
    for template in &mut solid.templates {
        template.mask = None;
        template.uvs.clear();
    }
    let Way::Masked(settings) = masked(Occluders::Meshes) else { return Ok(0) };
    let mut culler = Culler::new(settings, &solid, &[])?;
    let mut renderer = Fast::new(Arc::clone(&town.objects), LATENCY)?;
    let (mut out, mut lost) = (Frame::default(), 0);
    for (view, full) in path.views.iter().zip(&path.full) {
        culler.frame(&solid, &town.tree, view, &mut renderer, &mut out)?;
        lost += full.lost(renderer.image());
    }
    Ok(lost)
}

fn trees(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (with, without) = (town("city_trees", &[])?, town("city_small", &[])?);
    let (mut figures, mut gone, mut changed, mut control) = (Vec::new(), 0, 0, 0);
    for view in ["street", "turn"] {
        let path_with = path(&with, view, 30, 2)?;
        for (name, way) in [
            ("stop-and-wait", asks(Technique::StopAndWait)),
            ("CHC++", chc_plus_plus(|_| {})),
            ("two passes", hierarchical()),
            ("masked, meshes", masked(Occluders::Meshes)),
            ("masked, boxes", masked(Occluders::InnerBoxes)),
        ] {
            let lost = lost(&path_with.shown(&way)?);
            figures.push(figure(format!("{view}, {name}: pixels lost"), lost as f64, ""));
            gone += lost;
        }
        // The walls come first in both cities, in the same order.
        let path_without = path(&without, view, 30, 2)?;
        let walls = without.objects.objects.len() as u32;
        let way = masked(Occluders::Meshes);
        for (a, b) in path_with.shown(&way)?.iter().zip(&path_without.shown(&way)?) {
            let drawn = |list: &[u32]| -> BTreeSet<u32> {
                list.iter().copied().filter(|o| *o < walls).collect()
            };
            changed += u64::from(drawn(&a.drawn) != drawn(&b.drawn));
        }
        let lost = taken_for_solid(&path_with)?;
        figures.push(figure(format!("{view}, taken for solid: pixels lost"), lost as f64, ""));
        control += lost;
    }
    figures.push(figure("frames in which trees change the walls drawn", changed as f64, ""));
    let because = format!(
        "{gone} pixels are lost by five techniques, {control} where trees are taken for solid; \
         {changed} frames draw other walls"
    );
    Ok(judged(harmless(gone, changed, control), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_are_harmless_if_the_control_is_not() {
        assert_eq!(harmless(0, 0, 9), Verdict::Reproduced);
        assert_eq!(harmless(0, 0, 0), Verdict::Open);
        assert_eq!(harmless(1, 0, 9), Verdict::Refuted);
        assert_eq!(harmless(0, 1, 9), Verdict::Refuted);
    }
}
