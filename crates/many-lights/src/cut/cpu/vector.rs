//! Bounds and estimates of a node at eight points: [`packed`]'s operations in their order, without
//! branches within a lane, so that compilers make vectors of them. A test holds them to the same bits.

use super::lanes::{Points, Row, WIDTH};
use crate::{
    BoundForm, Emission, PackedNode,
    bound::{
        branchless::{self, OMNI, ORIENTED, SPOT, greater, lesser},
        packed::{self, PackedRegion},
    },
};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// How the lights of a node emit, where that makes other operations.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Omni,
    Oriented,
    Spot,
    Directional,
}

fn kind(node: &PackedNode) -> Kind {
    if node.kind == Emission::Directional.code() {
        Kind::Directional
    } else if node.kind == Emission::Omni.code() || node.cone_rad >= PI {
        Kind::Omni
    } else if node.kind == Emission::Oriented.code() {
        Kind::Oriented
    } else {
        Kind::Spot
    }
}

/// [`packed::point`] at eight points.
#[inline(always)]
pub(super) fn bounds(
    form: BoundForm,
    node: &PackedNode,
    points: &Points,
    clamp_squared: f32,
) -> Row {
    match (kind(node), form) {
        (Kind::Directional, _) => {
            let mut row = Row::default();
            for (lane, bound) in row.iter_mut().enumerate() {
                *bound = packed::point(form, node, &points.get(lane), clamp_squared);
            }
            row
        }
        (Kind::Omni, BoundForm::Cheap) => of_kind::<OMNI, true>(node, points, clamp_squared),
        (Kind::Omni, BoundForm::Walter) => of_kind::<OMNI, false>(node, points, clamp_squared),
        (Kind::Oriented, BoundForm::Cheap) => {
            of_kind::<ORIENTED, true>(node, points, clamp_squared)
        }
        (Kind::Oriented, BoundForm::Walter) => {
            of_kind::<ORIENTED, false>(node, points, clamp_squared)
        }
        (Kind::Spot, BoundForm::Cheap) => of_kind::<SPOT, true>(node, points, clamp_squared),
        (Kind::Spot, BoundForm::Walter) => of_kind::<SPOT, false>(node, points, clamp_squared),
    }
}

#[inline(always)]
fn of_kind<const KIND: u32, const CHEAP: bool>(
    node: &PackedNode,
    points: &Points,
    clamp_squared: f32,
) -> Row {
    let mut row = Row::default();
    for lane in 0..WIDTH {
        let at = PackedRegion::at(&points.get(lane));
        row[lane] = branchless::region::<KIND, CHEAP, true>(node, &at, clamp_squared);
    }
    row
}

/// [`packed::estimate`] at eight points, channel by channel.
#[inline(always)]
pub(super) fn estimates(node: &PackedNode, points: &Points, clamp_squared: f32) -> [Row; 3] {
    match kind(node) {
        Kind::Directional => {
            let mut rows = [Row::default(); 3];
            for lane in 0..WIDTH {
                let estimate = packed::estimate(node, &points.get(lane), clamp_squared);
                for channel in 0..3 {
                    rows[channel][lane] = estimate[channel];
                }
            }
            rows
        }
        Kind::Omni => estimates_of_kind::<OMNI>(node, points, clamp_squared),
        Kind::Oriented => estimates_of_kind::<ORIENTED>(node, points, clamp_squared),
        Kind::Spot => estimates_of_kind::<SPOT>(node, points, clamp_squared),
    }
}

#[inline(always)]
fn estimates_of_kind<const KIND: u32>(
    node: &PackedNode,
    points: &Points,
    clamp_squared: f32,
) -> [Row; 3] {
    let mut rows = [Row::default(); 3];
    for lane in 0..WIDTH {
        let (position, normal, albedo) = points.vectors(lane);
        let greatest = albedo * node.intensity * FRAC_1_PI;
        let to_light = node.position - position;
        let squared = to_light.dot(to_light);
        let direction = to_light / squared.sqrt();
        let cosine = greater(normal.dot(direction), 0.0);
        let falloff = match KIND {
            ORIENTED => greater(node.axis.dot(-direction), 0.0),
            SPOT => greater(1.0 - angle_between(node.axis, -direction) / node.half_angle_rad, 0.0),
            _ => 1.0,
        };
        let share = cosine * falloff / greater(squared, clamp_squared);
        let none = squared == 0.0 || cosine == 0.0;
        rows[0][lane] = if none { 0.0 } else { greatest.x * share };
        rows[1][lane] = if none { 0.0 } else { greatest.y * share };
        rows[2][lane] = if none { 0.0 } else { greatest.z * share };
    }
    rows
}

#[inline(always)]
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    let flip = a.dot(b) < 0.0;
    let (near, far) = (a - b, a + b);
    let chord = if flip { far.dot(far) } else { near.dot(near) };
    packed::from_half_chord(lesser(0.5 * chord.sqrt(), packed::HALF_CHORD), flip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightTree, Point, sample::Random, worlds};
    use glam::DVec3;

    /// Nodes of every kind, and points around, in and on their boxes.
    fn cases() -> (Vec<PackedNode>, Vec<Point>) {
        let spot = |half_angle_rad| Emission::Spot { half_angle_rad };
        let emissions = vec![
            Emission::Omni,
            Emission::Oriented,
            worlds::WINDOW,
            spot(3.0),
            Emission::Directional,
        ];
        let cloud = worlds::Cloud { lights: 200, emissions, ..worlds::Cloud::default() };
        let lights = worlds::cloud(&cloud).world.lights;
        let nodes = LightTree::median(&lights).unwrap().pack().nodes;
        let mut random = Random::new(3, 0, 0);
        let mut vector = || {
            let mut one = || 2.0 * random.unit() - 1.0;
            Vec3::new(one(), one(), one())
        };
        let mut points = Vec::new();
        for index in 0..40 * WIDTH {
            let node = &nodes[index % nodes.len()];
            let position = match index % 4 {
                0 => node.position,
                1 => node.min,
                2 => node.max + vector() * 1e-3,
                _ => vector() * 20.0,
            };
            let straight = DVec3::X.as_vec3();
            let normal = if index % 5 == 0 { straight } else { vector().normalize() };
            let albedo = vector().abs();
            points.push(Point { position, normal, albedo, ..Point::default() });
        }
        (nodes, points)
    }

    #[test]
    fn eight_lanes_compute_the_bits_of_one() {
        let (nodes, all) = cases();
        let (mut compared, mut lit) = (0, 0);
        for points in all.chunks(WIDTH) {
            let mut row = Points::default();
            points.iter().enumerate().for_each(|(lane, point)| row.set(lane, point));
            for node in &nodes {
                let estimates = estimates(node, &row, 0.01);
                for form in [BoundForm::Cheap, BoundForm::Walter] {
                    let bounds = bounds(form, node, &row, 0.01);
                    for (lane, point) in points.iter().enumerate() {
                        let bound = packed::point(form, node, point, 0.01);
                        assert_eq!(bounds[lane], bound, "{form:?} {node:?} {point:?}");
                        let estimate = packed::estimate(node, point, 0.01);
                        let found = Vec3::from_array(estimates.map(|channel| channel[lane]));
                        assert_eq!(found, estimate, "{node:?} {point:?}");
                        compared += 1;
                        lit += usize::from(estimate != Vec3::ZERO);
                    }
                }
            }
        }
        assert!(compared > 100_000 && lit > 10_000, "{compared}, {lit}");
    }
}
