//! Points of a face that a light may be seen from.

use super::gaps::{Gap, gaps};
use crate::{region::Cuboid, sample::Random};

/// Memory for the points of one light after another.
#[derive(Default)]
pub(super) struct Points {
    hidden: Vec<[f64; 2]>,
    gaps: Vec<Gap>,
    /// (u, w, h), the likeliest first.
    pub found: Vec<[f64; 3]>,
}

/// How far inside a gap its ends are tried, as shares of its width: next to the silhouettes.
const INSIDE: [f64; 6] = [0.5, 1e-9, 1.0 - 1e-9, 1e-4, 1.0 - 1e-4, 0.25];

/// The most gaps of one line that are tried: the widest.
const GAPS: usize = 8;

/// Levels and depths whose gaps are found: enough for the exact answer where the face has no depth and
/// nothing passes below occluders (the highest line sees the most), and good guesses elsewhere.
const DRAWN: usize = 2;

impl Points {
    /// The corners of a face, points at the silhouettes of occluders towards a light, and `random` more.
    pub fn fill(
        &mut self,
        face: &Cuboid,
        light: [f64; 3],
        occluders: &[Cuboid],
        (random, draws): (u32, &mut Random),
    ) {
        self.found.clear();
        let Cuboid { u, w, h } = *face;
        let mut draw = |[low, high]: [f64; 2]| {
            let share = f64::from(draws.unit());
            ((1.0 - share) * low + share * high).clamp(low, high)
        };
        let mut lines = vec![(w[1], h[1])];
        if w[0] < w[1] {
            lines.push((w[0], h[1]));
        }
        lines.extend((0..DRAWN).map(|_| (draw(w), draw(h))));
        lines.push((w[1], h[0]));
        for (at_w, at_h) in lines {
            if at_w >= light[1] {
                continue;
            }
            gaps(u, (at_w, at_h), light, occluders, &mut self.hidden, &mut self.gaps);
            self.gaps.sort_by(|a, b| (b.to - b.from).total_cmp(&(a.to - a.from)));
            for gap in self.gaps.iter().take(GAPS) {
                for share in INSIDE {
                    let at_u = ((1.0 - share) * gap.from + share * gap.to).clamp(u[0], u[1]);
                    self.found.push([at_u, at_w, at_h]);
                }
            }
        }
        for corner in 0..8 {
            let side =
                |bit: usize, [low, high]: [f64; 2]| if corner >> bit & 1 == 0 { low } else { high };
            self.found.push([side(0, u), side(1, w), side(2, h)]);
        }
        self.found.extend((0..random).map(|_| [draw(u), draw(w), draw(h)]));
        // What lies before a point's plane is seen towards another direction.
        self.found.retain(|point| point[1] < light[1]);
    }
}
