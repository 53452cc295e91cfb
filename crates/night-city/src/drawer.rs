//! What draws and answers while it is found what is seen.

use crate::NightError;
use dapple_gpu::Gpu;
use dapple_many_lights::{self as lights, World};
use dapple_occlusion::camera::{Image, Objects, Readiness, Renderer, gpu, software::Fast};
use std::sync::Arc;

/// When a device's answers are taken for there: by what was drawn and asked since, so that cells, and
/// with them all counts, are the same on every run.
const ANSWERS: Readiness = Readiness::Modelled(64);

/// A renderer.
pub enum Drawer<'g> {
    /// On the processor.
    Software(Box<Fast>),
    /// On the device.
    Device(Box<gpu::Renderer<'g>>),
}

/// A device that frames are lit on.
#[derive(Clone)]
pub struct Device<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// Lights and points on it, of the world that is lit: with what casts shadows where that is asked.
    pub lights: Arc<lights::gpu::Scene<'g>>,
    /// What is drawn, where it draws and answers too; `None` where the processor does.
    pub objects: Option<Arc<gpu::Scene>>,
}

impl<'g> Device<'g> {
    /// Uploads a world; draws on the processor.
    ///
    /// # Errors
    /// A device that is too small.
    pub fn new(gpu: &'g Gpu, world: &Arc<World>) -> Result<Self, NightError> {
        let lights = Arc::new(lights::gpu::Scene::new(gpu, world)?);
        Ok(Self { gpu, lights, objects: None })
    }

    /// The same, and draws too.
    ///
    /// # Errors
    /// A device that is too small.
    pub fn drawing(self, objects: &Objects) -> Result<Self, NightError> {
        let objects = Some(Arc::new(gpu::Scene::new(self.gpu, objects)?));
        Ok(Self { objects, ..self })
    }
}

impl<'g> Drawer<'g> {
    /// Where a device says, or on the processor.
    ///
    /// # Errors
    /// Objects that are refused, or a device that is too small.
    pub fn new(objects: &Arc<Objects>, device: Option<&Device<'g>>) -> Result<Self, NightError> {
        if let Some(Device { gpu, objects: Some(scene), .. }) = device {
            let settings = gpu::Settings { readiness: ANSWERS, ..gpu::Settings::default() };
            let renderer = gpu::Renderer::new(gpu, scene, settings)?;
            return Ok(Self::Device(Box::new(renderer)));
        }
        let fast = Fast::new(Arc::clone(objects), Readiness::Modelled(0))?;
        Ok(Self::Software(Box::new(fast)))
    }

    /// Whatever it is.
    pub fn renderer(&mut self) -> &mut dyn Renderer {
        match self {
            Self::Software(renderer) => &mut **renderer,
            Self::Device(renderer) => &mut **renderer,
        }
    }

    /// The last frame.
    ///
    /// # Errors
    /// The device's.
    pub fn image(&self) -> Result<Image, NightError> {
        Ok(match self {
            Self::Software(renderer) => renderer.image().clone(),
            Self::Device(renderer) => renderer.image()?,
        })
    }
}
