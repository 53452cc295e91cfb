//! A prepared case: objects, a camera path, what each frame shows by rays, and what each form draws
//! when it draws everything.

use super::{
    drawer, picture, subject,
    truth::{NOTHING, Truth},
};
use crate::{
    SuiteError,
    case::Case,
    city::{self, Loaded},
    knob::Get,
    problem::{Facts, Form, Picture, Prepared, Setting, Subject},
};
use dapple_gpu::Gpu;
use dapple_occlusion::camera::{Bounds, Image, Objects, Tree, View, city_keys, masked::InnerBox};
use dapple_scene::{
    Aabb, Camera,
    city::{Building, City},
};
use dapple_trace::Tracer;
use glam::DVec3;
use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    rc::Rc,
    sync::Arc,
};

/// Distance of the near plane over the scene's radius.
pub(super) const NEAR: f64 = 1e-4;

/// A path through a scene, as the truth is traced along it.
pub struct Frames<'a> {
    /// One a frame.
    pub cameras: &'a [Camera],
    /// One a frame.
    pub views: &'a [View],
    /// Columns and rows.
    pub size: [u32; 2],
    /// Rays of the finer grid a side of a pixel.
    pub samples: u32,
    /// Object of each placed triangle, and its index there.
    pub owners: &'a [[u32; 2]],
}

/// Objects seen along a path, with the truth of every frame.
pub struct VisibilityCase<'g> {
    gpu: Option<&'g Gpu>,
    facts: Facts,
    objects: Arc<Objects>,
    owners: Vec<[u32; 2]>,
    /// Path of each object through the city's hierarchy, where there is one.
    keys: Option<Vec<Vec<u32>>>,
    /// Boxes that lie inside buildings.
    inner: Option<Vec<InnerBox>>,
    views: Vec<View>,
    size: [u32; 2],
    seed: u64,
    truth: Truth,
    trees: RefCell<BTreeMap<String, Rc<Tree>>>,
    /// What forms show of the path, from its start, when they draw everything.
    everything: RefCell<BTreeMap<Form, Rc<Vec<Image>>>>,
    device: OnceCell<Rc<dapple_occlusion::camera::gpu::Scene>>,
}

