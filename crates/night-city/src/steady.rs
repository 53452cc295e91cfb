//! Cells that stay divided while they cover about as much as before.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.1 (cells by coverage).
//! Deviations: ours. A cell that covers a little more than the threshold in one frame and a little less
//! in the next costs evaluations of its parts and of itself in turn.

use dapple_occlusion::camera::{Cells, Tree};

/// What the last frame divided.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steady {
    /// One a node of the tree.
    divided: Vec<bool>,
    /// As if what stays divided covered more than the threshold.
    coverage: Vec<u32>,
}

impl Steady {
    /// Coverage by which what was divided stays so while it covers more than `rejoin` times `tau_px`.
    pub(crate) fn coverage<'a>(
        &'a mut self,
        tree: &Tree,
        coverage: &'a [u32],
        tau_px: u32,
        rejoin: f64,
    ) -> &'a [u32] {
        let least = (f64::from(tau_px) * rejoin).floor() as u32;
        if least >= tau_px || self.divided.len() != tree.nodes.len() {
            return coverage;
        }
        self.coverage.clear();
        self.coverage.extend(coverage.iter().zip(&self.divided).map(|(&pixels, &divided)| {
            if divided && pixels > least { pixels.max(tau_px.saturating_add(1)) } else { pixels }
        }));
        &self.coverage
    }

    /// What a frame divided: all nodes above its cells.
    pub(crate) fn divided(&mut self, tree: &Tree, cells: &Cells) {
        self.divided.clear();
        self.divided.resize(tree.nodes.len(), false);
        for cell in &cells.cells {
            let mut node = cell.node;
            while node != 0 {
                node = tree.nodes[node as usize].parent;
                if std::mem::replace(&mut self.divided[node as usize], true) {
                    break;
                }
            }
        }
    }
}
