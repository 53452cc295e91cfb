//! Lights drawn by chance.

mod descend;
mod expected;
mod form;
mod lane;
mod light_bvh;
mod random;
pub mod reservoirs;
pub mod statistics;
mod stochastic;
#[cfg(test)]
mod tests;
mod walked;

pub use expected::{Expected, expected};
pub use random::{Random, hash};

use crate::{Form, LightTree, Lighting, LightsError, Technique, World};
use form::{Kind, Sampler};
use std::sync::Arc;
use walked::{Double, Single};

impl Kind {
    /// # Errors
    /// A technique that draws no lights down a tree.
    fn of(technique: &Technique) -> Result<Self, LightsError> {
        match technique {
            Technique::LightBvh(settings) => Ok(Self::LightBvh(*settings)),
            Technique::StochasticLightcuts(settings) => Ok(Self::Stochastic(*settings)),
            other => Err(LightsError::value(format!("{other:?}"), "draws no lights down a tree")),
        }
    }
}

/// A sampler on the processor: the reference in f64 on one thread, the cpu form in f32 on all.
///
/// # Errors
/// A technique that draws no lights down a tree; a tree of other lights; the form on a device.
pub fn make(
    form: Form,
    technique: &Technique,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
) -> Result<Box<dyn Lighting>, LightsError> {
    let kind = Kind::of(technique)?;
    tree.check_number(&world.lights)?;
    let clamp_m = world.clamp_m;
    match form {
        Form::Reference => {
            let walked = Double { tree: Arc::clone(tree), clamp_m };
            Ok(Box::new(Sampler::new(kind, world, walked, false)))
        }
        Form::Cpu => {
            let walked = Single::new(tree.pack(), clamp_m);
            Ok(Box::new(Sampler::new(kind, world, walked, true)))
        }
        Form::Gpu => Err(LightsError::value(format!("{technique:?}"), "needs a device")),
    }
}
