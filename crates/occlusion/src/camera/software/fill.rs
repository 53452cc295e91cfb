//! Which pixels a triangle covers, span by span, and what is done with them.

use super::super::Mask;
use super::setup::{Edge, Masked, Row, SOLID, Triangle};
use std::ops::Range;

/// Some rows of the image: depth and ids of the pixels from row `first` on.
pub struct Band<'a> {
    pub first: u32,
    pub width: u32,
    pub depth: &'a mut [f32],
    pub ids: &'a mut [[u32; 2]],
}

/// Up to so many columns pixels are tested one by one, beyond the ends of a span are computed.
const NARROW: u32 = 8;

impl Band<'_> {
    /// Draws a triangle: the nearest wins, of equally near ones the first.
    #[inline(always)]
    pub fn draw(&mut self, triangle: &Triangle, masked: &[Masked], masks: &[Mask]) {
        let rows = self.first..self.first + self.ids.len() as u32 / self.width;
        if triangle.masked == SOLID {
            self.draw_where(triangle, rows, |_, _| true);
        } else {
            let coordinates = &masked[triangle.masked as usize];
            let mask = &masks[coordinates.mask as usize];
            self.draw_where(triangle, rows, |x, y| mask.at(coordinates.uv(x, y)));
        }
    }

    #[inline(always)]
    fn draw_where(
        &mut self,
        triangle: &Triangle,
        rows: Range<u32>,
        is_there: impl Fn(u32, u32) -> bool,
    ) {
        spans(triangle, rows, |y, columns| {
            let row = triangle.depth.row(y);
            let start = ((y - self.first) * self.width) as usize;
            let pixels = start + columns.start as usize..start + columns.end as usize;
            let drawn = self.depth[pixels.clone()].iter_mut().zip(&mut self.ids[pixels]);
            for (x, (drawn, id)) in columns.zip(drawn) {
                let depth = depth(triangle, &row, x);
                if depth > *drawn && is_there(x, y) {
                    *drawn = depth;
                    *id = triangle.id;
                }
            }
        });
    }
}

/// Samples of a triangle at least as near as `drawn`, an image of `width` columns.
#[inline(always)]
pub fn passing(triangle: &Triangle, width: u32, drawn: &[f32]) -> u32 {
    let mut count = 0_u32;
    let height = drawn.len() as u32 / width;
    spans(triangle, 0..height, |y, columns| {
        let row = triangle.depth.row(y);
        let start = (y * width) as usize;
        let pixels = start + columns.start as usize..start + columns.end as usize;
        for (x, drawn) in columns.zip(&drawn[pixels]) {
            count += u32::from(depth(triangle, &row, x) >= *drawn);
        }
    });
    count
}

// What is not a number becomes the least: such a plane belongs to a triangle seen edge-on.
#[inline(always)]
fn depth(triangle: &Triangle, row: &Row, x: u32) -> f32 {
    let [least, greatest] = triangle.range;
    let depth = row.at(x);
    let depth = if depth > least { depth } else { least };
    (if depth < greatest { depth } else { greatest }) as f32
}

/// The covered columns of each of `rows` that a triangle covers, top to bottom.
#[inline(always)]
fn spans(triangle: &Triangle, rows: Range<u32>, mut span: impl FnMut(u32, Range<u32>)) {
    let [first, last] = triangle.columns.map(u32::from);
    let top = u32::from(triangle.rows[0]).max(rows.start);
    let bottom = (u32::from(triangle.rows[1]) + 1).min(rows.end);
    let mut edges = triangle.edges;
    for edge in &mut edges {
        edge.at += edge.step_x * i64::from(first) + edge.step_y * i64::from(top);
    }
    let columns = last - first + 1;
    for y in top..bottom {
        let covered =
            if columns <= NARROW { narrow(&edges, columns) } else { wide(&edges, columns) };
        if !covered.is_empty() {
            span(y, first + covered.start..first + covered.end);
        }
        for edge in &mut edges {
            edge.at += edge.step_y;
        }
    }
}

// A negative edge function has its sign bit set, and so has what it is or-ed with.
#[inline(always)]
fn narrow(edges: &[Edge; 3], columns: u32) -> Range<u32> {
    let mut at = edges.map(|e| e.at);
    let mut step = |from: u32, inside: bool| {
        let mut x = from;
        while x < columns && ((at[0] | at[1] | at[2]) >= 0) != inside {
            for (at, edge) in at.iter_mut().zip(edges) {
                *at += edge.step_x;
            }
            x += 1;
        }
        x
    };
    let start = step(0, true);
    start..step(start, false)
}

fn wide(edges: &[Edge; 3], columns: u32) -> Range<u32> {
    let (mut start, mut end) = (0, i64::from(columns));
    for edge in edges {
        if edge.step_x > 0 {
            if edge.at < 0 {
                start = start.max((-edge.at + edge.step_x - 1) / edge.step_x);
            }
        } else if edge.at < 0 {
            return 0..0;
        } else if edge.step_x < 0 {
            end = end.min(edge.at / -edge.step_x + 1);
        }
    }
    if start < end { start as u32..end as u32 } else { 0..0 }
}
