//! Still views of a city on a graphics device, timed in turn.

use super::{
    support::{LATENCY, THESIS_SIZE, Town},
    verdict::paired,
};
use crate::SuiteError;
use dapple_gpu::Gpu;
use dapple_metrics::stats::Ratio;
use dapple_occlusion::camera::{
    Frame, Settings, State, View,
    gpu::{self, Counting, Drawing, Renderer, Scene},
    techniques,
};
use std::{rc::Rc, time::Instant};

/// A city on a device.
pub struct Device<'g> {
    gpu: &'g Gpu,
    town: Rc<Town>,
    scene: Scene,
    size: [u32; 2],
    /// Frames until what is remembered has settled.
    settle: usize,
    pairs: usize,
}

/// A still view, a technique and its draw calls.
pub type Run<'s> = (&'s str, &'s Settings, Drawing);

impl<'g> Device<'g> {
    /// Uploads a city. Software gets small images and few frames: its times decide nothing.
    ///
    /// # Errors
    /// A device that is too small.
    pub fn new(gpu: &'g Gpu, hardware: bool, town: &Rc<Town>) -> Result<Self, SuiteError> {
        Ok(Self {
            gpu,
            town: Rc::clone(town),
            scene: Scene::new(gpu, &town.objects)?,
            size: if hardware { THESIS_SIZE } else { [256, 192] },
            settle: if hardware { 8 } else { 2 },
            pairs: if hardware { 31 } else { 1 },
        })
    }

    /// Time of a frame of one over a frame of the other: median of pairs, until the device is done.
    ///
    /// # Errors
    /// The device's.
    pub fn ratio(&self, a: Run<'_>, b: Run<'_>) -> Result<Ratio, SuiteError> {
        let (mut a, mut b) = (self.start(a)?, self.start(b)?);
        for _ in 0..self.settle {
            a.ns()?;
            b.ns()?;
        }
        paired(self.pairs, || a.ns(), || b.ns())
    }

    fn start<'d>(&'d self, (view, settings, drawing): Run<'d>) -> Result<OnDevice<'d>, SuiteError> {
        let mut views = self.town.views(view, 1, 1, self.size)?;
        let view =
            views.pop().ok_or_else(|| SuiteError::Internal("a still view of no frame".into()))?;
        let device = gpu::Settings { drawing, counting: Counting::Auto, readiness: LATENCY };
        Ok(OnDevice {
            town: &self.town,
            settings,
            view,
            renderer: Renderer::new(self.gpu, &self.scene, device)?,
            state: State::new(&self.town.tree),
            out: Frame::default(),
        })
    }
}

/// A still view under way.
struct OnDevice<'d> {
    town: &'d Town,
    settings: &'d Settings,
    view: View,
    renderer: Renderer<'d>,
    state: State,
    out: Frame,
}

impl OnDevice<'_> {
    /// Nanoseconds of a frame, from the walk's start to the device's end.
    fn ns(&mut self) -> Result<f64, SuiteError> {
        let (objects, tree) = (&self.town.objects, &self.town.tree);
        let (state, renderer) = (&mut self.state, &mut self.renderer);
        let start = Instant::now();
        techniques::frame(
            self.settings,
            objects,
            tree,
            &self.view,
            state,
            renderer,
            &mut self.out,
        )?;
        renderer.times()?;
        Ok(start.elapsed().as_nanos() as f64)
    }
}
