//! Estimates and bounds of packed nodes, f32: what processors walk, and operation for operation what
//! `common/lights.wgsl` computes.

pub use super::angles::{angle_between, arc_sine, cosine_or_none};

pub(crate) use super::angles::{HALF_CHORD, from_half_chord};
use crate::{BoundForm, PackedNode, Point};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// [`super::GUARD`] in f32.
pub const GUARD: f32 = super::GUARD as f32;
/// [`super::ALONG_SLACK`] in f32.
pub const ALONG_SLACK: f32 = super::ALONG_SLACK as f32;
/// [`super::ANGLE_SLACK_RAD`] in f32.
pub const ANGLE_SLACK_RAD: f32 = super::ANGLE_SLACK_RAD as f32;
/// [`super::SQUARE_SLACK`] in f32.
pub const SQUARE_SLACK: f32 = super::SQUARE_SLACK as f32;
pub(crate) const NOWHERE: f32 = super::closest::NOWHERE as f32;

const OMNI: u32 = 0;
const ORIENTED: u32 = 1;
const SPOT: u32 = 2;
const DIRECTIONAL: u32 = 3;

/// [`super::Region`] in f32, 64 bytes, rounded outwards.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PackedRegion {
    /// Lower corner of the positions' box, metres.
    pub min: Vec3,
    /// The normals' greatest angle from their axis, radians; π where there may be any.
    pub normal_spread_rad: f32,
    /// Upper corner.
    pub max: Vec3,
    /// Unused.
    pub pad: u32,
    /// Middle of the normals, unit length.
    pub normal_axis: Vec3,
    /// Unused.
    pub pad_behind: u32,
    /// The greatest albedo of each channel.
    pub albedo: Vec3,
    /// Unused.
    pub pad_last: u32,
}

/// The square that squared distances are not below.
pub fn clamp_squared(clamp_m: f64) -> f32 {
    let clamp_m = clamp_m as f32;
    clamp_m * clamp_m
}

/// Share of the intensity that leaves at the angle between `axis` and `away`, both of unit length.
#[inline(always)]
pub fn falloff(kind: u32, half_angle_rad: f32, axis: Vec3, away: Vec3) -> f32 {
    match kind {
        ORIENTED => axis.dot(away).max(0.0),
        SPOT => (1.0 - angle_between(axis, away) / half_angle_rad).max(0.0),
        _ => 1.0,
    }
}

/// What the cluster gives by its representative, linear RGB; of a leaf, its light's radiance.
#[inline]
pub fn estimate(node: &PackedNode, point: &Point, clamp_squared: f32) -> Vec3 {
    let greatest = point.albedo * node.intensity * FRAC_1_PI;
    if node.kind == DIRECTIONAL {
        return greatest * (-point.normal.dot(node.axis)).max(0.0);
    }
    let to_light = node.position - point.position;
    let squared = to_light.dot(to_light);
    if squared == 0.0 {
        return Vec3::ZERO;
    }
    let direction = to_light / squared.sqrt();
    let cosine = point.normal.dot(direction).max(0.0);
    if cosine == 0.0 {
        return Vec3::ZERO;
    }
    let kind = if node.cone_rad >= PI { OMNI } else { node.kind };
    let falloff = falloff(kind, node.half_angle_rad, node.axis, -direction);
    greatest * (cosine * falloff / squared.max(clamp_squared))
}

/// The most that any channel can get from the cluster at a point.
#[inline]
pub fn point(form: BoundForm, node: &PackedNode, point: &Point, clamp_squared: f32) -> f32 {
    region(form, node, &PackedRegion::at(point), clamp_squared)
}

/// The most that any channel can get from the cluster at any point of a region.
#[inline]
pub fn region(
    form: BoundForm,
    node: &PackedNode,
    region: &PackedRegion,
    clamp_squared: f32,
) -> f32 {
    let greatest = GUARD * FRAC_1_PI * (region.albedo * node.intensity).max_element();
    if node.kind == DIRECTIONAL {
        let between = angle_between(region.normal_axis, -node.axis);
        return greatest * cosine_within(between - region.normal_spread_rad - node.cone_rad);
    }
    let (low, high) = (node.min - region.max, node.max - region.min);
    let outside = low.max(-high).max(Vec3::ZERO);
    let squared = outside.dot(outside);
    let to_normal = Closest::of(form, region.normal_axis, low, high, squared);
    let cosine = if region.normal_spread_rad == 0.0 {
        to_normal.cosine().max(0.0)
    } else {
        cosine_within(to_normal.angle() - region.normal_spread_rad)
    };
    if cosine == 0.0 {
        return 0.0;
    }
    let falloff = if node.kind == OMNI || node.cone_rad >= PI {
        1.0
    } else {
        let to_axis = Closest::of(form, node.axis, -high, -low, squared);
        let least = (to_axis.angle() - node.cone_rad - ANGLE_SLACK_RAD).max(0.0);
        if node.kind == ORIENTED {
            cosine_or_none(least)
        } else {
            (1.0 - least / node.half_angle_rad).max(0.0)
        }
    };
    greatest * (cosine * falloff / squared.max(clamp_squared))
}

#[inline(always)]
fn cosine_within(angle_rad: f32) -> f32 {
    cosine_or_none((angle_rad - ANGLE_SLACK_RAD).max(0.0))
}

/// As [`super::closest`]'s.
#[derive(Clone, Copy)]
struct Closest {
    along: f32,
    across_squared: f32,
}

