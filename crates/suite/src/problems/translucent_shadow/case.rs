//! A prepared case: receivers seen by the camera, their truth, and what the light meets on the way.

use super::{
    cascades,
    maps::Maps,
    picture::Lighting,
    port,
    scene::{self, Wishes},
    subject_cascades::CascadeSubject,
    subject_cpu::CpuSubject,
    subject_gpu::GpuSubject,
    subject_reference::ReferenceSubject,
    subject_search::SearchSubject,
    subject_search_gpu::GpuSearchSubject,
};
use crate::{
    SuiteError,
    case::Case,
    knob::Get,
    problem::{Facts, Form, Picture, Prepared, Setting, Subject},
    problems::shadow_filtering::given::Given,
    scene as complete,
    truth_cache::TruthCache,
};
use dapple_gpu::{Gpu, light_space::LightSpaceMesh};
use dapple_opacity_maps::{Fragments, Model, Receiver, exact::Exact};
use dapple_scene::{Camera, LightView, Scene};
use dapple_trace::{Footprint, Law, LightFragments, LightPath, Opacities, Surface, Tracer};
use glam::DVec3;
use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    rc::Rc,
};

/// Changes with whatever changes the truth's values.
const TRUTH_VERSION: u32 = 1;

/// Opaque receivers whose light comes in flatter than this (n.l) count as facing away.
const LEAST_N_DOT_L: f64 = 0.05;

/// A scene seen by a camera under one light, with the truth at every receiver.
pub struct TranslucentCase<'g> {
    gpu: Option<&'g Gpu>,
    facts: Facts,
    camera: Camera,
    view_depths: Vec<f32>,
    casters: Scene,
    tracer: Tracer,
    opacities: Opacities,
    /// The whole scene's map, and the one of what casts and receives.
    views: [LightView; 2],
    receivers: [Rc<Vec<Receiver>>; 2],
    size: [u32; 2],
    seed: u64,
    law: Model,
    truth: Vec<f32>,
    mask: Vec<bool>,
    lighting: Lighting,
    maps: Maps,
    meshes: RefCell<BTreeMap<bool, Rc<LightSpaceMesh>>>,
    true_image: OnceCell<Vec<f32>>,
}

