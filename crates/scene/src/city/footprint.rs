//! Footprints: polygons with holes in the plane (x, z).
//!
//! Signs follow the types: seen from above an outer ring runs counter-clockwise, and
//! `0.5 Σ (x_{i+1} z_i - x_i z_{i+1})` is positive. Orientation tests are exact (crate `robust`),
//! triangles come from `earcut`.

use super::Footprint;
use glam::DVec2;
use robust::{Coord, orient2d};

/// Most corners of one footprint: crossings are looked for among all pairs of its edges.
pub const MAX_CORNERS: usize = 10_000;

/// A triangulation may miss this share of the area, by rounding.
const AREA_TOLERANCE: f64 = 1e-6;

/// Area of a ring in square metres, positive where it runs counter-clockwise seen from above.
pub fn signed_area(ring: &[DVec2]) -> f64 {
    // Relative to a corner: far from the origin the products would cancel.
    let Some(&first) = ring.first() else { return 0.0 };
    edges_of(ring)
        .map(|[a, b]| (a - first, b - first))
        .map(|(a, b)| b.x * a.y - a.x * b.y)
        .sum::<f64>()
        * 0.5
}

/// The edges of a closed ring.
pub fn edges_of(ring: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// Twice the area of the triangle, its sign exact: positive where it runs clockwise seen from above
/// (counter-clockwise with z to the top).
fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Whether two closed segments have a point in common.
fn meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    if !(a.min(b).cmple(c.max(d)).all() && c.min(d).cmple(a.max(b)).all()) {
        return false;
    }
    let apart = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    !apart(side(a, b, c), side(a, b, d)) && !apart(side(c, d, a), side(c, d, b))
}

/// How many edges a ray from `p` along +x crosses.
fn crossings(edges: impl Iterator<Item = [DVec2; 2]>, p: DVec2) -> usize {
    edges
        .filter(|&[a, b]| {
            // Half open in z, so that a corner counts once.
            (a.y <= p.y) != (b.y <= p.y) && (side(a, b, p) > 0.0) == (b.y > a.y)
        })
        .count()
}

