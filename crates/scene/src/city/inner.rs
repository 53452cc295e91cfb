//! Inner boxes: upright boxes that lie entirely within a building's prism, so that whatever they
//! hide the building hides as well.
//!
//! In the frame of a footprint's dominant edges a grid is laid through its corners, and finer where
//! there are few. A cell that no edge enters is inside or outside as a whole, so the largest
//! rectangle of inside cells (by the stack over a histogram, row by row) holds no edge; its sides
//! are then moved outwards to the nearest edge. Further boxes are chosen by what they add. Each box
//! is shrunk by a margin and proved on its own ([`holds`]) before it is given out.

use super::{Footprint, OrientedBox};
use glam::{DVec2, DVec3};

/// What inner boxes are sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnerKnobs {
    /// Most boxes of one building.
    pub most: u32,
    /// Stop where a further box adds less than this share of the footprint's area.
    pub least_gain: f64,
    /// Distance that a box keeps from walls, ground and eaves, metres.
    pub margin_m: f64,
}

impl Default for InnerKnobs {
    fn default() -> Self {
        Self { most: 4, least_gain: 0.05, margin_m: 1e-3 }
    }
}

/// Frames tried: the dominant direction of the edges and the next that differs.
const FRAMES: usize = 2;
/// Grid lines along each side of the frame, corners included.
const LINES: usize = 64;
/// Lines at even distances, between those through corners.
const EVEN_LINES: usize = 24;
/// The longest edges decide the frame.
const VOTERS: usize = 256;
/// Edges within this angle of a direction count for it, degrees.
const VOTE_DEG: f64 = 1.0;
/// The next frame differs by at least this angle, degrees.
const APART_DEG: f64 = 10.0;
/// Rounding of frame coordinates, as a share of the footprint's extent.
const ROUNDING: f64 = 1e-12;

/// Boxes within the prism over `footprint` from `base_m` to `eaves_m`, largest first. Fewer than
/// asked for, or none, where the footprint is too narrow.
pub fn inner_boxes(
    footprint: &Footprint,
    base_m: f64,
    eaves_m: f64,
    knobs: &InnerKnobs,
) -> Vec<OrientedBox> {
    let area = footprint.area_m2();
    let half_height = 0.5 * (eaves_m - base_m) - knobs.margin_m;
    if !(area > 0.0 && area.is_finite() && half_height > 0.0) {
        return vec![];
    }
    let frames: Vec<Frame> =
        directions(footprint).into_iter().map(|a| Frame::new(footprint, a)).collect();
    let mut rectangles: Vec<Rectangle> = vec![];
    let mut boxes: Vec<OrientedBox> = vec![];
    while boxes.len() < knobs.most as usize {
        let candidates = frames.iter().filter_map(|f| f.largest(&rectangles));
        let Some((gain, rectangle)) = candidates.reduce(|a, b| if b.0 > a.0 { b } else { a })
        else {
            break;
        };
        if gain < knobs.least_gain * area {
            break;
        }
        // Kept whether or not it passes, so that the next search looks elsewhere.
        rectangles.push(rectangle);
        let half = rectangle.half - DVec2::splat(knobs.margin_m);
        let made = OrientedBox {
            centre: DVec3::new(rectangle.centre.x, 0.5 * (base_m + eaves_m), rectangle.centre.y),
            axis: rectangle.axis,
            half: DVec3::new(half.x, half_height, half.y),
        };
        if half.min_element() > 0.0 && holds(footprint, &made) {
            boxes.push(made);
        } else if rectangles.len() >= 2 * knobs.most as usize {
            break;
        }
    }
    boxes.sort_by(|a, b| b.volume_m3().total_cmp(&a.volume_m3()));
    boxes
}

/// Whether the box's plan lies entirely inside the footprint: its middle does, and no edge meets it.
pub fn holds(footprint: &Footprint, inner: &OrientedBox) -> bool {
    let centre = DVec2::new(inner.centre.x, inner.centre.z);
    let half = DVec2::new(inner.half.x, inner.half.z);
    let frame =
        |p: DVec2| DVec2::new((p - centre).dot(inner.axis), inner.axis.perp_dot(p - centre));
    footprint.contains(centre)
        && !footprint.edges().any(|[a, b]| clip(frame(a), frame(b), -half, half).is_some())
}

