//! Strands as flat ribbons that face one viewer or one direction: two triangles a segment.
//!
//! Both corners at a bend are shared by the segments that meet there and lie on the bend's bisector
//! (a mitred joint), so that a ribbon has no gaps, and away from its ends both its edges are a
//! radius away from the line. Seen from where it faces, it covers what a line of that radius covers,
//! but for the round ends. A segment shorter than its ribbon is wide, at a sharp bend, may fold over
//! itself.

use super::Strands;
use crate::Mesh;
use glam::{DVec3, Vec3};

/// A segment shorter than this share of its distance from the origin is no longer than the rounding
/// of its ends, and has no direction.
const SHORTEST: f64 = 2.4e-7;

/// Whom ribbons face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// A point: a perspective camera, a spot light. World space, metres.
    Point(DVec3),
    /// Whoever looks along this direction: the travel of parallel light, the axis of an
    /// orthographic camera. Any length but 0.
    Direction(DVec3),
}

impl Facing {
    /// Unit vector from a point towards the viewer.
    fn towards(self, point: DVec3) -> DVec3 {
        let away = match self {
            Self::Point(eye) => eye - point,
            Self::Direction(direction) => -direction,
        };
        away.normalize_or(DVec3::Y)
    }
}

/// Ribbons of all strands.
#[derive(Clone, Debug)]
pub struct Ribbons {
    /// One mesh of material 0, two triangles for each segment that is not skipped, strand by strand
    /// from root to tip; counter-clockwise as seen by the viewer, normals towards it.
    pub mesh: Mesh,
    /// Segments without length, which are left out.
    pub skipped: usize,
}

impl Strands {
    /// The strands as ribbons, each as wide as twice the radius at its points. They must be valid
    /// ([`Strands::validate`]).
    pub fn ribbons(&self, facing: Facing) -> Ribbons {
        let mut mesh = Mesh { name: self.name.clone(), ..Mesh::default() };
        let mut skipped = 0;
        let mut line = vec![];
        for range in self.ranges() {
            line.clear();
            for i in range {
                let point = Point::new(self.points[i].as_dvec3(), self.radius_at(i), facing);
                match line.last() {
                    Some(last) if !point.is_apart(last) => skipped += 1,
                    _ => line.push(point),
                }
            }
            push_ribbon(&mut mesh, &line);
        }
        Ribbons { mesh, skipped }
    }
}

/// A point of a strand that differs from the one before it.
struct Point {
    at: DVec3,
    radius: f64,
    towards: DVec3,
}

impl Point {
    fn new(at: DVec3, radius: f64, facing: Facing) -> Self {
        Self { at, radius, towards: facing.towards(at) }
    }

    fn is_apart(&self, other: &Self) -> bool {
        let far = self.at.abs().max(other.at.abs()).max_element();
        self.at.distance(other.at) > SHORTEST * far
    }
}

fn push_ribbon(mesh: &mut Mesh, line: &[Point]) {
    if line.len() < 2 {
        return;
    }
    let first = mesh.positions.len() as u32;
    // 1 while the ribbon's first corner is on the viewer's right of the line, else -1.
    let (mut side, mut before) = (1.0, None);
    for (i, point) in line.iter().enumerate() {
        let right_of = |from: usize, to: usize| right(line[to].at - line[from].at, point.towards);
        let into = (i > 0).then(|| right_of(i - 1, i)).flatten();
        let out = (i + 1 < line.len()).then(|| right_of(i, i + 1)).flatten();
        // A segment that points at the viewer has no side of its own.
        let into =
            into.or(before).or(out).unwrap_or_else(|| point.towards.any_orthonormal_vector());
        let out = out.unwrap_or(into);
        if i > 0 {
            let a = first + 2 * (i as u32 - 1);
            let [b, c, d] = [a + 1, a + 2, a + 3];
            let faces = if side > 0.0 { [[a, c, d], [a, d, b]] } else { [[a, d, c], [a, b, d]] };
            mesh.triangles.extend(faces);
        }
        // Where the line turns back by more than a right angle, left and right change places: the
        // ribbon folds over instead of running out into a spike.
        let turn = if into.dot(out) < 0.0 { -1.0 } else { 1.0 };
        let bisector = (into + turn * out).normalize_or(into);
        // Half the turn is 45 degrees at most.
        let reach = point.radius / bisector.dot(into).max(std::f64::consts::FRAC_1_SQRT_2);
        for corner in [side, -side] {
            mesh.positions.push((point.at + bisector * (corner * reach)).as_vec3());
            mesh.normals.push(unit(point.towards));
        }
        side *= turn;
        before = Some(out);
    }
}

