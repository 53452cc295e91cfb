//! From a scene's name to lights and the surfaces that they light.

use crate::{
    SuiteError,
    case::{self, Case, Source},
    city::{self, Loaded},
    knob::{Get, Knobs},
    scene,
};
use dapple_many_lights::{
    Emission, Light, World,
    sample::Random,
    tree::city::{Levels, keys},
    worlds::{self, Cloud, Facade, WINDOW},
};
use dapple_scene::{Aabb, Scene, city::City};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI};

/// Scenes that the problem makes itself, each with one line.
pub const OWN: &[(&str, &str)] = &[
    ("light_cloud", "random lights between walls; parameter `lights`, else 1,000"),
    ("light_facade", "a wall lit by the windows opposite: what R3 makes disks of"),
];

/// Lights of `light_cloud` where none are asked for.
const CLOUD: u32 = 1000;

/// Samples a side of a light that has an area.
const AREA_SAMPLES: u32 = 4;

/// Surfaces and the lights that light them.
pub struct Input {
    /// Surfaces, cameras, paths.
    pub scene: Scene,
    /// Positions relative to `origin`.
    pub lights: Vec<Light>,
    /// World space.
    pub origin: DVec3,
    /// Path of each light through a hierarchy, where the scene has one.
    pub hierarchy: Hierarchy,
    /// Identity of scene and lights' makings, parameters aside.
    pub hash: String,
    /// What was added, changed or left out.
    pub notes: Vec<String>,
}

/// What is known of how lights belong together.
pub enum Hierarchy {
    /// Nothing.
    None,
    /// A city's, and which of its lights burn: of windows, then lamps.
    City(Box<City>, Vec<bool>),
    /// A path a light.
    Paths(Vec<Vec<u32>>),
}

/// Loads or generates what a case names.
///
/// # Errors
/// An unknown name, a file that cannot be used, parameters that do not apply, or no light at all.
pub fn load(case: &Case) -> Result<Input, SuiteError> {
    let parameters = &case.parameters;
    let mut input = match case::source(&case.scene)? {
        Source::Generated(name) if OWN.iter().any(|(own, _)| *own == name) => own(&name, case)?,
        _ => loaded(city::load(&case.scene, case.seed, parameters)?, case)?,
    };
    if let Some(emission) = emission(parameters.word("emission")?) {
        let count = input.lights.len() as f64;
        for light in &mut input.lights {
            light.emission = emission;
            light.axis = light.axis.try_normalize().unwrap_or(DVec3::NEG_Y);
            if emission == Emission::Directional {
                // An intensity of metres away would be a thousand suns as an irradiance.
                light.intensity /= count;
            }
        }
    }
    if input.lights.is_empty() {
        return Err(SuiteError::Usage(format!("scene {}: no light burns", case.scene)));
    }
    Ok(input)
}

fn emission(word: &str) -> Option<Emission> {
    match word {
        "omni" => Some(Emission::Omni),
        "oriented" => Some(Emission::Oriented),
        "spot" => Some(Emission::Spot { half_angle_rad: FRAC_PI_4 }),
        "directional" => Some(Emission::Directional),
        _ => None,
    }
}

fn loaded(loaded: Loaded, case: &Case) -> Result<Input, SuiteError> {
    let Loaded { scene, city, hash, mut notes } = loaded;
    let parameters = &case.parameters;
    let origin = scene.bounds().centre();
    let lights = parameters.int("lights")? as u32;
    let (lights, hierarchy) = match city {
        Some((city, _)) => {
            if lights > 0 {
                return Err(SuiteError::Usage(format!(
                    "scene {} is a city with lights of its own: parameter `lights` does not apply to \
                     it",
                    case.scene
                )));
            }
            let lit = parameters.word("lit")?;
            let windows = std::iter::repeat_n(lit != "lamps", city.lights.len());
            let lamps = std::iter::repeat_n(lit != "windows", city.lamps.len());
            let burns: Vec<bool> = windows.chain(lamps).collect();
            let lights = burning(keys(&city, origin, Levels::default()).0, &burns);
            (lights, Hierarchy::City(Box::new(city), burns))
        }
        None if parameters.word("lit")? != "all" => {
            return Err(SuiteError::Usage(format!(
                "scene {} is no city: parameter `lit` does not apply to it",
                case.scene
            )));
        }
        None if lights > 0 => {
            notes.push(format!("{lights} random lights in and around it, instead of its own"));
            (random(&scene.bounds(), origin, lights, case.seed), Hierarchy::None)
        }
        None => {
            notes.push(
                "the scene's own lights, each as strong as lights the scene's middle well".into(),
            );
            (of_scene(&scene, origin), Hierarchy::None)
        }
    };
    Ok(Input { scene, lights, origin, hierarchy, hash, notes })
}

