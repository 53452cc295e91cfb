//! Layers of split rays without the split function.

use super::split::SplitFunction;

/// Cells of t that [`Cells`] tells apart.
const CELLS: usize = 1024;

/// Layers of those cells of t that no boundary crosses: the split function need not be evaluated
/// for fragments there.
#[derive(Clone, Debug)]
pub struct Cells(Vec<u16>);

impl Cells {
    /// A cell that a boundary crosses.
    const MIXED: u16 = u16::MAX;

    /// Evaluates `function` at the ends of cells; layers are H(t) `steps`.
    pub fn new(function: &SplitFunction, steps: f32) -> Self {
        let layer = |i: usize| (function.coordinate(i as f32 / CELLS as f32) * steps) as u16;
        let cell = |i| if layer(i) == layer(i + 1) { layer(i) } else { Self::MIXED };
        // A function that falls somewhere would be judged by the ends of cells alone.
        let at = (0..=2 * CELLS).map(|i| function.coordinate(i as f32 / (2 * CELLS) as f32));
        let rises = at.is_sorted();
        Self((0..CELLS).map(|i| if rises { cell(i) } else { Self::MIXED }).collect())
    }

    /// The layer at t, if its cell has one.
    #[inline]
    pub fn layer(&self, t: f32) -> Option<u32> {
        let cell = self.0.get((t.max(0.0) * CELLS as f32) as usize)?;
        (*cell != Self::MIXED).then_some(u32::from(*cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Split, SplitKind};

    #[test]
    fn cells_agree_with_the_function_and_few_are_crossed() {
        for kind in [SplitKind::Normalised, SplitKind::Listing, SplitKind::Positions] {
            for (lambda, steps) in [(0.3, 4), (1.0, 32), (1.0, 31), (0.7, 256)] {
                let function = SplitFunction::new(&Split { lambda, kind, width: 512 });
                let cells = Cells::new(&function, steps as f32);
                let mut checked = 0;
                for i in 0..=50_000 {
                    let t = i as f32 / 50_000.0;
                    if let Some(layer) = cells.layer(t) {
                        let c = function.coordinate(t) * steps as f32;
                        let tie = (c - c.round()).abs() < 1e-4;
                        assert!(layer == c as u32 || tie, "{kind:?} {lambda} {steps} {t}");
                        checked += 1;
                    }
                }
                assert!(checked > 50_000 - 60 * steps, "{kind:?} {steps}: {checked}");
            }
        }
    }

    #[test]
    fn a_function_that_falls_has_no_cells() {
        let split = Split { lambda: 1.0, kind: SplitKind::Listing, width: 4 };
        let falls = SplitFunction::with_table(&split, vec![0.0, 0.9, 0.2, 1.0]);
        let cells = Cells::new(&falls, 4.0);
        assert!((0..100).all(|i| cells.layer(i as f32 / 100.0).is_none()));
        let rises = SplitFunction::with_table(&split, vec![0.0, 0.2, 0.9, 1.0]);
        assert!(Cells::new(&rises, 4.0).layer(0.5).is_some());
    }
}
