//! Cells around surfaces.

use super::{Direction, Face, Turn, ViewCell};
use crate::bound::Region;
use crate::light::angle;
use dapple_scene::city::OrientedBox;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// What points may stand off their surface, over their farthest coordinate: rounded to f32 they lie
/// 2^-24 of it off along each axis, and rays start [`crate::World::sees`]'s 2^-22 above that.
const LIFTED: f64 = 1.0 / (1 << 21) as f64;

/// Something flat enough to be lit as one: a storey of a facade, a roof, a piece of ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// A box around it, local space, metres. Of a wall, along the wall: a box along the axes would be as
    /// deep as the wall is askew.
    pub around: OrientedBox,
    /// Middle of its normals, unit length.
    pub normal_axis: DVec3,
    /// Their greatest angle from it, radians; π where there may be any.
    pub normal_spread_rad: f64,
    /// Greatest diffuse reflectance of each channel.
    pub albedo: DVec3,
    /// How it votes for the turn of its cell: a horizontal vector (x, z) along a facade, as long as it
    /// counts (its length or area); 0 where it does not vote, as roofs and ground.
    pub vote: DVec2,
}

impl Surface {
    /// A wall over the line from `from` to `to`, (x, z); seen from outside it runs from left to right.
    /// It votes with its area.
    pub fn wall(from: DVec2, to: DVec2, [bottom, top]: [f64; 2], albedo: DVec3) -> Self {
        let along = to - from;
        let axis = along.try_normalize().unwrap_or(DVec2::X);
        let (middle, length) = (0.5 * (from + to), along.length());
        let around = OrientedBox {
            centre: DVec3::new(middle.x, 0.5 * (bottom + top), middle.y),
            axis,
            half: DVec3::new(0.5 * length, 0.5 * (top - bottom), 0.0),
        };
        let normal_axis = DVec3::new(-axis.y, 0.0, axis.x);
        Self { around, normal_axis, normal_spread_rad: 0.0, albedo, vote: along * (top - bottom) }
    }

    /// What lies flat between two corners and faces up.
    pub fn flat(min: DVec3, max: DVec3, albedo: DVec3) -> Self {
        Self { normal_axis: DVec3::Y, normal_spread_rad: 0.0, ..Self::any(min, max, albedo) }
    }

    /// What may face anywhere, between two corners.
    pub fn any(min: DVec3, max: DVec3, albedo: DVec3) -> Self {
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        let around = OrientedBox { centre, axis: DVec2::X, half };
        let (normal_axis, normal_spread_rad) = (DVec3::Y, PI);
        Self { around, normal_axis, normal_spread_rad, albedo, vote: DVec2::ZERO }
    }

    /// Whether any point of it may be lit from `direction`, turned.
    fn faces(&self, turn: Turn, direction: Direction) -> bool {
        if self.normal_spread_rad > 0.0 {
            return true;
        }
        let normal = turn.to(self.normal_axis);
        normal.y != 0.0 || normal.dot(direction.vector()) > 0.0
    }
}

/// The turn of most facades, in whole degrees, each as much as its vote; of several with as many votes
/// the smallest. [`Turn::NONE`] without votes.
pub fn turn_of(surfaces: &[Surface]) -> Turn {
    let mut votes = [0.0; 90];
    for surface in surfaces.iter().filter(|s| s.vote != DVec2::ZERO && s.vote.is_finite()) {
        votes[Turn::nearest_degrees(surface.vote) as usize] += surface.vote.length();
    }
    let best = (0..90).rev().max_by(|&a, &b| votes[a as usize].total_cmp(&votes[b as usize]));
    Turn::degrees(best.unwrap_or(0))
}

impl ViewCell {
    /// The cell of these surfaces: for each direction the box of those that face it.
    pub fn around(surfaces: &[Surface], turn: Turn) -> Self {
        let faces = Direction::ALL
            .map(|direction| face(surfaces.iter().filter(|s| s.faces(turn, direction)), turn));
        Self { turn, faces }
    }
}

