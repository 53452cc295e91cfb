//! Techniques made ready in one of three forms.

use crate::{
    LightTree, LightsError, Technique, Work, World, brute, capped, clustered, cut, gpu,
    sample::{self, reservoirs},
};
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
    let on_device = || gpu::scene_with_shadows(scene, world);
    let given = || cut::Given::new(technique, world, tree);
    Ok(match (technique, form) {
        (Technique::BruteForce, Form::Reference) => Box::new(brute::Reference::new(world)),
        (Technique::BruteForce, Form::Cpu) => Box::new(brute::Cpu::new(world)),
        (Technique::BruteForce, Form::Gpu) => gpu::brute_force(on_device()?)?,
        (Technique::Lightcuts(_) | Technique::Relative(_) | Technique::Absolute(_), form) => {
            match form {
                Form::Reference => Box::new(cut::Reference::new(given()?)),
                Form::Cpu => Box::new(cut::Cpu::new(given()?)),
                Form::Gpu => gpu::cut(on_device()?, &given()?)?,
            }
        }
        (Technique::LightBvh(_) | Technique::StochasticLightcuts(_), form) => match form {
            Form::Reference | Form::Cpu => sample::make(form, technique, world, tree)?,
            Form::Gpu => gpu::sampler(on_device()?, technique, tree)?,
        },
        (Technique::Reservoirs(settings), Form::Reference) => {
            Box::new(reservoirs::Reference::new(settings, world)?)
        }
        (Technique::Reservoirs(settings), Form::Cpu) => {
            Box::new(reservoirs::Cpu::new(settings, world)?)
        }
        (Technique::Reservoirs(settings), Form::Gpu) => {
            Box::new(gpu::OnDeviceReservoirs::new(settings, gpu::scene_of(scene, world)?)?)
        }
        (Technique::Clustered(settings), Form::Reference) => {
            Box::new(clustered::Reference::new(world, settings)?)
        }
        (Technique::Clustered(settings), Form::Cpu) => {
            Box::new(clustered::Cpu::new(world, settings)?)
        }
        (Technique::Clustered(settings), Form::Gpu) => {
            Box::new(gpu::OnDeviceClustered::new(on_device()?, settings)?)
        }
        (Technique::Capped(settings), Form::Reference) => {
            Box::new(capped::Reference::new(world, tree, settings)?)
        }
        (Technique::Capped(settings), Form::Cpu) => {
            Box::new(capped::Cpu::new(world, tree, settings)?)
        }
        (Technique::Capped(settings), Form::Gpu) => {
            Box::new(gpu::OnDeviceCapped::new(on_device()?, tree, settings)?)
        }
    })
}
