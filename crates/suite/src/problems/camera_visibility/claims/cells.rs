//! How view cells are built by the text, and as it must be meant.

use super::{
    support::{THESIS_SIZE, chc_plus_plus, path_of, town},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_occlusion::camera::{CellLimits, Coverage, Tree, view_cells};

/// Thresholds, pixels of 1200 x 900.
const THRESHOLDS: [u32; 4] = [1024, 4096, 16_384, 65_536];

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-4.1-cells",
        statement: "Descending the hierarchy and stopping only at clusters of more pixels than a \
                    threshold gives view cells of similar coverage",
        place: "Conte 2018, section 4.1",
        method: "coverage as CHC++ stores it, inner nodes summed, after eight frames of three views \
                 of the generated city, 1200 x 900; thresholds of 1,024 to 65,536 pixels. Cells by \
                 the letter (stop where coverage is above the threshold) and as meant (divide \
                 there). Met if the letter gives more cells for lower thresholds; contradicted if \
                 it gives one, the root, at each",
        judge: Box::new(cells),
    }]
}

/// The nodes at which the text stops: those of more than `tau_px` pixels.
fn by_the_letter(tree: &Tree, coverage: &[u32], tau_px: u32) -> Vec<u32> {
    let (mut open, mut cells) = (Vec::new(), Vec::new());
    open.extend((!tree.nodes.is_empty()).then_some(0_u32));
    while let Some(node) = open.pop() {
        if coverage[node as usize] > tau_px {
            cells.push(node);
        } else {
            open.extend(tree.nodes[node as usize].children.clone());
        }
    }
    cells
}

/// Cells by the letter at rising thresholds, one list a view.
fn similar(views: &[Vec<u64>]) -> Verdict {
    let falls = |cells: &Vec<u64>| cells.first() > cells.last() && cells.iter().all(|c| *c > 0);
    if views.is_empty() || views.iter().any(Vec::is_empty) {
        Verdict::Open
    } else if views.iter().all(falls) {
        Verdict::Reproduced
    } else if views.iter().flatten().all(|cells| *cells <= 1) {
        Verdict::Refuted
    } else {
        Verdict::Open
    }
}

fn cells(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let city = town("city", &[])?;
    let way = chc_plus_plus(|s| s.coverage = Coverage::Summed);
    let (mut figures, mut found) = (Vec::new(), Vec::new());
    for view in ["close_ended", "street", "birds_eye"] {
        let path = path_of(&city, view, 8, 1, THESIS_SIZE)?;
        let tree = &path.town.tree;
        let (mut coverage, mut drawn) = (Vec::new(), Vec::new());
        path.walk(&way, |now| {
            coverage = now.state.coverage().to_vec();
            drawn.clone_from(&now.frame.drawn);
            Ok(())
        })?;
        let levels = tree.levels();
        let root = coverage.first().copied().unwrap_or(0);
        figures.push(figure(format!("{view}: coverage of the root"), f64::from(root), "px"));
        let mut letter = Vec::new();
        for tau_px in THRESHOLDS {
            let cells = by_the_letter(tree, &coverage, tau_px).len();
            let limits = CellLimits { tau_px, most_level: u32::MAX };
            let meant = view_cells(tree, &coverage, &levels, &drawn, limits)?;
            let largest = meant.cells.iter().map(|c| coverage[c.node as usize]).max().unwrap_or(0);
            let what = format!("{view}, above {tau_px} px");
            figures.push(figure(format!("{what}: cells by the letter"), cells as f64, ""));
            figures.push(figure(format!("{what}: cells as meant"), meant.cells.len() as f64, ""));
            let largest = f64::from(largest);
            figures.push(figure(format!("{what}: largest cell as meant"), largest, "px"));
            letter.push(cells as u64);
        }
        found.push(letter);
    }
    let most = found.iter().flatten().max().copied().unwrap_or(0);
    let because = format!(
        "by the letter there are at most {most} cells: the root covers more than any threshold, \
         and the descent ends there"
    );
    Ok(judged(similar(&found), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Open, Refuted, Reproduced};
    use dapple_occlusion::camera::{Bounds, Node};

    #[test]
    fn one_cell_everywhere_contradicts() {
        assert_eq!(similar(&[vec![9, 5, 2]]), Reproduced);
        assert_eq!(similar(&[vec![1, 1, 1]]), Refuted);
        assert_eq!(similar(&[vec![9, 5, 2], vec![1, 1, 1]]), Open);
        assert_eq!(similar(&[]), Open);
    }

    #[test]
    fn the_letter_stops_at_what_covers_most() {
        let node =
            |parent, children| Node { bounds: Bounds::EMPTY, parent, children, objects: 0..1 };
        let tree =
            Tree { nodes: vec![node(0, 1..3), node(0, 0..0), node(0, 0..0)], objects: vec![] };
        assert_eq!(by_the_letter(&tree, &[30, 10, 20], 5), [0]);
        assert_eq!(by_the_letter(&tree, &[3, 10, 20], 5).len(), 2);
        assert!(by_the_letter(&tree, &[3, 1, 2], 5).is_empty());
    }
}