impl<'g> TranslucentCase<'g> {
    /// Loads the scene and traces receivers and truth (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, an unknown view, or a view without receivers.
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let wishes = Wishes::of(&case.parameters)?;
        Self::of(scene::load(&case.scene, &case.view, case.seed, &wishes)?, case, gpu)
    }

    /// The same for a scene at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`TranslucentCase::prepare`].
    pub fn of(
        loaded: scene::Loaded,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Self, SuiteError> {
        Self::given(loaded, &Given::default(), case, gpu)
    }

    /// The same with maps whose depth range is another than the one that fits. Techniques see the
    /// scene as the truth does: nothing else of `given` counts.
    ///
    /// # Errors
    /// As [`TranslucentCase::prepare`].
    pub fn given(
        loaded: scene::Loaded,
        given: &Given,
        case: &Case,
        gpu: Option<&'g Gpu>,
    ) -> Result<Self, SuiteError> {
        let scene::Loaded { seen, casters, lift_m, hash, mut notes } = loaded;
        scene::require_translucent(&seen)?;
        let width = case.parameters.int("width")? as u32;
        let height = (width * 9 / 16).max(1);
        let footprint = case.parameters.float("footprint")?;
        let rays = case.parameters.int("truth_rays")? as u32;
        let law = case.parameters.word("law")?;
        let camera = complete::camera(&seen, &case.view)?;
        let seen_tracer = Tracer::build(&seen)?;
        let alphas = Opacities::of(&seen)?;
        let layers = dapple_trace::camera_layers(&seen_tracer, &alphas, &camera, width, height)?;
        if layers.surfaces.is_empty() {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {}: the camera sees nothing",
                seen.name, camera.name
            )));
        }
        let same = casters.is_none();
        let casters = casters.unwrap_or_else(|| seen.clone());
        let tracer = if same { seen_tracer } else { Tracer::build(&casters)? };
        let opacities = Opacities::of(&casters)?;
        let (whole, note) = complete::light_view(&casters, &tracer.bounds())?;
        notes.extend(note);
        let views = [whole, focused(&casters, whole)?].map(|view| given.view(view));

        let paths: Vec<LightPath> = layers
            .surfaces
            .iter()
            .zip(&layers.alpha)
            .map(|(surface, alpha)| {
                let opaque = *alpha >= 1.0;
                // Hair has as many triangles whomever it faces: opaque ones keep their number.
                let own = opaque || same;
                let lift = if own { DVec3::ZERO } else { whole.forward * lift_m };
                LightPath {
                    position: surface.position - lift,
                    triangle: if own { surface.triangle } else { u32::MAX },
                    opaque,
                }
            })
            .collect();
        let receivers = views.map(|view| Rc::new(in_map(&view, &layers.surfaces, &paths)));
        let cosine = |s| dapple_trace::receiver(&whole, s).map_or(0.0, |r| r.n_dot_l) as f32;
        let n_dot_l: Vec<f32> = layers.surfaces.iter().map(cosine).collect();
        let mask: Vec<bool> = receivers[0].iter().map(|r| r.flags & Receiver::VALID != 0).collect();
        let counted = mask.iter().filter(|m| **m).count();
        if counted == 0 {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {}: no surface in view is translucent or faces the light",
                seen.name, camera.name
            )));
        }
        let translucent = paths.iter().filter(|p| !p.opaque).count();
        notes.push(format!(
            "{counted} receivers, {translucent} of them on translucent surfaces; {} on opaque \
             surfaces that face away from the light (n.l <= {LEAST_N_DOT_L}) are left out",
            paths.len() - counted
        ));
        let key = format!(
            "translucent-shadow v{TRUTH_VERSION} {hash} {} {camera:?} {whole:?} {width}x{height} \
             footprint {footprint:?} rays {rays} seed {} law {law} {:?}",
            casters.hash(),
            case.seed,
            case.parameters
        );
        let window = (footprint > 0.0).then_some(Footprint { width_uv: footprint, grid: rays });
        let traced = if law == "exponential" { Law::Exponential } else { Law::Product };
        let truth = TruthCache::from_environment().get(&key, paths.len(), || {
            let all = dapple_trace::transmittance_all(
                &tracer, &opacities, &whole, traced, window, &paths, case.seed,
            );
            // Those left out are dark by their cosine, whatever their shadow.
            let shown = all.into_iter().zip(&mask).map(|(t, m)| if *m { t as f32 } else { 1.0 });
            Ok::<_, SuiteError>(shown.collect())
        })?;
        let depth = |s: &Surface| cascades::view_depth(&camera, s.position) as f32;
        let view_depths = layers.surfaces.iter().map(depth).collect();
        let lighting = Lighting::of(&seen, &layers, &n_dot_l);
        let truth_in_words = if footprint > 0.0 {
            let metres = footprint * whole.side_m();
            format!("{} light rays a receiver over a window of {metres:.4} m", rays * rays)
        } else {
            "one light ray a receiver".into()
        };
        let facts = Facts {
            scene: seen.name.clone(),
            scene_hash: hash,
            view: camera.name.clone(),
            size: format!("{width}x{height}"),
            truth: format!("{truth_in_words}; {law} law"),
            notes,
        };
        Ok(Self {
            gpu,
            facts,
            camera,
            view_depths,
            casters,
            tracer,
            opacities,
            views,
            receivers,
            size: [width, height],
            seed: case.seed,
            law: port::law_model(law),
            truth,
            mask,
            lighting,
            maps: Maps::default(),
            meshes: RefCell::default(),
            true_image: OnceCell::new(),
        })
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Distance of each receiver from the camera along its axis, metres.
    pub fn view_depths(&self) -> &[f32] {
        &self.view_depths
    }

    /// Rays against what the light meets.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// What the light meets.
    pub fn casters(&self) -> &Scene {
        &self.casters
    }

    /// Opacity of each of their triangles.
    pub fn caster_opacities(&self) -> &Opacities {
        &self.opacities
    }

    /// The map's projection: of the whole scene, or cropped to what casts and receives.
    pub fn view(&self, crop: bool) -> &LightView {
        &self.views[usize::from(crop)]
    }

    /// Receivers in that map's coordinates, pixel by pixel, nearest first.
    pub fn receivers(&self, crop: bool) -> Rc<Vec<Receiver>> {
        Rc::clone(&self.receivers[usize::from(crop)])
    }

    /// Truth of every receiver.
    pub fn truth(&self) -> &[f32] {
        &self.truth
    }

    /// Which receivers count: all but opaque surfaces that face away from the light.
    pub fn mask(&self) -> &[bool] {
        &self.mask
    }

    /// The thickness model that the truth's law is.
    pub fn law(&self) -> Model {
        self.law
    }

    /// First receiver of every pixel, nearest first, and the end.
    pub fn pixels(&self) -> &[u32] {
        &self.lighting.starts
    }

    /// Columns and rows of the image.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The lit image of transmittances, one a receiver.
    pub fn image(&self, transmittance: &[f32]) -> Vec<f32> {
        self.lighting.image(transmittance)
    }

    /// Truth and result as pictures.
    pub fn picture(&self, transmittance: &[f32]) -> Picture {
        let [width, height] = self.size;
        let truth = self.true_image.get_or_init(|| self.image(&self.truth)).clone();
        Picture { width, height, truth, result: self.image(transmittance) }
    }

    /// Every surface that the light meets through the texels' centres.
    pub(super) fn light_fragments(
        &self,
        crop: bool,
        resolution: u32,
    ) -> Result<LightFragments, SuiteError> {
        Ok(dapple_trace::light_fragments(&self.tracer, self.view(crop), resolution, resolution)?)
    }

    /// The map's fragments by thickness model, made once.
    ///
    /// # Errors
    /// More of them than memory allows.
    pub fn fragments(
        &self,
        crop: bool,
        resolution: u32,
        model: Model,
    ) -> Result<Rc<Fragments>, SuiteError> {
        self.maps.fragments(self, crop, resolution, model)
    }

    /// The uncompressed deep shadow map of them, made once.
    ///
    /// # Errors
    /// As [`TranslucentCase::fragments`].
    pub fn exact(
        &self,
        crop: bool,
        resolution: u32,
        model: Model,
    ) -> Result<Rc<Exact>, SuiteError> {
        self.maps.exact(self, crop, resolution, model)
    }

    /// What a rasteriser of that map draws, made once.
    pub fn light_mesh(&self, crop: bool) -> Rc<LightSpaceMesh> {
        let mut meshes = self.meshes.borrow_mut();
        let make = || Rc::new(crate::light_mesh::light_space_mesh(&self.casters, self.view(crop)));
        Rc::clone(meshes.entry(crop).or_insert_with(make))
    }

    /// A seeded choice of at most `most` receivers, in order.
    pub fn subset(&self, most: usize) -> Vec<usize> {
        let mut rng = <rand_pcg::Pcg64 as rand::SeedableRng>::seed_from_u64(self.seed ^ 0x7a5);
        let counted: Vec<usize> = (0..self.mask.len()).filter(|i| self.mask[*i]).collect();
        let wanted = most.min(counted.len());
        let mut chosen = rand::seq::index::sample(&mut rng, counted.len(), wanted).into_vec();
        chosen.sort_unstable();
        chosen.into_iter().map(|i| counted[i]).collect()
    }
}

