//! Faces of a frame: its view cells, and the directions that what is seen of them faces.

use crate::{SuiteError, night::Night};
use dapple_many_lights::region::{Direction, ViewCell};
use dapple_night_city::{
    Part, TAU_IMAGE_PX,
    cells::{NodeCell, WholeCells, each},
};
use dapple_occlusion::camera::{CellLimits, exact_coverage, view_cells};
use std::sync::Arc;

/// A cell and a direction that something in it faces.
#[derive(Clone, Debug)]
pub struct Question {
    /// Around all that lies below its node.
    pub cell: Arc<NodeCell>,
    /// Node of the city's hierarchy.
    pub node: u32,
    /// Towards which lights are asked for.
    pub direction: Direction,
}

impl Question {
    /// As techniques take it.
    pub fn asked(&self) -> (&ViewCell, Direction) {
        (&self.cell.cell, self.direction)
    }
}

/// How cells are cut.
#[derive(Clone, Copy, Debug)]
pub struct Cutting {
    /// Pixels of an image of 1200 x 900 beyond which a cell is divided.
    pub tau_px: f64,
    /// The smallest cell.
    pub split: Part,
}

/// The questions of a frame, cell by cell: coverage is exact, by rays.
///
/// # Errors
/// None for a town's own tree.
pub fn questions(
    night: &Night,
    frame: usize,
    cutting: Cutting,
    whole: &mut WholeCells,
) -> Result<Vec<Question>, SuiteError> {
    let town = &night.town;
    let pixels = night.pixels(frame);
    let mut coverage = vec![0; town.tree.nodes.len()];
    exact_coverage(&town.tree, &pixels, &mut coverage)?;
    let visible: Vec<u32> =
        (0..pixels.len() as u32).filter(|object| pixels[*object as usize] > 0).collect();
    let image = night.size.map(f64::from);
    let limits = CellLimits {
        tau_px: (cutting.tau_px * image[0] * image[1] / TAU_IMAGE_PX).round() as u32,
        most_level: town.most_level(cutting.split),
    };
    let cells = view_cells(&town.tree, &coverage, town.levels(), &visible, limits)?;
    let mut questions = Vec::new();
    for (index, shown) in cells.cells.iter().enumerate() {
        let cell = whole.of(town, shown.node);
        let needed = cells.objects_of(index).iter().fold(0, |all, o| all | cell.directions(*o));
        let of = |direction| Question { cell: Arc::clone(&cell), node: shown.node, direction };
        questions.extend(each(needed).map(of));
    }
    Ok(questions)
}
