//! The upper edge of an umbra as it is by definition: slow, for tests and plots.

use super::super::Cuboid;
use super::point::{Corner, table};

/// The upper edge of an occluder's umbra on a plane as points (u, h) from left to right: over each
/// corner of the cell's top the upper hull of the projected top of the occluder, and the lowest of
/// the four. Empty where the four have no stretch in common, and where the occluder is not wholly
/// between the cell and the plane.
pub fn hull(cell: &Cuboid, occluder: &Cuboid, plane: f64) -> Vec<[f64; 2]> {
    if !(occluder.w[0] > cell.w[1] && occluder.w[1] <= plane) {
        return Vec::new();
    }
    let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let hulls = corners.map(|(u, w)| seen(cell.u[u], cell.w[w], cell.h[1], occluder, plane));
    let left = hulls.iter().map(|hull| hull[0][0]).fold(f64::NEG_INFINITY, f64::max);
    let right = hulls.iter().map(|hull| hull[hull.len() - 1][0]).fold(f64::INFINITY, f64::min);
    if left.partial_cmp(&right) != Some(std::cmp::Ordering::Less) {
        return Vec::new();
    }
    let mut places = vec![left, right];
    places.extend(hulls.iter().flatten().map(|vertex| vertex[0]));
    for (i, a) in hulls.iter().enumerate() {
        for b in &hulls[i + 1..] {
            places.extend(crossings(a, b));
        }
    }
    places.retain(|u| (left..=right).contains(u));
    places.sort_by(f64::total_cmp);
    places.dedup();
    let lowest = |u: f64| hulls.iter().map(|hull| height(hull, u)).fold(f64::INFINITY, f64::min);
    bends(places.into_iter().map(|u| [u, lowest(u)]))
}

/// The upper hull of the top of an occluder from one point.
fn seen(u: f64, w: f64, h: f64, occluder: &Cuboid, plane: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::with_capacity(4);
    for at_w in occluder.w {
        let k = (plane - w) / (at_w - w);
        points.extend(occluder.u.map(|at| [u + k * (at - u), h + k * (occluder.h[1] - h)]));
    }
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut hull: Vec<[f64; 2]> = Vec::with_capacity(4);
    for point in points {
        // Of points above each other only the highest counts.
        if hull.last().is_some_and(|last| last[0] == point[0]) {
            hull.pop();
        }
        while let [.., a, b] = hull[..]
            && (b[0] - a[0]) * (point[1] - a[1]) >= (point[0] - a[0]) * (b[1] - a[1])
        {
            hull.pop();
        }
        hull.push(point);
    }
    hull
}

/// Height of an edge at `u`, within it.
fn height(edge: &[[f64; 2]], u: f64) -> f64 {
    let Some(&[a, b]) =
        edge.array_windows().find(|[_, b]| u <= b[0]).or_else(|| edge.array_windows().last())
    else {
        return edge.first().map_or(f64::NAN, |point| point[1]);
    };
    let share = (u - a[0]) / (b[0] - a[0]);
    (1.0 - share) * a[1] + share * b[1]
}

/// Where two edges cross.
fn crossings(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<f64> {
    let mut found = Vec::new();
    for [p, q] in a.array_windows() {
        for [r, s] in b.array_windows() {
            let (left, right) = (p[0].max(r[0]), q[0].min(s[0]));
            if left < right {
                let apart = |u| height(&[*p, *q], u) - height(&[*r, *s], u);
                let (first, last) = (apart(left), apart(right));
                if first * last < 0.0 {
                    found.push(left + (right - left) * first / (first - last));
                }
            }
        }
    }
    found
}

/// Share of the heights by which points count as on one line.
const STRAIGHT: f64 = 1e-9;

/// Points without those that lie on the line of their neighbours.
fn bends(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., a, b] = kept[..] {
            let size = a[1].abs().max(b[1].abs()).max(point[1].abs());
            if (height(&[a, point], b[0]) - b[1]).abs() > STRAIGHT * size {
                break;
            }
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

/// Sides of the occluder's top that are part of the horizon of any point of the cell's top, which
/// decide its umbra: the thesis's union of edges, each once. The cell lies before the occluder.
pub fn union_of_edges(cell: &Cuboid, occluder: &Cuboid) -> Vec<[Corner; 2]> {
    let [a0, a1] = occluder.u;
    let mut places = vec![cell.u[0], cell.u[1]];
    // Of the middle section one place stands for all.
    let (first, last) = (cell.u[0].max(a0), cell.u[1].min(a1));
    if first <= last {
        places.push(0.5 * (first + last));
    }
    let mut edges: Vec<[Corner; 2]> = Vec::new();
    for u in places {
        let Some(list) = table([u, cell.w[1], cell.h[1]], occluder) else { continue };
        for &[a, b] in list.array_windows() {
            if !edges.contains(&[a, b]) && !edges.contains(&[b, a]) {
                edges.push([a, b]);
            }
        }
    }
    edges
}
