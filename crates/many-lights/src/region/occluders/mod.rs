//! What hides lights: upright boxes within buildings, in the turn of a cell.
//!
//! A cell and its occluders have to be upright boxes of one space. So the boxes of a city, which stand
//! every way, are inscribed with upright boxes of each turn that cells ask for: those lie within, so
//! that whatever they hide the city hides as well. What is lost is reported.

mod inscribed;

use super::{OccluderMode, Turn};
use dapple_scene::city::{City, OrientedBox};
use glam::DVec3;
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
    /// In a fixed order.
    pub solids: Vec<Solid>,
    /// Share of the occluders' plan area that the turn took from them, 0..=1.
    pub lost: f64,
}

/// Everything that may hide a light, local space.
#[derive(Debug, Default)]
pub struct Occluders {
    boxes: Vec<OrientedBox>,
    turned: Mutex<HashMap<Key, Cell>>,
}

/// A turn's axis and a mode.
type Key = ([u64; 2], OccluderMode);
type Cell = Arc<OnceLock<Arc<Turned>>>;

impl Occluders {
    /// Boxes that lie within the buildings of a city. `origin` is [`crate::World::origin`].
    pub fn of_city(city: &City, origin: DVec3) -> Self {
        let local = |b: &OrientedBox| OrientedBox { centre: b.centre - origin, ..*b };
        Self::of_boxes(city.buildings.iter().flat_map(|b| &b.inner).map(local).collect())
    }

    /// Boxes of local space.
    pub fn of_boxes(boxes: Vec<OrientedBox>) -> Self {
        Self { boxes, ..Self::default() }
    }

    /// Nothing hides anything.
    pub fn none() -> Self {
        Self::default()
    }

    /// The occluders in the space of a turn: made when it is first asked for, then kept.
    pub fn turned(&self, turn: Turn, mode: OccluderMode) -> Arc<Turned> {
        let key = (turn.axis().to_array().map(f64::to_bits), mode);
        let cell = {
            let mut turned = self.turned.lock().unwrap_or_else(PoisonError::into_inner);
            turned.entry(key).or_default().clone()
        };
        cell.get_or_init(|| Arc::new(self.turn(turn, mode))).clone()
    }

    fn turn(&self, turn: Turn, _mode: OccluderMode) -> Turned {
        let solids = self.boxes.iter().filter_map(|b| inscribed::largest(b, turn)).collect();
        Turned { solids, lost: 0.0 }
    }
}
