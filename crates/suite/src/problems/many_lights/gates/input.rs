//! Random worlds of lights, settings of techniques, and frames of any form.

pub use crate::verify::{default_setting, rng};

use crate::{
    SuiteError,
    knob::Knob,
    problem::{Form, Setting, Technique},
    problems::many_lights::{
        SPEC,
        settings::{self, TreeKind},
    },
    verify::{GateContext, anywhere},
};
use dapple_gpu::Gpu;
use dapple_many_lights::{
    Emission, LightTree, Lighting, Point, Shaded, World,
    gpu::Scene,
    make,
    tree::{self, Build},
    worlds::{Cloud, WINDOW, cloud},
};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;
use serde_json::Value;
use std::{f64::consts::PI, sync::Arc};

/// Every kind of emission, spots that light all sides among them.
pub const EMISSIONS: [Emission; 5] = [
    Emission::Omni,
    Emission::Oriented,
    WINDOW,
    Emission::Directional,
    Emission::Spot { half_angle_rad: PI },
];

/// Cases of a control: it has to be caught at once.
const CONTROLS: u32 = 2;

/// Greatest settings that are drawn here: what costs a pixel more time tells nothing more.
const MOST: i64 = 32;

/// Number of cases: at most `most`, a control's fewer.
pub fn cases(context: &GateContext<'_>, most: u32, faulty: bool) -> u32 {
    context.cases.min(if faulty { CONTROLS.min(most) } else { most })
}

/// World `number` of a seed: walls and ground, up to 60 lights of one kind or of all, some in one
/// place, some dark, two frames of a size that rarely fills its tiles.
pub fn world(seed: u64, number: u32) -> World {
    let mut rng = rng(seed, "world", number);
    let emissions = match number % 3 {
        0 => EMISSIONS.to_vec(),
        _ => vec![EMISSIONS[rng.random_range(0..EMISSIONS.len())]],
    };
    let mut made = cloud(&Cloud {
        lights: rng.random_range(20..60),
        emissions,
        seed: rng.random(),
        size: [rng.random_range(9..24), rng.random_range(9..20)],
        frames: 2,
        origin: DVec3::ZERO,
    });
    let lights = &mut made.world.lights;
    let count = lights.len();
    for (index, at) in [(1, 2), (3, 2), (4, 5)] {
        lights[index % count].position = lights[at % count].position;
    }
    lights[5 % count].axis = -lights[4 % count].axis;
    lights[6 % count].intensity = DVec3::ZERO;
    made.world
}

/// The same with shadows in every other world.
///
/// # Errors
/// None for these worlds.
pub fn world_in_shadow(seed: u64, number: u32) -> Result<World, SuiteError> {
    let world = world(seed, number);
    if number.is_multiple_of(2) {
        return Ok(world);
    }
    // Walls stand where they stand in every cloud.
    let shadows = cloud(&Cloud { lights: 0, size: [1, 1], ..Cloud::default() }).with_shadows()?;
    Ok(World { occluders: shadows.occluders, ..world })
}

/// A world with what techniques are made ready from beside it.
pub struct Given<'g> {
    /// Lights and frames.
    pub world: Arc<World>,
    /// Of all random numbers.
    pub seed: u64,
    /// On the device.
    pub scene: Option<Arc<Scene<'g>>>,
}

impl<'g> Given<'g> {
    /// A world, on a device too if there is one.
    ///
    /// # Errors
    /// A device that is too small.
    pub fn new(world: World, seed: u64, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let world = Arc::new(world);
        let scene = match gpu {
            Some(gpu) => Some(Arc::new(Scene::new(gpu, &world)?)),
            None => None,
        };
        Ok(Self { world, seed, scene })
    }

    /// The tree that a setting asks for; a hierarchy is made of random paths.
    ///
    /// # Errors
    /// Lights that are refused.
    pub fn tree(&self, setting: &Setting) -> Result<Arc<LightTree>, SuiteError> {
        let lights = &self.world.lights;
        let technique = settings::technique(setting)?;
        let (kind, representative) = settings::tree(&technique, setting, true, self.seed)?;
        Ok(Arc::new(match kind {
            TreeKind::None => LightTree::default(),
            TreeKind::Of(build) => LightTree::build(lights, build, representative)?,
            TreeKind::Hierarchy { fanout, .. } => {
                let mut paths = paths(&mut rng(self.seed, "paths", 0), lights.len());
                if fanout > 0 {
                    paths = tree::city::limited(lights, &paths, fanout)?;
                }
                LightTree::build(lights, Build::Keys(&paths), representative)?
            }
        }))
    }

    /// A technique made ready.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn lighting(&self, setting: &Setting) -> Result<Box<dyn Lighting + 'g>, SuiteError> {
        let technique = settings::technique(setting)?;
        let (form, tree) = (settings::form(setting.form), self.tree(setting)?);
        Ok(make(form, &technique, &self.world, &tree, self.scene.as_ref())?)
    }

    /// All frames from a reset, counted.
    ///
    /// # Errors
    /// As [`Given::lighting`].
    pub fn frames(&self, setting: &Setting, seed: u32) -> Result<Vec<Shaded>, SuiteError> {
        let mut lighting = self.lighting(setting)?;
        frames(&mut *lighting, 0..self.world.frames.len(), seed, true)
    }
}

/// Some frames from a reset.
///
/// # Errors
/// The technique's.
pub fn frames(
    lighting: &mut dyn Lighting,
    which: std::ops::Range<usize>,
    seed: u32,
    count: bool,
) -> Result<Vec<Shaded>, SuiteError> {
    lighting.reset(seed)?;
    let mut all = Vec::new();
    for frame in which {
        lighting.shade(frame, count)?;
        let mut shaded = Shaded::default();
        lighting.read(&mut shaded)?;
        all.push(shaded);
    }
    Ok(all)
}

/// What every pixel of a frame should show, by the definition.
pub fn truth(world: &World, frame: usize) -> Vec<DVec3> {
    let one = |point: &Point| if point.is_there() { world.truth(point) } else { DVec3::ZERO };
    world.frames[frame].points.iter().map(one).collect()
}

/// A path a light through a hierarchy of up to four levels.
pub fn paths(rng: &mut Pcg64, lights: usize) -> Vec<Vec<u32>> {
    let path = |_| (0..rng.random_range(0..5)).map(|_| rng.random_range(0..3)).collect();
    (0..lights).map(path).collect()
}

/// A setting of a technique's variant: every knob anywhere in its useful range.
pub fn setting(rng: &mut Pcg64, technique: &Technique, variant: &str, form: Form) -> Setting {
    let mut value = |knob: &Knob| {
        let value = anywhere(rng, knob);
        match knob.name {
            "samples" | "cut" | "candidates" | "slices" | "history" => {
                value.as_i64().unwrap_or(1).min(MOST).into()
            }
            _ => value,
        }
    };
    let knobs = technique.knobs.iter().map(|knob| (knob.name.to_string(), value(knob))).collect();
    Setting { technique: technique.id.into(), variant: variant.into(), form, knobs }
}

/// The same, but for the knobs given.
///
/// # Errors
/// A value that a knob does not take.
pub fn setting_with(
    rng: &mut Pcg64,
    technique: &Technique,
    variant: &str,
    form: Form,
    given: &[(&str, Value)],
) -> Result<Setting, SuiteError> {
    let mut setting = setting(rng, technique, variant, form);
    for (name, value) in given {
        setting.knobs.insert((*name).into(), value.clone());
    }
    SPEC.check(&setting)?;
    Ok(setting)
}
