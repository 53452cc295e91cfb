//! What draws and answers, by form.

use super::{case::VisibilityCase, settings};
use crate::{
    SuiteError,
    problem::{Form, Setting},
};
use dapple_occlusion::camera::{
    Image, Readiness, Renderer, gpu,
    hierarchical_depth::ShowsDepth,
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
        let (gpu, scene) = case.device()?;
        let renderer = gpu::Renderer::new(gpu, &scene, settings::device(setting)?)?;
        Ok(Self::Device(Box::new(renderer)))
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
    pub fn renderer(&mut self) -> &mut dyn Renderer {
        match self {
            Self::Reference(renderer) => &mut **renderer,
            Self::Fast(renderer) => &mut **renderer,
            Self::Device(renderer) => &mut **renderer,
        }
    }

    /// The same where depths are at hand while drawing: on the processor.
    pub fn showing_depth(&mut self) -> Option<&mut dyn ShowsDepth> {
        match self {
            Self::Reference(renderer) => Some(&mut **renderer),
            Self::Fast(renderer) => Some(&mut **renderer),
            Self::Device(_) => None,
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
        })
    }

    /// Waits until the frame is done.
    ///
    /// # Errors
    /// The device's.
    pub fn finish(&self) -> Result<Vec<(&'static str, u64)>, SuiteError> {
        Ok(match self {
            Self::Device(renderer) => renderer.times()?.passes,
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
            // Two ids and a depth a pixel.
            _ => 12 * u64::from(width) * u64::from(height) + case.objects().bytes(),
        }
    }
}

/// Draws every object in the path's first frames.
///
/// # Errors
/// The renderer's.
pub fn everything(
    case: &VisibilityCase<'_>,
    frames: usize,
    drawer: &mut Drawer<'_>,
) -> Result<Vec<Image>, SuiteError> {
    let all: Vec<u32> = (0..case.objects().objects.len() as u32).collect();
    let one = |view| {
        let renderer = drawer.renderer();
        renderer.begin(view)?;
        renderer.draw(&all)?;
        renderer.end()?;
        drawer.image()
    };
    case.views().iter().take(frames).map(one).collect()
}
