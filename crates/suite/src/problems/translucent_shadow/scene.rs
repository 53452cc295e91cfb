//! From a scene's name to translucent geometry under one light: which surfaces let light through,
//! and how hair is seen from either side.

use crate::{
    SuiteError,
    case::{self, Source},
    knob::{Get, Knobs},
    scene as complete,
};
use dapple_scene::{Facing, Light, Mesh, Scene, Strands, generate, import};
use glam::DVec3;

/// What is cast and what is seen.
pub struct Loaded {
    /// What the camera sees.
    pub seen: Scene,
    /// What the light meets, where that is not the same.
    pub casters: Option<Scene>,
    /// How far receivers are lifted towards the light, metres: a line of hair has a thickness, and
    /// the ribbon that faces the light is not the one that faces the camera.
    pub lift_m: f64,
    /// Identity of the scene as loaded.
    pub hash: String,
    /// What was added, changed or left out.
    pub notes: Vec<String>,
}

/// How a scene is to be treated.
#[derive(Clone, Debug)]
pub struct Wishes {
    /// `scene`, `above`, `slanted` or `side`.
    pub light: String,
    /// Angle between the light and the vertical in place of `light`, degrees.
    pub degrees: Option<f64>,
    /// Opacity of all translucent surfaces, 0 for the scene's own.
    pub opacity: f32,
    /// `lines` or `ribbons`.
    pub hair: String,
}

impl Wishes {
    /// What a case's parameters ask for.
    ///
    /// # Errors
    /// A parameter that is not there or of another kind.
    pub fn of(parameters: &Knobs) -> Result<Self, SuiteError> {
        Ok(Self {
            light: parameters.word("light")?.into(),
            degrees: None,
            opacity: parameters.float("opacity")? as f32,
            hair: parameters.word("hair")?.into(),
        })
    }
}

/// Loads or generates a scene, completes it and treats it as wished.
///
/// # Errors
/// As [`complete::load`].
pub fn load(name: &str, view: &str, seed: u64, wishes: &Wishes) -> Result<Loaded, SuiteError> {
    let complete::Loaded { scene, hash, notes } = complete::load(name, seed)?;
    let mut loaded = Loaded { seen: scene, casters: None, lift_m: 0.0, hash, notes };
    if let Some(strands) = strands(name, seed)? {
        face(&mut loaded, &strands, view, wishes)?;
    }
    // What casts is the same scene but for its hair: notes are of the one that is seen.
    let (notes, mut unheard) = (&mut loaded.notes, Vec::new());
    let scenes = [(Some(&mut loaded.seen), notes), (loaded.casters.as_mut(), &mut unheard)];
    for (scene, notes) in scenes.into_iter().filter_map(|(s, n)| s.map(|s| (s, n))) {
        turn_light(scene, wishes, notes)?;
        let leaves = leaf_opacity(scene);
        if leaves > 0 {
            notes.push(format!(
                "{leaves} alpha-tested materials are taken as leaves of opacity {:.3}",
                generate::LEAF_OPACITY
            ));
        }
        if wishes.opacity > 0.0 {
            set_opacity(scene, wishes.opacity);
        }
    }
    Ok(loaded)
}

/// That there is something for light to go through.
///
/// # Errors
/// A scene in which nothing is translucent.
pub fn require_translucent(scene: &Scene) -> Result<(), SuiteError> {
    if scene.materials.iter().any(|m| m.opacity > 0.0 && m.opacity < 1.0) {
        return Ok(());
    }
    Err(SuiteError::Usage(format!(
        "scene {}: no material is translucent (opacity between 0 and 1), and none is cut out by an \
         alpha texture; --param opacity=0.5 has nothing to apply to",
        scene.name
    )))
}

fn is_hair(path: &std::path::Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    matches!(extension.as_str(), "tfx" | "hair")
}

