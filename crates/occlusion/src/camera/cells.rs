//! View cells: parts of the hierarchy that cover about as many pixels each, so that what is
//! computed once for a cell serves about as many pixels.
//!
//! Based on: Conte 2018, section 4.1. Deviations: the text stops at nodes of *more* coverage than
//! the threshold, which the root always has; here nodes of more coverage are divided, so that a
//! higher threshold gives fewer cells, as its results have it. Coverage may be missing (nodes that
//! were not asked) although something is visible below: a node counts as covering at least one pixel
//! for every visible object below, and what has none below is left out.

#[cfg(test)]
mod tests;

use super::Tree;
use crate::OcclusionError;
use std::ops::Range;

/// Where the descent stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellLimits {
    /// Nodes of more pixels are divided; `u32::MAX` divides none.
    pub tau_px: u32,
    /// Nodes at this level or below are not divided; `u32::MAX` for no limit.
    pub most_level: u32,
}

/// A node and what is visible of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Index of the node: its bounds are the cell.
    pub node: u32,
    /// Visible objects below, a range of [`Cells::objects`]; never empty.
    pub objects: Range<u32>,
}

/// The view cells of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    /// In the order of the tree's objects.
    pub cells: Vec<Cell>,
    /// Visible objects, cell by cell.
    pub objects: Vec<u32>,
}

impl Cells {
    /// Visible objects of cell `index`.
    pub fn objects_of(&self, index: usize) -> &[u32] {
        let range = &self.cells[index].objects;
        &self.objects[range.start as usize..range.end as usize]
    }
}

/// The cells that the `visible` objects fall into: each into exactly one. `coverage` has the pixels
/// of every node, `levels` what [`CellLimits::most_level`] is compared with: [`Tree::levels`], or
/// [`Tree::path_lengths`] to stop at a kind of node.
///
/// # Errors
/// A list that is not as long as the tree, a visible object that the tree does not have.
pub fn view_cells(
    tree: &Tree,
    coverage: &[u32],
    levels: &[u32],
    visible: &[u32],
    limits: CellLimits,
) -> Result<Cells, OcclusionError> {
    for (element, length) in [("coverage", coverage.len()), ("levels", levels.len())] {
        if length != tree.nodes.len() {
            let limit = format!("{length} nodes, where the tree has {}", tree.nodes.len());
            return Err(OcclusionError::value(element, limit));
        }
    }
    let before = counts_before(tree, visible)?;
    let mut found = Cells::default();
    let mut open = Vec::new();
    if !tree.nodes.is_empty() {
        open.push(0_u32);
    }
    while let Some(index) = open.pop() {
        let node = &tree.nodes[index as usize];
        let range = node.objects.start as usize..node.objects.end as usize;
        let below = before[range.end] - before[range.start];
        if below == 0 {
            continue;
        }
        let pixels = coverage[index as usize].max(below);
        let divided = pixels > limits.tau_px && levels[index as usize] < limits.most_level;
        if divided && !node.children.is_empty() {
            open.extend(node.children.clone().rev());
            continue;
        }
        let start = found.objects.len() as u32;
        let shown = range.filter(|&place| before[place + 1] > before[place]);
        found.objects.extend(shown.map(|place| tree.objects[place]));
        found.cells.push(Cell { node: index, objects: start..found.objects.len() as u32 });
    }
    Ok(found)
}

/// Number of visible objects before each place of the tree's objects, and of all.
fn counts_before(tree: &Tree, visible: &[u32]) -> Result<Vec<u32>, OcclusionError> {
    let mut shown = vec![false; tree.objects.len()];
    for &object in visible {
        let Some(flag) = shown.get_mut(object as usize) else {
            let limit = format!("object {object}, where the tree has {}", tree.objects.len());
            return Err(OcclusionError::value("visible objects", limit));
        };
        *flag = true;
    }
    let mut count = 0;
    let mut before = Vec::with_capacity(tree.objects.len() + 1);
    before.push(0);
    for &object in &tree.objects {
        count += u32::from(shown[object as usize]);
        before.push(count);
    }
    Ok(before)
}
