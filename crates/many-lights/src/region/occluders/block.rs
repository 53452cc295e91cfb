//! Boxes as they stand, and the walls of the buildings that they stand in.

use crate::region::{Solid, Turn};
use dapple_scene::city::{Building, City, OrientedBox};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// An upright box, local space, turned about the vertical.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Corners of its plan (x, z), around it.
    pub plan: [DVec2; 4],
    /// Height of its foot, minus infinity where nothing passes below.
    pub foot: f64,
    /// Of its top.
    pub top: f64,
    /// What it stands in: index into [`Walls`], or [`NO_BUILDING`].
    pub building: u32,
}

/// A block that stands in nothing that is known.
pub const NO_BUILDING: u32 = u32::MAX;

/// The walls of each building, local space (x, z).
#[derive(Clone, Debug, Default)]
pub struct Walls(Vec<Vec<Wall>>);

#[derive(Clone, Copy, Debug)]
struct Wall {
    ends: [DVec2; 2],
    /// The building that has the very same wall from its other side.
    neighbour: u32,
}

impl Block {
    /// A box; `None` where a number is not finite or a side negative.
    pub fn new(b: &OrientedBox) -> Option<Self> {
        let finite = b.centre.is_finite() && b.axis.is_finite() && b.half.is_finite();
        if !finite || b.half.min_element() < 0.0 {
            return None;
        }
        let corner = |i: usize| b.corners()[i];
        let plan = [0, 1, 5, 4].map(|i| DVec2::new(corner(i).x, corner(i).z));
        let (foot, top) = (b.centre.y - b.half.y, b.centre.y + b.half.y);
        Some(Self { plan, foot, top, building: NO_BUILDING })
    }

    /// Area of its plan, square metres.
    pub fn area_m2(&self) -> f64 {
        let [a, b, _, d] = self.plan;
        a.distance(b) * a.distance(d)
    }

    /// The turned box around it.
    pub fn around(&self, turn: Turn) -> Solid {
        let plan = self.plan.map(|p| turned(turn, p));
        let min = plan.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let max = plan.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        Solid { min: DVec3::new(min.x, self.foot, min.y), max: DVec3::new(max.x, self.top, max.y) }
    }

    /// Boxes of building `index`: a rectangle along the axes stands for itself, so that neighbours
    /// touch exactly; else its inner boxes, from base to eaves.
    fn of_building<'a>(
        b: &'a Building,
        index: u32,
        origin: DVec3,
        lowest: f64,
    ) -> impl Iterator<Item = Self> + 'a {
        let (foot, top) = heights([b.base_m, b.eaves_m], origin, lowest);
        let outer = &b.footprint.outer;
        let rectangle = <[DVec2; 4]>::try_from(&outer[..])
            .ok()
            .filter(|plan| b.footprint.holes.is_empty() && is_upright(plan));
        let plans = match rectangle {
            Some(plan) => vec![plan],
            None => b.inner.iter().filter_map(Self::new).map(|block| block.plan).collect(),
        };
        let at = DVec2::new(origin.x, origin.z);
        plans.into_iter().map(move |plan| Self {
            plan: plan.map(|p| p - at),
            foot,
            top,
            building: index,
        })
    }
}

/// A local point of the plane (x, z), turned.
pub fn turned(turn: Turn, p: DVec2) -> DVec2 {
    let p = turn.to(DVec3::new(p.x, 0.0, p.y));
    DVec2::new(p.x, p.z)
}

/// Foot and top, local space. Nothing passes below what stands on the lowest point of everything:
/// both ends of every ray lie higher.
fn heights([base, top]: [f64; 2], origin: DVec3, lowest: f64) -> (f64, f64) {
    (if base <= lowest { f64::NEG_INFINITY } else { base - origin.y }, top - origin.y)
}

