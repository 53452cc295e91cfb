//! Roofs that meet their walls corner to corner.
//!
//! A storey's upper edge has the corners of its strips; a roof's edge beside it, drawn from end to
//! end, would leave gaps of parts of a pixel. So roofs get the same corners.

use super::Facade;
use super::templates::{STOREY, STRIPS};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// `triangles` with each edge that runs along the top of a facade cut at the corners of its strips.
pub fn cut(triangles: &[[DVec3; 3]], facades: &[Facade], eaves_m: f64) -> Vec<[DVec3; 3]> {
    // Only looked up, never walked through.
    let tops: HashMap<[u64; 4], &Facade> =
        facades.iter().map(|f| (ends(f.from, f.to), f)).collect();
    let corners = |a: DVec3, b: DVec3| -> Vec<DVec3> {
        if a.y != eaves_m || b.y != eaves_m {
            return vec![];
        }
        let (from, to) = (DVec2::new(a.x, a.z), DVec2::new(b.x, b.z));
        let along = |f: &Facade| {
            let inner = STRIPS[..STRIPS.len() - 1].iter();
            let scale = (f.to - f.from) / f64::from(STOREY[0]);
            inner.map(move |s| f.from + scale * f64::from(s.0)).collect::<Vec<DVec2>>()
        };
        let forwards = tops.get(&ends(from, to)).map(|f| along(f));
        let backwards = || {
            tops.get(&ends(to, from)).map(|f| along(f).into_iter().rev().collect::<Vec<DVec2>>())
        };
        let found = forwards.or_else(backwards).unwrap_or_default();
        found.into_iter().map(|p| DVec3::new(p.x, eaves_m, p.y)).collect()
    };
    let mut out = vec![];
    for &[a, b, c] in triangles {
        split([a, b, c], [corners(a, b), corners(b, c), corners(c, a)], &mut out);
    }
    out
}

/// Triangles between the corners of a triangle and those within its edges a-b, b-c, c-a.
fn split(corners: [DVec3; 3], within: [Vec<DVec3>; 3], out: &mut Vec<[DVec3; 3]>) {
    let Some(edge) = within.iter().position(|w| !w.is_empty()) else {
        out.push(corners);
        return;
    };
    let [a, b, c] = [0, 1, 2].map(|i| corners[(edge + i) % 3]);
    let [ab, bc, ca] = [0, 1, 2].map(|i| &within[(edge + i) % 3]);
    let points: Vec<DVec3> =
        std::iter::once(a).chain(ab.iter().copied()).chain(std::iter::once(b)).collect();
    let last = points.len() - 2;
    for (i, p) in points.windows(2).enumerate() {
        let first_edge = if i == 0 { ca.clone() } else { vec![] };
        let last_edge = if i == last { bc.clone() } else { vec![] };
        split([p[0], p[1], c], [vec![], last_edge, first_edge], out);
    }
}

/// The bits of two points; -0 counts as 0.
fn ends(from: DVec2, to: DVec2) -> [u64; 4] {
    [from.x, from.y, to.x, to.y].map(|v| (v + 0.0).to_bits())
}
