//! Heights below which lights are hidden, kept with the lists.

use super::{
    support::{OURS, VIEW, evaluator, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_many_lights::{
    LightTree,
    region::{
        Face, OccluderMode, Precuts, ViewCell,
        truth::{Obstacles, Sight, kept, seen_strongly},
    },
};

/// Heights of a face that are tried.
const HEIGHTS: u32 = 3;

/// Random points of a face's lower part that each light is looked for from.
const POINTS: u32 = 32;

/// Share of the lights that surely is more than none.
const SOME: f64 = 0.01;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H6.4",
        statement: "A height kept with each cluster leaves lights out for low points, without new \
                    evaluations of cells",
        place: "Conte 2018, section 6.1",
        method: "city, close-ended street and street, 12 faces each by chance, three heights of a face: \
                 lights of a list that the face's foot need not look at, over those of the list. Met if \
                 it is 1 in 100 or more, contradicted if it is none, or if a ray from up to such a \
                 height brings a light that was left out there. No cell is added; what finding the \
                 heights costs in tests, over those of the lists themselves, stands beside",
        judge: Box::new(heights),
    }]
}

/// Lights below some nodes.
fn lights(tree: &LightTree, nodes: &[u32]) -> u64 {
    kept(tree, nodes).iter().filter(|kept| **kept).count() as u64
}

/// The cell with its faces only up to a height.
fn up_to(cell: &ViewCell, top: f64) -> ViewCell {
    let lower = |face: &Face| {
        let mut face = *face;
        face.max.y = top.clamp(face.min.y, face.max.y);
        face.region.max.y = top.clamp(face.region.min.y, face.region.max.y);
        face
    };
    ViewCell { turn: cell.turn, faces: cell.faces.each_ref().map(|f| f.as_ref().map(lower)) }
}

/// Lights of lists, those that feet skip, and those skipped that a ray brings to where they are.
fn lowers(all: u64, skipped: u64, wrong: u64) -> Verdict {
    match (all, skipped) {
        _ if wrong > 0 => Verdict::Refuted,
        (0, _) => Verdict::Open,
        (_, 0) => Verdict::Refuted,
        (all, skipped) if skipped as f64 >= SOME * all as f64 => Verdict::Reproduced,
        _ => Verdict::Open,
    }
}

fn heights(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut sums) = (Vec::new(), [0; 3]);
    for view in [VIEW, "street"] {
        let case = prepared("city", view, 12)?;
        let town = &case.night().town;
        let mut evaluator = evaluator(&case, OURS);
        let (mut nodes, mut below) = (Vec::new(), Vec::new());
        let [mut all, mut skipped, mut wrong, mut looked] = [0; 4];
        for face in &case.truth()[0] {
            let (cell, direction) = case.frames()[0][face.question].asked();
            let Some(foot) = cell.face(direction).map(|face| face.min.y) else { continue };
            evaluator.precut(cell, direction, &mut nodes);
            below.clear();
            below.resize(nodes.len(), f32::INFINITY);
            evaluator.heights(cell, direction, HEIGHTS, &nodes, &mut below);
            let pairs = || nodes.iter().zip(&below).map(|(node, top)| (*node, f64::from(*top)));
            let low: Vec<u32> = pairs().filter(|(_, top)| foot <= *top).map(|(n, _)| n).collect();
            all += lights(&town.lights, &nodes);
            skipped += lights(&town.lights, &low);
            // Each height by itself, by rays to some of the lights that it leaves out.
            let mut tops: Vec<f64> =
                pairs().map(|(_, top)| top).filter(|top| foot <= *top && top.is_finite()).collect();
            tops.sort_by(f64::total_cmp);
            tops.dedup();
            for top in tops {
                let out: Vec<u32> =
                    pairs().filter(|(_, at)| *at == top).map(|(node, _)| node).collect();
                let left_out = kept(&town.lights, &out);
                let of = (0..left_out.len() as u32).filter(|light| left_out[*light as usize]);
                let of: Vec<u32> = of.take(256).collect();
                let lower = up_to(cell, top);
                let solids = town.occluders.turned(cell.turn, OccluderMode::Leaf);
                let world = town.world(true);
                let triangles = Obstacles::Triangles(world);
                let sight = Sight::new(world, &lower, direction, &solids.solids, triangles);
                let found = sight.map(|s| seen_strongly(&s, &of, 0.0, POINTS, 1).sightings);
                wrong += found.into_iter().flatten().flatten().count() as u64;
                looked += of.len() as u64;
            }
        }
        let tests = |s: &dapple_many_lights::region::Steps| s.potential + s.last + s.early;
        let more = tests(evaluator.height_steps()) as f64 / tests(evaluator.steps()).max(1) as f64;
        figures.extend([
            figure(format!("{view}: lights of the lists"), all as f64, ""),
            figure(
                format!("{view}: share that the foot skips"),
                skipped as f64 / all.max(1) as f64,
                "",
            ),
            figure(
                format!("{view}: lights looked for by rays below their heights"),
                looked as f64,
                "",
            ),
            figure(format!("{view}: of these seen"), wrong as f64, ""),
            figure(format!("{view}: tests for {HEIGHTS} heights over those for lists"), more, ""),
        ]);
        sums = [sums[0] + all, sums[1] + skipped, sums[2] + wrong];
    }
    let [all, skipped, wrong] = sums;
    let because = format!(
        "the feet of faces skip {:.1} % of the lights; {wrong} of them are seen",
        100.0 * skipped as f64 / all.max(1) as f64
    );
    Ok(judged(lowers(all, skipped, wrong), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};

    #[test]
    fn heights_leave_lights_out_or_not() {
        assert_eq!(lowers(100, 10, 0), Reproduced);
        assert_eq!(lowers(1000, 1, 0), Open);
        assert_eq!(lowers(100, 0, 0), Refuted);
        assert_eq!(lowers(100, 10, 1), Refuted);
        assert_eq!(lowers(0, 0, 0), Open);
    }
}
