//! The strongest lights of every tile of a frame, rows of tiles in parallel.

use super::{Choice, Groups, strongest};
use crate::{
    Frame, Work,
    bound::packed::PackedRegion,
    cut::tile::{pixels, tiles},
};
use rayon::prelude::*;

/// Lists of a frame's tiles. They keep their memory from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    rows: Vec<Row>,
}

/// Lists of a row of tiles.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Where each tile's lights begin, and the end.
    pub first: Vec<usize>,
    /// Indices of lights, those of a tile in increasing order.
    pub lights: Vec<u32>,
    choice: Choice,
    work: Work,
}

impl Lists {
    /// Chooses at most `most` lights for every tile.
    pub fn fill(&mut self, groups: &Groups, frame: &Frame, most: usize, clamp_squared: f32) {
        let (columns, rows) = tiles(frame.width, frame.height);
        self.rows.resize(rows as usize, Row::default());
        self.rows.par_iter_mut().enumerate().for_each(|(row, out)| {
            out.first.clear();
            out.first.push(0);
            out.lights.clear();
            out.work = Work::default();
            // No frame knows of another: its choices, and their work, do not depend on what was lit.
            out.choice.lights.clear();
            for column in 0..columns {
                let pixels = pixels(frame.width, frame.height, column, row as u32);
                if let Some(over) = PackedRegion::of(pixels.map(|pixel| &frame.points[pixel])) {
                    strongest(groups, &over, most, clamp_squared, &mut out.choice);
                    out.lights.extend_from_slice(&out.choice.lights);
                    out.work.bounds += out.choice.bounds;
                    out.work.ended += u64::from(out.choice.ended);
                }
                out.first.push(out.lights.len());
            }
            out.work.entries = out.lights.len() as u64;
        });
    }

    /// Rows of tiles, top to bottom.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Lights of tile (`column`, `row`).
    pub fn of(&self, column: usize, row: usize) -> &[u32] {
        let row = &self.rows[row];
        &row.lights[row.first[column]..row.first[column + 1]]
    }

    /// Bounds, entries, and lists that the cap ended.
    pub fn work(&self) -> Work {
        let mut work = Work::default();
        self.rows.iter().for_each(|row| work += row.work);
        work
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let of = |row: &Row| {
            size_of::<usize>() * row.first.capacity() + size_of::<u32>() * row.lights.capacity()
        };
        self.rows.iter().map(of).sum::<usize>() as u64
    }
}
