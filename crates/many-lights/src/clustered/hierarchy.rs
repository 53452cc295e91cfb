//! Lights in an order that keeps neighbours together, and boxes around 32 of them at a time.
//!
//! Nothing is missed by rounding: differences, squares and their sums are rounded monotonically, so
//! the distance of two boxes, as f32 has it, is at most that of any two points in them.

use super::{Cell, Reach};
use crate::{Light, PackedNode, light::Emission};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Lights of a group, and groups of a group of the next level.
pub const FAN: usize = 32;

/// A box around the positions of up to [`FAN`] lights or groups. 32 bytes, as on a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Group {
    /// Lower corner, metres.
    pub min: Vec3,
    /// The farthest reach of any of them, squared, m².
    pub reach_squared: f32,
    /// Upper corner.
    pub max: Vec3,
    /// Unused.
    pub pad: u32,
}

/// All lights of a world that have a reach, and groups of them.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    /// The lights, along a curve through space, directional ones last; [`PackedNode::light`] is the
    /// index in the world.
    pub lights: Vec<PackedNode>,
    /// Their reaches.
    pub reaches: Vec<Reach>,
    /// Levels from the lights up: group `i` of a level holds `32 i ..` of what is below it.
    pub levels: Vec<Vec<Group>>,
}

impl Group {
    fn near(&self, cell: &Cell) -> bool {
        let outside = (cell.min - self.max).max(self.min - cell.max).max(Vec3::ZERO);
        outside.length_squared() <= self.reach_squared
    }

    fn around(parts: &[Self]) -> Self {
        let first = parts.first().copied().unwrap_or_default();
        parts.iter().fold(first, |a, b| Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            reach_squared: a.reach_squared.max(b.reach_squared),
            pad: 0,
        })
    }
}

impl Hierarchy {
    /// Sorts and groups lights under a cutoff.
    pub fn new(lights: &[Light], cutoff: f64) -> Self {
        let reaching = lights.iter().enumerate();
        let mut order: Vec<_> = reaching
            .map(|(index, light)| (index, light, Reach::of(light, cutoff)))
            .filter(|(_, _, reach)| reach.squared > 0.0)
            .collect();
        let curve = Curve::of(order.iter().map(|(_, light, _)| light.position));
        order.sort_by_cached_key(|(index, light, _)| {
            (light.emission == Emission::Directional, curve.place(light.position), *index)
        });
        let reaches: Vec<_> = order.iter().map(|(_, _, reach)| *reach).collect();
        let lights: Vec<_> =
            order.iter().map(|&(index, light, _)| PackedNode::of(light, index as u32)).collect();
        let alone = |(node, reach): (&PackedNode, &Reach)| Group {
            min: node.position,
            max: node.position,
            reach_squared: reach.squared,
            pad: 0,
        };
        let below: Vec<_> = lights.iter().zip(&reaches).map(alone).collect();
        let mut levels = vec![grouped(&below)];
        while let Some(last) = levels.last().filter(|last| last.len() > FAN) {
            levels.push(grouped(last));
        }
        Self { lights, reaches, levels }
    }

    /// Appends the lights (places in [`Hierarchy::lights`]) whose reach and cone touch the box of a
    /// cell, in increasing order.
    pub fn list(&self, cell: &Cell, list: &mut Vec<u32>) {
        if cell.is_empty() {
            return;
        }
        let top = self.levels.len();
        let groups = self.levels.last().map_or(0, Vec::len);
        (0..groups).for_each(|group| self.descend(cell, top - 1, group, list));
    }

    fn descend(&self, cell: &Cell, level: usize, group: usize, list: &mut Vec<u32>) {
        if !self.levels[level][group].near(cell) {
            return;
        }
        let first = group * FAN;
        if level > 0 {
            let end = (first + FAN).min(self.levels[level - 1].len());
            (first..end).for_each(|below| self.descend(cell, level - 1, below, list));
            return;
        }
        for place in first..(first + FAN).min(self.lights.len()) {
            let position = self.lights[place].position;
            let outside = (cell.min - position).max(position - cell.max).max(Vec3::ZERO);
            let near = outside.length_squared() <= self.reaches[place].squared;
            if near && self.lights[place].shines_into(cell.min, cell.max) {
                list.push(place as u32);
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let groups: usize = self.levels.iter().map(|level| size_of_val(&**level)).sum();
        (size_of_val(&*self.lights) + size_of_val(&*self.reaches) + groups) as u64
    }
}

fn grouped(below: &[Group]) -> Vec<Group> {
    below.chunks(FAN).map(Group::around).collect()
}

/// Places along a curve that takes 2^20 steps to each side (Morton order).
struct Curve {
    min: DVec3,
    scale: f64,
}

impl Curve {
    fn of(positions: impl Iterator<Item = DVec3>) -> Self {
        let (min, max) = positions
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let extent = (max - min).max_element();
        let usable = extent > 0.0 && extent.is_finite();
        Self { min, scale: if usable { f64::from((1 << 20) - 1) / extent } else { 0.0 } }
    }

    fn place(&self, position: DVec3) -> u64 {
        let step = (position - self.min) * self.scale;
        spread(step.x as u64) | spread(step.y as u64) << 1 | spread(step.z as u64) << 2
    }
}

/// The lowest 21 bits, two zeros after each.
fn spread(bits: u64) -> u64 {
    let mut x = bits & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