fn face<'a>(facing: impl Iterator<Item = &'a Surface> + Clone, turn: Turn) -> Option<Face> {
    let within = |turn: Turn| {
        let corners = facing.clone().flat_map(|s| s.around.corners());
        let joined = |a: [DVec3; 2], b: [DVec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        corners.map(|p| [turn.to(p); 2]).reduce(joined)
    };
    let [min, max] = within(Turn::NONE)?;
    let turned = within(turn)?;
    let lifted = LIFTED * min.abs().max(max.abs()).max_element();
    let (min, max) = (min - lifted, max + lifted);
    let axis = facing.clone().map(|s| s.normal_axis).sum::<DVec3>().try_normalize();
    let (normal_axis, normal_spread_rad) = match axis {
        Some(axis) => {
            let spread = facing.clone().map(|s| angle(axis, s.normal_axis) + s.normal_spread_rad);
            (axis, spread.fold(0.0, f64::max).min(PI))
        }
        None => (DVec3::Y, PI),
    };
    let albedo = facing.map(|s| s.albedo).fold(DVec3::ZERO, DVec3::max);
    let region = Region { min, max, normal_axis, normal_spread_rad, albedo };
    Some(Face { min: turned[0] - lifted, max: turned[1] + lifted, region })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GREY: DVec3 = DVec3::splat(0.5);

    fn horizontal(degrees: f64) -> DVec3 {
        let DVec2 { x, y } = DVec2::from_angle(degrees.to_radians());
        DVec3::new(x, 0.0, y)
    }

    #[test]
    fn walls_face_what_they_are_turned_to_and_flat_things_face_all() {
        // Seen from outside a wall towards +x faces +z.
        let wall = Surface::wall(DVec2::ZERO, DVec2::new(4.0, 0.0), [1.0, 3.0], GREY);
        assert_eq!(wall.normal_axis, DVec3::Z);
        let faced = |surface: Surface, degrees: u32| {
            let cell = ViewCell::around(&[surface], Turn::degrees(degrees));
            Direction::ALL.map(|d| cell.face(d).is_some())
        };
        assert_eq!(faced(wall, 0), [false, false, true, false]);
        assert_eq!(faced(wall, 30), [true, false, true, false]);
        let ground = Surface::flat(DVec3::ZERO, DVec3::new(5.0, 0.0, 5.0), GREY);
        let ceiling = Surface { normal_axis: DVec3::NEG_Y, ..ground };
        // A light over the ridge is in front of a roof that falls the other way.
        let roof = Surface { normal_axis: DVec3::new(0.6, 0.8, 0.0), ..ground };
        let tree = Surface::any(DVec3::ZERO, DVec3::ONE, GREY);
        for surface in [ground, ceiling, roof, tree] {
            assert_eq!(faced(surface, 0), [true; 4]);
            assert_eq!(faced(surface, 30), [true; 4]);
        }
        assert_eq!(ViewCell::around(&[], Turn::NONE).faces, [None; 4]);
    }

    #[test]
    fn a_face_holds_what_faces_it_and_nothing_else() {
        let front = Surface::wall(DVec2::ZERO, DVec2::new(4.0, 0.0), [1.0, 3.0], GREY);
        let back =
            Surface::wall(DVec2::new(4.0, -9.0), DVec2::new(0.0, -9.0), [1.0, 5.0], DVec3::X);
        let cell = ViewCell::around(&[front, back], Turn::NONE);
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-5;
        let face = cell.face(Direction::PlusZ).unwrap();
        assert!(
            near(face.min, DVec3::new(0.0, 1.0, 0.0)) && near(face.max, DVec3::new(4.0, 3.0, 0.0))
        );
        assert_eq!((face.region.normal_axis, face.region.normal_spread_rad), (DVec3::Z, 0.0));
        assert_eq!(face.region.albedo, GREY);
        let face = cell.face(Direction::MinusZ).unwrap();
        assert!(
            near(face.min, DVec3::new(0.0, 1.0, -9.0))
                && near(face.max, DVec3::new(4.0, 5.0, -9.0))
        );
        assert_eq!(face.region.albedo, DVec3::X);
        assert!(cell.face(Direction::PlusX).is_none());
        // Opposite normals: any.
        let flat = Surface::flat(DVec3::ZERO, DVec3::ONE, GREY);
        let both = [flat, Surface { normal_axis: DVec3::NEG_Y, albedo: DVec3::Z, ..flat }];
        let region = ViewCell::around(&both, Turn::NONE).faces[0].unwrap().region;
        assert_eq!((region.normal_spread_rad, region.albedo), (PI, DVec3::new(0.5, 0.5, 1.0)));
    }

    #[test]
    fn facades_vote_by_their_area_and_the_smallest_angle_wins_a_tie() {
        let wall = |degrees: f64, length: f64, height: f64| {
            let along = DVec2::from_angle(degrees.to_radians()) * length;
            Surface::wall(DVec2::ONE, DVec2::ONE + along, [0.0, height], GREY)
        };
        let roof = Surface::flat(DVec3::ZERO, DVec3::splat(100.0), GREY);
        assert_eq!(turn_of(&[]), Turn::NONE);
        assert_eq!(turn_of(&[roof]), Turn::NONE);
        assert_eq!(turn_of(&[roof, wall(33.2, 1.0, 1.0)]), Turn::degrees(33));
        assert_eq!(turn_of(&[wall(33.0, 5.0, 1.0), wall(61.0, 2.0, 2.0)]), Turn::degrees(33));
        assert_eq!(turn_of(&[wall(33.0, 5.0, 1.0), wall(61.0, 3.0, 2.0)]), Turn::degrees(61));
        // Opposite walls and walls across vote together; between 89.5 and 90.5 degrees is none.
        let house = [61.0, 151.0, 241.0, 331.0].map(|d| wall(d, 2.0, 1.0));
        assert_eq!(turn_of(&[&house[..], &[wall(33.0, 7.0, 1.0)]].concat()), Turn::degrees(61));
        assert_eq!(turn_of(&[wall(89.8, 1.0, 1.0)]), Turn::NONE);
        let tied = [wall(70.0, 2.0, 1.0), wall(20.0, 2.0, 1.0)];
        assert_eq!(turn_of(&tied), turn_of(&[tied[1], tied[0]]));
        let broken = Surface { vote: DVec2::NAN, ..roof };
        assert_eq!(turn_of(&[broken, wall(12.0, 1.0, 1.0)]), Turn::degrees(12));
    }

    proptest! {
        #[test]
        fn a_light_before_a_surface_is_in_front_of_a_face(
            normal in 0.0..360.0f64, up in prop_oneof![Just(0.0), -1.0..1.0f64],
            to_light in prop::array::uniform3(-1.0..1.0f64), degrees in 0u32..90,
        ) {
            let normal_axis = (horizontal(normal) + DVec3::Y * up).normalize();
            let flat = Surface::flat(DVec3::ZERO, DVec3::ZERO, GREY);
            let turn = Turn::degrees(degrees);
            let cell = ViewCell::around(&[Surface { normal_axis, ..flat }], turn);
            let to_light = DVec3::from(to_light);
            let horizontally = to_light.with_y(0.0).length() > 1e-6;
            if normal_axis.dot(to_light) > 1e-9 && horizontally {
                let turned = turn.to(to_light);
                let before = |d: &Direction| cell.face(*d).is_some() && d.vector().dot(turned) > 0.0;
                prop_assert!(Direction::ALL.iter().any(before));
            }
        }

        #[test]
        fn points_and_the_starts_of_their_rays_lie_in_every_face_of_their_surface(
            from in prop::array::uniform2(-1e5..1e5f64), along in 0.0..360.0f64, length in 0.1..300.0f64,
            bottom in -100.0..1e3f64, height in 0.0..200.0f64, degrees in 0u32..90,
            share in prop::array::uniform2(0.0..=1.0f64), ends in any::<[bool; 2]>(),
        ) {
            let (from, along) = (DVec2::from(from), horizontal(along));
            let to = from + DVec2::new(along.x, along.z) * length;
            let wall = Surface::wall(from, to, [bottom, bottom + height], GREY);
            let turn = Turn::degrees(degrees);
            let cell = ViewCell::around(&[wall], turn);
            let share = [0, 1].map(|i| if ends[i] { share[i].round() } else { share[i] });
            let plan = from.lerp(to, share[0]);
            let point = DVec3::new(plan.x, bottom + share[1] * height, plan.y);
            let point = crate::Point { position: point.as_vec3(), ..crate::Point::default() };
            // As rays of truth start.
            let farthest = f64::from(point.position.abs().max_element());
            let lifted = point.position.as_dvec3() + wall.normal_axis * farthest / f64::from(1 << 22);
            for face in cell.faces.iter().flatten() {
                for p in [point.position.as_dvec3(), lifted] {
                    let turned = turn.to(p);
                    prop_assert!(turned.cmpge(face.min).all() && turned.cmple(face.max).all());
                    prop_assert!(p.cmpge(face.region.min).all() && p.cmple(face.region.max).all());
                }
                // As shallow as the wall is askew by, no deeper.
                let askew = turn.to(along).with_y(0.0).abs();
                let grown = 1e5 * 1.5 / f64::from(1 << 20);
                let sides = face.max - face.min;
                prop_assert!(sides.x <= askew.x * length + grown && sides.z <= askew.z * length + grown);
            }
            prop_assert!(cell.faces.iter().flatten().count() >= 1);
        }

        #[test]
        fn normals_of_all_surfaces_lie_in_the_regions_cone(
            normals in prop::collection::vec((0.0..360.0f64, -1.0..1.0f64), 1..6),
        ) {
            let surface = |&(degrees, up): &(f64, f64)| Surface {
                normal_axis: (horizontal(degrees) + DVec3::Y * up).normalize(),
                ..Surface::flat(DVec3::ZERO, DVec3::ONE, GREY)
            };
            let surfaces: Vec<Surface> = normals.iter().map(surface).collect();
            let cell = ViewCell::around(&surfaces, Turn::NONE);
            for surface in &surfaces {
                for direction in Direction::ALL.into_iter().filter(|d| surface.faces(Turn::NONE, *d)) {
                    let region = cell.face(direction).unwrap().region;
                    let off = angle(region.normal_axis, surface.normal_axis);
                    prop_assert!(off <= region.normal_spread_rad + 1e-12, "{off} {region:?}");
                }
            }
        }
    }
}
