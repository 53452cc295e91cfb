//! Scenes as the judges see them: receivers, truth and fragments, prepared once and shared, and
//! settings scored and timed on them.

use super::super::{SPEC, TranslucentCase, port};
pub use super::methods::{
    LOOKUPS, Method, RESOLUTION, SPANS, bom, bom_split, dom, layered, osm, thesis_bins,
    thesis_reading,
};
use super::verdict::paired;
use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    problems::translucent_shadow::subject_gpu,
};
use dapple_gpu::Gpu;
use dapple_metrics::stats::Ratio;
use dapple_opacity_maps::{Fragments, Model, Receiver, cpu::Maps, exact::Exact, gpu::Renderer};
use serde_json::Value;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, time::Instant};

/// Image columns; rows are 9/16 of it.
pub const WIDTH: i64 = 128;

/// Translucent scenes of every kind, with what they are made for.
pub const SCENES: [&str; 10] = [
    "grass",
    "grass_sparse",
    "grass_dense",
    "tree",
    "willow",
    "trees",
    "hair",
    "mixed",
    "two_far",
    "slab",
];

/// A scene with the problem's own parameters, made at the first call.
///
/// # Errors
/// Those of [`TranslucentCase::prepare`].
pub fn still(scene: &str) -> Result<Rc<Still>, SuiteError> {
    still_with(scene, 0, &[])
}

/// The same under a seed with some parameters given.
///
/// # Errors
/// As [`still`]; a parameter that there is not, or out of range.
pub fn still_with(
    scene: &str,
    seed: u64,
    given: &[(&str, Value)],
) -> Result<Rc<Still>, SuiteError> {
    thread_local! {
        // Cases share what they hold by counting in one thread.
        static MADE: RefCell<BTreeMap<String, Rc<Still>>> = const { RefCell::new(BTreeMap::new()) };
    }
    let mut parameters = Knobs::from([("width".into(), WIDTH.into())]);
    parameters.extend(given.iter().map(|(name, value)| ((*name).into(), value.clone())));
    let case = Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed,
        parameters: knob::complete("parameter", SPEC.parameters, &parameters)?,
    };
    let key = format!("{case:?}");
    if let Some(made) = MADE.with_borrow(|made| made.get(&key).map(Rc::clone)) {
        return Ok(made);
    }
    let case_made = TranslucentCase::prepare(&case, None)?;
    let still = Rc::new(Still { name: case.name(), case: case_made });
    MADE.with_borrow_mut(|made| made.insert(key, Rc::clone(&still)));
    Ok(still)
}

/// One scene with its receivers and truth.
pub struct Still {
    /// Scene and seed.
    pub name: String,
    /// The prepared case.
    pub case: TranslucentCase<'static>,
}

/// How wrong a method is on a still.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Transmittance against truth by light rays.
    pub rmse: f64,
    /// Against the uncompressed deep shadow map of the same texels, taps and model.
    pub layering: f64,
    /// Root mean squared step of the layering error along light rays.
    pub banding: f64,
    /// Share of (ray, layer) cells without a fragment; 0 for what has no layers.
    pub idle: f64,
}

impl Still {
    /// The fragments of a method's grid.
    ///
    /// # Errors
    /// More of them than memory allows.
    pub fn fragments(&self, method: &Method) -> Result<Rc<Fragments>, SuiteError> {
        self.case.fragments(true, method.resolution, method.model)
    }

    /// The uncompressed deep shadow map of a method's grid.
    ///
    /// # Errors
    /// As [`Still::fragments`].
    pub fn exact(&self, method: &Method) -> Result<Rc<Exact>, SuiteError> {
        self.case.exact(true, method.resolution, method.model)
    }

    /// A method's grid with all it is judged by.
    fn grid(&self, method: &Method) -> Result<port::Grid, SuiteError> {
        port::Grid::of(&self.case, true, method.resolution, method.model)
    }

