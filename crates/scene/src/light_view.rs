//! The projection of a shadow map: world space to map coordinates and linear depth.

use crate::Aabb;
use glam::{DVec2, DVec3};

/// A light seen as a camera. Map coordinates (u, v) lie in 0..=1 with v downwards; depth z is
/// *linear* along the light's axis, 0 at `near` and 1 at `far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightView {
    /// A point of the plane z = 0 (parallel light) or the light itself (perspective).
    pub origin: DVec3,
    /// Unit axes: right (u grows), down (v grows), forward (z grows).
    pub right: DVec3,
    /// See `right`.
    pub down: DVec3,
    /// See `right`.
    pub forward: DVec3,
    /// Parallel: half the map's side in metres. Perspective: tangent of half the opening angle.
    pub half_extent: f64,
    /// Distance along `forward` where z = 0, metres.
    pub near_m: f64,
    /// Distance along `forward` where z = 1, metres.
    pub far_m: f64,
    /// Whether rays leave one point.
    pub perspective: bool,
}

/// Why a light cannot be given a shadow map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightViewError {
    /// The direction has no length or is not finite.
    #[error("light direction {0} has no usable length")]
    Direction(DVec3),
    /// Nothing to light.
    #[error("the scene is empty: a shadow map needs bounds")]
    EmptyBounds,
    /// The half angle is out of range.
    #[error("spot half angle {0} rad is outside (0, pi/2)")]
    HalfAngle(f64),
    /// A crop to something that is no rectangle.
    #[error("crop from {min} to {max}: the corners must be finite, the first not above the second")]
    Rectangle {
        /// Lower corner as given.
        min: DVec2,
        /// Upper corner as given.
        max: DVec2,
    },
}

pub(crate) fn axes(direction: DVec3) -> Result<(DVec3, DVec3, DVec3), LightViewError> {
    let forward = direction.try_normalize().ok_or(LightViewError::Direction(direction))?;
    // The world axis least aligned with the light keeps the cross product long.
    let helper = if forward.y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    let right = forward.cross(helper).normalize();
    Ok((right, forward.cross(right), forward))
}

impl LightView {
    /// A square parallel view along `direction` that holds `bounds`, with a margin of 2 % of the
    /// side on each side in u and v and of 1 % of the depth range at each end.
    pub fn fit_directional(direction: DVec3, bounds: &Aabb) -> Result<Self, LightViewError> {
        if bounds.is_empty() {
            return Err(LightViewError::EmptyBounds);
        }
        let (right, down, forward) = axes(direction)?;
        let centre = bounds.centre();
        let (mut side, mut deep) = (0.0_f64, 0.0_f64);
        for corner in bounds.corners() {
            let d = corner - centre;
            side = side.max(d.dot(right).abs()).max(d.dot(down).abs());
            deep = deep.max(d.dot(forward).abs());
        }
        // A flat scene seen along its plane still needs a positive range.
        let least = bounds.radius().max(f64::MIN_POSITIVE) * 1e-3;
        let (half_extent, half_depth) = ((side * 1.04).max(least), (deep * 1.02).max(least));
        Ok(Self {
            origin: centre - forward * half_depth,
            right,
            down,
            forward,
            half_extent,
            near_m: 0.0,
            far_m: 2.0 * half_depth,
            perspective: false,
        })
    }

    /// A square perspective view from a spot light; depth range from the bounds in front of it.
    pub fn fit_spot(
        position: DVec3,
        direction: DVec3,
        half_angle_rad: f64,
        bounds: &Aabb,
    ) -> Result<Self, LightViewError> {
        if bounds.is_empty() {
            return Err(LightViewError::EmptyBounds);
        }
        if !(half_angle_rad > 0.0 && half_angle_rad < std::f64::consts::FRAC_PI_2) {
            return Err(LightViewError::HalfAngle(half_angle_rad));
        }
        let (right, down, forward) = axes(direction)?;
        let (mut near, mut far) = (f64::INFINITY, 0.0_f64);
        for corner in bounds.corners() {
            let z = (corner - position).dot(forward);
            near = near.min(z);
            far = far.max(z);
        }
        let far_m = (far * 1.01).max(bounds.radius() * 1e-3).max(f64::MIN_POSITIVE);
        // A light inside the bounds keeps a near plane in front of itself.
        let near_m = (near * 0.99).max(far_m * 1e-4);
        Ok(Self {
            origin: position,
            right,
            down,
            forward,
            half_extent: half_angle_rad.tan(),
            near_m,
            far_m,
            perspective: true,
        })
    }

    /// (u, v, z) of a world point. Behind a perspective light z is negative and (u, v) is not
    /// meaningful.
    pub fn project(&self, p: DVec3) -> DVec3 {
        let d = p - self.origin;
        let distance = d.dot(self.forward);
        let scale = if self.perspective { self.half_extent * distance } else { self.half_extent };
        DVec3::new(
            0.5 + 0.5 * d.dot(self.right) / scale,
            0.5 + 0.5 * d.dot(self.down) / scale,
            (distance - self.near_m) / (self.far_m - self.near_m),
        )
    }

    /// The ray of light through map point (u, v): its point at z = 0, and the vector from there to
    /// its point at z = 1. So `origin + vector * z` has depth z.
    pub fn ray(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let side = self.right * (2.0 * u - 1.0) + self.down * (2.0 * v - 1.0);
        let depth = self.far_m - self.near_m;
        if self.perspective {
            let d = self.forward + side * self.half_extent;
            (self.origin + d * self.near_m, d * depth)
        } else {
            (
                self.origin + side * self.half_extent + self.forward * self.near_m,
                self.forward * depth,
            )
        }
    }

    /// World units a map coordinate of 1 spans: the map's side in metres for parallel light, at
    /// the depth of `far_m` for a perspective one.
    pub fn side_m(&self) -> f64 {
        2.0 * self.half_extent * if self.perspective { self.far_m } else { 1.0 }
    }
}
