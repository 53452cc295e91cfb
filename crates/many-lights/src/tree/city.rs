//! A city's lights, and where each belongs.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1: window, storey,
//! facade, building, block, city.
//! Deviations: street lamps, which the thesis has not, belong to square tiles, and in them to halves.

use super::{KINDS, median::halve};
use crate::{Emission, Light, LightsError};
use dapple_scene::city::{City, StreetLamp, WindowLight};
use glam::DVec3;
use std::collections::BTreeSet;

/// Which levels of a city there are between all of it and a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Blocks; tiles of street lamps.
    pub block: bool,
    /// Buildings.
    pub building: bool,
    /// Facades.
    pub facade: bool,
    /// Storeys of a facade, or of a building without facades.
    pub storey: bool,
}

impl Default for Levels {
    fn default() -> Self {
        Self { block: true, building: true, facade: true, storey: true }
    }
}

/// Side of the tiles that street lamps belong to, metres: about that of a block with its streets.
pub const TILE_M: f64 = 100.0;

/// Most street lamps that lie next to each other in one cluster.
pub const LAMPS: usize = 8;

/// All lights of a city, windows (spot) before street lamps (omni), relative to `origin`, and the path
/// of each for [`super::Build::Keys`].
pub fn keys(city: &City, origin: DVec3, levels: Levels) -> (Vec<Light>, Vec<Vec<u32>>) {
    let windows = city.lights.iter().map(|window| of_window(window, origin));
    let lamps = city.lamps.iter().map(|lamp| of_lamp(lamp, origin));
    let lights: Vec<Light> = windows.chain(lamps).collect();
    let mut keys = window_keys(city, levels);
    keys.extend(lamp_keys(&lights[keys.len()..], levels));
    (lights, keys)
}

fn of_window(window: &WindowLight, origin: DVec3) -> Light {
    Light {
        position: window.position - origin,
        axis: window.direction,
        intensity: window.intensity.as_dvec3(),
        emission: Emission::Spot { half_angle_rad: window.half_angle_rad },
    }
}

fn of_lamp(lamp: &StreetLamp, origin: DVec3) -> Light {
    Light {
        position: lamp.position - origin,
        axis: DVec3::NEG_Y,
        intensity: lamp.intensity.as_dvec3(),
        emission: Emission::Omni,
    }
}

/// A level that is left out does not mix what it told apart: facades are numbered through the city, and
/// so are the storeys of buildings.
fn window_keys(city: &City, levels: Levels) -> Vec<Vec<u32>> {
    let mut block_of = vec![city.blocks.len() as u32; city.buildings.len()];
    for (block, range) in (0..).zip(&city.blocks) {
        for building in range.clone() {
            if let Some(of) = block_of.get_mut(building as usize) {
                *of = block;
            }
        }
    }
    let (mut facades, mut storeys) = (0_u32, 0_u32);
    let before: Vec<[u32; 2]> = city
        .buildings
        .iter()
        .map(|building| {
            let before = [facades, storeys];
            facades += building.facades.len() as u32;
            storeys += building.storeys;
            before
        })
        .collect();
    let key = |window: &WindowLight| {
        let building = window.building as usize;
        let [facade, storey] = before.get(building).copied().unwrap_or_default();
        let all = [
            (levels.block, block_of.get(building).copied().unwrap_or(city.blocks.len() as u32)),
            (levels.building, window.building),
            (levels.facade, facade + window.facade),
            (levels.storey, storey + window.storey),
        ];
        all.into_iter().filter(|(kept, _)| *kept).map(|(_, key)| key).collect()
    };
    city.lights.iter().map(key).collect()
}