    /// The receivers in the map's coordinates.
    pub fn receivers(&self) -> Rc<Vec<Receiver>> {
        self.case.receivers(true)
    }

    /// The depth of the deepest ray, of the light's depth range: no layers need to reach further.
    ///
    /// # Errors
    /// As [`Still::fragments`].
    pub fn deepest(&self) -> Result<f32, SuiteError> {
        let exact = self.case.exact(true, RESOLUTION, Model::ExpTau)?;
        Ok(exact.deepest_span().max(1e-6))
    }

    /// The maps, built.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn maps(&self, method: &Method) -> Result<Maps, SuiteError> {
        let side = method.resolution;
        let mut maps = Maps::new(side, side, &method.settings)?;
        maps.build(&*self.fragments(method)?)?;
        Ok(maps)
    }

    /// Transmittance of every receiver.
    ///
    /// # Errors
    /// As [`Still::maps`].
    pub fn shade(&self, maps: &Maps) -> Result<Vec<f32>, SuiteError> {
        let receivers = self.receivers();
        let mut out = vec![0.0; receivers.len()];
        maps.shade(&receivers, &mut out)?;
        Ok(out)
    }

    /// What the uncompressed deep shadow map says to every receiver, with the method's model, taps
    /// and bias.
    ///
    /// # Errors
    /// As [`Still::fragments`].
    pub fn deep(&self, method: &Method) -> Result<Vec<f32>, SuiteError> {
        let grid = self.grid(method)?;
        Ok(port::deep(&grid, &grid.own, &method.settings))
    }

    /// The method's error against the deep shadow map of the same texels alone.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn layering(&self, method: &Method) -> Result<f64, SuiteError> {
        let (result, deep) = (self.shade(&self.maps(method)?)?, self.deep(method)?);
        Ok(dapple_metrics::rmse(&result, &deep, Some(self.case.mask()))?)
    }

    /// The one of some methods with the least of these errors, and that error.
    ///
    /// # Errors
    /// Settings that are refused, or no method.
    pub fn best(
        &self,
        methods: impl IntoIterator<Item = Method>,
    ) -> Result<(Method, f64), SuiteError> {
        let mut best: Option<(Method, f64)> = None;
        for method in methods {
            let error = self.layering(&method)?;
            if best.as_ref().is_none_or(|(_, least)| error < *least) {
                best = Some((method, error));
            }
        }
        best.ok_or_else(|| SuiteError::Usage("no method to choose from".into()))
    }

    /// A method read in its own best way.
    ///
    /// # Errors
    /// As [`Still::best`].
    pub fn best_lookup(&self, method: &Method) -> Result<(Method, f64), SuiteError> {
        self.best(LOOKUPS.map(|lookup| method.clone().lookup(lookup)))
    }

    /// Deep opacity maps at their best span and lookup; `change` says what else they are to be.
    ///
    /// # Errors
    /// As [`Still::best`].
    pub fn best_dom(
        &self,
        layers: u32,
        change: impl Fn(Method) -> Method,
    ) -> Result<(Method, f64), SuiteError> {
        let deepest = self.deepest()?;
        let of = |span: f32| LOOKUPS.map(|l| change(dom(layers, span * deepest)).lookup(l));
        self.best(SPANS.into_iter().flat_map(of))
    }

    /// How wrong a method is.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn score(&self, method: &Method) -> Result<Score, SuiteError> {
        let maps = self.maps(method)?;
        self.score_of(method, &maps, &self.shade(&maps)?)
    }

    /// How wrong a result of built maps is.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn score_of(
        &self,
        method: &Method,
        maps: &Maps,
        result: &[f32],
    ) -> Result<Score, SuiteError> {
        let grid = self.grid(method)?;
        let mut checked = crate::problem::Checked::default();
        port::measure(&self.case, &grid, &method.settings, result, &mut checked)?;
        if let Some(violation) = checked.violations.first() {
            return Err(SuiteError::Usage(format!("{}: {violation}", self.name)));
        }
        let along = |texel: usize, depth: f32| maps.code().decode(texel, maps.texel(texel), depth);
        let layers = method.layers();
        let sums = |texel: usize| {
            let words = maps.texel(texel);
            &words[words.len() - layers..]
        };
        let idle = if layers > 0 { port::idle_layers(&grid.fragments, layers, sums) } else { None };
        let error = |name: &str| checked.errors.get(name).copied().unwrap_or(0.0);
        Ok(Score {
            rmse: error("rmse"),
            layering: error("layering_rmse"),
            banding: port::banding(&grid, along).unwrap_or(0.0),
            idle: idle.unwrap_or(0.0),
        })
    }

    /// Time of `a` over time of `b` on the processor, maps and shading, `pairs` pairs in turn.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn cpu_ratio(&self, pairs: usize, a: &Method, b: &Method) -> Result<Ratio, SuiteError> {
        let (mut a, mut b) = (CpuRun::new(self, a)?, CpuRun::new(self, b)?);
        paired(pairs, || a.ns(), || b.ns())
    }

    /// The same on the device, a whole frame with its rasterising, by the device's clock where it
    /// is sound.
    ///
    /// # Errors
    /// Settings that are refused, or the device's.
    pub fn gpu_ratio(
        &self,
        gpu: &Gpu,
        pairs: usize,
        a: &Method,
        b: &Method,
    ) -> Result<Ratio, SuiteError> {
        let (a, b) = (self.renderer(gpu, a)?, self.renderer(gpu, b)?);
        paired(pairs, || frame_ns(gpu, &a), || frame_ns(gpu, &b))
    }

    /// The renderer of a method on the device.
    ///
    /// # Errors
    /// As [`Still::gpu_ratio`].
    pub fn renderer(&self, gpu: &Gpu, method: &Method) -> Result<Renderer, SuiteError> {
        let mesh = self.case.light_mesh(true);
        let size = [method.resolution; 2];
        Renderer::new(gpu, &mesh, method.model, &self.receivers(), size, &method.settings)
            .map_err(subject_gpu::refused)
    }
}

