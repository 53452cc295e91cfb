//! The vector of a box that leans most towards an axis.

use super::{ALONG_SLACK, ANGLE_SLACK_RAD, SQUARE_SLACK};
use crate::{BoundForm, Emission, Light};
use glam::DVec3;

/// No vector of the box makes a smaller angle with the axis than this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closest {
    /// Along the axis.
    along: f64,
    /// Across it, squared.
    across_squared: f64,
}

impl Closest {
    /// Of the box `low ..= high` whose squared distance from 0 is `squared`; `axis` of unit length.
    /// `share` of the slack is given.
    pub(super) fn of(
        form: BoundForm,
        axis: DVec3,
        low: DVec3,
        high: DVec3,
        squared: f64,
        share: f64,
    ) -> Self {
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let slack = share * ALONG_SLACK * low.abs().max(high.abs()).element_sum();
        let along = axis.dot(centre) + axis.abs().dot(half) + slack;
        // No vector is shorter than the box is far.
        let by_distance = squared * (1.0 - share * SQUARE_SLACK) - along * along;
        if form == BoundForm::Cheap {
            if along < 0.0 {
                return Self { along: 0.0, across_squared: 1.0 };
            }
            return Self { along, across_squared: by_distance.max(0.0) };
        }
        let (u, v) = frame(axis);
        let middle = DVec3::new(u.dot(centre), v.dot(centre), 0.0).abs();
        let reach = DVec3::new(u.abs().dot(half), v.abs().dot(half), 0.0);
        if along < 0.0 {
            let farthest = middle + reach + slack;
            return Self { along, across_squared: farthest.truncate().length_squared() };
        }
        let nearest = (middle - reach - slack).max(DVec3::ZERO);
        Self { along, across_squared: nearest.length_squared().max(by_distance) }
    }

    /// The greatest cosine.
    pub(super) fn cosine(self) -> f64 {
        let squared = self.along * self.along + self.across_squared;
        let straight = self.across_squared <= 0.0 && self.along >= 0.0;
        if straight || squared < NOWHERE { 1.0 } else { self.along / squared.sqrt() }
    }

    /// The smallest angle, radians.
    pub(super) fn angle(self) -> f64 {
        let squared = self.along * self.along + self.across_squared;
        if squared < NOWHERE { 0.0 } else { self.across_squared.max(0.0).sqrt().atan2(self.along) }
    }
}

impl Light {
    /// Whether the light leaves it towards any place of a box, as far as the angle from its axis tells
    /// and rounding can.
    pub fn shines_into(&self, min: DVec3, max: DVec3) -> bool {
        if matches!(self.emission, Emission::Omni | Emission::Directional) {
            return true;
        }
        let (low, high) = (min - self.position, max - self.position);
        let squared = low.max(-high).max(DVec3::ZERO).length_squared();
        let axis = self.axis.normalize_or(DVec3::Z);
        let least = Closest::of(BoundForm::Walter, axis, low, high, squared, 1.0).angle();
        least - ANGLE_SLACK_RAD < self.emission.half_angle_rad()
    }
}

/// Squared lengths below this have no direction: f32 would lose them.
pub(super) const NOWHERE: f64 = 1e-30;

/// Two unit vectors at right angles to a third and to each other; the same as f32's, or bounds would
/// differ where nothing else does.
///
/// Based on: T. Duff et al., "Building an orthonormal basis, revisited", 2017, listing 3.
fn frame(axis: DVec3) -> (DVec3, DVec3) {
    let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let u = DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    (u, DVec3::new(b, sign + axis.y * axis.y * a, -axis.y))
}
