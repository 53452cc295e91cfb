//! Which lights a face may mirror towards an eye: a reflection cone against a light tree.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 1.2 (light that is
//! reflected is constrained by occlusion and by the reflective cone of a cone-like lobe) and 6.1.
//! Deviations: the thesis only says that it is feasible. Here a face is divided into parts; from a part,
//! the mirror directions of an eye lie in one cone and the directions to a cluster in another, and the
//! cluster is kept where the two come as near as the lobe is wide.

use crate::{
    Emission, LightTree, LightsError, Node,
    bound::{ANGLE_SLACK_RAD, Region},
    cut::walk,
    light::angle,
};
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Times a face may be halved.
pub const MOST_HALVINGS: u32 = 12;

/// Share of the greatest coordinate by which differences of coordinates may be off.
const ROUNDING: f64 = 1e-14;

/// Directions: all within an angle from an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    axis: DVec3,
    /// π where there may be any.
    half_angle_rad: f64,
}

/// A part of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    min: DVec3,
    max: DVec3,
    /// Where the eye is mirrored to from it.
    mirrored: Cone,
}

/// What an eye may see mirrored in a face.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    parts: Vec<Part>,
    /// Of the surfaces: the side on which light is mirrored.
    normals: Cone,
    /// Half the opening of the lobe, radians.
    lobe_rad: f64,
}

impl Mirror {
    /// Of a face seen from an eye anywhere in the box `eye` (lower and upper corner, local space, the
    /// same for a single eye), whose surfaces mirror light to all directions within `lobe_rad` of the
    /// mirror direction. The face is halved `halvings` times: more parts leave out more.
    ///
    /// # Errors
    /// [`LightsError::Value`]: a box or an angle that is no number, a lobe outside 0..=π/2, more than
    /// [`MOST_HALVINGS`].
    pub fn new(
        region: &Region,
        eye: [DVec3; 2],
        lobe_rad: f64,
        halvings: u32,
    ) -> Result<Self, LightsError> {
        let refuse = |name: &str, limit: String| Err(LightsError::value(name, limit));
        if !(0.0..=FRAC_PI_2).contains(&lobe_rad) {
            return refuse("lobe", format!("{lobe_rad} is not in 0..=π/2 radians"));
        }
        if halvings > MOST_HALVINGS {
            return refuse("halvings of a face", format!("{halvings} of at most {MOST_HALVINGS}"));
        }
        if ![eye[0], eye[1], region.min, region.max].iter().all(|corner| corner.is_finite()) {
            return refuse("face and eye", "their corners have to be finite numbers".into());
        }
        let axis = region.normal_axis.normalize_or(DVec3::Z);
        let normals = Cone { axis, half_angle_rad: region.normal_spread_rad };
        let mut boxes = vec![(region.min, region.max)];
        for _ in 0..halvings {
            boxes = boxes.into_iter().flat_map(halves).collect();
        }
        let parts = boxes.into_iter().filter_map(|(min, max)| {
            let to_eye = between(min, max, eye[0], eye[1]);
            // An eye behind all surfaces sees none of them.
            normals.face(to_eye).then(|| {
                let mirrored = Cone::around(mirrored(axis, to_eye));
                // A normal that leans by an angle turns what it mirrors by twice as much.
                let half_angle_rad = mirrored.half_angle_rad + 2.0 * normals.half_angle_rad;
                Part { min, max, mirrored: Cone { half_angle_rad, ..mirrored } }
            })
        });
        Ok(Self { parts: parts.collect(), normals, lobe_rad })
    }

    /// Whether any point of the face may mirror any light of a cluster towards the eye. Never refuses
    /// one that does.
    pub fn may_reflect(&self, node: &Node) -> bool {
        self.parts.iter().any(|part| {
            let to_light = if node.kind == Emission::Directional.code() {
                let axis = -node.axis.normalize_or(DVec3::Z);
                Cone { axis, half_angle_rad: node.cone_rad }
            } else {
                let vectors = between(part.min, part.max, node.min, node.max);
                if !self.normals.face(vectors) {
                    return false;
                }
                Cone::around(vectors)
            };
            self.normals.comes_within(&to_light, FRAC_PI_2)
                && part.mirrored.comes_within(&to_light, self.lobe_rad)
        })
    }

    /// The single lights below `nodes` (a precut) that may be mirrored, as nodes in increasing order
    /// where `nodes` are: highlights of clusters would be highlights where no light is. Clusters
    /// that were looked at are counted.
    pub fn reflected(&self, tree: &LightTree, nodes: &[u32], lights: &mut Vec<u32>) -> u64 {
        lights.clear();
        let mut tests = 0;
        walk(tree, nodes, |index, node| {
            tests += 1;
            let may = self.may_reflect(node);
            if may && node.is_leaf() {
                lights.push(index);
            }
            !may || node.is_leaf()
        });
        tests
    }
}

impl Cone {
    /// Around the vectors of a box that is given by its middle and half its sides.
    fn around((middle, half): (DVec3, DVec3)) -> Self {
        let everything = Self { axis: DVec3::Z, half_angle_rad: PI };
        let Some(axis) = middle.try_normalize() else { return everything };
        let corner = |index: u32| {
            let side = |bit: u32| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
            middle + half * DVec3::new(side(0), side(1), side(2))
        };
        let half_angle_rad = (0..8).map(|i| angle(axis, corner(i))).fold(0.0, f64::max);
        // Narrower cones are convex and hold what lies between the corners; a box around 0 has
        // corners beyond.
        if half_angle_rad < FRAC_PI_2 { Self { axis, half_angle_rad } } else { everything }
    }