/// Those of a city's lights (or their paths), windows before lamps, that burn.
pub fn burning<T>(all: Vec<T>, burns: &[bool]) -> Vec<T> {
    all.into_iter().zip(burns).filter(|(_, burns)| **burns).map(|(light, _)| light).collect()
}

/// Intensity at which `count` lights spread over a scene of that radius light its middle well: an
/// albedo of 0.5 to about 0.3.
fn strength(bounds: &Aabb, count: f64) -> f64 {
    let radius = bounds.radius();
    4.0 * radius * radius / count
}

/// Omni and spot lights in turn, in a box half as large again as the scene's.
fn random(bounds: &Aabb, origin: DVec3, count: u32, seed: u64) -> Vec<Light> {
    let half = 0.75 * (bounds.max - bounds.min);
    let strength = strength(bounds, f64::from(count));
    let light = |index: u32| {
        let mut random = Random::new(seed as u32, (seed >> 32) as u32, index);
        let mut signed = || 2.0 * f64::from(random.unit()) - 1.0;
        let position = bounds.centre() - origin + half * DVec3::new(signed(), signed(), signed());
        let axis = DVec3::new(signed(), signed(), signed());
        let colour = DVec3::new(signed(), signed(), signed()) * 0.25 + 0.75;
        let spot = index % 2 == 1;
        Light {
            position,
            axis: axis.try_normalize().unwrap_or(DVec3::NEG_Y),
            intensity: colour * (strength * (1.0 + 0.5 * signed())),
            emission: if spot { WINDOW } else { Emission::Omni },
        }
    };
    (0..count).map(light).collect()
}

/// The scene's own lights; one with an area as a grid of small patches on both sides.
fn of_scene(scene: &Scene, origin: DVec3) -> Vec<Light> {
    let unit = |v: DVec3| v.try_normalize().unwrap_or(DVec3::NEG_Y);
    let strong = DVec3::splat(strength(&scene.bounds(), 1.0));
    let mut lights = Vec::new();
    for light in &scene.lights {
        match *light {
            dapple_scene::Light::Directional { direction } => lights.push(Light {
                position: DVec3::ZERO,
                axis: unit(direction),
                intensity: DVec3::splat(PI),
                emission: Emission::Directional,
            }),
            dapple_scene::Light::Spot { position, direction, half_angle_rad } => {
                lights.push(Light {
                    position: position - origin,
                    axis: unit(direction),
                    intensity: strong,
                    emission: Emission::Spot { half_angle_rad },
                })
            }
            dapple_scene::Light::Area { centre, half_u, half_v } => {
                let normal = unit(half_u.cross(half_v));
                let cells = AREA_SAMPLES * AREA_SAMPLES;
                let middle = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(AREA_SAMPLES) - 1.0;
                for cell in 0..cells {
                    let at =
                        half_u * middle(cell % AREA_SAMPLES) + half_v * middle(cell / AREA_SAMPLES);
                    lights.extend([normal, -normal].map(|axis| Light {
                        position: centre - origin + at,
                        axis,
                        intensity: strong / f64::from(cells),
                        emission: Emission::Oriented,
                    }));
                }
            }
        }
    }
    lights
}

fn own(name: &str, case: &Case) -> Result<Input, SuiteError> {
    let parameters = &case.parameters;
    refuse_city(name, parameters)?;
    let size = [64, 36];
    let (made, hierarchy) = if name == "light_cloud" {
        let asked = parameters.int("lights")? as u32;
        let lights = if asked == 0 { CLOUD } else { asked };
        let emissions = vec![Emission::Omni, Emission::Oriented, WINDOW];
        let frames = parameters.int("frames")? as u32;
        let seed = case.seed as u32;
        let cloud = Cloud { lights, emissions, seed, size, frames, origin: DVec3::ZERO };
        (worlds::cloud(&cloud), Hierarchy::None)
    } else {
        if parameters.int("lights")? > 0 {
            return Err(SuiteError::Usage(format!(
                "scene {name} has lights of its own: parameter `lights` does not apply to it"
            )));
        }
        let facade = Facade { storeys: 16, windows: 24, distance_m: 10.0, emission: WINDOW, size };
        let (made, paths) = worlds::facade(&facade);
        (made, Hierarchy::Paths(paths))
    };
    let World { lights, origin, .. } = made.world;
    let scene = scene::complete(made.scene, Vec::new())?;
    Ok(Input { scene: scene.scene, lights, origin, hierarchy, hash: scene.hash, notes: Vec::new() })
}

fn refuse_city(name: &str, parameters: &Knobs) -> Result<(), SuiteError> {
    city::refuse_parameters(name, parameters)?;
    if parameters.word("lit")? != "all" {
        return Err(SuiteError::Usage(format!(
            "scene {name} is no city: parameter `lit` does not apply to it"
        )));
    }
    Ok(())
}
