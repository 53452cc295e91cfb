//! Clusters of lights at points, drawn so that every edge of the bounds is met.

use dapple_many_lights::{
    BoundForm, Emission, Light, LightTree, Node, PackedNode, Point, bound, radiance,
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

pub const CLAMP_M: f64 = 0.1;

/// Lights of one kind and the node around them, at a point.
#[derive(Clone, Debug)]
pub struct Case {
    pub lights: Vec<Light>,
    pub node: Node,
    pub point: Point,
}

impl Case {
    pub fn new(lights: Vec<Light>, point: Point) -> Self {
        Self { node: node_around(&lights), lights, point }
    }

    pub fn packed(&self) -> PackedNode {
        let tree = LightTree { nodes: vec![self.node], ..LightTree::default() };
        tree.pack().nodes[0]
    }

    /// The sum over the lights of the greatest channel's radiance: each channel on its own.
    pub fn sum(&self) -> f64 {
        let sum: DVec3 = self.lights.iter().map(|l| radiance(&self.point, l, CLAMP_M)).sum();
        sum.max_element()
    }
}

/// A node as trees make them: axis and cone as their documentation says.
pub fn node_around(lights: &[Light]) -> Node {
    let min = lights.iter().map(|l| l.position).reduce(DVec3::min).unwrap();
    let max = lights.iter().map(|l| l.position).reduce(DVec3::max).unwrap();
    let total: f64 = lights.iter().map(Light::luminance).sum();
    let weight = |l: &Light| if total > 0.0 { l.luminance() } else { 1.0 };
    let weights: f64 = lights.iter().map(weight).sum();
    let mean: DVec3 = lights.iter().map(|l| l.position * (weight(l) / weights)).sum();
    let lean: DVec3 = lights.iter().map(|l| l.axis * (weight(l) / weights)).sum();
    let between = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    let (axis, cone_rad) = if lights.len() == 1 {
        (lights[0].axis, 0.0)
    } else if lean.length() < 1e-6 {
        (DVec3::Z, PI)
    } else {
        let axis = lean.normalize();
        // The cross product of nearly equal axes is off by a rounding.
        let widest = lights.iter().map(|l| between(axis, l.axis)).fold(0.0, f64::max);
        (axis, (widest + 1e-15).min(PI))
    };
    Node {
        min,
        max,
        position: if lights.len() == 1 { lights[0].position } else { mean.clamp(min, max) },
        intensity: lights.iter().map(|l| l.intensity).sum(),
        axis,
        cone_rad,
        half_angle_rad: lights.iter().map(|l| l.emission.half_angle_rad()).fold(0.0, f64::max),
        kind: lights[0].emission.code(),
        size: 2 * lights.len() as u32 - 1,
        light: 0,
    }
}

pub fn unit() -> impl Strategy<Value = DVec3> {
    prop_oneof![
        4 => (-1.0..1.0, 0.0..2.0 * PI).prop_map(|(z, turn): (f64, f64)| {
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * turn.cos(), across * turn.sin(), z)
        }),
        1 => prop::sample::select(vec![
            DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z,
        ]),
    ]
}

fn within(half: f64) -> impl Strategy<Value = DVec3> {
    [-half..half, -half..half, -half..half].prop_map(DVec3::from_array)
}

fn decade(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    range.prop_map(|exponent| 10f64.powf(exponent))
}

fn emission() -> impl Strategy<Value = Emission> {
    let spot = |half_angle_rad| Emission::Spot { half_angle_rad };
    prop_oneof![
        2 => Just(Emission::Omni),
        2 => Just(Emission::Oriented),
        1 => Just(Emission::Directional),
        2 => prop::sample::select(vec![FRAC_PI_4, FRAC_PI_2, PI, 1e-3]).prop_map(spot),
        1 => (1e-2..PI).prop_map(spot),
    ]
}

/// How far the axes of a cluster lie apart.
#[derive(Clone, Copy, Debug)]
enum Axes {
    Same,
    Near(f64),
    Any,
    Opposite,
}

fn axes() -> impl Strategy<Value = Axes> {
    prop_oneof![
        Just(Axes::Same),
        decade(-6.0..0.0).prop_map(Axes::Near),
        Just(Axes::Any),
        Just(Axes::Opposite),
    ]
}

/// Where the point lies, by a share of the box in each axis: corners, faces, inside, outside.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => Just(0.0),
        2 => Just(1.0),
        3 => 0.0..1.0,
        2 => -3.0..4.0,
        1 => decade(1.0..4.0),
        1 => decade(1.0..4.0).prop_map(|far| -far),
    ]
}

