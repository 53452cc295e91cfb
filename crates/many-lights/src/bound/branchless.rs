//! [`super::packed`]'s bounds without branches, operation for operation: where lanes side by side do
//! the same, compilers make vectors of them. Tests hold them to the same bits.

use super::packed::{
    ALONG_SLACK, ANGLE_SLACK_RAD, GUARD, NOWHERE, PackedRegion, SQUARE_SLACK, cosine_or_none,
    frame, from_half_chord,
};
use crate::PackedNode;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// How lights emit, where that makes other operations; parallel light has no such form.
pub(crate) const OMNI: u32 = 0;
pub(crate) const ORIENTED: u32 = 1;
pub(crate) const SPOT: u32 = 2;

/// [`super::packed::region`] of a node that emits as `KIND` says, whatever the node does. `PLANAR` where
/// all normals agree.
#[inline(always)]
pub(crate) fn region<const KIND: u32, const CHEAP: bool, const PLANAR: bool>(
    node: &PackedNode,
    region: &PackedRegion,
    clamp_squared: f32,
) -> f32 {
    let greatest = GUARD * FRAC_1_PI * max_element(region.albedo * node.intensity);
    let (low, high) = (node.min - region.max, node.max - region.min);
    let outside = Vec3::new(
        greater(greater(low.x, -high.x), 0.0),
        greater(greater(low.y, -high.y), 0.0),
        greater(greater(low.z, -high.z), 0.0),
    );
    let squared = outside.dot(outside);
    let to_normal = closest::<CHEAP>(region.normal_axis, low, high, squared);
    let cosine = if PLANAR {
        greater(to_normal.cosine(), 0.0)
    } else {
        let least = to_normal.angle() - region.normal_spread_rad - ANGLE_SLACK_RAD;
        cosine_or_none(greater(least, 0.0))
    };
    let falloff = if KIND == OMNI {
        1.0
    } else {
        let angle = closest::<CHEAP>(node.axis, -high, -low, squared).angle();
        let least = greater(angle - node.cone_rad - ANGLE_SLACK_RAD, 0.0);
        if KIND == ORIENTED {
            cosine_or_none(least)
        } else {
            greater(1.0 - least / node.half_angle_rad, 0.0)
        }
    };
    let bound = greatest * (cosine * falloff / greater(squared, clamp_squared));
    if cosine == 0.0 { 0.0 } else { bound }
}

/// The greater of two numbers, `b` where `a` is none: one instruction, which [`f32::max`] is not.
#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The lesser of two numbers, `b` where `a` is none.
#[inline(always)]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max_element(v: Vec3) -> f32 {
    greater(v.x, greater(v.y, v.z))
}

#[derive(Clone, Copy)]
struct Closest {
    along: f32,
    across_squared: f32,
}

#[inline(always)]
fn absolute(v: Vec3) -> Vec3 {
    Vec3::new(v.x.abs(), v.y.abs(), v.z.abs())
}

#[inline(always)]
fn closest<const CHEAP: bool>(axis: Vec3, low: Vec3, high: Vec3, squared: f32) -> Closest {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let farthest = Vec3::new(
        greater(low.x.abs(), high.x.abs()),
        greater(low.y.abs(), high.y.abs()),
        greater(low.z.abs(), high.z.abs()),
    );
    let slack = ALONG_SLACK * (farthest.x + farthest.y + farthest.z);
    let along = axis.dot(centre) + absolute(axis).dot(half) + slack;
    let by_distance = squared * (1.0 - SQUARE_SLACK) - along * along;
    if CHEAP {
        let behind = along < 0.0;
        return Closest {
            along: if behind { 0.0 } else { along },
            across_squared: if behind { 1.0 } else { greater(by_distance, 0.0) },
        };
    }
    let (u, v) = frame(axis);
    let (middle_u, reach_u) = (u.dot(centre).abs(), absolute(u).dot(half));
    let (middle_v, reach_v) = (v.dot(centre).abs(), absolute(v).dot(half));
    let (far_u, far_v) = (middle_u + reach_u + slack, middle_v + reach_v + slack);
    let near_u = greater(middle_u - reach_u - slack, 0.0);
    let near_v = greater(middle_v - reach_v - slack, 0.0);
    let near = greater(near_u * near_u + near_v * near_v, by_distance);
    let far = far_u * far_u + far_v * far_v;
    Closest { along, across_squared: if along < 0.0 { far } else { near } }
}

impl Closest {
    #[inline(always)]
    fn cosine(self) -> f32 {
        let squared = self.along * self.along + self.across_squared;
        let cosine = self.along / squared.sqrt();
        if self.across_squared <= 0.0 || squared < NOWHERE { 1.0 } else { cosine }
    }

    #[inline(always)]
    fn angle(self) -> f32 {
        let squared = self.along * self.along + self.across_squared;
        let length = squared.sqrt();
        let twice = 2.0 * length * (length + self.along.abs());
        let half_chord = (greater(self.across_squared, 0.0) / twice).sqrt();
        let angle = from_half_chord(half_chord, self.along < 0.0);
        if squared < NOWHERE { 0.0 } else { angle }
    }
}