/// Whether the plan is a rectangle along the axes, exactly.
pub fn is_upright(plan: &[DVec2; 4]) -> bool {
    let along = |axis: usize, i: usize| plan[i][1 - axis] == plan[(i + 1) % 4][1 - axis];
    let from = |axis: usize| (0..4).all(|i| along((axis + i) % 2, i));
    from(0) || from(1)
}

/// Boxes of a city's buildings.
pub fn buildings(city: &City, origin: DVec3) -> Vec<Block> {
    let lowest = lowest(city);
    let numbered = (0..).zip(&city.buildings);
    numbered.flat_map(|(i, b)| Block::of_building(b, i, origin, lowest)).collect()
}

/// Every storey of every facade as a box without thickness.
pub fn storeys(city: &City, origin: DVec3) -> Vec<Block> {
    let (lowest, at) = (lowest(city), DVec2::new(origin.x, origin.z));
    let mut blocks = vec![];
    for building in &city.buildings {
        let storey_m = (building.eaves_m - building.base_m) / f64::from(building.storeys.max(1));
        // The same number where two storeys meet, and the eaves at the top.
        let height = |storey: u32| match storey == building.storeys {
            true => building.eaves_m,
            false => building.base_m + f64::from(storey) * storey_m,
        };
        for facade in &building.facades {
            let [from, to] = [facade.from, facade.to].map(|p| p - at);
            for storey in 0..building.storeys {
                let (foot, top) = heights([height(storey), height(storey + 1)], origin, lowest);
                blocks.push(Block { plan: [from, to, to, from], foot, top, building: NO_BUILDING });
            }
        }
    }
    blocks
}

/// Below every point of a city, world space.
fn lowest(city: &City) -> f64 {
    let bases = city.buildings.iter().map(|b| b.base_m.min(b.outer.min.y));
    let grounds = city.grounds.iter().flat_map(|g| g.triangles.iter().flatten()).map(|p| p.y);
    let lights = city.lights.iter().map(|l| l.position.y);
    let lamps = city.lamps.iter().map(|l| l.position.y);
    let trees = city.trees.iter().map(|t| t.position.y);
    bases.chain(grounds).chain(lights).chain(lamps).chain(trees).fold(f64::INFINITY, f64::min)
}

impl Walls {
    /// The walls of a city's buildings.
    pub fn of(city: &City, origin: DVec3) -> Self {
        // Only looked up, never walked through.
        let mut known: HashMap<[u64; 4], u32> = HashMap::new();
        for (index, building) in (0..).zip(&city.buildings) {
            for ends in building.footprint.edges() {
                known.entry(key(ends)).or_insert(index);
            }
        }
        let at = DVec2::new(origin.x, origin.z);
        let wall = |[from, to]: [DVec2; 2]| Wall {
            ends: [from - at, to - at],
            neighbour: known.get(&key([to, from])).copied().unwrap_or(NO_BUILDING),
        };
        Self(city.buildings.iter().map(|b| b.footprint.edges().map(wall).collect()).collect())
    }

    /// Bytes of the walls.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(|walls| size_of_val(&walls[..]) as u64).sum()
    }

    /// Whether two blocks' buildings are one, or share a wall.
    pub fn related(&self, a: u32, b: u32) -> bool {
        let Some(walls) = self.0.get(a as usize) else { return false };
        a == b || b != NO_BUILDING && walls.iter().any(|w| w.neighbour == b)
    }

    /// The border of the plans of two related buildings taken together: what both have from either
    /// side is inside.
    pub fn border(&self, a: u32, b: u32) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let of = |building: u32, other: u32| {
            let walls = self.0.get(building as usize).into_iter().flatten();
            walls.filter(move |w| building == other || w.neighbour != other).map(|w| w.ends)
        };
        let second = (a != b).then(|| of(b, a));
        of(a, b).chain(second.into_iter().flatten())
    }
}

/// The bits of two points; -0 counts as 0.
fn key(ends: [DVec2; 2]) -> [u64; 4] {
    let [a, b] = ends;
    [a.x, a.y, b.x, b.y].map(|v| (v + 0.0).to_bits())
}