/// Lights of one kind, and points around them.
pub fn cluster() -> impl Strategy<Value = Vec<Light>> {
    let one = (within(1.0), unit(), [0.0..1.0, 0.0..1.0, 0.0..1.0], 0..6u8);
    (
        prop::collection::vec(one, 1..9),
        emission(),
        axes(),
        unit(),
        within(1.0),
        decade(-4.0..6.0),
        prop_oneof![Just(0.0), decade(-4.0..3.0)],
        decade(-3.0..4.0),
        0..4u8,
    )
        .prop_map(|(drawn, emission, axes, axis, place, away, size, power, flat)| {
            let flat = match flat {
                1 => DVec3::new(1.0, 1.0, 0.0),
                2 => DVec3::new(0.0, 1.0, 0.0),
                _ => DVec3::ONE,
            };
            let light = |(index, (offset, own, intensity, zero)): (usize, _)| {
                let own: DVec3 = own;
                let axis = match axes {
                    Axes::Same => axis,
                    Axes::Near(spread) => (axis + own * spread).normalize_or(axis),
                    Axes::Any => own,
                    Axes::Opposite => {
                        if index % 2 == 0 {
                            axis
                        } else {
                            -axis
                        }
                    }
                };
                let dark = if zero == 0 { 0.0 } else { power };
                Light {
                    position: place * away + offset * flat * size,
                    axis,
                    intensity: DVec3::from_array(intensity) * dark,
                    emission,
                }
            };
            drawn.into_iter().enumerate().map(light).collect()
        })
}

/// A cluster and a point that is near, in, on or at it.
pub fn case() -> impl Strategy<Value = Case> {
    let point =
        ([share(), share(), share()], unit(), 0..4u8, 0..8u8, [0.0f32..=1.0, 0.0..=1.0, 0.0..=1.0]);
    (cluster(), point).prop_map(|(lights, (shares, normal, turned, at, albedo))| {
        let node = node_around(&lights);
        let size = (node.max - node.min).max(DVec3::splat(1e-3));
        let beside = node.min + size * DVec3::from_array(shares);
        let position = if at == 0 { lights[0].position } else { beside };
        let to_lights = (node.position - position).normalize_or(DVec3::Z);
        let normal = match turned {
            0 => to_lights,
            // Grazing.
            1 => to_lights.cross(normal).normalize_or(DVec3::X),
            _ => normal,
        };
        let point = Point {
            position: position.as_vec3(),
            normal: normal.as_vec3().normalize(),
            albedo: Vec3::from_array(albedo),
            ..Point::default()
        };
        Case::new(lights, point)
    })
}

pub const FORMS: [BoundForm; 2] = [BoundForm::Walter, BoundForm::Cheap];

/// What of P14 a case breaks, with the bound and the estimate as given: f64 sums of either stay
/// below the bound, and a single light's estimate is its radiance. Numbers under 1e-30 count as 0.
pub fn broken(case: &Case, estimate: DVec3, bound: f64, rounding: f64) -> Option<String> {
    let (most, least) = (estimate.max_element(), estimate.min_element());
    let sum = case.sum();
    if !(bound.is_finite() && estimate.is_finite()) {
        return Some(format!("not finite: bound {bound}, estimate {estimate}"));
    }
    if !(least >= 0.0 && most <= bound) {
        return Some(format!("estimate {estimate} is not in 0..={bound}"));
    }
    if sum.is_nan() || sum > bound * (1.0 + rounding) + 1e-30 {
        return Some(format!("the lights give {sum}, above {bound}"));
    }
    let exactly = radiance(&case.point, &case.lights[0], CLAMP_M);
    if case.lights.len() == 1 && rounding == 0.0 && estimate != exactly {
        return Some(format!("a leaf's estimate {estimate} is not its light's {exactly}"));
    }
    None
}

/// P14 in f64, with clamps of the estimate and the bound.
pub fn broken_f64(case: &Case, clamp_estimate: f64, clamp_bound: f64) -> Option<String> {
    FORMS.iter().find_map(|&form| {
        let estimate = bound::estimate(&case.node, &case.point, clamp_estimate);
        let bound = bound::point(form, &case.node, &case.point, clamp_bound);
        broken(case, estimate, bound, 0.0).map(|why| format!("{form:?}: {why}"))
    })
}
