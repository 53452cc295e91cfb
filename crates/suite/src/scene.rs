//! From a scene's name to a scene that can be measured: what is missing is filled in, what it
//! does not need is left out, and each change is a sentence for the user.

use crate::{
    SuiteError,
    case::{self, Source},
};
use dapple_scene::{
    Aabb, Camera, Eye, EyeError, Light, LightView, Orbit, OrbitError, Scene, add_ground, generate,
    import, inspect,
};

/// A complete scene.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// With a light, a camera and something to receive shadows; without alpha tests that change
    /// nothing.
    pub scene: Scene,
    /// Identity of the scene before anything was left out.
    pub hash: String,
    /// What was added, left out or warned about.
    pub notes: Vec<String>,
}

/// Loads or generates a scene and completes it.
///
/// # Errors
/// An unknown generator, a file that is not a scene, or test data that are not at hand.
pub fn load(name: &str, seed: u64) -> Result<Loaded, SuiteError> {
    let (mut scene, mut notes, from_file) = match case::source(name)? {
        Source::Generated(name) => {
            let known = generate::NAMES.iter().map(|(name, _)| *name);
            let scene = generate::by_name(&name, seed)
                .ok_or_else(|| SuiteError::unknown("scene", &name, known))?;
            (scene, Vec::new(), false)
        }
        Source::File(path) => {
            let loaded = import::load(&path)?;
            (loaded.scene, loaded.warnings, true)
        }
        Source::MissingData(path) => return Err(case::missing_data(&path)),
    };
    // Generated scenes are complete as they are; a bare model floats in the air.
    if from_file && !scene.has_ground() {
        add_ground(&mut scene);
        notes.push("no ground: a square below the model was added to receive its shadow".into());
    }
    complete(scene, notes)
}

/// Adds what a scene lacks and leaves out the alpha tests it does not need.
///
/// # Errors
/// A scene that does not validate.
pub fn complete(mut scene: Scene, mut notes: Vec<String>) -> Result<Loaded, SuiteError> {
    // First of all: views are framed by the vertices.
    scene.validate()?;
    // The view is still: a path is added too, but says nothing here.
    notes.extend(scene.add_defaults().into_iter().filter(|n| !n.contains("camera path")));
    scene.validate()?;
    let hash = scene.hash();
    let needs = inspect::inspect(&scene);
    let declared = scene.materials.iter().any(|m| m.alpha_test.is_some());
    let idle = |need: &&inspect::Need| need.option == "alpha-test" && !need.needed;
    for need in needs.needs.iter().filter(|need| declared && idle(need)) {
        leave_out_alpha_tests(&mut scene);
        notes.push(format!("alpha test left out: {}", need.because));
    }
    Ok(Loaded { scene, hash, notes })
}

fn leave_out_alpha_tests(scene: &mut Scene) {
    for material in &mut scene.materials {
        material.alpha_test = None;
    }
}

/// The camera of that name, the first for an empty one, the first turned about the scene's
/// middle for `orbit:AZIMUTH,ELEVATION,DISTANCE` (see [`Orbit`]), or one placed by hand for
/// `eye:X,Y,Z,TX,TY,TZ` (see [`Eye`]).
///
/// # Errors
/// [`SuiteError::Unknown`] with the views there are; [`SuiteError::Usage`] for an orbit or an eye
/// that is not of that form.
pub fn camera(scene: &Scene, view: &str) -> Result<Camera, SuiteError> {
    let unknown =
        || SuiteError::unknown("view", view, scene.cameras.iter().map(|c| c.name.as_str()));
    // A camera may well be called that; then it is meant.
    if !view.is_empty()
        && let Some(named) = scene.cameras.iter().find(|c| c.name == view)
    {
        return Ok(named.clone());
    }
    let first = || scene.cameras.first().ok_or_else(unknown);
    if view.is_empty() {
        return first().cloned();
    }
    if Eye::is_meant(view) {
        let eye: Eye = view.parse().map_err(|e: EyeError| SuiteError::Usage(e.to_string()))?;
        return Ok(eye.camera(first()?));
    }
    if !Orbit::is_meant(view) {
        return Err(unknown());
    }
    let orbit: Orbit = view.parse().map_err(|e: OrbitError| SuiteError::Usage(e.to_string()))?;
    Ok(orbit.turn(first()?, scene.bounds().centre()))
}

/// The map of the first light that can have one, and a note where other lights are left out.
///
/// # Errors
/// A scene whose lights all have an area, or a light without a usable direction.
pub fn light_view(scene: &Scene, bounds: &Aabb) -> Result<(LightView, Option<String>), SuiteError> {
    let mut fitted = scene.lights.iter().enumerate().filter_map(|(i, light)| match *light {
        Light::Directional { direction } => {
            Some((i, LightView::fit_directional(direction, bounds)))
        }
        Light::Spot { position, direction, half_angle_rad } => {
            Some((i, LightView::fit_spot(position, direction, half_angle_rad, bounds)))
        }
        Light::Area { .. } => None,
    });
    let (index, view) = fitted.next().ok_or_else(|| {
        SuiteError::Usage(format!(
            "scene {}: none of its {} lights is directional or a spot, and no other has a shadow map",
            scene.name,
            scene.lights.len()
        ))
    })?;
    let others = scene.lights.len() - 1;
    let note =
        (others > 0).then(|| format!("light {index} casts the shadow; {others} more left out"));
    Ok((view?, note))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_found_by_name_first_or_by_orbit() {
        let scene = load("spheres", 0).unwrap().scene;
        let first = &scene.cameras[0];
        assert_eq!(camera(&scene, "").unwrap().name, first.name);
        assert_eq!(camera(&scene, &first.name).unwrap().position, first.position);
        let same = camera(&scene, "orbit:0,0,1").unwrap();
        assert_eq!((same.position, same.target, same.up), (first.position, first.target, first.up));
        let turned = camera(&scene, "orbit:90,0,1").unwrap();
        let centre = scene.bounds().centre();
        assert!(turned.position.distance(first.position) > 0.1);
        let radii = [turned.position, first.position].map(|p| p.distance(centre));
        assert!((radii[0] - radii[1]).abs() < 1e-9 * radii[1]);
        let placed = camera(&scene, "eye:1,2,3,0,0.5,0").unwrap();
        assert_eq!((placed.position.to_array(), placed.target.y), ([1.0, 2.0, 3.0], 0.5));
        for (view, what) in [
            ("orbit:1,2", "orbit:AZIMUTH,ELEVATION,DISTANCE"),
            ("eye:1,2", "eye:X,Y,Z,TX,TY,TZ"),
            ("nowhere", "no view `nowhere`"),
        ] {
            let error = camera(&scene, view).unwrap_err();
            assert!(error.to_string().contains(what), "{error}");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