impl<'g> VisibilityCase<'g> {
    /// Loads the scene and traces the path (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, or an unknown view.
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        Self::of(city::load(&case.scene, case.seed, &case.parameters)?, case, gpu)
    }

    /// The same for a scene at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`VisibilityCase::prepare`].
    pub fn of(loaded: Loaded, case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let Loaded { scene, city, hash, mut notes } = loaded;
        let parameters = &case.parameters;
        let width = parameters.int("width")? as u32;
        let size = [width, (width * 9 / 16).max(1)];
        let samples = parameters.int("truth_samples")? as u32;
        let most = parameters.int("object_triangles")? as u32;
        let (view, cameras) = city::cameras(&scene, &case.view, parameters.int("frames")? as u32)?;
        let (objects, owners) = Objects::from_scene(&scene, most)?;
        let near_m = NEAR * scene.bounds().radius();
        let views = cameras
            .iter()
            .map(|camera| View::new(camera, &objects, size[0], size[1], near_m))
            .collect::<Result<Vec<_>, _>>()?;
        let tracer = Tracer::build(&scene)?;
        let frames = Frames { cameras: &cameras, views: &views, size, samples, owners: &owners };
        let key =
            format!("{hash} {cameras:?} {size:?} near {near_m:?} samples {samples} most {most}");
        let truth = Truth::of(&key, &tracer, &frames)?;
        let seen = truth.frames.iter().map(Vec::len).max().unwrap_or(0);
        if seen == 0 {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {view}: no frame shows anything",
                scene.name
            )));
        }
        notes.push(format!(
            "{} objects of {} triangles ({} bytes); {} are seen along the path, at most {seen} in a \
             frame",
            objects.objects.len(),
            scene.triangle_count(),
            objects.bytes(),
            truth.ever()
        ));
        let keys = city.as_ref().map(|(_, parts)| city_keys(parts, &scene, &owners, &objects));
        let inner = city.as_ref().map(|(city, _)| inner_boxes(city, objects.origin));
        let facts = Facts {
            scene: scene.name.clone(),
            scene_hash: hash,
            view,
            size: format!("{}x{}, {} frames", size[0], size[1], views.len()),
            truth: format!("item buffer: a ray at each centre and {samples}x{samples} a pixel"),
            notes,
        };
        Ok(Self {
            gpu,
            facts,
            objects: Arc::new(objects),
            owners,
            keys,
            inner,
            views,
            size,
            seed: case.seed,
            truth,
            trees: RefCell::default(),
            everything: RefCell::default(),
            device: OnceCell::new(),
        })
    }

    /// What may be drawn.
    pub fn objects(&self) -> &Objects {
        &self.objects
    }

    /// The same, to be shared.
    pub fn shared_objects(&self) -> &Arc<Objects> {
        &self.objects
    }

    /// Boxes inscribed in buildings; `None` for a scene that is no city.
    pub fn inner(&self) -> Option<&[InnerBox]> {
        self.inner.as_deref()
    }

    /// The scene's name.
    pub fn scene(&self) -> &str {
        &self.facts.scene
    }

    /// One a frame.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Seed of what techniques do by chance.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What every frame shows.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The hierarchy of that name, made once.
    ///
    /// # Errors
    /// The city's hierarchy of a scene that is no city.
    pub fn tree(&self, name: &str) -> Result<Rc<Tree>, SuiteError> {
        let kind = match (name, &self.keys) {
            ("auto", Some(_)) => "city",
            ("auto", None) => "bottom-up",
            (other, _) => other,
        };
        if let Some(tree) = self.trees.borrow().get(kind) {
            return Ok(Rc::clone(tree));
        }
        let tree = Rc::new(match (kind, &self.keys) {
            ("city", Some(keys)) => Tree::by_keys(&self.objects, keys)?,
            ("city", None) => {
                return Err(SuiteError::Usage(format!(
                    "scene {} is no city: knob `tree` = city does not apply to it",
                    self.facts.scene
                )));
            }
            _ => Tree::bottom_up(&self.objects)?,
        });
        self.trees.borrow_mut().insert(kind.into(), Rc::clone(&tree));
        Ok(tree)
    }

    /// What a form shows when it draws everything, frame by frame; drawn once.
    ///
    /// # Errors
    /// The renderer's.
    pub fn everything(&self, form: Form) -> Result<Rc<Vec<Image>>, SuiteError> {
        self.everything_at_start(form, self.views.len())
    }

    /// The same for the path's first frames, so many at least where the path has them.
    ///
    /// # Errors
    /// The renderer's.
    pub fn everything_at_start(
        &self,
        form: Form,
        frames: usize,
    ) -> Result<Rc<Vec<Image>>, SuiteError> {
        let frames = frames.min(self.views.len());
        let drawn = self.everything.borrow().get(&form).map(Rc::clone);
        if let Some(images) = drawn.filter(|images| images.len() >= frames) {
            return Ok(images);
        }
        let images = Rc::new(drawer::everything(self, form, frames)?);
        self.everything.borrow_mut().insert(form, Rc::clone(&images));
        Ok(images)
    }

    /// The device, and the objects on it, uploaded once.
    ///
    /// # Errors
    /// No device, or one that is too small.
    pub fn device(
        &self,
    ) -> Result<(&'g Gpu, Rc<dapple_occlusion::camera::gpu::Scene>), SuiteError> {
        let gpu = self.gpu.ok_or_else(|| SuiteError::Internal("no graphics device".into()))?;
        if let Some(scene) = self.device.get() {
            return Ok((gpu, Rc::clone(scene)));
        }
        let scene = Rc::new(dapple_occlusion::camera::gpu::Scene::new(gpu, &self.objects)?);
        Ok((gpu, Rc::clone(self.device.get_or_init(|| scene))))
    }

    /// Truth and result of the last frame as pictures.
    pub fn picture(&self, image: &Image) -> Picture {
        let [width, height] = self.size;
        let truth = self.truth.last.iter().map(|triangle| {
            if *triangle == NOTHING {
                return picture::SKY;
            }
            let [object, within] = self.owners[*triangle as usize];
            picture::shade(&self.objects, object, within)
        });
        let result = image.ids.iter().map(|[object, triangle]| match object.checked_sub(1) {
            Some(object) => picture::shade(&self.objects, object, *triangle),
            None => picture::SKY,
        });
        Picture { width, height, truth: truth.collect(), result: result.collect() }
    }
}

/// The boxes inscribed in a city's buildings, relative to `origin`.
pub fn inner_boxes(city: &City, origin: DVec3) -> Vec<InnerBox> {
    let local = |p: DVec3| (p - origin).as_vec3();
    let of = |building: &Building| {
        let Aabb { min, max } = building.outer;
        let solid = Bounds { min: local(min), max: local(max) };
        let inner = building.inner.iter();
        inner.map(move |b| InnerBox { corners: b.corners().map(local), solid }).collect::<Vec<_>>()
    };
    city.buildings.iter().flat_map(of).collect()
}

impl Prepared for VisibilityCase<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        subject::of(self, setting)
    }
}
