//! Deep shadow map: the transmittance along a ray as few straight pieces as an error allows.
//!
//! Based on: Tom Lokovic, Eric Veach, "Deep shadow maps", SIGGRAPH 2000, §3.3 (compression: from
//! each node, the range of slopes that pass through the error windows of all vertices so far is
//! narrowed vertex by vertex; when it is empty the piece ends at the vertex before, on the middle
//! of the range) and §3.4 (lookup by search).
//!
//! The curve is a staircase, each step two vertices at one depth. No piece passes both windows of
//! a step higher than twice the tolerance: there the curve keeps two nodes at one depth, the lower
//! on the step's own value. |T - truth| is at most the tolerance; T is exactly 1 up to and
//! including the first fragment's depth, and constant behind the last. With a tolerance of 0 every
//! step is kept and T is exact.
//!
//! Deviations: slopes are kept at or below 0, so that T is monotone (a falling curve always leaves
//! room for that: its windows only sink), and windows within 0..=1; the last piece aims at its
//! vertex, not at the middle. Where more nodes would be needed than there is room for, the
//! tolerance of that texel is doubled until they fit. Curves are worked out in f64 and rounded
//! when a texel is done, so that rounding never decides where a piece ends.

use crate::{Deep, Fragment, code::TexelCode, gather};

/// Tolerance tried after 0, when the nodes do not fit.
const FIRST_TOLERANCE: f64 = 1.0 / 1024.0;

/// The number of nodes, then pairs of depth and transmittance by depth. Capacity, not use, is
/// fixed: a stored map would hold used nodes alone (see [`used_bytes`]).
pub struct Code(pub Deep);

/// A node or a vertex: depth and transmittance.
type Point = [f64; 2];

/// A piece that is still open: where it begins, and its slopes so far.
struct Piece {
    from: Point,
    least: f64,
    most: f64,
    /// The last vertex whose window it passes.
    last: Point,
}

impl Piece {
    fn new(from: Point) -> Self {
        Self { from, least: f64::NEG_INFINITY, most: 0.0, last: from }
    }

    /// Whether it also passes the vertex's window; if so its slopes are narrowed.
    fn takes(&mut self, vertex: Point, tolerance: f64) -> bool {
        let (low, high) = window(vertex, tolerance);
        let run = vertex[0] - self.from[0];
        if run == 0.0 {
            return low <= self.from[1] && self.from[1] <= high;
        }
        let least = self.least.max((low - self.from[1]) / run);
        let most = self.most.min((high - self.from[1]) / run);
        if least > most {
            return false;
        }
        (self.least, self.most, self.last) = (least, most, vertex);
        true
    }

    /// Its end, on a slope within its range.
    fn end(&self, slope: f64) -> Point {
        let [depth, t] = self.from;
        [self.last[0], (t + slope * (self.last[0] - depth)).clamp(0.0, 1.0)]
    }
}

/// The error window of a vertex.
fn window([_, t]: Point, tolerance: f64) -> (f64, f64) {
    ((t - tolerance).max(0.0), (t + tolerance).min(1.0))
}

/// Writes the nodes of a staircase of fragments by depth; the number of nodes, or `None` where
/// they do not fit.
fn compress(sorted: &[Fragment], tolerance: f64, words: &mut [f32]) -> Option<usize> {
    let mut count = 0;
    let mut write = |point: Point| {
        let node = words.get_mut(2 * count..2 * count + 2)?;
        node.copy_from_slice(&[point[0] as f32, point[1] as f32]);
        count += 1;
        Some(())
    };
    let Some(first) = sorted.first() else { return Some(0) };
    let mut piece = Piece::new([f64::from(first.depth), 1.0]);
    write(piece.from)?;
    let mut omega = 0.0;
    let mut t = 1.0;
    let mut rest = sorted;
    while let Some(f) = rest.first() {
        let depth = f64::from(f.depth);
        let step = rest.iter().take_while(|g| g.depth == f.depth).count();
        omega += rest[..step].iter().map(|g| f64::from(g.omega)).sum::<f64>();
        rest = &rest[step..];
        let after = (-omega).exp();
        for vertex in [[depth, t], [depth, after]] {
            if piece.takes(vertex, tolerance) {
                continue;
            }
            if piece.last[0] > piece.from[0] {
                let end = piece.end(0.5 * (piece.least + piece.most));
                write(end)?;
                piece = Piece::new(end);
            }
            if !piece.takes(vertex, tolerance) {
                // No line reaches it: a step.
                let below = [piece.last[0], vertex[1]];
                write(below)?;
                piece = Piece::new(below);
                piece.takes(vertex, tolerance);
            }
        }
        t = after;
    }
    if piece.last[0] > piece.from[0] {
        let aim = (t - piece.from[1]) / (piece.last[0] - piece.from[0]);
        write(piece.end(aim.clamp(piece.least, piece.most)))?;
    }
    Some(count)
}