impl Closest {
    #[inline(always)]
    fn of(form: BoundForm, axis: Vec3, low: Vec3, high: Vec3, squared: f32) -> Self {
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let farthest = low.abs().max(high.abs());
        let slack = ALONG_SLACK * (farthest.x + farthest.y + farthest.z);
        let along = axis.dot(centre) + axis.abs().dot(half) + slack;
        let by_distance = squared * (1.0 - SQUARE_SLACK) - along * along;
        if form == BoundForm::Cheap {
            if along < 0.0 {
                return Self { along: 0.0, across_squared: 1.0 };
            }
            return Self { along, across_squared: by_distance.max(0.0) };
        }
        let (u, v) = frame(axis);
        let (middle_u, reach_u) = (u.dot(centre).abs(), u.abs().dot(half));
        let (middle_v, reach_v) = (v.dot(centre).abs(), v.abs().dot(half));
        if along < 0.0 {
            let (far_u, far_v) = (middle_u + reach_u + slack, middle_v + reach_v + slack);
            return Self { along, across_squared: far_u * far_u + far_v * far_v };
        }
        let near_u = (middle_u - reach_u - slack).max(0.0);
        let near_v = (middle_v - reach_v - slack).max(0.0);
        Self { along, across_squared: (near_u * near_u + near_v * near_v).max(by_distance) }
    }

    #[inline(always)]
    fn cosine(self) -> f32 {
        let squared = self.along * self.along + self.across_squared;
        if self.across_squared <= 0.0 || squared < NOWHERE {
            1.0
        } else {
            self.along / squared.sqrt()
        }
    }

    #[inline(always)]
    fn angle(self) -> f32 {
        let squared = self.along * self.along + self.across_squared;
        if squared < NOWHERE {
            return 0.0;
        }
        let length = squared.sqrt();
        // 1 - cos without the difference: across² / (length (length + along)).
        let twice = 2.0 * length * (length + self.along.abs());
        from_half_chord((self.across_squared.max(0.0) / twice).sqrt(), self.along < 0.0)
    }
}

/// As [`super::closest`]'s.
#[inline(always)]
pub(crate) fn frame(axis: Vec3) -> (Vec3, Vec3) {
    let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let u = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    (u, Vec3::new(b, sign + axis.y * axis.y * a, -axis.y))
}

impl PackedNode {
    /// [`crate::Light::shines_into`] of a leaf, in f32.
    pub(crate) fn shines_into(&self, min: Vec3, max: Vec3) -> bool {
        if self.kind == OMNI || self.kind == DIRECTIONAL {
            return true;
        }
        let (low, high) = (min - self.position, max - self.position);
        let outside = low.max(-high).max(Vec3::ZERO);
        let squared = outside.dot(outside);
        let least = Closest::of(BoundForm::Walter, self.axis, low, high, squared).angle();
        least - ANGLE_SLACK_RAD < self.half_angle_rad
    }
}

impl PackedRegion {
    /// A single point.
    #[inline]
    pub fn at(point: &Point) -> Self {
        Self {
            min: point.position,
            max: point.position,
            normal_axis: point.normal,
            albedo: point.albedo,
            ..Self::default()
        }
    }

    /// The least region around all points that show anything; `None` without any.
    pub fn of<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Option<Self> {
        let there = points.filter(|p| p.is_there());
        let mut region = there.clone().map(Self::at).reduce(|a, b| Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            normal_axis: a.normal_axis + b.normal_axis,
            albedo: a.albedo.max(b.albedo),
            ..a
        })?;
        match region.normal_axis.try_normalize() {
            Some(axis) => {
                let from_axis = |p: &Point| angle_between(axis, p.normal);
                region.normal_axis = axis;
                region.normal_spread_rad = there.map(from_axis).fold(0.0, f32::max);
            }
            None => {
                region.normal_axis = Vec3::Z;
                region.normal_spread_rad = PI;
            }
        }
        Some(region)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mirror<T>(name: &str, fields: &[(&str, u32)]) {
        let source = dapple_shaders::source("common/lights.wgsl").unwrap();
        let layout = dapple_shaders::struct_layout(&source, name).unwrap();
        let names: Vec<_> = layout.fields.iter().map(|f| (f.0.as_str(), f.1)).collect();
        assert_eq!(names, fields);
        assert_eq!(layout.size as usize, size_of::<T>());
    }

    macro_rules! at {
        ($type:ty: $($field:ident as $name:literal),* $(,)?) => {
            &[$(($name, std::mem::offset_of!($type, $field) as u32)),*]
        };
    }

    #[test]
    fn structs_lie_as_on_the_device() {
        let node = at!(PackedNode: position as "position", cone_rad as "cone_rad",
            intensity as "intensity", size as "size", axis as "axis",
            half_angle_rad as "half_angle_rad", min as "low", light as "light", max as "high",
            kind as "kind");
        mirror::<PackedNode>("LightNode", node);
        let point = at!(Point: position as "position", object as "object", normal as "normal",
            pad as "pad", albedo as "albedo", pad_behind as "pad_behind");
        mirror::<Point>("Point", point);
        let region = at!(PackedRegion: min as "low", normal_spread_rad as "normal_spread_rad",
            max as "high", pad as "pad", normal_axis as "normal_axis",
            pad_behind as "pad_behind", albedo as "albedo", pad_last as "pad_last");
        mirror::<PackedRegion>("Region", region);
    }
}
