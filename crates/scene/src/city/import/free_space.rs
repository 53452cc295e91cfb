//! Where a camera can stand: a raster of the distance to the nearest wall, tree or border.

use crate::city::City;
use glam::DVec2;

/// Side of a cell, metres: narrower passages count as closed.
const CELL_M: f64 = 1.0;
/// Largest side of the square that is looked at, metres.
const WINDOW_M: f64 = 1024.0;
/// What is kept clear around a trunk, metres.
const TREE_M: f64 = 1.0;

/// Distances over a window of the city.
pub struct FreeSpace {
    origin: DVec2,
    size: [usize; 2],
    /// Metres to the nearest obstacle, row by row; 0 on obstacles. Approximate to a cell.
    distance: Vec<f32>,
}

impl FreeSpace {
    /// Around the middle building, as far as buildings reach and the window goes. `None` without
    /// buildings.
    pub fn new(city: &City) -> Option<Self> {
        let middles: Vec<DVec2> = city
            .buildings
            .iter()
            .map(|b| b.footprint.bounds())
            .map(|[lo, hi]| 0.5 * (lo + hi))
            .collect();
        let median = |axis: usize| {
            let mut all: Vec<f64> = middles.iter().map(|m| m[axis]).collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied()
        };
        let middle = DVec2::new(median(0)?, median(1)?);
        let reach = DVec2::splat(0.5 * WINDOW_M);
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for building in &city.buildings {
            let [a, b] = building.footprint.bounds();
            (lo, hi) = (lo.min(a), hi.max(b));
        }
        let (lo, hi) = (lo.max(middle - reach), hi.min(middle + reach));
        let cells = ((hi - lo) / CELL_M).ceil().max(DVec2::ONE);
        let size = [cells.x as usize, cells.y as usize];
        let far = (size[0] + size[1]) as f32 * CELL_M as f32;
        let mut space = Self { origin: lo, size, distance: vec![far; size[0] * size[1]] };
        for building in &city.buildings {
            space.fill(building.footprint.edges());
        }
        for tree in &city.trees {
            let at = DVec2::new(tree.position.x, tree.position.z);
            let d = DVec2::splat(TREE_M);
            space.close(at - d, at + d);
        }
        space.spread();
        Some(space)
    }

    /// Lower and upper corner of the window.
    pub fn bounds(&self) -> [DVec2; 2] {
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64) * CELL_M;
        [self.origin, self.origin + size]
    }

    /// Metres to the nearest obstacle, 0 outside the window.
    pub fn clearance(&self, p: DVec2) -> f64 {
        let cell = ((p - self.origin) / CELL_M).floor();
        let inside = cell.x >= 0.0 && cell.y >= 0.0;
        let (x, y) = (cell.x as usize, cell.y as usize);
        if !inside || x >= self.size[0] || y >= self.size[1] {
            return 0.0;
        }
        f64::from(self.distance[y * self.size[0] + x])
    }

    /// How far one can go from `p` along a unit direction keeping `clear_m`, at most `most_m`.
    pub fn free_m(&self, p: DVec2, direction: DVec2, clear_m: f64, most_m: f64) -> f64 {
        let mut gone = 0.0;
        while gone < most_m {
            let clearance = self.clearance(p + direction * gone);
            if clearance < clear_m {
                return gone;
            }
            // Distances are up to 8 % too long.
            gone += (0.9 * (clearance - clear_m)).max(0.5 * CELL_M);
        }
        most_m
    }

    /// Closes the cells whose middle is inside, by the parity of crossings, and those that the
    /// edges touch.
    fn fill(&mut self, edges: impl Iterator<Item = [DVec2; 2]>) {
        let edges: Vec<[DVec2; 2]> = edges.map(|e| e.map(|p| (p - self.origin) / CELL_M)).collect();
        let mut rows = [f64::INFINITY, f64::NEG_INFINITY];
        for e in &edges {
            rows = [rows[0].min(e[0].y), rows[1].max(e[0].y)];
        }
        let last = self.size[1].saturating_sub(1) as f64;
        let (first, last) = (rows[0].floor().clamp(0.0, last), rows[1].floor().clamp(0.0, last));
        for row in first as usize..=last as usize {
            let middle = row as f64 + 0.5;
            let mut crossings: Vec<f64> = vec![];
            for [a, b] in &edges {
                if (a.y <= middle) != (b.y <= middle) {
                    crossings.push(a.x + (middle - a.y) / (b.y - a.y) * (b.x - a.x));
                }
                // The part of the edge within the row.
                let within = |y: f64| y.clamp(row as f64, row as f64 + 1.0);
                let (p, q) = (within(a.y.min(b.y)), within(a.y.max(b.y)));
                if a.y.min(b.y) > p || a.y.max(b.y) < q {
                    continue;
                }
                let x = |y: f64| {
                    if a.y == b.y { a.x } else { a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x) }
                };
                let (from, to) = if a.y == b.y { (a.x, b.x) } else { (x(p), x(q)) };
                self.close_row(row, from.min(to), from.max(to) + 1.0);
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                self.close_row(row, pair[0], pair[1]);
            }
        }
    }

    /// Cells from that of `from` up to before that of `to`.
    fn close_row(&mut self, row: usize, from: f64, to: f64) {
        let cell = |x: f64| x.floor().clamp(0.0, self.size[0] as f64) as usize;
        let (from, to) = (cell(from), cell(to));
        if from < to {
            self.distance[row * self.size[0]..][from..to].fill(0.0);
        }
    }

    fn close(&mut self, lo: DVec2, hi: DVec2) {
        let (lo, hi) = ((lo - self.origin) / CELL_M, (hi - self.origin) / CELL_M);
        for row in 0..self.size[1] {
            if (row as f64) + 1.0 > lo.y && (row as f64) < hi.y {
                self.close_row(row, lo.x, hi.x + 1.0);
            }
        }
    }

    /// Distances from the closed cells by two sweeps (Borgefors, "Distance transformations in
    /// digital images", 1986, with 1 and √2). Never more than the true distance to a cell's middle
    /// by more than 8 %.
    fn spread(&mut self) {
        let [w, h] = self.size;
        let (straight, diagonal) = (CELL_M as f32, (CELL_M * std::f64::consts::SQRT_2) as f32);
        for y in 0..h {
            for x in 0..w {
                let mut d = self.distance[y * w + x];
                if x > 0 {
                    d = d.min(self.distance[y * w + x - 1] + straight);
                }
                if y > 0 {
                    let above = &self.distance[(y - 1) * w..y * w];
                    d = d.min(above[x] + straight);
                    if x > 0 {
                        d = d.min(above[x - 1] + diagonal);
                    }
                    if x + 1 < w {
                        d = d.min(above[x + 1] + diagonal);
                    }
                }
                self.distance[y * w + x] = d;
            }
        }
        for y in (0..h).rev() {
            for x in (0..w).rev() {
                let mut d = self.distance[y * w + x];
                if x + 1 < w {
                    d = d.min(self.distance[y * w + x + 1] + straight);
                }
                if y + 1 < h {
                    let below = &self.distance[(y + 1) * w..(y + 2) * w];
                    d = d.min(below[x] + straight);
                    if x > 0 {
                        d = d.min(below[x - 1] + diagonal);
                    }
                    if x + 1 < w {
                        d = d.min(below[x + 1] + diagonal);
                    }
                }
                self.distance[y * w + x] = d;
            }
        }
    }
}