/// Transmittance of nodes (depth, transmittance) at a depth.
fn lookup<T: Copy>(nodes: &[T], point: impl Fn(T) -> Point, depth: f32) -> f64 {
    let depth = f64::from(depth);
    let after = nodes.partition_point(|&node| point(node)[0] < depth);
    let Some(before) = after.checked_sub(1) else { return 1.0 };
    let from = point(nodes[before]);
    let Some(&to) = nodes.get(after) else { return from[1] };
    let to = point(to);
    let share = (depth - from[0]) / (to[0] - from[0]);
    (from[1] + (to[1] - from[1]) * share).max(0.0)
}

impl TexelCode for Code {
    fn words(&self) -> usize {
        1 + 2 * self.0.nodes as usize
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        gather::sorted(fragments, opaque, scratch);
        let mut tolerance = f64::from(self.0.tolerance);
        words[0] = loop {
            match compress(scratch, tolerance, &mut words[1..]) {
                Some(count) => break count as f32,
                // Two nodes hold any curve within 1.
                None => tolerance = grown(tolerance),
            }
        };
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        let (nodes, _) = words[1..].as_chunks::<2>();
        let used = &nodes[..(words[0] as usize).min(nodes.len())];
        lookup(used, |node| node.map(f64::from), depth) as f32
    }

    fn bytes_per_texel(&self) -> u64 {
        4 + 8 * u64::from(self.0.nodes)
    }

    fn used_bytes(&self, words: &[f32]) -> u64 {
        4 + 8 * words[0] as u64
    }

    fn geometry_passes(&self) -> u64 {
        1
    }
}

/// The tolerance to try after one that needs too many nodes.
fn grown(tolerance: f64) -> f64 {
    (2.0 * tolerance).max(FIRST_TOLERANCE)
}

/// The same curve in f64 from all its vertices at once, and the tolerance it took. The processor's
/// form differs by the rounding of what it stores.
pub fn reference_curve(
    settings: &Deep,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
) -> (Vec<Point>, f64) {
    let vertices = staircase(fragments, opaque);
    let mut tolerance = f64::from(settings.tolerance);
    loop {
        let nodes = pieces(&vertices, tolerance);
        if nodes.len() <= settings.nodes as usize {
            return (nodes, tolerance);
        }
        tolerance = grown(tolerance);
    }
}

/// T(d) of [`reference_curve`].
pub fn reference(
    settings: &Deep,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    depth: f32,
) -> f64 {
    lookup(&reference_curve(settings, fragments, opaque).0, |node| node, depth)
}

/// Two vertices for each different depth, from the front.
fn staircase(fragments: &[Fragment], opaque: Option<Fragment>) -> Vec<Point> {
    let mut all: Vec<Fragment> = gather::everything(fragments, opaque).collect();
    all.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.omega.total_cmp(&b.omega)));
    let mut vertices = Vec::new();
    let mut omega = 0.0;
    for same in all.chunk_by(|a, b| a.depth == b.depth) {
        let depth = f64::from(same[0].depth);
        vertices.push([depth, f64::exp(-omega)]);
        omega += same.iter().map(|f| f64::from(f.omega)).sum::<f64>();
        vertices.push([depth, f64::exp(-omega)]);
    }
    vertices
}

/// Nodes of the pieces through all windows.
fn pieces(vertices: &[Point], tolerance: f64) -> Vec<Point> {
    let Some(&first) = vertices.first() else { return Vec::new() };
    let mut nodes = vec![first];
    let mut from = first;
    // Vertices from here on are not passed yet.
    let mut next = 1;
    while next < vertices.len() {
        let slopes = |vertex: &Point| {
            let (low, high) = window(*vertex, tolerance);
            let run = vertex[0] - from[0];
            let inside = low <= from[1] && from[1] <= high;
            match (run == 0.0, inside) {
                (true, true) => (f64::NEG_INFINITY, 0.0),
                (true, false) => (f64::INFINITY, f64::NEG_INFINITY),
                _ => ((low - from[1]) / run, (high - from[1]) / run),
            }
        };
        let (mut least, mut most) = (f64::NEG_INFINITY, 0.0);
        let mut end = next;
        for (low, high) in vertices[next..].iter().map(slopes) {
            let narrowed = (f64::max(least, low), f64::min(most, high));
            if narrowed.0 > narrowed.1 {
                break;
            }
            (least, most) = narrowed;
            end += 1;
        }
        let reached = if end > next { vertices[end - 1] } else { from };
        if reached[0] > from[0] {
            let run = reached[0] - from[0];
            let middle = 0.5 * (least + most);
            let aim = ((reached[1] - from[1]) / run).clamp(least, most);
            let slope = if end == vertices.len() { aim } else { middle };
            from = [reached[0], (from[1] + slope * run).clamp(0.0, 1.0)];
            nodes.push(from);
        } else if end < vertices.len() {
            from = [from[0], vertices[end][1]];
            nodes.push(from);
        }
        next = end;
    }
    nodes
}
