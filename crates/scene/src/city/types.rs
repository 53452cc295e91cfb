//! A city's data, plain and public.

use crate::{Aabb, Camera, CameraPath};
use glam::{DVec2, DVec3, Vec3};
use std::ops::Range;

/// Everything that is known of a city.
#[derive(Clone, Debug, Default)]
pub struct City {
    /// Name shown in tables: the generator's, or a file stem.
    pub name: String,
    /// Buildings, block by block.
    pub buildings: Vec<Building>,
    /// Buildings of each block, in order and without gaps (real cities: of each square tile).
    pub blocks: Vec<Range<u32>>,
    /// One a lit window, by building, facade, storey and window.
    pub lights: Vec<WindowLight>,
    /// Street lamps.
    pub lamps: Vec<StreetLamp>,
    /// Trees.
    pub trees: Vec<Tree>,
    /// Streets, sidewalks and all else that lies flat.
    pub grounds: Vec<Ground>,
    /// Named still views.
    pub cameras: Vec<Camera>,
    /// Camera paths.
    pub paths: Vec<CameraPath>,
    /// How places on the earth became metres, one sentence; empty for generated cities.
    pub projection: String,
}

/// A polygon with holes in the plane (x, z).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Outer ring, metres, counter-clockwise seen from above, so that walls run from left to right
    /// seen from outside; the first corner is not repeated. The area
    /// `0.5 Σ (x_{i+1} z_i - x_i z_{i+1})` is positive, and the outward normal of an edge (x, z) is
    /// (-z, x).
    pub outer: Vec<DVec2>,
    /// Courtyards, wound the other way (clockwise): the same rule gives their outward normals.
    pub holes: Vec<Vec<DVec2>>,
}

/// A building: its footprint raised.
#[derive(Clone, Debug)]
pub struct Building {
    /// From the file, or `block.number`.
    pub id: String,
    /// Seen from above.
    pub footprint: Footprint,
    /// Height of the ground, metres.
    pub base_m: f64,
    /// Height of the eaves above 0 (not above the base), metres: walls reach it everywhere.
    pub eaves_m: f64,
    /// Storeys that facades are divided into, at least one.
    pub storeys: u32,
    /// Walls, one an edge of the footprint: outer ring, then holes.
    pub facades: Vec<Facade>,
    /// Roof triangles, world space; a flat roof lies at the eaves.
    pub roof: Vec<[DVec3; 3]>,
    /// Walls above the eaves (gables), world space.
    pub gables: Vec<[DVec3; 3]>,
    /// The smallest axis-aligned box that holds the building.
    pub outer: Aabb,
    /// Boxes that lie within the building's solid, largest first; may be empty.
    pub inner: Vec<OrientedBox>,
}

/// One wall, from the base to the eaves. Seen from outside it runs from left to right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facade {
    /// Left end seen from outside, (x, z).
    pub from: DVec2,
    /// Right end.
    pub to: DVec2,
    /// A wall shared with a neighbour: no windows are lit there.
    pub party: bool,
}

/// An upright box, turned about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// Middle, world space.
    pub centre: DVec3,
    /// Unit vector in (x, z) along the first horizontal side.
    pub axis: DVec2,
    /// Half of the sides: along `axis`, up, and along the horizontal across it.
    pub half: DVec3,
}

/// A lit window: light leaves it into a cone, falling linearly with the angle to 0 at its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowLight {
    /// Just outside the window's middle, world space, metres.
    pub position: DVec3,
    /// Outward normal of the facade, unit length.
    pub direction: DVec3,
    /// Half the cone's opening, radians.
    pub half_angle_rad: f64,
    /// Radiant intensity along the normal, linear RGB.
    pub intensity: Vec3,
    /// Index into [`City::buildings`].
    pub building: u32,
    /// Index into its facades.
    pub facade: u32,
    /// From 0 at the ground.
    pub storey: u32,
}

impl WindowLight {
    /// Share of the intensity that leaves at `angle_rad` from the normal: 1 ahead, linear in the
    /// angle, 0 at the cone's edge and beyond.
    pub fn falloff(&self, angle_rad: f64) -> f64 {
        (1.0 - angle_rad / self.half_angle_rad).clamp(0.0, 1.0)
    }
}

/// A lamp over a street.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreetLamp {
    /// World space, metres.
    pub position: DVec3,
    /// Radiant intensity, linear RGB.
    pub intensity: Vec3,
}

/// A tree: a crown on a trunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tree {
    /// Foot of the trunk, world space.
    pub position: DVec3,
    /// To the top of the crown, metres.
    pub height_m: f64,
    /// Radius of the crown, metres.
    pub crown_radius_m: f64,
}

/// What lies flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundKind {
    /// Carriageway.
    Street,
    /// Beside it.
    Sidewalk,
    /// All else.
    Land,
    /// Water.
    Water,
}

/// A flat piece of the city.
#[derive(Clone, Debug)]
pub struct Ground {
    /// What it is.
    pub kind: GroundKind,
    /// World space, facing up.
    pub triangles: Vec<[DVec3; 3]>,
}

impl OrientedBox {
    /// The eight corners, world space; bit 0 of the index is the side along `axis`, bit 1 up, bit 2
    /// across.
    pub fn corners(&self) -> [DVec3; 8] {
        let along = DVec3::new(self.axis.x, 0.0, self.axis.y) * self.half.x;
        let across = DVec3::new(-self.axis.y, 0.0, self.axis.x) * self.half.z;
        let up = DVec3::Y * self.half.y;
        std::array::from_fn(|i| {
            let side = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            self.centre + along * side(0) + up * side(1) + across * side(2)
        })
    }

    /// Volume in cubic metres.
    pub fn volume_m3(&self) -> f64 {
        8.0 * self.half.x * self.half.y * self.half.z
    }
}

/// Bytes that a city's data take, what is reserved but unused left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CityBytes {
    /// Buildings with their facades, footprints, roofs and boxes.
    pub buildings: u64,
    /// Window lights and street lamps.
    pub lights: u64,
    /// Grounds and trees.
    pub grounds: u64,
}

impl CityBytes {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.buildings + self.lights + self.grounds
    }
}

impl City {
    /// Bytes of the city's data.
    pub fn bytes(&self) -> CityBytes {
        fn of<T>(list: &[T]) -> u64 {
            size_of_val(list) as u64
        }
        let building = |b: &Building| {
            let rings = of(&b.footprint.outer)
                + of(&b.footprint.holes)
                + b.footprint.holes.iter().map(|hole| of(hole)).sum::<u64>();
            let walls = of(&b.facades) + of(&b.roof) + of(&b.gables) + of(&b.inner);
            rings + walls + b.id.len() as u64
        };
        CityBytes {
            buildings: of(&self.buildings) + self.buildings.iter().map(building).sum::<u64>(),
            lights: of(&self.lights) + of(&self.lamps),
            grounds: of(&self.grounds)
                + of(&self.trees)
                + self.grounds.iter().map(|g| of(&g.triangles)).sum::<u64>(),
        }
    }
}