    /// Whether a vector of a box may lie on the side that one of these normals shows.
    fn face(&self, (middle, half): (DVec3, DVec3)) -> bool {
        let spread = self.half_angle_rad + ANGLE_SLACK_RAD;
        let highest = self.axis.dot(middle) + self.axis.abs().dot(half);
        let farthest = (middle.abs() + half).length();
        spread >= FRAC_PI_2
            || highest > 0.0
            // What lies below all is raised by no more than a normal leans.
            || highest * spread.cos() + farthest * spread.sin() > 0.0
    }

    /// Whether a direction of this and one of another cone may be within an angle of each other.
    fn comes_within(&self, other: &Self, angle_rad: f64) -> bool {
        let reach = self.half_angle_rad + other.half_angle_rad + angle_rad + ANGLE_SLACK_RAD;
        angle(self.axis, other.axis) <= reach
    }
}

/// Vectors from one box to another, as middle and half sides, with what their differences lose.
fn between(min: DVec3, max: DVec3, to_min: DVec3, to_max: DVec3) -> (DVec3, DVec3) {
    let (low, high) = (to_min - max, to_max - min);
    let farthest = [min, max, to_min, to_max].map(|v| v.abs().max_element());
    let lost = ROUNDING * farthest.into_iter().fold(0.0, f64::max);
    (0.5 * (low + high), 0.5 * (high - low) + lost)
}

/// The box around the mirror images of a box of vectors: each is turned half about the normal.
fn mirrored(normal: DVec3, (middle, half): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let turn = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * 2.0
        - DMat3::IDENTITY;
    let reach = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
    // Turning rounds too.
    (turn * middle, reach * half + ROUNDING * (middle.abs().element_sum()))
}

fn halves((min, max): (DVec3, DVec3)) -> [(DVec3, DVec3); 2] {
    let axis = (max - min).max_position();
    let middle = 0.5 * (min[axis] + max[axis]);
    let (mut first, mut second) = ((min, max), (min, max));
    (first.1[axis], second.0[axis]) = (middle, middle);
    [first, second]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, tree::Representative};

    /// The plane z = 0, facing +z, and an eye in front of its middle.
    fn wall(half: f64) -> Region {
        Region {
            min: DVec3::new(-half, -half, 0.0),
            max: DVec3::new(half, half, 0.0),
            normal_axis: DVec3::Z,
            normal_spread_rad: 0.0,
            albedo: DVec3::ONE,
        }
    }

    fn node(position: DVec3, emission: Emission, axis: DVec3) -> Node {
        let light = Light { position, axis, intensity: DVec3::ONE, emission };
        LightTree::build(&[light], crate::tree::Build::Median, Representative::Weighted)
            .unwrap()
            .nodes[0]
    }

    #[test]
    fn a_point_of_a_wall_mirrors_what_lies_in_the_mirror_direction() {
        let eye = [DVec3::new(-3.0, 0.0, 4.0); 2];
        let mirror = Mirror::new(&wall(0.0), eye, 0.1, 0).unwrap();
        let at = |degrees: f64| {
            // Towards (3, 0, 4), and turned away from it.
            let direction = DVec3::new(0.6, 0.0, 0.8);
            let turned = glam::DQuat::from_rotation_y(degrees.to_radians()) * direction;
            mirror.may_reflect(&node(turned * 20.0, Emission::Omni, DVec3::Z))
        };
        // The lobe is 5.73 degrees wide.
        assert_eq!(
            [0.0, 5.7, -5.7, 5.8, -5.8, 90.0].map(at),
            [true, true, true, false, false, false]
        );
        let parallel = |axis: DVec3| node(DVec3::ZERO, Emission::Directional, axis);
        assert!(mirror.may_reflect(&parallel(DVec3::new(-0.6, 0.0, -0.8))));
        assert!(!mirror.may_reflect(&parallel(DVec3::new(0.6, 0.0, 0.8))));
    }

    #[test]
    fn eyes_behind_a_wall_see_nothing_in_it_and_eyes_on_it_anything() {
        let behind = Mirror::new(&wall(2.0), [DVec3::new(0.0, 0.0, -1.0); 2], 0.5, 3).unwrap();
        assert!(behind.parts.is_empty());
        let on = Mirror::new(&wall(2.0), [DVec3::ZERO; 2], 0.0, 0).unwrap();
        assert!(on.may_reflect(&node(DVec3::new(9.0, 3.0, 1.0), Emission::Omni, DVec3::Z)));
        // Whatever is mirrored lies in front.
        assert!(!on.may_reflect(&node(DVec3::new(0.0, 0.0, -1.0), Emission::Omni, DVec3::Z)));
    }

    #[test]
    fn what_means_nothing_is_refused_by_name() {
        let eye = [DVec3::Z; 2];
        let error = |region: &Region, eye, lobe, halvings| {
            Mirror::new(region, eye, lobe, halvings).unwrap_err().to_string()
        };
        let wall = wall(1.0);
        assert_eq!(error(&wall, eye, 2.0, 0), "lobe: 2 is not in 0..=π/2 radians");
        assert!(error(&wall, eye, f64::NAN, 0).starts_with("lobe"));
        assert_eq!(error(&wall, eye, 0.1, 13), "halvings of a face: 13 of at most 12");
        let nowhere = [DVec3::NAN; 2];
        assert_eq!(
            error(&wall, nowhere, 0.1, 0),
            "face and eye: their corners have to be finite numbers"
        );
    }
}