/// Nanoseconds of one frame on the device.
///
/// # Errors
/// A lost device.
pub fn frame_ns(gpu: &Gpu, renderer: &Renderer) -> Result<f64, SuiteError> {
    let mut frame = gpu.frame();
    renderer.record(&mut frame);
    let times = frame.finish()?;
    Ok(times.gpu_ns.unwrap_or(times.wall_ns) as f64)
}

/// A method's frame on the processor, everything allocated.
pub struct CpuRun {
    maps: Maps,
    fragments: Rc<Fragments>,
    receivers: Rc<Vec<Receiver>>,
    out: Vec<f32>,
}

impl CpuRun {
    /// Over a still.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(still: &Still, method: &Method) -> Result<Self, SuiteError> {
        let (maps, receivers) = (still.maps(method)?, still.receivers());
        let out = vec![0.0; receivers.len()];
        Ok(Self { maps, fragments: still.fragments(method)?, receivers, out })
    }

    /// Nanoseconds of maps and shading.
    ///
    /// # Errors
    /// None that the making has not met.
    pub fn ns(&mut self) -> Result<f64, SuiteError> {
        Ok(self.build_ns()? + self.shade_ns()?)
    }

    /// Nanoseconds of the maps.
    ///
    /// # Errors
    /// As [`CpuRun::ns`].
    pub fn build_ns(&mut self) -> Result<f64, SuiteError> {
        let start = Instant::now();
        self.maps.build(&self.fragments)?;
        Ok(start.elapsed().as_nanos() as f64)
    }

    /// Nanoseconds of shading.
    ///
    /// # Errors
    /// As [`CpuRun::ns`].
    pub fn shade_ns(&mut self) -> Result<f64, SuiteError> {
        let start = Instant::now();
        self.maps.shade(&self.receivers, &mut self.out)?;
        Ok(start.elapsed().as_nanos() as f64)
    }
}
