//! Upper bounds of what a cluster can give, at a point and over a region, and the estimate they bound.
//!
//! Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 4
//! (bounds of point, oriented and directional clusters), and Melino Conte, "Real-time Rendering of
//! Cities at Night", 2018, section 3.2 (the same in a cut on a GPU).
//! Deviations: spot lights and the cheap form are ours; the lights' axes are a cone rather than one
//! direction, and its half opening is taken from the angle; Walter's form also knows the box's own
//! distance, so that it is nowhere above the cheap one.
//!
//! `U = max over channels(albedo · intensity) / π · cos θ · S(max(0, φ - cone)) / max(d², clamp²)`:
//! cos θ is the greatest cosine to the normal of any vector from the point into the box, φ the
//! smallest angle to the axis of any vector from the box to the point, d the box's distance.
//! Always `0 <= estimate <= U`, and the sum over the cluster's lights is at most `U`, in f64 here and
//! in f32 in [`packed`]. What rounding could take away is given back by constants that both share,
//! so that both decide alike: [`GUARD`], [`ALONG_SLACK`], [`ANGLE_SLACK_RAD`] and [`SQUARE_SLACK`].

mod angles;
pub(crate) mod branchless;
mod closest;
pub mod packed;
mod region;

pub use region::Region;

use crate::{BoundForm, Emission, Light, Node, PackedNode, Point, light::angle, radiance};
use closest::Closest;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Every bound is multiplied by this. Some 40 roundings to f32 in a row stay below 2.4e-6; normals and
/// axes may be 1e-6 longer than 1; a device divides and takes roots to 3 units in the last place.
pub const GUARD: f64 = 1.0 + 1e-5;

/// Added to the farthest reach along an axis, times the farthest corner's coordinates summed: 16 half
/// units of f32 in the last place, where 9 roundings of differences and products lead there.
pub const ALONG_SLACK: f64 = 9.6e-7;

/// Subtracted from smallest angles, radians: what the polynomials, and axes rounded to f32, are off by.
pub const ANGLE_SLACK_RAD: f64 = 2e-6;

/// Share by which squared distances count as smaller where another square is taken from them.
pub const SQUARE_SLACK: f64 = 2e-6;

/// What the cluster gives by its representative, linear RGB: of a leaf, exactly its light's radiance.
pub fn estimate(node: &Node, point: &Point, clamp_m: f64) -> DVec3 {
    let emission = if node.kind == Emission::Directional.code() {
        Emission::Directional
    } else if node.cone_rad >= PI {
        Emission::Omni
    } else {
        Emission::of(node.kind, node.half_angle_rad)
    };
    let Node { position, axis, intensity, .. } = *node;
    radiance(point, &Light { position, axis, intensity, emission }, clamp_m)
}

/// The most that any channel can get from the cluster at a point.
pub fn point(form: BoundForm, node: &Node, point: &Point, clamp_m: f64) -> f64 {
    region(form, node, &Region::at(point), clamp_m)
}

/// The most that any channel can get from the cluster at any point of a region. Where all normals
/// agree, it is at least every point's bound; where they differ, only at least what any point gets:
/// boxes are turned to the region's axis rather than to a point's.
pub fn region(form: BoundForm, node: &Node, region: &Region, clamp_m: f64) -> f64 {
    slackened(form, node, region, clamp_m, 1.0)
}

/// Between what the f32 bound lies, on processors and devices, when the f64 one is that of `node` and
/// `packed` is the same in f32: decisions may differ where a threshold lies between, and only there.
/// Boxes that are rounded outwards are what widens it most.
pub fn band(
    form: BoundForm,
    node: &Node,
    packed: &PackedNode,
    region: &Region,
    clamp_m: f64,
) -> (f64, f64) {
    let packed = packed.unpack();
    let least = |node: &Node| slackened(form, node, region, clamp_m, 0.0);
    (least(node).min(least(&packed)), slackened(form, &packed, region, clamp_m, 2.0))
}

/// The bound with `share` of every slack: f32's roundings stay within one, so that its bound, which
/// has one of its own, lies between those with none and with two.
fn slackened(form: BoundForm, node: &Node, region: &Region, clamp_m: f64, share: f64) -> f64 {
    let guard = 1.0 + share * (GUARD - 1.0);
    let angle_slack = share * ANGLE_SLACK_RAD;
    let greatest = guard * FRAC_1_PI * (region.albedo * node.intensity).max_element();
    if node.kind == Emission::Directional.code() {
        let between = angle(region.normal_axis, -node.axis);
        let least = between - region.normal_spread_rad - node.cone_rad;
        return greatest * cosine_or_none(least - angle_slack);
    }
    // All vectors from the region into the cluster's box.
    let (low, high) = (node.min - region.max, node.max - region.min);
    let squared = low.max(-high).max(DVec3::ZERO).length_squared();
    let to_normal = Closest::of(form, region.normal_axis, low, high, squared, share);
    let cosine = if region.normal_spread_rad == 0.0 {
        to_normal.cosine().max(0.0)
    } else {
        cosine_or_none(to_normal.angle() - region.normal_spread_rad - angle_slack)
    };
    if cosine == 0.0 {
        return 0.0;
    }
    let emission = Emission::of(node.kind, node.half_angle_rad);
    let falloff = if emission == Emission::Omni || node.cone_rad >= PI {
        1.0
    } else {
        let axis = node.axis.normalize_or(DVec3::Z);
        let to_axis = Closest::of(form, axis, -high, -low, squared, share);
        emission.falloff((to_axis.angle() - node.cone_rad - angle_slack).max(0.0))
    };
    greatest * cosine * falloff / squared.max(clamp_m * clamp_m)
}

/// The cosine of a smallest angle: 1 below 0, and 0 from π/2 on.
fn cosine_or_none(angle_rad: f64) -> f64 {
    if angle_rad >= 0.5 * PI { 0.0 } else { angle_rad.max(0.0).cos() }
}
