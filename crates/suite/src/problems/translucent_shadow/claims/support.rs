//! Scenes as the judges see them: receivers, truth and fragments, prepared once and shared, and
//! settings scored and timed on them.

use super::super::{SPEC, TranslucentCase, port};
use super::verdict::paired;
use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knobs},
    problems::translucent_shadow::subject_gpu,
};
use dapple_gpu::Gpu;
use dapple_metrics::stats::Ratio;
use dapple_opacity_maps::{
    Bins, Blend, Code, EndMap, Format, Fragments, Layered, Layout, Lookup, Model, Opaque, Packing,
    Receiver, Settings, Slicing, Split, SplitKind, Storage, Taps, cpu::Maps, exact::Exact,
    gpu::Renderer,
};
use serde_json::Value;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc, time::Instant};

/// Side of the map of every figure unless it says otherwise, texels.
pub const RESOLUTION: u32 = 256;

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

/// A setting of the maps on a grid of texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Thickness of a surface.
    pub model: Model,
    /// Side of the map, texels.
    pub resolution: u32,
    /// The maps.
    pub settings: Settings,
}

/// How wrong a method is on a still.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Transmittance against truth by light rays.
    pub rmse: f64,
    /// Against the uncompressed deep shadow map of the same texels, taps and model.
    pub layering: f64,
    /// Of that deep shadow map against truth, one tap.
    pub map: f64,
    /// Root mean squared step of the layering error along light rays.
    pub banding: f64,
    /// Light too little: mean of -error where it is negative.
    pub dark: f64,
    /// Light too much.
    pub leak: f64,
    /// Share of (ray, layer) cells without a fragment; 0 for what has no layers.
    pub idle: f64,
}

impl Method {
    /// The suite's defaults with a code: thickness -ln(1 - alpha), 3 x 3 taps, each decoded, a bias
    /// of 1e-3, opaque casters in a map of their own.
    pub fn of(code: Code) -> Self {
        let settings = Settings { taps: Taps::Box3, bias: 1e-3, ..Settings::plain(code) };
        Self { model: Model::ExpTau, resolution: RESOLUTION, settings }
    }

    /// The same with one tap.
    pub fn one_tap(self) -> Self {
        self.taps(Taps::One)
    }

    /// The same with other taps.
    pub fn taps(mut self, taps: Taps) -> Self {
        self.settings.taps = taps;
        self
    }

    /// The same on another grid.
    pub fn at(mut self, resolution: u32) -> Self {
        self.resolution = resolution;
        self
    }

    /// The same read in another way, where it has layers.
    pub fn lookup(self, lookup: Lookup) -> Self {
        self.with(|layered| layered.lookup = lookup)
    }

    /// The same in another packing, where it has layers.
    pub fn packing(self, packing: Packing) -> Self {
        self.with(|layered| layered.packing = packing)
    }

    /// The same with something else about its layers, where it has some.
    pub fn with(mut self, change: impl FnOnce(&mut Layered)) -> Self {
        if let Code::Layered(layered) = &mut self.settings.code {
            change(layered);
        }
        self
    }

    /// Layers K, 0 for what has none.
    pub fn layers(&self) -> usize {
        match &self.settings.code {
            Code::Layered(layered) => layered.layers as usize,
            _ => 0,
        }
    }
}

/// K layers of a layout, interpolated, added up in 32-bit floats.
pub fn layered(layout: Layout, layers: u32) -> Method {
    Method::of(Code::Layered(Layered {
        layout,
        layers,
        lookup: Lookup::Lerp,
        write_bias: 0.0,
        soft_start: false,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Targets(8),
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
    }))
}

/// Opacity shadow maps: even planes.
pub fn osm(layers: u32) -> Method {
    layered(Layout::Planes(Slicing::Uniform), layers)
}

/// Deep opacity maps of even layers, `span` of the light's depth range deep.
pub fn dom(layers: u32, span: f32) -> Method {
    layered(Layout::Deep { span, growth: 1.0, listing: false }, layers)
}

/// Bounding opacity maps of even layers.
pub fn bom(layers: u32) -> Method {
    bom_split(layers, 0.0, SplitKind::Normalised)
}

/// Bounding opacity maps with a split function.
pub fn bom_split(layers: u32, lambda: f32, kind: SplitKind) -> Method {
    let split = Split { lambda, kind, width: super::super::settings::TABLE_WIDTH };
    layered(Layout::Bounded { split, bins: Bins::Full }, layers)
}

/// The thesis's bins, K - 1 of them, with the fragments' depths biased as the receivers'.
pub fn thesis_bins(method: Method) -> Method {
    let bias = method.settings.bias;
    method.with(|layered| {
        layered.write_bias = bias;
        if let Layout::Bounded { bins, .. } = &mut layered.layout {
            *bins = Bins::Thesis;
        }
    })
}

/// Everything else of the thesis: thickness is alpha, the layer's own sum is read, sums are
/// averaged before they are decoded, opaque casters weigh 3.
pub fn thesis_reading(method: Method) -> Method {
    let mut method = method.lookup(Lookup::Nearest);
    method.model = Model::ExpAlpha;
    method.settings.blur = dapple_opacity_maps::Blur::Stored;
    method.settings.opaque = Opaque::Weight { weight: 3.0, in_bounds: false };
    method
}

/// Shares of the deepest ray that deep opacity maps are tried over.
pub const SPANS: [f32; 8] = [0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 1.5, 3.0];

/// All ways of reading layers.
pub const LOOKUPS: [Lookup; 3] = [Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive];

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
        let (fragments, own) = (self.fragments(method)?, self.exact(method)?);
        let receivers = self.receivers();
        let grid =
            port::Grid { fragments: &fragments, own: &own, law: &own, receivers: &receivers };
        Ok(port::deep(&grid, &own, &method.settings))
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
        let (fragments, own) = (self.fragments(method)?, self.exact(method)?);
        let law = self.case.exact(true, method.resolution, self.case.law())?;
        let receivers = self.receivers();
        let grid =
            port::Grid { fragments: &fragments, own: &own, law: &law, receivers: &receivers };
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
        let idle = if layers > 0 { port::idle_layers(&fragments, layers, sums) } else { None };
        let error = |name: &str| checked.errors.get(name).copied().unwrap_or(0.0);
        Ok(Score {
            rmse: error("rmse"),
            layering: error("layering_rmse"),
            map: error("map_rmse"),
            banding: port::banding(&grid, along).unwrap_or(0.0),
            dark: error("dark"),
            leak: error("leak"),
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
