//! What hides lights: upright boxes within buildings, in the turn of a cell.
//!
//! A cell and its occluders have to be upright boxes of one space. So the boxes of a city, which stand
//! every way, are inscribed with upright boxes of each turn that cells ask for: those lie within, so
//! that whatever they hide the city hides as well. What is lost is reported ([`Turned::lost`]).
//!
//! Boxes of neighbours are to touch, else their shadows are never joined. Plans that are rectangles
//! along the axes stand for themselves, and share the numbers of the wall between them; elsewhere gaps
//! that lie inside two buildings with a wall in common are closed (`gaps`).

mod block;
mod clusters;
mod gaps;
mod inscribed;
mod runs;

use super::{OccluderMode, Turn};
use block::{Block, NO_BUILDING, Walls};
use dapple_scene::city::{City, OrientedBox};
use gaps::{Placed, Plan};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// An upright box of turned space, closed: its sides hide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Lower corner, metres; `min.y` is the foot, minus infinity where nothing passes below.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

/// Occluders as seen from cells of one turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turned {
    /// In a fixed order; runs come after their members.
    pub solids: Vec<Solid>,
    /// Share of the boxes' plan area that the turn took from them, 0..=1. Parts that several boxes
    /// share count for each.
    pub lost: f64,
}

/// Everything that may hide a light, local space.
#[derive(Debug, Default)]
pub struct Occluders {
    blocks: Vec<Block>,
    walls: Walls,
    turned: Mutex<HashMap<Key, Made>>,
}

/// A turn's axis and a mode.
type Key = ([u64; 2], OccluderMode);
/// What is made once, by whoever comes first.
type Made = Arc<OnceLock<Arc<Turned>>>;

impl Occluders {
    /// The buildings of a city: boxes that lie within them, from base to eaves. `origin` is
    /// [`crate::World::origin`].
    pub fn of_city(city: &City, origin: DVec3) -> Self {
        let (blocks, walls) = (block::buildings(city, origin), Walls::of(city, origin));
        Self { blocks, walls, ..Self::default() }
    }

    /// All objects of a city: its buildings, and every storey of every facade as a box without
    /// thickness. Storeys count in turns that they are parallel to; a box that is askew to them lies
    /// in none.
    pub fn of_objects(city: &City, origin: DVec3) -> Self {
        let mut all = Self::of_city(city, origin);
        all.blocks.extend(block::storeys(city, origin));
        all
    }

    /// Boxes of local space. Those with numbers that are not finite, or negative sides, are left out.
    pub fn of_boxes(boxes: Vec<OrientedBox>) -> Self {
        Self { blocks: boxes.iter().filter_map(Block::new).collect(), ..Self::default() }
    }

    /// Nothing hides anything.
    pub fn none() -> Self {
        Self::default()
    }

    /// Boxes, before any turn.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    /// The occluders in the space of a turn: made when it is first asked for, then kept.
    pub fn turned(&self, turn: Turn, mode: OccluderMode) -> Arc<Turned> {
        let key = (turn.axis().to_array().map(f64::to_bits), mode);
        let made = {
            let mut turned = self.turned.lock().unwrap_or_else(PoisonError::into_inner);
            turned.entry(key).or_default().clone()
        };
        made.get_or_init(|| Arc::new(self.turn(turn, mode))).clone()
    }

    /// Bytes of the boxes, and of what has been made for turns.
    pub fn bytes(&self) -> u64 {
        let turned = self.turned.lock().unwrap_or_else(PoisonError::into_inner);
        let made = turned.values().filter_map(|made| made.get());
        let solids: usize = made.map(|t| size_of_val(&t.solids[..])).sum();
        (size_of_val(&self.blocks[..]) + solids) as u64 + self.walls.bytes()
    }

    fn turn(&self, turn: Turn, mode: OccluderMode) -> Turned {
        let mut inscribed: Vec<Solid> = vec![];
        let mut placed: Vec<Placed> = vec![];
        for block in &self.blocks {
            inscribed::within(block, turn, &mut inscribed);
            let building = block.building;
            placed.extend(inscribed.drain(..).map(|solid| Placed { solid, building }));
        }
        let area = |p: &Placed| (p.solid.max.x - p.solid.min.x) * (p.solid.max.z - p.solid.min.z);
        let kept: f64 = placed.iter().map(area).sum();
        let whole: f64 = self.blocks.iter().map(Block::area_m2).sum();
        let lost = if whole > 0.0 { (1.0 - kept / whole).clamp(0.0, 1.0) } else { 0.0 };
        let solids = match mode {
            OccluderMode::BoundingBoxes => self.clusters(turn),
            OccluderMode::Leaf | OccluderMode::ContiguousMin => {
                let local = |p: DVec2| block::turned(turn, p);
                let plan = Plan { walls: &self.walls, turn: &local };
                let runs = match mode {
                    OccluderMode::ContiguousMin => runs::runs(&placed, &plan),
                    _ => vec![],
                };
                plan.close(&mut placed);
                placed.iter().map(|p| p.solid).chain(runs).collect()
            }
        };
        Turned { solids, lost }
    }

    /// Boxes around clusters of buildings; of blocks that stand in none, around clusters of these.
    fn clusters(&self, turn: Turn) -> Vec<Solid> {
        let mut boxes: Vec<Placed> = vec![];
        for block in &self.blocks {
            let Solid { min, max } = block.around(turn);
            match boxes.last_mut() {
                Some(last) if last.building == block.building && block.building != NO_BUILDING => {
                    let own = &mut last.solid;
                    (own.min, own.max) = (own.min.min(min), own.max.max(max));
                }
                _ => boxes.push(Placed { solid: Solid { min, max }, building: block.building }),
            }
        }
        // Boxes alone share a wall where they touch.
        let alone = |p: &Placed| p.building == NO_BUILDING;
        clusters::clusters(&boxes, |a, b| {
            alone(a) || alone(b) || self.walls.related(a.building, b.building)
        })
    }
}
