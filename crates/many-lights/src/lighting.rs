//! Techniques made ready in one of three forms.

use crate::{LightTree, LightsError, Technique, Work, World, brute, cut, gpu, sample::reservoirs};
use glam::Vec3;
use std::sync::Arc;

/// In which shape a technique runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Form {
    /// f64, scalar, clear.
    Reference,
    /// f32, parallel.
    Cpu,
    /// On a device.
    Gpu,
}

/// Times of a frame's passes by the device's clock; empty on the processor.
pub type Times = Vec<(&'static str, u64)>;

/// What a frame came out as.
#[derive(Clone, Debug, Default)]
pub struct Shaded {
    /// Linear RGB, one a pixel, rows top to bottom; 0 where nothing shows.
    pub radiance: Vec<Vec3>,
    /// Its work; 0 where it was not counted.
    pub work: Work,
    /// Nodes visited by pixel; empty where it was not counted, or no tree is walked.
    pub visits: Vec<u32>,
}

impl Shaded {
    /// An empty image of so many pixels, with visits by pixel where they are counted. Allocates only
    /// where it is larger than any before.
    pub fn clear(&mut self, pixels: usize, visits: bool) {
        self.radiance.clear();
        self.radiance.resize(pixels, Vec3::ZERO);
        self.visits.clear();
        self.visits.resize(if visits { pixels } else { 0 }, 0);
        self.work = Work::default();
    }

    /// Becomes the same as another, in the memory it has.
    pub fn copy_from(&mut self, other: &Self) {
        self.radiance.clone_from(&other.radiance);
        self.visits.clone_from(&other.visits);
        self.work = other.work;
    }
}

/// A technique that lights the frames of a world, in order from a reset.
pub trait Lighting {
    /// Forgets every earlier frame; random numbers follow `seed` from here on.
    ///
    /// # Errors
    /// The device's.
    fn reset(&mut self, seed: u32) -> Result<(), LightsError>;

    /// Lights frame `index` of the world. Counting costs time and changes nothing else.
    /// Allocates nothing of its own.
    ///
    /// # Errors
    /// A frame that there is not, or the device's.
    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError>;

    /// What the last frame came out as.
    ///
    /// # Errors
    /// The device's.
    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError>;

    /// Bytes of what it holds beside the world's frames: lights or tree, lists, state.
    fn bytes(&self) -> u64;
}

/// A technique made ready. `tree` is used by techniques that walk one; `scene` by the gpu form.
///
/// # Errors
/// Settings that are refused, or a device that is too small.
pub fn make<'g>(
    form: Form,
    technique: &Technique,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
    scene: Option<&Arc<crate::gpu::Scene<'g>>>,
) -> Result<Box<dyn Lighting + 'g>, LightsError> {
    technique.check()?;
    match (form, technique) {
        (Form::Reference, Technique::BruteForce) => Ok(Box::new(brute::Reference::new(world))),
        (Form::Cpu, Technique::BruteForce) => Ok(Box::new(brute::Cpu::new(world))),
        (Form::Gpu, Technique::BruteForce) => {
            gpu::brute_force(gpu::scene_with_shadows(scene, world)?)
        }
        (Form::Gpu, Technique::Lightcuts(_) | Technique::Relative(_) | Technique::Absolute(_)) => {
            gpu::cut(
                gpu::scene_with_shadows(scene, world)?,
                &cut::Given::new(technique, world, tree)?,
            )
        }
        (
            Form::Reference,
            Technique::Lightcuts(_) | Technique::Relative(_) | Technique::Absolute(_),
        ) => Ok(Box::new(cut::Reference::new(cut::Given::new(technique, world, tree)?))),
        (Form::Cpu, Technique::Lightcuts(_) | Technique::Relative(_) | Technique::Absolute(_)) => {
            Ok(Box::new(cut::Cpu::new(cut::Given::new(technique, world, tree)?)))
        }
        (Form::Gpu, Technique::Reservoirs(settings)) => {
            Ok(Box::new(gpu::OnDeviceReservoirs::new(settings, gpu::scene_of(scene, world)?)?))
        }
        (Form::Reference, Technique::Reservoirs(settings)) => {
            Ok(Box::new(reservoirs::Reference::new(settings, world)?))
        }
        (Form::Cpu, Technique::Reservoirs(settings)) => {
            Ok(Box::new(reservoirs::Cpu::new(settings, world)?))
        }
        (
            Form::Reference | Form::Cpu,
            Technique::LightBvh(_) | Technique::StochasticLightcuts(_),
        ) => crate::sample::make(form, technique, world, tree),
        (Form::Reference, Technique::Clustered(settings)) => {
            Ok(Box::new(crate::clustered::Reference::new(world, settings)?))
        }
        (Form::Gpu, Technique::Clustered(settings)) => {
            let scene = gpu::scene_with_shadows(scene, world)?;
            Ok(Box::new(gpu::OnDeviceClustered::new(scene, settings)?))
        }
        (Form::Gpu, Technique::Capped(settings)) => {
            let scene = gpu::scene_with_shadows(scene, world)?;
            Ok(Box::new(gpu::OnDeviceCapped::new(scene, tree, settings)?))
        }
        (Form::Reference, Technique::Capped(settings)) => {
            Ok(Box::new(crate::capped::Reference::new(world, tree, settings)?))
        }
        (Form::Cpu, Technique::Capped(settings)) => {
            Ok(Box::new(crate::capped::Cpu::new(world, tree, settings)?))
        }
        (Form::Cpu, Technique::Clustered(settings)) => {
            Ok(Box::new(crate::clustered::Cpu::new(world, settings)?))
        }
        (Form::Gpu, Technique::LightBvh(_) | Technique::StochasticLightcuts(_)) => {
            gpu::sampler(gpu::scene_with_shadows(scene, world)?, technique, tree)
        }
    }
}
