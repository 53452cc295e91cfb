//! A city at night, as the problems take it that ask which lights reach what.

use crate::{
    SuiteError,
    case::Case,
    city::{self, Loaded},
    knob::Get,
};
use dapple_many_lights::{
    LightTree, World,
    region::Occluders,
    tree::city::{Levels, keys},
};
use dapple_night_city::{Given, Part, Town, frame};
use dapple_occlusion::camera::{Objects, View, city_keys};
use dapple_scene::city::City;
use dapple_trace::Tracer;
use std::sync::Arc;

/// Instances of more triangles are cut into objects of at most so many: grounds of real cities are large.
const MOST_TRIANGLES: u32 = 128;

/// Distance of the near plane over the scene's radius.
const NEAR: f64 = 1e-4;

/// Surfaces, lights and what hides them, shared by all techniques.
pub struct Night {
    /// The city.
    pub city: City,
    /// What its frames are made from.
    pub town: Arc<Town>,
    /// Name of the scene.
    pub scene: String,
    /// Identity of the scene.
    pub hash: String,
    /// The view's name.
    pub view: String,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Names everything that frames and lights depend on.
    pub key: String,
    /// What was added, changed or left out.
    pub notes: Vec<String>,
}

impl Night {
    /// Loads or generates the city that a case names, and finds what its frames show. Of the case's
    /// parameters, width, frames, clamp and those of cities are used.
    ///
    /// # Errors
    /// A scene that is no city or cannot be used, an unknown view, a city without a light, or frames
    /// that show nothing.
    pub fn load(case: &Case) -> Result<Self, SuiteError> {
        Self::of(city::load(&case.scene, case.seed, &case.parameters)?, case)
    }

    /// The same for a scene at hand.
    ///
    /// # Errors
    /// As [`Night::load`].
    pub fn of(loaded: Loaded, case: &Case) -> Result<Self, SuiteError> {
        let Loaded { scene, city, hash, mut notes } = loaded;
        let Some((city, parts)) = city else {
            return Err(SuiteError::Usage(format!(
                "scene {} is no city: it has no buildings whose windows could be lit",
                case.scene
            )));
        };
        let parameters = &case.parameters;
        let width = parameters.int("width")? as u32;
        let size = [width, (width * 3 / 4).max(1)];
        let (view, cameras) = city::cameras(&scene, &case.view, parameters.int("frames")? as u32)?;
        let (objects, owners) = Objects::from_scene(&scene, MOST_TRIANGLES)?;
        let near_m = NEAR * scene.bounds().radius();
        let views = cameras
            .iter()
            .map(|camera| View::new(camera, &objects, size[0], size[1], near_m))
            .collect::<Result<Vec<_>, _>>()?;
        let tracer = Arc::new(Tracer::build(&scene)?);
        let origin = objects.origin;
        let (lights, paths) = keys(&city, origin, Levels::default());
        if lights.is_empty() {
            return Err(SuiteError::Usage(format!("scene {}: no light burns", case.scene)));
        }
        let frames: Vec<_> = cameras
            .iter()
            .map(|camera| frame(&scene, &tracer, &objects, &owners, camera, size))
            .collect();
        if frames.iter().all(|f| f.points.iter().all(|p| !p.is_there())) {
            return Err(SuiteError::Usage(format!(
                "scene {}, view {view}: no frame shows anything",
                scene.name
            )));
        }
        notes.push(format!(
            "{} buildings, {} objects, {} lights",
            city.buildings.len(),
            objects.objects.len(),
            lights.len()
        ));
        let clamp_m = parameters.float("clamp")?;
        let tree = Arc::new(LightTree::by_keys(&lights, &paths)?);
        let town = Town::new(Given {
            keys: &city_keys(&parts, &scene, &owners, &objects),
            parts: &parts,
            scene: &scene,
            owners: &owners,
            views,
            world: World { origin, lights, frames, clamp_m, occluders: None },
            lights: tree,
            occluders: Arc::new(Occluders::of_city(&city, origin)),
            tracer,
            objects: Arc::new(objects),
        })?;
        Ok(Self {
            city,
            town: Arc::new(town),
            scene: scene.name,
            key: format!("{hash} {cameras:?} {size:?} clamp {clamp_m:?}"),
            hash,
            view,
            size,
            notes,
        })
    }

    /// Pixels of a frame that each object shows at.
    pub fn pixels(&self, frame: usize) -> Vec<u32> {
        let mut pixels = vec![0; self.town.objects.objects.len()];
        for point in &self.town.world(false).frames[frame].points {
            if let Some(count) = pixels.get_mut(point.object as usize).filter(|_| point.is_there())
            {
                *count += 1;
            }
        }
        pixels
    }
}

/// The smallest cell, by its word.
///
/// # Errors
/// A word that is none.
pub fn part(word: &str) -> Result<Part, SuiteError> {
    match word {
        "any" => Ok(Part::Any),
        "storey" => Ok(Part::Storey),
        "facade" => Ok(Part::Facade),
        "building" => Ok(Part::Building),
        word => Err(SuiteError::unknown(
            "part of a city",
            word,
            ["any", "storey", "facade", "building"],
        )),
    }
}
