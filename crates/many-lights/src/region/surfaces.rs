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
