//! A prepared case: a city, what its frames show, and what some pixels should show.

use super::{method::Method, settings, subject};
use crate::{
    SuiteError,
    case::Case,
    knob::Get,
    night::Night,
    problem::{Facts, Form, Picture, Prepared, Setting, Subject},
    problems::many_lights::{picture::grey, truth::Truth},
};
use dapple_gpu::Gpu;
use dapple_many_lights::{LightTree, Shaded, Technique, make};
use dapple_night_city::Device;
use glam::Vec3;
use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    sync::Arc,
};

/// A city's frames at night, with the truth of each.
pub struct NightCase<'g> {
    gpu: Option<&'g Gpu>,
    facts: Facts,
    night: Night,
    truth: Truth,
    seed: u64,
    /// By whether shadow rays are cast on the device.
    devices: RefCell<BTreeMap<bool, Device<'g>>>,
    whole: OnceCell<Vec<Vec3>>,
}

impl<'g> NightCase<'g> {
    /// Loads the city and sums up the truth (cached between runs).
    ///
    /// # Errors
    /// A scene that cannot be used, or an unknown view.
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        Self::of(Night::load(case)?, case, gpu)
    }

    /// The same for a city at hand; of `case`, its scene's name is not used.
    ///
    /// # Errors
    /// As [`NightCase::prepare`].
    pub fn of(night: Night, case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let most = case.parameters.int("truth_pixels")? as usize;
        let world = night.town.world(true);
        let truth = Truth::of(&format!("night-city {}", night.key), world, most, case.seed);
        let mut notes = night.notes.clone();
        notes.push(format!("truth at {} pixels of {} frames", truth.pixels(), world.frames.len()));
        let facts = Facts {
            scene: night.scene.clone(),
            scene_hash: night.hash.clone(),
            view: night.view.clone(),
            size: format!("{}x{}, {} frames", night.size[0], night.size[1], world.frames.len()),
            truth: format!(
                "sum over {} lights in f64 with shadow rays, at most {most} pixels a frame",
                world.lights.len()
            ),
            notes,
        };
        Ok(Self {
            gpu,
            facts,
            night,
            truth,
            seed: case.seed,
            devices: RefCell::default(),
            whole: OnceCell::new(),
        })
    }

    /// The city.
    pub fn night(&self) -> &Night {
        &self.night
    }

    /// What pixels should show.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Seed of what techniques do by chance.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// A technique made ready for this case.
    ///
    /// # Errors
    /// Settings that are refused, or a device that is too small.
    pub fn method(&self, setting: &Setting) -> Result<Method<'g>, SuiteError> {
        let night = settings::night(setting, self.seed)?;
        let device = match setting.form {
            Form::Gpu => Some(self.device(night.shadow_rays)?),
            Form::Cpu | Form::Reference => None,
        };
        Method::new(self, setting, &night, device.as_ref())
    }

    /// The device, with points, lights and objects on it, uploaded once.
    fn device(&self, shadows: bool) -> Result<Device<'g>, SuiteError> {
        let gpu = self.gpu.ok_or_else(|| SuiteError::Internal("no graphics device".into()))?;
        if let Some(device) = self.devices.borrow().get(&shadows) {
            return Ok(device.clone());
        }
        let town = &self.night.town;
        let device = Device::new(gpu, town.world(shadows))?.drawing(&town.objects)?;
        self.devices.borrow_mut().insert(shadows, device.clone());
        Ok(device)
    }

    /// Truth and result of the last frame as pictures. The truth of the whole image is summed up in
    /// f32, once.
    ///
    /// # Errors
    /// The technique's.
    pub fn picture(&self, radiance: &[Vec3]) -> Result<Picture, SuiteError> {
        let world = self.night.town.world(true);
        let last = world.frames.len() - 1;
        if self.whole.get().is_none() {
            let none = Arc::new(LightTree::default());
            let form = dapple_many_lights::Form::Cpu;
            let mut all = make(form, &Technique::BruteForce, world, &none, None)?;
            let mut shaded = Shaded::default();
            all.reset(0)?;
            all.shade(last, false)?;
            all.read(&mut shaded)?;
            let _ = self.whole.set(shaded.radiance);
        }
        let [width, height] = self.night.size;
        let truth = self.whole.get().into_iter().flatten().copied().map(grey).collect();
        let result = radiance.iter().copied().map(grey).collect();
        Ok(Picture { width, height, truth, result })
    }
}

impl Prepared for NightCase<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        Ok(Box::new(subject::NightSubject::new(self, setting)?))
    }
}