/// Share of the footprint's area that the boxes cover together, each place counted once, to about
/// 1e-3.
pub fn covered_share(footprint: &Footprint, boxes: &[OrientedBox]) -> f64 {
    const ROWS: usize = 1024;
    let [lo, hi] = footprint.bounds();
    let (area, step) = (footprint.area_m2(), (hi.y - lo.y) / ROWS as f64);
    if !(area > 0.0 && step > 0.0) {
        return 0.0;
    }
    let mut covered = 0.0;
    let mut spans: Vec<[f64; 2]> = vec![];
    for row in 0..ROWS {
        let z = lo.y + (row as f64 + 0.5) * step;
        spans.clear();
        spans.extend(boxes.iter().filter_map(|b| span(b, z)));
        covered += union_length(&mut spans) * step;
    }
    covered / area
}

/// Length of the union of intervals, which are put in order.
pub(crate) fn union_length(spans: &mut [[f64; 2]]) -> f64 {
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut total, mut reached) = (0.0, f64::NEG_INFINITY);
    for &[from, to] in &*spans {
        total += (to - from.max(reached)).max(0.0);
        reached = reached.max(to);
    }
    total
}

/// Where the line of this z crosses a box's plan.
fn span(b: &OrientedBox, z: f64) -> Option<[f64; 2]> {
    let corners = b.corners();
    let plan = [0, 1, 5, 4].map(|i: usize| DVec2::new(corners[i].x, corners[i].z));
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..4 {
        let (p, q) = (plan[i], plan[(i + 1) % 4]);
        if (p.y <= z) != (q.y <= z) {
            let x = p.x + (z - p.y) / (q.y - p.y) * (q.x - p.x);
            range = [range[0].min(x), range[1].max(x)];
        }
    }
    (range[0] <= range[1]).then_some(range)
}

/// The part of a segment inside the closed rectangle, if there is any (Liang and Barsky).
fn clip(a: DVec2, b: DVec2, lo: DVec2, hi: DVec2) -> Option<[DVec2; 2]> {
    let d = b - a;
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (p, q) in [(-d.x, a.x - lo.x), (d.x, hi.x - a.x), (-d.y, a.y - lo.y), (d.y, hi.y - a.y)] {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            from = from.max(q / p);
        } else {
            to = to.min(q / p);
        }
    }
    (from <= to).then(|| [a + d * from, a + d * to])
}

/// Unit directions of the frames, best first; each in x > 0, z >= 0, since boxes are the same after a
/// quarter turn.
fn directions(footprint: &Footprint) -> Vec<DVec2> {
    let mut edges: Vec<(f64, DVec2)> = footprint
        .edges()
        .map(|[a, b]| ((b - a).length(), b - a))
        // By division: an edge along x then gives (1, 0) exactly.
        .map(|(length, d)| (length, first_quadrant(d / length)))
        .filter(|(length, d)| *length > 0.0 && d.is_finite())
        .collect();
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    edges.truncate(VOTERS);
    let votes = |direction: DVec2| -> f64 {
        let near = edges.iter().filter(|(_, d)| turn_deg(direction, *d) <= VOTE_DEG);
        near.map(|(length, _)| length).sum()
    };
    let mut ranked: Vec<(f64, DVec2)> = edges.iter().map(|&(_, d)| (votes(d), d)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<DVec2> = vec![];
    for (_, d) in ranked {
        if chosen.len() < FRAMES && chosen.iter().all(|c| turn_deg(*c, d) >= APART_DEG) {
            chosen.push(d);
        }
    }
    chosen
}

/// The same up to quarter turns, with x > 0 and y >= 0.
fn first_quadrant(d: DVec2) -> DVec2 {
    let mut d = d;
    while !(d.x > 0.0 && d.y >= 0.0) {
        d = DVec2::new(-d.y, d.x);
        if !d.is_finite() || d == DVec2::ZERO {
            return DVec2::X;
        }
    }
    // Without the minus sign that a turned 0 carries.
    d + DVec2::ZERO
}

/// Angle between two directions up to quarter turns, degrees in 0..=45.
fn turn_deg(a: DVec2, b: DVec2) -> f64 {
    let angle = a.perp_dot(b).atan2(a.dot(b)).to_degrees().rem_euclid(90.0);
    angle.min(90.0 - angle)
}

/// A rectangle of the plane, not yet shrunk.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    centre: DVec2,
    axis: DVec2,
    half: DVec2,
}

