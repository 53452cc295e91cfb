//! A prepared case: what every frame shows, the lights, the truth, and the trees built so far.

use super::{
    input::{self, Hierarchy, Input, burning},
    picture,
    settings::{self, TreeKind},
    subject,
    truth::Truth,
};
use crate::{
    SuiteError,
    case::Case,
    city,
    knob::Get,
    problem::{Facts, Picture, Prepared, Setting, Subject},
};
use dapple_gpu::Gpu;
use dapple_many_lights::{
    Eye, Form, Frame, LightTree, Lighting, Point, Shaded, Technique, World, gpu, make,
    tree::{self, Build, city::Levels},
};
use dapple_scene::{Camera, Scene};
use dapple_trace::{Ray, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    sync::Arc,
};

/// Surfaces lit by many lights, with the truth of every frame.
pub struct LightsCase<'g> {
    gpu: Option<&'g Gpu>,
    facts: Facts,
    world: Arc<World>,
    hierarchy: Hierarchy,
    seed: u64,
    truth: Truth,
    trees: RefCell<BTreeMap<String, Arc<LightTree>>>,
    device: OnceCell<Arc<gpu::Scene<'g>>>,
    whole: OnceCell<Vec<Vec3>>,
}

impl<'g> LightsCase<'g> {
    /// Loads the scene, finds what pixels show, and sums up the truth (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, or an unknown view.
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        Self::of(input::load(case)?, case, gpu)
    }

    /// The same for lights and surfaces at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`LightsCase::prepare`].
    pub fn of(input: Input, case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let Input { scene, lights, origin, hierarchy, hash, mut notes } = input;
        let parameters = &case.parameters;
        let width = parameters.int("width")? as u32;
        let height = (width * 9 / 16).max(1);
        let (view, cameras) = city::cameras(&scene, &case.view, parameters.int("frames")? as u32)?;
        let tracer = Arc::new(Tracer::build(&scene)?);
        let frames: Vec<Frame> = cameras
            .iter()
            .map(|camera| frame(&scene, &tracer, camera, [width, height], origin))
            .collect();
        if frames.iter().all(|f| f.points.iter().all(|p| !p.is_there())) {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {view}: no frame shows anything",
                scene.name
            )));
        }
        let shadows = parameters.word("visibility")? == "on";
        let world = World {
            origin,
            lights,
            frames,
            clamp_m: parameters.float("clamp")?,
            occluders: shadows.then(|| Arc::clone(&tracer)),
        };
        world.check()?;
        let most = parameters.int("truth_pixels")? as usize;
        // Lights follow from the scene and from these.
        let of_lights: Vec<_> = ["lights", "lit", "emission", "clamp", "visibility"]
            .iter()
            .map(|name| parameters.get(*name))
            .collect();
        let key = format!("{hash} {cameras:?} {width}x{height} {of_lights:?} {}", case.seed);
        let truth = Truth::of(&key, &world, most, case.seed);
        notes.push(format!(
            "{} lights; truth at {} pixels of {} frames",
            world.lights.len(),
            truth.pixels(),
            world.frames.len()
        ));
        let facts = Facts {
            scene: scene.name.clone(),
            scene_hash: hash,
            view,
            size: format!("{width}x{height}, {} frames", world.frames.len()),
            truth: format!(
                "sum over {} lights in f64{}, at most {most} pixels a frame",
                world.lights.len(),
                if shadows { " with shadow rays" } else { "" }
            ),
            notes,
        };
        Ok(Self {
            gpu,
            facts,
            world: Arc::new(world),
            hierarchy,
            seed: case.seed,
            truth,
            trees: RefCell::default(),
            device: OnceCell::new(),
            whole: OnceCell::new(),
        })
    }

    /// Lights and frames.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// What pixels should show.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Seed of what techniques do by chance.
    pub fn seed(&self) -> u32 {
        (self.seed ^ self.seed >> 32) as u32
    }

    /// A technique made ready for this case.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn lighting(&self, setting: &Setting) -> Result<Box<dyn Lighting + 'g>, SuiteError> {
        let technique = settings::technique(setting)?;
        let tree = self.tree(&technique, setting)?;
        let form = settings::form(setting.form);
        let scene = if form == Form::Gpu { Some(self.device()?) } else { None };
        Ok(make(form, &technique, &self.world, &tree, scene.as_ref())?)
    }

    /// The device, with points and lights on it, uploaded once.
    ///
    /// # Errors
    /// No device, or one that is too small.
    pub fn device(&self) -> Result<Arc<gpu::Scene<'g>>, SuiteError> {
        let gpu = self.gpu.ok_or_else(|| SuiteError::Internal("no graphics device".into()))?;
        if let Some(scene) = self.device.get() {
            return Ok(Arc::clone(scene));
        }
        let scene = Arc::new(gpu::Scene::new(gpu, &self.world)?);
        Ok(Arc::clone(self.device.get_or_init(|| scene)))
    }

    /// The tree that a setting asks for, built once.
    ///
    /// # Errors
    /// The city's hierarchy where there is none.
    pub fn tree(
        &self,
        technique: &Technique,
        setting: &Setting,
    ) -> Result<Arc<LightTree>, SuiteError> {
        let has_hierarchy = !matches!(self.hierarchy, Hierarchy::None);
        let plan = settings::tree(technique, setting, has_hierarchy, self.seed)?;
        let key = format!("{plan:?}");
        if let Some(tree) = self.trees.borrow().get(&key) {
            return Ok(Arc::clone(tree));
        }
        let (kind, representative) = plan;
        let lights = &self.world.lights;
        let tree = Arc::new(match kind {
            TreeKind::None => LightTree::default(),
            TreeKind::Of(build) => LightTree::build(lights, build, representative)?,
            TreeKind::Hierarchy { levels, fanout } => {
                let mut paths = self.paths(levels)?;
                if fanout > 0 {
                    paths = tree::city::limited(lights, &paths, fanout)?;
                }
                LightTree::build(lights, Build::Keys(&paths), representative)?
            }
        });
        self.trees.borrow_mut().insert(key, Arc::clone(&tree));
        Ok(tree)
    }

    /// Path of each light through the scene's hierarchy.
    fn paths(&self, levels: Levels) -> Result<Vec<Vec<u32>>, SuiteError> {
        match &self.hierarchy {
            Hierarchy::City(city, burns) => {
                Ok(burning(tree::city::keys(city, self.world.origin, levels).1, burns))
            }
            Hierarchy::Paths(paths) => Ok(paths.clone()),
            Hierarchy::None => Err(SuiteError::Usage(format!(
                "scene {} has no hierarchy: knob `tree` = city does not apply to it",
                self.facts.scene
            ))),
        }
    }

    /// Truth and result of the last frame as pictures. The truth of the whole image is summed up in
    /// f32, once.
    ///
    /// # Errors
    /// The technique's.
    pub fn picture(&self, radiance: &[Vec3]) -> Result<Picture, SuiteError> {
        let last = self.world.frames.len() - 1;
        let Frame { width, height, .. } = self.world.frames[last];
        if self.whole.get().is_none() {
            let none = Arc::new(LightTree::default());
            let mut all = make(Form::Cpu, &Technique::BruteForce, &self.world, &none, None)?;
            let mut shaded = Shaded::default();
            all.reset(0)?;
            all.shade(last, false)?;
            all.read(&mut shaded)?;
            let _ = self.whole.set(shaded.radiance);
        }
        let truth = self.whole.get().into_iter().flatten().copied().map(picture::grey).collect();
        let result = radiance.iter().copied().map(picture::grey).collect();
        Ok(Picture { width, height, truth, result })
    }
}

/// What every pixel's centre shows, by rays.
pub fn frame(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    [width, height]: [u32; 2],
    origin: DVec3,
) -> Frame {
    let aspect = f64::from(width) / f64::from(height);
    let point = |pixel: u32| {
        let x = (f64::from(pixel % width) + 0.5) / f64::from(width);
        let y = (f64::from(pixel / width) + 0.5) / f64::from(height);
        let (from, direction) = camera.ray(x, y, aspect);
        let ray = Ray::new(from, direction);
        let Some(hit) = tracer.closest(&ray) else { return Point::nothing() };
        let surface = tracer.surface(&ray, &hit);
        let albedo = scene.materials.get(surface.material as usize).map_or(Vec3::ONE, |m| m.albedo);
        Point {
            position: (surface.position - origin).as_vec3(),
            object: surface.instance,
            normal: surface.normal.as_vec3(),
            albedo,
            ..Point::default()
        }
    };
    let points = (0..width * height).into_par_iter().map(point).collect();
    Frame { width, height, eye: Eye::new(camera, origin, aspect), points }
}

impl Prepared for LightsCase<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        Ok(Box::new(subject::LightsSubject::new(self, setting)?))
    }
}
