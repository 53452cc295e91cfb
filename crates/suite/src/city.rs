//! Scenes that may be cities: generated as parameters ask, or read from files; and paths through them.

use crate::{
    SuiteError,
    case::{self, Source},
    knob::{Get, Knob, Knobs},
    scene as complete,
};
use dapple_scene::{
    Camera, CameraPath, Scene,
    city::{self, City, Part},
    generate, import,
};
use std::path::Path;

/// Generated cities: blocks a side.
pub const BLOCKS: Knob =
    Knob::int("blocks", [0, 0, 24], "generated cities: blocks a side; 0: the scene's own");
/// Generated cities: heights of buildings.
pub const HEIGHTS: Knob = Knob::choice(
    "heights",
    &["scene", "varied", "independent", "seven"],
    "generated cities: the scene's, 1 to 7 storeys alike in each block, by chance, or 7",
);
/// Generated cities: how blocks lie.
pub const LAYOUT: Knob = Knob::choice(
    "layout",
    &["scene", "brick", "grid"],
    "generated cities: the scene's, alternate rows moved by half a block, or not",
);
/// Generated cities: empty lots.
pub const EMPTY: Knob =
    Knob::float("empty", [0.0, 0.0, 0.5], "generated cities: share of empty lots");
/// Generated cities: streets.
pub const STREET: Knob =
    Knob::float("street", [0.0, 0.0, 30.0], "generated cities: width of streets; 0: the scene's")
        .unit("m");

/// A scene, and what is known of it as a city.
pub struct Loaded {
    /// One instance an object, for cities.
    pub scene: Scene,
    /// The city, where it is one, and the part that each instance is.
    pub city: Option<(City, Vec<Part>)>,
    /// Identity of the scene.
    pub hash: String,
    /// What was added, changed or left out.
    pub notes: Vec<String>,
}

/// Loads or generates a scene; a generated city as its parameters ask.
///
/// # Errors
/// An unknown name, a file that cannot be used, or a city's parameter for a scene that is none.
pub fn load(name: &str, seed: u64, parameters: &Knobs) -> Result<Loaded, SuiteError> {
    let mut notes = Vec::new();
    let (city, mut scene) = match case::source(name)? {
        Source::MissingData(path) => return Err(case::missing_data(&path)),
        Source::Generated(name) => match generate::city_knobs(&name) {
            Some(knobs) => {
                let mut city = city::generate(&asked(knobs, parameters)?, seed)?;
                city.name.clone_from(&name);
                (Some(city), None)
            }
            None => {
                let known = generate::NAMES.iter().map(|(name, _)| *name);
                let scene = generate::by_name(&name, seed)
                    .ok_or_else(|| SuiteError::unknown("scene", &name, known))?;
                (None, Some(scene))
            }
        },
        Source::File(path) if is_city(&path) => {
            let loaded = city::load(&path)?;
            notes.extend(loaded.warnings);
            notes.push(loaded.city.projection.clone());
            (Some(loaded.city), None)
        }
        Source::File(path) => {
            let loaded = import::load(&path)?;
            notes.extend(loaded.warnings);
            (None, Some(loaded.scene))
        }
    };
    if !matches!(case::source(name)?, Source::Generated(n) if generate::city_knobs(&n).is_some()) {
        refuse_parameters(name, parameters)?;
    }
    let mut parts = None;
    if let Some(city) = &city {
        let made = city.scene();
        scene = Some(made.scene);
        parts = Some(made.parts);
    }
    let mut scene = scene.ok_or_else(|| SuiteError::Internal("no scene was made".into()))?;
    scene.validate()?;
    notes.extend(scene.add_defaults().into_iter().filter(|note| !note.contains("light")));
    scene.validate()?;
    let hash = scene.hash();
    Ok(Loaded { scene, city: city.zip(parts), hash, notes })
}

fn is_city(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    matches!(extension.as_str(), "json" | "pbf")
}

/// The generator's knobs with what the parameters change.
fn asked(mut knobs: city::Knobs, parameters: &Knobs) -> Result<city::Knobs, SuiteError> {
    let blocks = parameters.int("blocks")? as u32;
    if blocks > 0 {
        (knobs.blocks_x, knobs.blocks_z) = (blocks, blocks);
    }
    match parameters.word("heights")? {
        "varied" => knobs.heights = city::Heights::Stratified { least: 1, most: 7 },
        "independent" => knobs.heights = city::Heights::Independent { least: 1, most: 7 },
        "seven" => knobs.heights = city::Heights::Fixed(7),
        _ => {}
    }
    match parameters.word("layout")? {
        "brick" => knobs.brick_offset = true,
        "grid" => knobs.brick_offset = false,
        _ => {}
    }
    let empty = parameters.float("empty")?;
    if empty > 0.0 {
        knobs.empty_lots = empty;
    }
    let street = parameters.float("street")?;
    if street > 0.0 {
        knobs.street_m = street;
    }
    Ok(knobs)
}

/// Refuses the parameters of generated cities for a scene that is none.
///
/// # Errors
/// [`SuiteError::Usage`] that names the parameter.
pub fn refuse_parameters(name: &str, parameters: &Knobs) -> Result<(), SuiteError> {
    let asked = [
        ("blocks", parameters.int("blocks")? != 0),
        ("heights", parameters.word("heights")? != "scene"),
        ("layout", parameters.word("layout")? != "scene"),
        ("empty", parameters.float("empty")? != 0.0),
        ("street", parameters.float("street")? != 0.0),
    ];
    match asked.into_iter().find(|(_, asked)| *asked) {
        Some((parameter, _)) => Err(SuiteError::Usage(format!(
            "scene {name} is not a generated city: parameter `{parameter}` does not apply to it"
        ))),
        None => Ok(()),
    }
}

/// The first `frames` cameras of a view: a path of that name (the first path for an empty one), or a
/// still view repeated. A path shorter than that ends earlier.
///
/// # Errors
/// As [`complete::camera`], naming paths too.
pub fn cameras(
    scene: &Scene,
    view: &str,
    frames: u32,
) -> Result<(String, Vec<Camera>), SuiteError> {
    let named = |path: &&CameraPath| path.name == view || view.is_empty();
    if let Some(path) = scene.paths.iter().find(named) {
        let count = frames.min(path.frames);
        let cameras = (0..count).filter_map(|i| path.camera(i)).collect();
        return Ok((path.name.clone(), cameras));
    }
    let camera = complete::camera(scene, view).map_err(|error| match error {
        SuiteError::Unknown { what, name, known } => {
            let paths: Vec<&str> = scene.paths.iter().map(|p| p.name.as_str()).collect();
            SuiteError::Unknown { what, name, known: format!("{}, {known}", paths.join(", ")) }
        }
        other => other,
    })?;
    Ok((camera.name.clone(), vec![camera; frames as usize]))
}