impl Footprint {
    /// A polygon of these rings, turned the right way round; corners that repeat their neighbour,
    /// and corners less than `tolerance_m` off the line between their neighbours, are left out.
    ///
    /// # Errors
    /// One clause: fewer than three corners, no area, rings that cross, touch or lie outside, more
    /// than [`MAX_CORNERS`].
    pub fn new(
        outer: &[DVec2],
        holes: &[Vec<DVec2>],
        tolerance_m: f64,
    ) -> Result<Self, &'static str> {
        if outer.iter().chain(holes.iter().flatten()).any(|p| !p.is_finite()) {
            return Err("with corners that are not finite");
        }
        if outer.len() + holes.iter().map(Vec::len).sum::<usize>() > MAX_CORNERS {
            return Err("with more than 10000 corners");
        }
        let outer = turned(simplified(outer, tolerance_m)?, true)?;
        let holes = holes
            .iter()
            .map(|hole| turned(simplified(hole, tolerance_m)?, false))
            .collect::<Result<Vec<_>, _>>()?;
        let made = Self { outer, holes };
        made.check()?;
        Ok(made)
    }

    /// All rings, the outer first.
    pub fn rings(&self) -> impl Iterator<Item = &[DVec2]> + '_ {
        std::iter::once(&self.outer[..]).chain(self.holes.iter().map(|h| &h[..]))
    }

    /// All edges: the outer ring's, then each hole's. Facades follow this order.
    pub fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        self.rings().flat_map(edges_of)
    }

    /// Area without the holes, square metres.
    pub fn area_m2(&self) -> f64 {
        self.rings().map(signed_area).sum()
    }

    /// Lower and upper corner of the outer ring's bounds; infinite and empty for no corners.
    pub fn bounds(&self) -> [DVec2; 2] {
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        self.outer.iter().fold(start, |[lo, hi], &p| [lo.min(p), hi.max(p)])
    }

    /// Whether `p` is inside, holes left out. Points of an edge may fall on either side.
    pub fn contains(&self, p: DVec2) -> bool {
        crossings(self.edges(), p) % 2 == 1
    }

    /// Triangles that cover the polygon, facing up: counter-clockwise seen from above.
    ///
    /// # Errors
    /// One clause, where the triangles' area is not the polygon's.
    pub fn triangulate(&self) -> Result<Vec<[DVec2; 3]>, &'static str> {
        let corners: Vec<DVec2> = self.rings().flatten().copied().collect();
        let Some(&first) = corners.first() else { return Ok(vec![]) };
        let mut starts = vec![];
        let mut end = self.outer.len();
        for hole in &self.holes {
            starts.push(end as u32);
            end += hole.len();
        }
        let mut indices: Vec<u32> = vec![];
        let local = corners.iter().map(|&p| (p - first).to_array());
        earcut::Earcut::new().earcut(local, &starts, &mut indices);
        let mut triangles = Vec::with_capacity(indices.len() / 3);
        for t in indices.chunks_exact(3) {
            let mut t = [t[0], t[1], t[2]].map(|i| corners[i as usize]);
            if signed_area(&t) < 0.0 {
                t.swap(1, 2);
            }
            triangles.push(t);
        }
        let (area, covered) =
            (self.area_m2(), triangles.iter().map(|t| signed_area(t)).sum::<f64>());
        if (area - covered).abs() > AREA_TOLERANCE * area {
            return Err("that no triangulation covers");
        }
        Ok(triangles)
    }

    /// Rings are simple, do not meet, and every hole lies inside the outer one.
    fn check(&self) -> Result<(), &'static str> {
        for ring in self.rings() {
            let edges: Vec<_> = edges_of(ring).collect();
            for (i, &[a, b]) in edges.iter().enumerate() {
                for (j, &other) in edges.iter().enumerate().skip(i + 1) {
                    if j == i + 1 || (i == 0 && j + 1 == edges.len()) {
                        // Neighbours share a corner; they must not fold back onto each other.
                        let (corner, p, q) =
                            if j == i + 1 { (b, a, other[1]) } else { (a, b, other[0]) };
                        if side(p, corner, q) == 0.0 && (p - corner).dot(q - corner) > 0.0 {
                            return Err("that cross themselves");
                        }
                    } else if meet([a, b], other) {
                        return Err("that cross themselves");
                    }
                }
            }
        }
        for (i, hole) in self.holes.iter().enumerate() {
            let others = std::iter::once(&self.outer).chain(&self.holes[..i]);
            for other in others {
                if edges_of(hole).any(|e| edges_of(other).any(|o| meet(e, o))) {
                    return Err("whose courtyards touch another ring");
                }
            }
            // Inside the outer ring, and inside no other hole.
            let around = self.rings().enumerate().filter(|(ring, _)| *ring != i + 1);
            if around.map(|(_, ring)| crossings(edges_of(ring), hole[0]) % 2).sum::<usize>() != 1
                || crossings(edges_of(&self.outer), hole[0]) % 2 == 0
            {
                return Err("whose courtyards lie outside");
            }
        }
        Ok(())
    }
}

fn turned(mut ring: Vec<DVec2>, positive: bool) -> Result<Vec<DVec2>, &'static str> {
    let area = signed_area(&ring);
    if area == 0.0 {
        return Err("without area");
    }
    if (area > 0.0) != positive {
        ring.reverse();
    }
    Ok(ring)
}

/// The ring without repeated corners and corners that bend it by less than `tolerance_m`.
fn simplified(ring: &[DVec2], tolerance_m: f64) -> Result<Vec<DVec2>, &'static str> {
    let mut kept: Vec<DVec2> = Vec::with_capacity(ring.len());
    for &p in ring {
        if kept.last() != Some(&p) {
            kept.push(p);
        }
    }
    while kept.len() > 1 && kept.first() == kept.last() {
        kept.pop();
    }
    // Against the last corner that was kept, so that a fine curve is not worn away.
    let mut straight: Vec<DVec2> = Vec::with_capacity(kept.len());
    let mut skipped: Vec<DVec2> = vec![];
    for (i, &p) in kept.iter().enumerate() {
        let next = kept[(i + 1) % kept.len()];
        if let Some(&before) = straight.last() {
            skipped.push(p);
            if skipped.iter().all(|&q| between(before, q, next, tolerance_m)) {
                continue;
            }
            skipped.clear();
        }
        straight.push(p);
    }
    if straight.len() < 3 {
        return Err("with fewer than three corners");
    }
    Ok(straight)
}

/// Whether `q` lies within `tolerance_m` of the segment from `a` to `b`, and between its ends.
fn between(a: DVec2, q: DVec2, b: DVec2, tolerance_m: f64) -> bool {
    let along = b - a;
    let Some(direction) = along.try_normalize() else { return false };
    let t = (q - a).dot(direction);
    t > 0.0 && t < along.length() && (q - a).perp_dot(direction).abs() <= tolerance_m
}
