//! The extended depth map of one plane.

use super::grid::Grid;
use crate::region::Cuboid;
use crate::region::horizon::{Projection, Umbra, project};
use std::ops::Range;

/// What is hidden on a plane, texel by texel: from every point of the cell, by something no farther
/// than the texel's depth.
pub(super) struct Map {
    /// Texels a side.
    texels: usize,
    /// w of the plane.
    pub plane: f64,
    columns: Grid,
    rows: Grid,
    /// Column by column; infinite where the texel is open. f32, rounded up.
    depth: Vec<f32>,
    /// Open texels to the left of and below each corner, `texels + 1` a column.
    open: Vec<u32>,
}

/// What a map says of an occludee.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// All its texels are hidden by what is nearer: what touches its near side does not hide it.
    Hidden,
    /// Some are.
    Partial,
    /// None is.
    Free,
}

/// A shadow on the plane, and how far away what throws it reaches.
pub(super) struct Drawn {
    pub umbra: Umbra,
    pub depth: f64,
}

/// A shadow in a column that it covers in part.
struct Part {
    u: [f64; 2],
    rows: Range<usize>,
    depth: f32,
}

/// The least f32 that is not below.
fn up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

impl Map {
    /// Without any plane.
    pub fn new(texels: usize) -> Self {
        let grid = Grid::new([0.0, 0.0], texels);
        Self { texels, plane: 0.0, columns: grid, rows: grid, depth: vec![], open: vec![] }
    }

    /// Begins a plane: nothing on it is hidden. The window is what the map holds of it: finite.
    pub fn clear(&mut self, plane: f64, window: &Projection) {
        self.plane = plane;
        self.columns = Grid::new(window.u, self.texels);
        self.rows = Grid::new(window.h, self.texels);
        self.depth.clear();
        self.depth.resize(self.texels * self.texels, f32::INFINITY);
    }

    /// Hides what everything drawn hides: texels that lie wholly in one shadow, and those that two
    /// touching shadows, one from each side, share.
    pub fn draw(&mut self, drawn: &[Drawn]) {
        let mut parts: Vec<(usize, Part)> = Vec::new();
        for Drawn { umbra, depth } in drawn {
            let depth = up(*depth);
            let inside = self.columns.within(umbra.u);
            for column in inside.clone() {
                let ends = [self.columns.edge(column), self.columns.edge(column + 1)];
                let rows = self.rows_under(umbra, ends);
                self.cover(column, rows, depth);
            }
            let Some(touched) = self.columns.around_clipped(umbra.u) else { continue };
            for column in touched.filter(|c| !inside.contains(c)) {
                let ends = [self.columns.edge(column), self.columns.edge(column + 1)];
                let u = [ends[0].max(umbra.u[0]), ends[1].min(umbra.u[1])];
                parts.push((column, Part { u, rows: self.rows_under(umbra, u), depth }));
            }
        }
        parts.sort_by_key(|(column, _)| *column);
        for same in parts.chunk_by(|a, b| a.0 == b.0) {
            let Some(&(column, _)) = same.first() else { continue };
            let ends = [self.columns.edge(column), self.columns.edge(column + 1)];
            for (_, left) in same.iter().filter(|(_, p)| p.u[0] <= ends[0]) {
                for (_, right) in same.iter().filter(|(_, p)| p.u[1] >= ends[1]) {
                    if left.u[1] >= right.u[0] {
                        let first = left.rows.start.max(right.rows.start);
                        let end = left.rows.end.min(right.rows.end);
                        self.cover(column, first..end, left.depth.max(right.depth));
                    }
                }
            }
        }
    }

    /// The rows that a shadow covers over a stretch inside it: it is convex.
    fn rows_under(&self, umbra: &Umbra, [from, to]: [f64; 2]) -> Range<usize> {
        self.rows.within([umbra.foot, umbra.height(from).min(umbra.height(to))])
    }

    fn cover(&mut self, column: usize, rows: Range<usize>, depth: f32) {
        let start = column * self.texels;
        if rows.start < rows.end {
            for texel in &mut self.depth[start + rows.start..start + rows.end] {
                *texel = texel.min(depth);
            }
        }
    }

    /// Hides the texels that `before`, the map of a nearer plane, hides from the whole cell: those whose
    /// projections on that plane lie on its hidden texels.
    pub fn erode(&mut self, cell: &Cuboid, before: &Self) {
        let depth = up(before.plane);
        let w = [self.plane; 2];
        let on = |u: [f64; 2], h: [f64; 2]| project(cell, &Cuboid { u, w, h }, before.plane);
        // The projection of a box is a product of two of lower dimension.
        let column = |i: usize| {
            let u = [self.columns.edge(i), self.columns.edge(i + 1)];
            before.columns.around(on(u, [0.0; 2]).u)
        };
        let row = |i: usize| {
            let h = [self.rows.edge(i), self.rows.edge(i + 1)];
            before.rows.around(on([0.0; 2], h).h)
        };
        let rows: Vec<Option<Range<usize>>> = (0..self.texels).map(row).collect();
        for i in 0..self.texels {
            let Some(columns) = column(i) else { continue };
            let texels = &mut self.depth[i * self.texels..(i + 1) * self.texels];
            for (texel, rows) in texels.iter_mut().zip(&rows) {
                if let Some(rows) = rows
                    && before.open_in(&columns, rows) == 0
                {
                    *texel = texel.min(depth);
                }
            }
        }
    }

    /// Counts open texels: before anything is asked.
    pub fn finish(&mut self) {
        let side = self.texels + 1;
        self.open.clear();
        self.open.resize(side * side, 0);
        for column in 0..self.texels {
            let mut below = 0;
            for row in 0..self.texels {
                below += u32::from(self.depth[column * self.texels + row] == f32::INFINITY);
                self.open[(column + 1) * side + row + 1] =
                    self.open[column * side + row + 1] + below;
            }
        }
    }

    fn open_in(&self, columns: &Range<usize>, rows: &Range<usize>) -> u32 {
        let at = |column: usize, row: usize| self.open[column * (self.texels + 1) + row];
        // Sums wrap, differences are right.
        at(columns.end, rows.end)
            .wrapping_add(at(columns.start, rows.start))
            .wrapping_sub(at(columns.start, rows.end))
            .wrapping_sub(at(columns.end, rows.start))
    }

    /// What covers a projection, of an occludee no part of which is nearer than `nearest`.
    pub fn test(&self, p: &Projection, nearest: f64) -> Verdict {
        if let (Some(columns), Some(rows)) = (self.columns.around(p.u), self.rows.around(p.h)) {
            let open = self.open_in(&columns, &rows);
            if open == 0 {
                let nearer = nearest > self.plane || self.farthest(columns, rows) < nearest;
                return if nearer { Verdict::Hidden } else { Verdict::Partial };
            }
        }
        let columns = self.columns.around_clipped(p.u);
        let (Some(columns), Some(rows)) = (columns, self.rows.around_clipped(p.h)) else {
            return Verdict::Free;
        };
        let open = self.open_in(&columns, &rows) as usize;
        if open == columns.len() * rows.len() { Verdict::Free } else { Verdict::Partial }
    }

    fn farthest(&self, columns: Range<usize>, rows: Range<usize>) -> f64 {
        let column =
            |c: usize| &self.depth[c * self.texels + rows.start..c * self.texels + rows.end];
        f64::from(columns.flat_map(column).fold(f32::NEG_INFINITY, |a, b| a.max(*b)))
    }

    /// Bytes of it.
    pub fn bytes(&self) -> u64 {
        4 * (self.depth.capacity() + self.open.capacity()) as u64
    }
}