fn lamp_keys(lamps: &[Light], levels: Levels) -> Vec<Vec<u32>> {
    let tile = |lamp: &Light| {
        let tile = (lamp.position / TILE_M).floor();
        [tile.z as i64, tile.x as i64]
    };
    let tiles: Vec<[i64; 2]> = BTreeSet::from_iter(lamps.iter().map(tile)).into_iter().collect();
    let mut of_tile: Vec<Vec<u32>> = vec![Vec::new(); if levels.block { tiles.len() } else { 1 }];
    let mut keys = vec![Vec::new(); lamps.len()];
    for (index, lamp) in lamps.iter().enumerate() {
        let number = if levels.block { tiles.partition_point(|t| *t < tile(lamp)) } else { 0 };
        if let Some(of) = of_tile.get_mut(number) {
            of.push(index as u32);
        }
        keys[index].push(number as u32);
    }
    for mut ids in of_tile {
        halves(lamps, &mut ids, &mut keys);
    }
    keys
}

fn halves(lights: &[Light], ids: &mut [u32], keys: &mut [Vec<u32>]) {
    if ids.len() <= LAMPS {
        return;
    }
    let (left, right) = halve(&|id: u32| lights[id as usize].position, ids);
    for (key, half) in (0..).zip([left, right]) {
        for &id in &*half {
            keys[id as usize].push(key);
        }
        halves(lights, half, keys);
    }
}

/// Keys under which no cluster has more than `most` children: those of wider ones are put into groups
/// of neighbours, as many levels of them as it takes.
///
/// # Errors
/// `most` below 2, or keys that [`super::Build::Keys`] refuses.
pub fn limited(
    lights: &[Light],
    keys: &[Vec<u32>],
    most: u32,
) -> Result<Vec<Vec<u32>>, LightsError> {
    if most < 2 {
        return Err(LightsError::value(
            "children of a cluster",
            format!("{most} is not at least 2"),
        ));
    }
    super::keys::check(lights, keys)?;
    let mut limited = Limited { lights, keys, most: most as usize, new: vec![vec![]; keys.len()] };
    for kind in 0..KINDS {
        let mut ids: Vec<u32> = (0..lights.len() as u32)
            .filter(|&id| lights[id as usize].emission.code() == kind)
            .collect();
        super::keys::sort(keys, &mut ids);
        limited.node(&ids, 0);
    }
    Ok(limited.new)
}

struct Limited<'a> {
    lights: &'a [Light],
    keys: &'a [Vec<u32>],
    most: usize,
    new: Vec<Vec<u32>>,
}

impl Limited<'_> {
    /// Lights, sorted, that agree in the first `level` keys.
    fn node(&mut self, ids: &[u32], level: usize) {
        if ids.len() < 2 {
            return;
        }
        let keys = self.keys;
        let (groups, level) = super::keys::groups(keys, ids, level);
        let groups: Vec<&[u32]> = groups.collect();
        let mut order: Vec<u32> = (0..groups.len() as u32).collect();
        if groups.len() > self.most {
            let middles: Vec<DVec3> = groups.iter().map(|ids| self.middle(ids)).collect();
            neighbours(&middles, &mut order);
            self.part(&groups, &order);
        }
        for ids in groups {
            for &id in ids {
                self.new[id as usize].extend(keys[id as usize].get(level));
            }
            self.node(ids, level + 1);
        }
    }

    fn middle(&self, ids: &[u32]) -> DVec3 {
        let at = |&id: &u32| super::median::place_of(&self.lights[id as usize]);
        let min = ids.iter().map(at).fold(DVec3::INFINITY, DVec3::min);
        0.5 * (min + ids.iter().map(at).fold(DVec3::NEG_INFINITY, DVec3::max))
    }

    /// Numbers nearly equal parts of groups that are more than may be, and parts of the parts.
    fn part(&mut self, groups: &[&[u32]], order: &[u32]) {
        if order.len() <= self.most {
            return;
        }
        for part in 0..self.most {
            let bound = |part: usize| part * order.len() / self.most;
            let order = &order[bound(part)..bound(part + 1)];
            for &group in order {
                for &id in groups[group as usize] {
                    self.new[id as usize].push(part as u32);
                }
            }
            self.part(groups, order);
        }
    }
}

/// Orders numbers so that what follows each other lies together.
fn neighbours(at: &[DVec3], ids: &mut [u32]) {
    if ids.len() > 1 {
        let (left, right) = halve(&|id: u32| at[id as usize], ids);
        neighbours(at, left);
        neighbours(at, right);
    }
}
