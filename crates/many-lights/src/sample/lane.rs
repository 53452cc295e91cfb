//! One pixel while lights are drawn for it.

use super::{Random, walked::Walked};
use crate::{Point, Work, World};
use glam::DVec3;

/// A pixel, its random numbers and its work.
pub(super) struct Lane<'a> {
    pub world: &'a World,
    pub point: &'a Point,
    pub random: Random,
    /// Nodes looked at.
    pub visits: u32,
    pub work: Work,
}

impl Lane<'_> {
    /// What a light gives, shadow ray and all.
    pub fn light(&mut self, walked: &impl Walked, leaf: u32) -> DVec3 {
        self.work.lights += 1;
        let radiance = walked.radiance(leaf, self.point);
        if radiance == DVec3::ZERO {
            return radiance;
        }
        self.work.rays += u64::from(self.world.occluders.is_some());
        unshadowed(self.world, self.point, walked, leaf, radiance)
    }
}

/// `radiance` of the light of a leaf where that is seen, else nothing.
pub(super) fn unshadowed(
    world: &World,
    point: &Point,
    walked: &impl Walked,
    leaf: u32,
    radiance: DVec3,
) -> DVec3 {
    let Some(light) = world.lights.get(walked.light(leaf) as usize) else { return DVec3::ZERO };
    if world.sees(point, light) { radiance } else { DVec3::ZERO }
}