impl Rectangle {
    fn contains(&self, p: DVec2) -> bool {
        let d = p - self.centre;
        d.dot(self.axis).abs() <= self.half.x && self.axis.perp_dot(d).abs() <= self.half.y
    }
}

/// The footprint turned so that `axis` is the first coordinate, and which cells of a grid are
/// inside it.
struct Frame {
    axis: DVec2,
    /// World point that frame coordinates are relative to.
    origin: DVec2,
    edges: Vec<[DVec2; 2]>,
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// Row by row.
    inside: Vec<bool>,
}

impl Frame {
    fn new(footprint: &Footprint, axis: DVec2) -> Self {
        let [lo, hi] = footprint.bounds();
        let origin = 0.5 * (lo + hi);
        let turned = |p: DVec2| DVec2::new((p - origin).dot(axis), axis.perp_dot(p - origin));
        let edges: Vec<[DVec2; 2]> = footprint.edges().map(|e| e.map(turned)).collect();
        let columns = lines(edges.iter().map(|e| e[0].x).collect());
        let rows = lines(edges.iter().map(|e| e[0].y).collect());
        let mut frame = Self { axis, origin, edges, columns, rows, inside: vec![] };
        frame.mark();
        frame
    }

    fn rounding(&self) -> f64 {
        let extent = |l: &[f64]| l.last().unwrap_or(&0.0) - l.first().unwrap_or(&0.0);
        ROUNDING * extent(&self.columns).max(extent(&self.rows))
    }

    /// Fills `inside`: the middle is inside, and no edge enters.
    fn mark(&mut self) {
        let eps = self.rounding();
        let width = self.columns.len().saturating_sub(1);
        for row in self.rows.windows(2) {
            let middle = 0.5 * (row[0] + row[1]);
            let mut crossings: Vec<f64> = vec![];
            let mut entered = vec![false; width];
            for &[a, b] in &self.edges {
                if (a.y <= middle) != (b.y <= middle) {
                    crossings.push(a.x + (middle - a.y) / (b.y - a.y) * (b.x - a.x));
                }
                let (lo, hi) =
                    (DVec2::new(f64::MIN, row[0] + eps), DVec2::new(f64::MAX, row[1] - eps));
                let Some([p, q]) = clip(a, b, lo, hi) else { continue };
                let (from, to) = (p.x.min(q.x), p.x.max(q.x));
                let first = self.columns.partition_point(|&c| c <= from + eps).saturating_sub(1);
                for (i, cell) in self.columns.windows(2).enumerate().skip(first) {
                    if cell[0] + eps >= to {
                        // A segment along a line enters no cell; further cells begin beyond it.
                        if cell[0] >= to + eps {
                            break;
                        }
                        continue;
                    }
                    if cell[1] - eps > from {
                        entered[i] = true;
                    }
                }
            }
            crossings.sort_by(f64::total_cmp);
            for (i, cell) in self.columns.windows(2).enumerate() {
                let left = crossings.partition_point(|&c| c < 0.5 * (cell[0] + cell[1]));
                self.inside.push(left % 2 == 1 && !entered[i]);
            }
        }
    }

