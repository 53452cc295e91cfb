//! A prepared case: receivers seen by the camera, their truth, and depth maps by resolution.

use super::{
    errors::Compared,
    given::{Given, NOT_VALID, receiver},
    settings::{self, kernel_texels},
    subject_cpu::CpuSubject,
    subject_gpu::{GpuSubject, raster_error},
    subject_reference::ReferenceSubject,
};
use crate::{
    SuiteError,
    case::Case,
    knob::Get,
    light_mesh,
    problem::{Facts, Form, Prepared, Setting, Subject},
    scene,
    truth_cache::TruthCache,
};
use dapple_gpu::{Gpu, light_space::LightSpaceMesh};
use dapple_scene::{LightView, Scene};
use dapple_shadows::filtering::{DepthMap, Receiver, gpu_depth::DepthRaster};
use dapple_trace::Tracer;
use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    rc::Rc,
};

/// Changes with whatever changes the truth's values.
const TRUTH_VERSION: u32 = 4;

/// Texel comparisons that one check against the reference may cost.
const REFERENCE_BUDGET: u64 = 1 << 26;

/// Most receivers held against the reference.
const MOST_CHECKED: u64 = 2048;

/// A scene seen by a camera under one light, with the truth at every pixel.
pub struct ShadowCase<'g> {
    gpu: Option<&'g Gpu>,
    facts: Facts,
    scene: Scene,
    tracer: Tracer,
    /// What the maps see, where it is not the scene.
    casters: Option<(Scene, Tracer)>,
    view: LightView,
    width: u32,
    height: u32,
    footprint: f64,
    seed: u64,
    receivers: Vec<Receiver>,
    mask: Vec<bool>,
    truth: Vec<f32>,
    maps: RefCell<BTreeMap<u32, Rc<DepthMap>>>,
    mesh: OnceCell<LightSpaceMesh>,
    rasters: RefCell<BTreeMap<u32, Rc<DepthRaster>>>,
}

