//! The reference: the truth itself, f64, in the order of the lights.

use crate::{Lighting, LightsError, Shaded, Times, Work, World, radiance};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Every light at every pixel, one after another.
pub struct Reference {
    world: Arc<World>,
    shaded: Shaded,
}

impl Reference {
    /// Ready for the frames of a world.
    pub fn new(world: &Arc<World>) -> Self {
        Self { world: Arc::clone(world), shaded: Shaded::default() }
    }
}

impl Lighting for Reference {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = &self.world;
        let frame = world.frame(index)?;
        let shaded = &mut self.shaded;
        shaded.work = Work::default();
        shaded.radiance.clear();
        for point in &frame.points {
            let there = point.is_there();
            let truth = if there { world.truth(point) } else { DVec3::ZERO };
            shaded.radiance.push(truth.as_vec3());
            if there && count {
                let reaches = |l: &&_| radiance(point, l, world.clamp_m) != DVec3::ZERO;
                let rays = || world.lights.iter().filter(reaches).count() as u64;
                shaded.work += Work {
                    pixels: 1,
                    lights: world.lights.len() as u64,
                    rays: if world.occluders.is_some() { rays() } else { 0 },
                    ..Work::default()
                };
            }
        }
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clone_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let lights = size_of_val(self.world.lights.as_slice());
        (lights + size_of::<Vec3>() * self.shaded.radiance.len()) as u64
    }
}
