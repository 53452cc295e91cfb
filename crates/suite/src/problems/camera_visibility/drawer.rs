//! What draws and answers, by form.

use super::{case::VisibilityCase, settings};
use crate::{
    SuiteError,
    problem::{Form, Setting},
};
use dapple_occlusion::camera::{
    Image, Readiness, Renderer, gpu,
    hierarchical_depth::{ShowsDepth, gpu::Culler},
    software::{Fast, Reference},
};
use std::sync::Arc;

/// A renderer of one of the forms.
pub enum Drawer<'g> {
    /// Scalar, in f64.
    Reference(Box<Reference>),
    /// Fast and parallel.
    Fast(Box<Fast>),
    /// The device's.
    Device(Box<gpu::Renderer<'g>>),
    /// The device's, which decides by itself what to draw: it is no renderer.
    Culler {
        /// Two passes with a pyramid of depths.
        culler: Box<Culler<'g>>,
        /// Times of the last frame's passes.
        passes: Vec<(&'static str, u64)>,
    },
}

impl<'g> Drawer<'g> {
    /// The renderer that a setting asks for.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn of(case: &VisibilityCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        if setting.form != Form::Gpu {
            return Self::software(case, setting.form, settings::readiness(setting)?);
        }
        if setting.technique == "hierarchical-depth" {
            let (gpu, scene) = case.device()?;
            let settings = settings::hierarchical(setting)?;
            let culler = Culler::new(gpu, &scene, case.objects(), &settings)?;
            return Ok(Self::Culler { culler: Box::new(culler), passes: Vec::new() });
        }
        Self::device(case, settings::device(setting)?)
    }

    /// One on the device.
    ///
    /// # Errors
    /// No device, or one that is too small.
    pub fn device(case: &VisibilityCase<'g>, settings: gpu::Settings) -> Result<Self, SuiteError> {
        let (gpu, scene) = case.device()?;
        Ok(Self::Device(Box::new(gpu::Renderer::new(gpu, &scene, settings)?)))
    }

    /// One on the processor.
    ///
    /// # Errors
    /// Objects that are refused.
    pub fn software(
        case: &VisibilityCase<'g>,
        form: Form,
        readiness: Readiness,
    ) -> Result<Self, SuiteError> {
        let objects = Arc::clone(case.shared_objects());
        Ok(match form {
            Form::Reference => Self::Reference(Box::new(Reference::new(objects, readiness)?)),
            _ => Self::Fast(Box::new(Fast::new(objects, readiness)?)),
        })
    }

    /// Whatever draws.
    ///
    /// # Errors
    /// A device that decides by itself.
    pub fn renderer(&mut self) -> Result<&mut dyn Renderer, SuiteError> {
        Ok(match self {
            Self::Reference(renderer) => &mut **renderer,
            Self::Fast(renderer) => &mut **renderer,
            Self::Device(renderer) => &mut **renderer,
            Self::Culler { .. } => {
                return Err(SuiteError::Internal("a culler on the device draws by itself".into()));
            }
        })
    }

    /// The same where depths are at hand while drawing: on the processor.
    pub fn showing_depth(&mut self) -> Option<&mut dyn ShowsDepth> {
        match self {
            Self::Reference(renderer) => Some(&mut **renderer),
            Self::Fast(renderer) => Some(&mut **renderer),
            Self::Device(_) | Self::Culler { .. } => None,
        }
    }

    /// The last frame.
    ///
    /// # Errors
    /// The device's.
    pub fn image(&self) -> Result<Image, SuiteError> {
        Ok(match self {
            Self::Reference(renderer) => renderer.image().clone(),
            Self::Fast(renderer) => renderer.image().clone(),
            Self::Device(renderer) => renderer.image()?,
            Self::Culler { culler, .. } => culler.image()?,
        })
    }

    /// Waits until the frame is done.
    ///
    /// # Errors
    /// The device's.
    pub fn finish(&self) -> Result<Vec<(&'static str, u64)>, SuiteError> {
        Ok(match self {
            Self::Device(renderer) => renderer.times()?.passes,
            Self::Culler { passes, .. } => passes.clone(),
            _ => Vec::new(),
        })
    }

    /// Draw calls of the last frame, where a device counts them.
    pub fn draw_calls(&self) -> Option<u64> {
        match self {
            Self::Device(renderer) => Some(renderer.counters().draw_calls),
            _ => None,
        }
    }

    /// Bytes of targets and scene.
    pub fn bytes(&self, case: &VisibilityCase<'_>) -> u64 {
        let [width, height] = case.size();
        match self {
            Self::Device(renderer) => renderer.bytes(),
            Self::Culler { culler, .. } => culler.bytes(),
            // Two ids and a depth a pixel.
            _ => 12 * u64::from(width) * u64::from(height) + case.objects().bytes(),
        }
    }
}

/// What a form shows of the path's first frames when every object is drawn.
///
/// # Errors
/// The renderer's.
pub fn everything(
    case: &VisibilityCase<'_>,
    form: Form,
    frames: usize,
) -> Result<Vec<Image>, SuiteError> {
    let mut drawer = match form {
        Form::Gpu => Drawer::device(case, gpu::Settings::default())?,
        form => Drawer::software(case, form, Readiness::Modelled(0))?,
    };
    let all: Vec<u32> = (0..case.objects().objects.len() as u32).collect();
    let one = |view| {
        let renderer = drawer.renderer()?;
        renderer.begin(view)?;
        renderer.draw(&all)?;
        renderer.end()?;
        drawer.image()
    };
    case.views().iter().take(frames).map(one).collect()
}