    /// The rectangle that adds most area to `chosen`, and how much that is.
    fn largest(&self, chosen: &[Rectangle]) -> Option<(f64, Rectangle)> {
        let (width, height) = (self.columns.len().checked_sub(1)?, self.rows.len().checked_sub(1)?);
        // Sums of the area not yet covered, over all cells below and to the left.
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        let at = |i: usize, j: usize| j * (width + 1) + i;
        for j in 0..height {
            for i in 0..width {
                let cell = DVec2::new(self.columns[i], self.rows[j]);
                let end = DVec2::new(self.columns[i + 1], self.rows[j + 1]);
                let middle = self.world(0.5 * (cell + end));
                let free = self.inside[j * width + i] && !chosen.iter().any(|r| r.contains(middle));
                let own = if free { (end - cell).element_product() } else { 0.0 };
                sums[at(i + 1, j + 1)] =
                    own + sums[at(i, j + 1)] + sums[at(i + 1, j)] - sums[at(i, j)];
            }
        }
        let mut best: Option<(f64, [usize; 4])> = None;
        let mut depth = vec![0usize; width + 1];
        for j in 0..height {
            for (deep, inside) in depth.iter_mut().zip(&self.inside[j * width..(j + 1) * width]) {
                *deep = if *inside { *deep + 1 } else { 0 };
            }
            // Open rectangles: first column and depth, growing. The last column closes all.
            let mut open: Vec<(usize, usize)> = vec![];
            for i in 0..=width {
                let mut first = i;
                while let Some(&(start, deep)) = open.last() {
                    if deep < depth[i] {
                        break;
                    }
                    open.pop();
                    first = start;
                    let below = j + 1 - deep;
                    let gain = sums[at(i, j + 1)] - sums[at(start, j + 1)] - sums[at(i, below)]
                        + sums[at(start, below)];
                    if deep > 0 && best.is_none_or(|(most, _)| gain > most) {
                        best = Some((gain, [start, i, below, j + 1]));
                    }
                }
                open.push((first, depth[i]));
            }
        }
        let (gain, [left, right, below, above]) = best?;
        let lo = DVec2::new(self.columns[left], self.rows[below]);
        let hi = DVec2::new(self.columns[right], self.rows[above]);
        let [lo, hi] = self.grown(lo, hi);
        let centre = self.world(0.5 * (lo + hi));
        Some((gain, Rectangle { centre, axis: self.axis, half: 0.5 * (hi - lo) }))
    }

    /// Moves each side out to the nearest edge beside it.
    fn grown(&self, mut lo: DVec2, mut hi: DVec2) -> [DVec2; 2] {
        let eps = self.rounding();
        for side in [0, 1, 0, 1] {
            let other = 1 - side;
            let (mut from, mut to) = (DVec2::splat(f64::MIN), DVec2::splat(f64::MAX));
            (from[other], to[other]) = (lo[other] + eps, hi[other] - eps);
            let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
            let middle = 0.5 * (lo[side] + hi[side]);
            for &[a, b] in &self.edges {
                for p in clip(a, b, from, to).into_iter().flatten() {
                    if p[side] < middle {
                        below = below.max(p[side]);
                    } else {
                        above = above.min(p[side]);
                    }
                }
            }
            if below.is_finite() && above.is_finite() {
                (lo[side], hi[side]) = (below.min(lo[side]), above.max(hi[side]));
            }
        }
        [lo, hi]
    }

    fn world(&self, p: DVec2) -> DVec2 {
        self.origin + self.axis * p.x + DVec2::new(-self.axis.y, self.axis.x) * p.y
    }
}

/// Grid lines through corners, thinned or filled up.
fn lines(mut corners: Vec<f64>) -> Vec<f64> {
    corners.sort_by(f64::total_cmp);
    let (Some(&lo), Some(&hi)) = (corners.first(), corners.last()) else { return vec![] };
    let apart = |l: &mut Vec<f64>| l.dedup_by(|b, a| *b - *a <= ROUNDING * (hi - lo));
    apart(&mut corners);
    if corners.len() > LINES {
        let all = std::mem::take(&mut corners);
        corners.extend((0..LINES).map(|i| all[i * (all.len() - 1) / (LINES - 1)]));
    } else {
        corners.extend((1..EVEN_LINES).map(|i| lo + (hi - lo) * i as f64 / EVEN_LINES as f64));
        corners.sort_by(f64::total_cmp);
        apart(&mut corners);
    }
    corners
}
