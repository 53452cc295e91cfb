//! Upper edges of umbrae that are not level.

use super::super::Edge;
use super::{Peak, Umbra};

/// The lowest of a level line and up to two others, one that rises to the right and one that falls.
/// Each function gives the height of its line at `u`, not above it by rounding.
pub(super) struct Outline<L: Fn(f64) -> f64, R: Fn(f64) -> f64> {
    /// Ends of the umbra.
    pub u: [f64; 2],
    /// Height above which it hides.
    pub foot: f64,
    /// Height of the level line.
    pub level: f64,
    /// Where the other lines cross the level one, within the ends.
    pub knees: [f64; 2],
    /// The line that rises, infinite where there is none.
    pub rising: L,
    /// The line that falls, infinite where there is none.
    pub falling: R,
}

impl<L: Fn(f64) -> f64, R: Fn(f64) -> f64> Outline<L, R> {
    /// The umbra below these lines: with its whole edge, or cut off from end to end.
    pub fn umbra(&self, edge: Edge) -> Option<Umbra> {
        let [left, right] = self.u;
        if left.partial_cmp(&right) != Some(std::cmp::Ordering::Less) {
            return None;
        }
        let top = self.u.map(|u| self.height(u));
        let peak = match edge {
            Edge::Hull => Some(self.peak()).filter(|peak| peak.h > top[0].min(top[1])),
            Edge::Flat | Edge::Sloped => None,
        };
        let umbra = Umbra { u: self.u, top, foot: self.foot, peak };
        (self.foot < umbra.highest()).then_some(umbra)
    }

    fn height(&self, u: f64) -> f64 {
        self.level.min((self.rising)(u)).min((self.falling)(u))
    }

    /// Both ends lie below the lines, so that all between them does.
    fn peak(&self) -> Peak {
        let [first, last] = self.knees;
        if first <= last {
            return Peak { u: self.knees, h: self.height(first).min(self.height(last)) };
        }
        // The two lines cross below the level one.
        let apart = |u: f64| (self.rising)(u) - (self.falling)(u);
        let (below, above) = (apart(last), apart(first));
        let share = (below / (below - above)).clamp(0.0, 1.0);
        let crossing = last + share * (first - last);
        Peak { u: [crossing; 2], h: self.height(crossing) }
    }
}