/// The strands that a scene's hair is made of, where it has any.
fn strands(name: &str, seed: u64) -> Result<Option<Strands>, SuiteError> {
    Ok(match case::source(name)? {
        Source::File(path) if is_hair(&path) => Some(import::strands(&path)?.0),
        Source::Generated(name) => generate::strands_of(&name, seed),
        _ => None,
    })
}

/// Turns ribbons to whoever looks at them: those that are seen to the camera, and where hair is
/// lines, those that cast to the light.
fn face(
    loaded: &mut Loaded,
    strands: &Strands,
    view: &str,
    wishes: &Wishes,
) -> Result<(), SuiteError> {
    let camera = complete::camera(&loaded.seen, view)?;
    let light = light_direction(&loaded.seen, wishes)?;
    replace(&mut loaded.seen, strands, Facing::Point(camera.position));
    loaded.notes.push("hair: ribbons that face the camera are seen".into());
    match wishes.hair.as_str() {
        "lines" => {
            let mut casters = loaded.seen.clone();
            replace(&mut casters, strands, Facing::Direction(light));
            loaded.casters = Some(casters);
            let thickest = strands.radius.iter().copied().fold(0.0, f32::max);
            loaded.lift_m = 2.0 * f64::from(thickest);
            loaded.notes.push(
                "hair: ribbons of the same width that face the light cast shadows; receivers are \
                 lifted by a strand's thickness"
                    .into(),
            );
        }
        _ => loaded.notes.push("hair: the same ribbons cast shadows".into()),
    }
    Ok(())
}

/// Gives the strands' mesh, which bears their name, another facing.
fn replace(scene: &mut Scene, strands: &Strands, facing: Facing) {
    for mesh in scene.meshes.iter_mut().filter(|m| m.name == strands.name) {
        let material = mesh.material;
        *mesh = Mesh { material, ..strands.ribbons(facing).mesh };
    }
}

/// Direction of travel of the light that is wished.
fn light_direction(scene: &Scene, wishes: &Wishes) -> Result<DVec3, SuiteError> {
    if let Some(degrees) = wishes.degrees {
        let (sin, cos) = degrees.to_radians().sin_cos();
        return Ok(DVec3::new(-sin, -cos, 0.0));
    }
    let side = 10.0_f64.to_radians();
    Ok(match wishes.light.as_str() {
        "scene" => scene
            .lights
            .iter()
            .find_map(|l| match *l {
                Light::Directional { direction } | Light::Spot { direction, .. } => Some(direction),
                Light::Area { .. } => None,
            })
            .unwrap_or(DVec3::NEG_Y),
        "above" => DVec3::NEG_Y,
        "slanted" => DVec3::new(-1.0, -1.0, 0.0),
        "side" => DVec3::new(-side.cos(), -side.sin(), 0.0),
        other => {
            return Err(SuiteError::unknown("light", other, ["scene", "above", "slanted", "side"]));
        }
    }
    .normalize_or(DVec3::NEG_Y))
}

fn turn_light(
    scene: &mut Scene,
    wishes: &Wishes,
    notes: &mut Vec<String>,
) -> Result<(), SuiteError> {
    if wishes.light == "scene" && wishes.degrees.is_none() {
        return Ok(());
    }
    let direction = light_direction(scene, wishes)?;
    scene.lights = vec![Light::Directional { direction }];
    let from = wishes.degrees.map(|degrees| format!("{degrees} degrees off the vertical"));
    let from = from.unwrap_or_else(|| wishes.light.clone());
    notes.push(format!("the scene's lights are replaced by one from {from}"));
    Ok(())
}

/// Makes alpha-tested materials that are opaque otherwise translucent; how many there were.
fn leaf_opacity(scene: &mut Scene) -> usize {
    let leaves = scene.materials.iter_mut().filter(|m| m.alpha_test.is_some() && m.opacity >= 1.0);
    leaves.map(|m| m.opacity = generate::LEAF_OPACITY).count()
}

fn set_opacity(scene: &mut Scene, opacity: f32) {
    for material in &mut scene.materials {
        if material.opacity > 0.0 && material.opacity < 1.0 {
            material.opacity = opacity;
        }
    }
}