/// The map of what casts and receives: of everything but the ground, where the light is parallel.
fn focused(scene: &Scene, whole: LightView) -> Result<LightView, SuiteError> {
    if whole.perspective {
        return Ok(whole);
    }
    // Hair, leaves and trunks; the ground only receives.
    let casters = scene.subject_bounds();
    Ok(LightView::focused(whole.forward, &casters, &scene.bounds())?)
}

/// Receivers in a map's coordinates. Opaque ones that face away from the light are left out of it:
/// they are dark by their cosine.
fn in_map(view: &LightView, surfaces: &[Surface], paths: &[LightPath]) -> Vec<Receiver> {
    paths
        .iter()
        .zip(surfaces)
        .map(|(path, surface)| {
            let at = view.project(path.position);
            let mut receiver = Receiver::at(at.x as f32, at.y as f32, at.z as f32);
            if path.opaque {
                receiver.flags |= Receiver::OPAQUE;
                match dapple_trace::receiver(view, surface) {
                    Some(plane) if plane.n_dot_l > LEAST_N_DOT_L => {
                        receiver.slope_u = plane.dz_du as f32;
                        receiver.slope_v = plane.dz_dv as f32;
                    }
                    _ => receiver.flags &= !Receiver::VALID,
                }
            }
            receiver
        })
        .collect()
}

impl Prepared for TranslucentCase<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        match setting.technique.as_str() {
            "pssm" => return Ok(Box::new(CascadeSubject::new(self, self.gpu, setting)?)),
            "bom-search" if setting.form == Form::Cpu => {
                return Ok(Box::new(SearchSubject::new(self, setting)?));
            }
            _ => {}
        }
        match (setting.form, self.gpu) {
            (Form::Cpu, _) => Ok(Box::new(CpuSubject::new(self, setting)?)),
            (Form::Gpu, Some(gpu)) if setting.technique == "bom-search" => {
                Ok(Box::new(GpuSearchSubject::new(self, gpu, setting)?))
            }
            (Form::Gpu, Some(gpu)) => Ok(Box::new(GpuSubject::new(self, gpu, setting)?)),
            (Form::Gpu, None) => {
                Err(SuiteError::Usage(format!("{setting} needs a graphics adapter")))
            }
            (Form::Reference, _) => Ok(Box::new(ReferenceSubject::new(self, setting)?)),
        }
    }
}