/// Unit vector to the right of `along` as seen by the viewer; `None` if it points at the viewer.
fn right(along: DVec3, towards: DVec3) -> Option<DVec3> {
    let across = along.cross(towards);
    (across.length() > 1e-9 * along.length()).then(|| across.normalize())
}

fn unit(v: DVec3) -> Vec3 {
    v.as_vec3().normalize_or(Vec3::Y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    fn strand(points: &[[f32; 3]], radius: f32) -> Strands {
        let points = points.iter().map(|p| Vec3::from_array(*p)).collect();
        Strands { name: "one".into(), starts: vec![0], points, radius: vec![radius] }
    }

    /// Twice the area that the viewer along -z sees of a triangle, positive if counter-clockwise.
    fn seen(mesh: &Mesh, t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3().truncate());
        (b - a).perp_dot(c - a)
    }

    #[test]
    fn a_straight_strand_is_a_rectangle_that_faces_the_viewer() {
        let s = strand(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 0.25);
        let Ribbons { mesh, skipped } = s.ribbons(Facing::Direction(DVec3::NEG_Z * 7.0));
        let low = |x| Vec3::new(x, -0.25, 0.0);
        let high = |x| Vec3::new(x, 0.25, 0.0);
        let expected = [low(0.0), high(0.0), low(1.0), high(1.0), low(3.0), high(3.0)];
        assert_eq!(mesh.positions, expected);
        assert_eq!(mesh.normals, [Vec3::Z; 6]);
        assert_eq!((mesh.triangles.len(), skipped, mesh.name.as_str()), (4, 0, "one"));
        assert!(mesh.triangles.iter().all(|t| seen(&mesh, *t) > 0.0));
        // Two by two and a half metres, in all.
        let area: f64 = mesh.triangles.iter().map(|t| 0.5 * seen(&mesh, *t)).sum();
        assert!((area - 3.0 * 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_right_angle_is_mitred_on_shared_corners() {
        let s = strand(&[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]], 0.5);
        let mesh = s.ribbons(Facing::Direction(DVec3::NEG_Z)).mesh;
        assert!(mesh.positions[2].distance(Vec3::new(2.5, -0.5, 0.0)) < 1e-6);
        assert!(mesh.positions[3].distance(Vec3::new(1.5, 0.5, 0.0)) < 1e-6);
        assert!(mesh.triangles.iter().all(|t| seen(&mesh, *t) > 0.0));
    }

    #[test]
    fn a_point_sees_the_full_width_wherever_it_is() {
        let eye = DVec3::new(1.0, 5.0, -3.0);
        let points = [[0.0, 0.0, 0.0], [0.5, 0.1, 0.3], [1.5, -0.2, 0.4], [1.4, 0.8, 0.5]];
        let mesh = strand(&points, 0.01).ribbons(Facing::Point(eye)).mesh;
        for (pair, p) in mesh.positions.chunks(2).zip(points) {
            let (middle, p) = (0.5 * (pair[0] + pair[1]).as_dvec3(), Vec3::from(p).as_dvec3());
            let across = (pair[1] - pair[0]).as_dvec3();
            assert!(middle.distance(p) < 1e-6);
            assert!(across.normalize().dot((eye - p).normalize()).abs() < 1e-4, "not facing");
        }
        let towards = mesh.normals[0].as_dvec3();
        assert!(towards.distance(eye.normalize()) < 1e-6);
    }

    #[test]
    fn segments_without_length_are_skipped_and_counted() {
        let doubled = [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        let Ribbons { mesh, skipped } =
            strand(&doubled, 0.1).ribbons(Facing::Direction(DVec3::NEG_Z));
        let plain = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        let expected = strand(&plain, 0.1).ribbons(Facing::Direction(DVec3::NEG_Z)).mesh;
        assert_eq!(
            (mesh.positions, mesh.triangles, skipped),
            (expected.positions, expected.triangles, 2)
        );
        let nothing = strand(&[[1.0; 3]; 4], 0.1).ribbons(Facing::Point(DVec3::ZERO));
        assert_eq!((nothing.mesh.triangles.len(), nothing.skipped), (0, 3));
    }

    #[test]
    fn strands_that_point_at_the_viewer_or_turn_back_stay_finite_and_joined() {
        let at_viewer = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]];
        let bent = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        let back = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.5, 0.0]];
        for points in [&at_viewer[..], &bent, &back] {
            for facing in [Facing::Direction(DVec3::NEG_Z), Facing::Point(DVec3::ZERO)] {
                let mesh = strand(points, 0.1).ribbons(facing).mesh;
                assert!(mesh.positions.iter().chain(&mesh.normals).all(|p| p.is_finite()));
                assert_eq!(mesh.triangles.len(), 2 * (points.len() - 1));
                for pair in mesh.positions.chunks(2) {
                    let width = pair[0].distance(pair[1]);
                    assert!((0.19..0.29).contains(&width), "{width}");
                }
            }
        }
        // Turning back on itself: no crossed corners, both ways a full ribbon.
        let mesh = strand(&back[..3], 0.1).ribbons(Facing::Direction(DVec3::NEG_Z)).mesh;
        let areas: Vec<f64> = mesh.triangles.iter().map(|t| 0.5 * seen(&mesh, *t)).collect();
        assert!(areas.iter().all(|a| (a - 0.1).abs() < 1e-6), "{areas:?}");
    }

    /// Whether a point of the image lies in a triangle, its edge included.
    fn covers(mesh: &Mesh, p: DVec2) -> bool {
        mesh.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3().truncate());
            let side = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a);
            let sides = [side(a, b), side(b, c), side(c, a)];
            sides.iter().all(|s| *s >= -1e-7) || sides.iter().all(|s| *s <= 1e-7)
        })
    }

    fn config() -> ProptestConfig {
        let cases = std::env::var("PROPTEST_CASES").ok().and_then(|c| c.parse().ok());
        ProptestConfig::with_cases(cases.unwrap_or(64))
    }

    proptest! {
        #![proptest_config(config())]
        #[test]
        fn what_is_nearer_than_a_radius_is_covered_also_at_bends(
            turns in proptest::collection::vec(-2.8..2.8f64, 1..6), u in 0.0..1.0f64, v in -0.99..0.99f64,
        ) {
            let radius = 0.05;
            let (mut at, mut angle, mut points) = (DVec3::ZERO, 0.3_f64, vec![[0.0f32; 3]]);
            for turn in turns {
                angle += turn;
                at += DVec3::new(angle.cos(), angle.sin(), 0.3);
                points.push(at.as_vec3().to_array());
            }
            let s = strand(&points, radius as f32);
            let mesh = s.ribbons(Facing::Direction(DVec3::NEG_Z)).mesh;
            for pair in s.points.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|p| p.as_dvec3().truncate());
                // Not near the ends, where the bevel of a sharp bend may pass.
                let along = (b - a).normalize();
                let p = a.lerp(b, 0.1 + 0.8 * u) + along.perp() * (radius * v);
                prop_assert!(covers(&mesh, p), "{} of {:?}", p, points);
                let outside = along.perp() * (1.01 * radius);
                let one = strand(&[pair[0].to_array(), pair[1].to_array()], radius as f32);
                let alone = one.ribbons(Facing::Direction(DVec3::NEG_Z)).mesh;
                prop_assert!(!covers(&alone, a.lerp(b, u) + outside), "too wide");
            }
            // On the line itself at each joint.
            for p in &s.points[1..s.points.len() - 1] {
                prop_assert!(covers(&mesh, p.as_dvec3().truncate()));
            }
        }
    }
}
