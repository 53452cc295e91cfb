//! The cap in f64: every light is bounded over every tile.

use crate::{
    BoundForm, Capped, LightTree, Lighting, LightsError, Shaded, Times, Work, World,
    bound::{Region, region},
    cut::tile::{all, pixels},
    radiance,
};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// The `most` lights with the largest bounds over a region, in increasing order, and whether others
/// that may give something are left out.
pub fn strongest_of_all(
    tree: &LightTree,
    over: &Region,
    most: usize,
    clamp_m: f64,
) -> (Vec<u32>, bool) {
    let bound = |&leaf: &u32| region(BoundForm::Walter, &tree.nodes[leaf as usize], over, clamp_m);
    let mut lights: Vec<_> = tree.leaves.iter().map(bound).zip(0_u32..).collect();
    lights.retain(|(bound, _)| *bound > 0.0);
    lights.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let ended = lights.len() > most;
    lights.truncate(most);
    let mut lights: Vec<_> = lights.into_iter().map(|(_, light)| light).collect();
    lights.sort_unstable();
    (lights, ended)
}

/// The cap as f64 has it.
pub struct Reference {
    world: Arc<World>,
    tree: Arc<LightTree>,
    most: usize,
    shaded: Shaded,
}

impl Reference {
    /// Ready for all frames of a world.
    ///
    /// # Errors
    /// A tree of other lights.
    pub fn new(
        world: &Arc<World>,
        tree: &Arc<LightTree>,
        settings: &Capped,
    ) -> Result<Self, LightsError> {
        tree.check_number(&world.lights)?;
        Ok(Self {
            world: Arc::clone(world),
            tree: Arc::clone(tree),
            most: settings.most as usize,
            shaded: Shaded::default(),
        })
    }
}

impl Lighting for Reference {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = &*self.world;
        let frame = world.frame(index)?;
        let (width, height) = (frame.width, frame.height);
        self.shaded.radiance.clear();
        self.shaded.radiance.resize(frame.points.len(), Vec3::ZERO);
        let mut work = Work::default();
        for (column, row) in all(width, height) {
            let pixels = || pixels(width, height, column, row);
            let Some(over) = Region::of(pixels().map(|pixel| &frame.points[pixel])) else {
                continue;
            };
            let (lights, ended) = strongest_of_all(&self.tree, &over, self.most, world.clamp_m);
            work.bounds += world.lights.len() as u64;
            work.entries += lights.len() as u64;
            work.ended += u64::from(ended);
            for pixel in pixels().filter(|&pixel| frame.points[pixel].is_there()) {
                let point = &frame.points[pixel];
                let mut sum = DVec3::ZERO;
                for &index in &lights {
                    let light = &world.lights[index as usize];
                    let given = radiance(point, light, world.clamp_m);
                    if given == DVec3::ZERO {
                        continue;
                    }
                    work.rays += u64::from(world.occluders.is_some());
                    if world.sees(point, light) {
                        sum += given;
                    }
                }
                work.pixels += 1;
                work.lights += lights.len() as u64;
                self.shaded.radiance[pixel] = sum.as_vec3();
            }
        }
        self.shaded.work = if count { work } else { Work::default() };
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.clone_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        (size_of_val(&*self.tree.nodes) + size_of_val(&*self.tree.leaves)) as u64
    }
}
