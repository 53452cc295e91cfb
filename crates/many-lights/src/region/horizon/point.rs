//! Horizons of an upright box from single points: which corners of its top outline it.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, Figure 4.4: two classes of
//! height by eight sections around the box.
//! Deviations: from above and straight before a side, that table leaves out the two sides that run
//! away from the eye; [`silhouette`] has them.

use super::super::Cuboid;
use std::cmp::Ordering;

/// A corner of the top of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Least u, least w.
    NearLeft,
    /// Greatest u, least w.
    NearRight,
    /// Greatest u, greatest w.
    FarRight,
    /// Least u, greatest w.
    FarLeft,
}

use Corner::{FarLeft, FarRight, NearLeft, NearRight};

impl Corner {
    /// Its place (u, w).
    pub fn place(self, of: &Cuboid) -> [f64; 2] {
        let ([a0, a1], [b0, b1]) = (of.u, of.w);
        match self {
            NearLeft => [a0, b0],
            NearRight => [a1, b0],
            FarRight => [a1, b1],
            FarLeft => [a0, b1],
        }
    }
}

/// Where an eye is along one axis: before an interval, within it, or past it.
fn section(eye: f64, [low, high]: [f64; 2]) -> Ordering {
    match (eye < low, eye > high) {
        (true, _) => Ordering::Less,
        (_, true) => Ordering::Greater,
        _ => Ordering::Equal,
    }
}

/// The thesis's table: corners of the horizon from an eye (u, w, h), from left to right as the eye
/// sees them. `None` above or inside the box, where its outline runs all around.
pub fn table(eye: [f64; 3], of: &Cuboid) -> Option<&'static [Corner]> {
    use Ordering::{Equal, Greater, Less};
    let is_above = eye[2] > of.h[1];
    Some(match (section(eye[0], of.u), section(eye[1], of.w), is_above) {
        (Equal, Equal, _) => return None,
        (Less, Less, false) => &[FarLeft, NearLeft, NearRight],
        (Equal, Less, false) => &[NearLeft, NearRight],
        (Greater, Less, false) => &[NearLeft, NearRight, FarRight],
        (Greater, Equal, false) => &[NearRight, FarRight],
        (Greater, Greater, false) => &[NearRight, FarRight, FarLeft],
        (Equal, Greater, false) => &[FarRight, FarLeft],
        (Less, Greater, false) => &[FarRight, FarLeft, NearLeft],
        (Less, Equal, false) => &[FarLeft, NearLeft],
        (Less, Less, true) => &[FarLeft, FarRight, NearRight],
        (Equal, Less, true) => &[FarLeft, FarRight],
        (Greater, Less, true) => &[NearLeft, FarLeft, FarRight],
        (Greater, Equal, true) => &[NearLeft, FarLeft],
        (Greater, Greater, true) => &[NearRight, NearLeft, FarLeft],
        (Equal, Greater, true) => &[NearRight, NearLeft],
        (Less, Greater, true) => &[FarRight, NearRight, NearLeft],
        (Less, Equal, true) => &[FarRight, NearRight],
    })
}

/// The whole outline: as [`table`], with the two sides that run away from an eye above the box.
pub fn silhouette(eye: [f64; 3], of: &Cuboid) -> Option<&'static [Corner]> {
    let list = table(eye, of)?;
    Some(match list {
        [FarLeft, FarRight] => &[NearLeft, FarLeft, FarRight, NearRight],
        [NearLeft, FarLeft] => &[NearRight, NearLeft, FarLeft, FarRight],
        [NearRight, NearLeft] => &[FarRight, NearRight, NearLeft, FarLeft],
        [FarRight, NearRight] => &[FarLeft, FarRight, NearRight, NearLeft],
        whole => whole,
    })
}