impl<'g> ShadowCase<'g> {
    /// Loads the scene and traces receivers and truth (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, an unknown view, or a view without receivers.
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        Self::of(scene::load(&case.scene, case.seed)?, case, gpu)
    }

    /// The same for a scene at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`ShadowCase::prepare`].
    pub fn of(
        loaded: scene::Loaded,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Self, SuiteError> {
        Self::given(loaded, Given::default(), case, gpu)
    }

    /// The same where techniques are given something else than the truth is traced in.
    ///
    /// # Errors
    /// As [`ShadowCase::prepare`].
    pub fn given(
        loaded: scene::Loaded,
        given: Given,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Self, SuiteError> {
        let scene::Loaded { scene, hash, mut notes } = loaded;
        let least = given.least_n_dot_l;
        let width = case.parameters.int("width")? as u32;
        let height = (width * 9 / 16).max(1);
        let footprint = case.parameters.float("footprint")?;
        let rays = case.parameters.int("truth_rays")? as u32;
        let camera = scene::camera(&scene, &case.view)?;
        let tracer = Tracer::build(&scene)?;
        let (view, note) = scene::light_view(&scene, &tracer.bounds())?;
        notes.extend(note);

        let items = dapple_trace::item_buffer(&tracer, &camera, width, height);
        let mut surfaces = dapple_trace::surfaces(&tracer, &items);
        let seen = surfaces.iter().flatten().count();
        let given_view = given.view(view);
        let mut receivers = Vec::with_capacity(surfaces.len());
        let mut picture_of_masked = Vec::with_capacity(surfaces.len());
        for surface in &mut surfaces {
            picture_of_masked.push(if surface.is_some() { 0.0 } else { 1.0 });
            *surface = surface.filter(|s| receiver(&view, s, least).is_some());
            receivers.push(surface.map_or(NOT_VALID, |s| given.receiver(&given_view, &s)));
        }
        let mask: Vec<bool> = surfaces.iter().map(Option::is_some).collect();
        let counted = mask.iter().filter(|m| **m).count();
        if counted == 0 {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {}: no surface in view faces the light",
                scene.name, camera.name
            )));
        }
        let left_out = 100.0 * (seen - counted) as f64 / seen as f64;
        notes.push(format!(
            "{counted} receivers; {left_out:.1} % of the surface in view is left out: it faces away \
             from the light, is grazed by it (n.l <= {least}) or lies outside its map"
        ));
        let key = format!(
            "shadow-filtering v{TRUTH_VERSION} {hash} {camera:?} {view:?} {width}x{height} \
             footprint {footprint:?} rays {rays} seed {} least {least} plane {:?} {:?}",
            case.seed,
            dapple_trace::PLANE_EPSILON,
            dapple_trace::SURFACE_REACH
        );
        let truth = TruthCache::from_environment().get(&key, mask.len(), || {
            let all = dapple_trace::filtered_visibility_all(
                &tracer, &view, &surfaces, footprint, rays, case.seed,
            );
            let shown = all.iter().zip(&mask).zip(&picture_of_masked);
            Ok::<_, SuiteError>(
                shown.map(|((v, m), other)| if *m { *v as f32 } else { *other }).collect(),
            )
        })?;
        let casters = match given.single_precision {
            Some(scene) => Some(Tracer::build(&scene).map(|tracer| (scene, tracer))?),
            None => None,
        };
        let facts = Facts {
            scene: scene.name.clone(),
            scene_hash: hash,
            view: camera.name,
            size: format!("{width}x{height}"),
            truth: format!(
                "{} stratified rays a receiver over a window of {:.4} m ({footprint} of the map's side)",
                rays * rays,
                footprint * view.side_m()
            ),
            notes,
        };
        Ok(Self {
            gpu,
            facts,
            scene,
            tracer,
            casters,
            view: given_view,
            width,
            height,
            footprint,
            seed: case.seed,
            receivers,
            mask,
            truth,
            maps: RefCell::default(),
            mesh: OnceCell::new(),
            rasters: RefCell::default(),
        })
    }

    /// The scene as it is measured.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The tracer of that scene.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// The map's projection.
    pub fn view(&self) -> &LightView {
        &self.view
    }

    /// Columns and rows of the image.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// One a pixel, rows top to bottom; `valid` is 0 where none takes part.
    pub fn receivers(&self) -> &[Receiver] {
        &self.receivers
    }

    /// Which pixels take part.
    pub fn mask(&self) -> &[bool] {
        &self.mask
    }

    /// Truth of every pixel that takes part; for the others 1 where nothing is, 0 where a surface
    /// faces away.
    pub fn truth(&self) -> &[f32] {
        &self.truth
    }

    /// Side of the window over the map's side.
    pub fn footprint(&self) -> f64 {
        self.footprint
    }

    /// The ray-cast depth map of `resolution` x `resolution` texels, made once.
    pub fn depth_map(&self, resolution: u32) -> Rc<DepthMap> {
        let mut maps = self.maps.borrow_mut();
        let make = || {
            let tracer = self.casters.as_ref().map_or(&self.tracer, |(_, tracer)| tracer);
            let depths = dapple_trace::depth_map(tracer, &self.view, resolution, resolution);
            Rc::new(DepthMap { width: resolution, height: resolution, depths })
        };
        Rc::clone(maps.entry(resolution).or_insert_with(make))
    }

    /// The rasteriser of that map, made once and shared by the settings that use it.
    pub(super) fn raster(&self, gpu: &Gpu, resolution: u32) -> Result<Rc<DepthRaster>, SuiteError> {
        if let Some(raster) = self.rasters.borrow().get(&resolution) {
            return Ok(Rc::clone(raster));
        }
        let scene = self.casters.as_ref().map_or(&self.scene, |(scene, _)| scene);
        let mesh = self.mesh.get_or_init(|| light_mesh::light_space_mesh(scene, &self.view));
        let made = DepthRaster::new(gpu, mesh, resolution, resolution).map_err(raster_error)?;
        let raster = Rc::new(made);
        self.rasters.borrow_mut().insert(resolution, Rc::clone(&raster));
        Ok(raster)
    }

    /// Every metric of a result, one value a pixel (those that take no part are ignored).
    ///
    /// # Errors
    /// Another length, or a value that is not finite.
    pub fn errors(&self, result: &[f32]) -> Result<BTreeMap<String, f64>, SuiteError> {
        let (width, height) = (self.width, self.height);
        Compared { width, height, result, truth: &self.truth, mask: &self.mask }.errors()
    }

    /// A seeded choice of pixels to hold against the reference, fewer for wider windows.
    pub fn subset(&self, resolution: u32) -> Vec<usize> {
        let kernel = u64::from(kernel_texels(self.footprint, resolution));
        let affordable = (REFERENCE_BUDGET / (kernel * kernel)).clamp(64, MOST_CHECKED) as usize;
        let taking_part: Vec<usize> = (0..self.mask.len()).filter(|i| self.mask[*i]).collect();
        let mut rng = <rand_pcg::Pcg64 as rand::SeedableRng>::seed_from_u64(self.seed ^ 0x5b5e7);
        let wanted = affordable.min(taking_part.len());
        let chosen = rand::seq::index::sample(&mut rng, taking_part.len(), wanted);
        chosen.into_iter().map(|i| taking_part[i]).collect()
    }
}

impl Prepared for ShadowCase<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        let resolution = settings::resolution(setting)?;
        let settings = settings::settings(setting, self.footprint)?;
        match (setting.form, self.gpu) {
            (Form::Cpu, _) => Ok(Box::new(CpuSubject::new(self, resolution, settings)?)),
            (Form::Gpu, Some(gpu)) => {
                Ok(Box::new(GpuSubject::new(self, gpu, resolution, settings)?))
            }
            (Form::Gpu, None) => {
                Err(SuiteError::Usage(format!("{setting} needs a graphics adapter")))
            }
            (Form::Reference, _) => Ok(Box::new(ReferenceSubject::new(self, resolution, settings))),
        }
    }
}
