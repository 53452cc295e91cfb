//! Extremes of the scene and its light.

use super::{CHEAP, FORMS, Given, HARDER, TranslucentCase, UNCHANGED, both, load, pushed};
use crate::{
    case::Case,
    knob::Get,
    problem::Setting,
    problems::translucent_shadow::scene::{self, Loaded, Wishes},
    stress::{
        Axis, Criterion, Prepare, Values, edit,
        settings::{as_it_is, never, position, with},
    },
};
use dapple_scene::{Light, Scene, generate};
use glam::{DAffine3, DQuat, DVec3};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        scale(),
        offset(),
        depth_range(),
        light_angle(),
        off_vertical(),
        opacity(),
        degenerate(),
        content(),
    ]
}

/// An axis of the scene alone: every technique is pushed, as it is.
fn of_scene(id: &'static str, help: &'static str, values: Values, prepare: Prepare) -> Axis {
    Axis {
        id,
        unit: "",
        help,
        values,
        home: 0.0,
        parameters: CHEAP,
        forms: FORMS,
        criterion: UNCHANGED,
        must_refuse: never,
        prepare,
        setting: as_it_is,
    }
}

fn scale() -> Axis {
    let values = Values::Log { least: 1e-6, greatest: 1e6, per_decade: 1 };
    let prepare = pushed(|loaded, value, _| scaled(loaded, value));
    let help = "all lengths of the scene times this; the light inside it is the same";
    Axis { home: 1.0, ..of_scene("scale", help, values, prepare) }
}

/// All lengths times `scale`.
pub(super) fn scaled(loaded: Loaded, scale: f64) -> Loaded {
    let lift_m = loaded.lift_m * scale;
    Loaded { lift_m, ..both(loaded, |scene| edit::scaled(scene, scale)) }
}

fn offset() -> Axis {
    let values = Values::FromZero { least: 1.0, greatest: 1e7, per_decade: 1 };
    let prepare = pushed(|loaded, value, _| moved(loaded, value));
    let help = "distance of the scene from the origin in its own radii, by placements in f64; \
                vertices keep their bits";
    Axis { unit: "radii", ..of_scene("offset", help, values, prepare) }
}

/// Moved by so many radii: what casts by the same metres as what is seen.
pub(super) fn moved(loaded: Loaded, radii: f64) -> Loaded {
    let away = edit::away(&loaded.seen, radii);
    both(loaded, |scene| edit::moved_by(scene, away))
}

fn depth_range() -> Axis {
    let values = Values::Log { least: 1e-3, greatest: 1e6, per_decade: 1 };
    let prepare: Prepare = Box::new(|case, value, gpu| {
        let given = Given { depth_range: value, ..Given::default() };
        Ok(Box::new(TranslucentCase::given(load(case)?, &given, case, gpu)?))
    });
    Axis {
        home: 1.0,
        criterion: HARDER,
        setting: depths_of_one_length,
        ..of_scene(
            "depth-range",
            "depth range of the map over the scene's own: the near plane moves towards the sun, as \
             for a distant caster; below 1 it clips. Bias and span stay the same length",
            values,
            prepare,
        )
    }
}

/// Depths are measured in the scene by whoever sets them, and rounding has nothing to do with it:
/// left as a share of the range they would hide all else from the first decade on.
fn depths_of_one_length(setting: &Setting, range: f64) -> Option<Setting> {
    let mut setting = setting.clone();
    for (knob, most) in [("bias", 0.1), ("span", 10.0)] {
        if let Ok(depth) = setting.knobs.float(knob) {
            setting = with(&setting, knob, (depth / range).min(most))?;
        }
    }
    Some(setting)
}

fn light_angle() -> Axis {
    let prepare: Prepare = Box::new(|case, value, gpu| {
        Ok(Box::new(TranslucentCase::of(lit_at(case, value)?, case, gpu)?))
    });
    Axis {
        unit: "degrees",
        criterion: HARDER,
        home: 30.0,
        ..of_scene(
            "light-angle",
            "angle between the light and the vertical, from straight above to level",
            Values::Linear { least: 0.0, greatest: 90.0, steps: 9 },
            prepare,
        )
    }
}

/// The scene under a light at `degrees` from the vertical; lines of hair face it.
pub(super) fn lit_at(case: &Case, degrees: f64) -> Result<Loaded, crate::SuiteError> {
    let wishes = Wishes { degrees: Some(degrees), ..Wishes::of(&case.parameters)? };
    scene::load(&case.scene, &case.view, case.seed, &wishes)
}

fn off_vertical() -> Axis {
    Axis {
        unit: "degrees",
        prepare: light_angle().prepare,
        ..of_scene(
            "off-vertical",
            "angle between the light and the world's up, from parallel: no basis of the map may \
             degenerate, and nothing may change",
            Values::FromZero { least: 1e-9, greatest: 0.1, per_decade: 1 },
            light_angle().prepare,
        )
    }
}

/// The faintest that an 8-bit opacity can be.
const FAINTEST: f64 = 1.0 / 255.0;

fn opacity() -> Axis {
    let prepare: Prepare = Box::new(|case, value, gpu| {
        let mut case = case.clone();
        case.parameters.insert("opacity".into(), value.into());
        Ok(Box::new(TranslucentCase::prepare(&case, gpu)?))
    });
    Axis {
        home: 0.5,
        criterion: HARDER,
        must_refuse: |value| value >= 1.0,
        ..of_scene(
            "opacity",
            "opacity of every translucent surface, from a 255th; at 1 nothing is translucent, which \
             must be refused",
            Values::Log { least: FAINTEST, greatest: 1.0, per_decade: 4 },
            prepare,
        )
    }
}

fn degenerate() -> Axis {
    Axis {
        unit: "triangles",
        ..of_scene(
            "degenerate",
            "triangles without area added to the largest mesh: a corner three times, a corner \
             twice, corners on a line; nothing may change",
            Values::Whole { least: 0, greatest: 100_000, per_decade: 1 },
            pushed(|loaded, value, case| {
                let add = |scene| edit::with_degenerate_triangles(scene, value as u32, case.seed);
                both(loaded, add)
            }),
        )
    }
}

/// What [`content`] puts in place of the scene.
type Content = (&'static str, fn(Scene) -> Scene);

const CONTENTS: &[Content] = &[
    ("as-it-is", |scene| scene),
    ("one-depth", |scene| one_square(scene, Pose::Facing, LEAF)),
    ("edge-on", |scene| one_square(scene, Pose::Along, LEAF)),
    ("speck", |scene| one_square(scene, Pose::Facing, 1e-3 * LEAF)),
    ("opaque-above", under_a_roof),
    ("empty-view", edit::seen_from_behind),
    ("all-opaque", |scene| with_opacity(scene, 1.0)),
    ("all-clear", |scene| with_opacity(scene, 0.0)),
];

/// The first of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = 5;

const CONTENT_WORDS: [&str; CONTENTS.len()] = {
    let mut words = [""; CONTENTS.len()];
    let mut i = 0;
    while i < words.len() {
        words[i] = CONTENTS[i].0;
        i += 1;
    }
    words
};

fn content() -> Axis {
    Axis {
        // Much harder where it is not much easier: twice the error still says where light falls.
        criterion: Criterion { times: 2.0, ..HARDER },
        must_refuse: |value| position(value) >= EMPTY_VIEW,
        ..of_scene(
            "content",
            "the scene; one translucent square above the ground, which faces the light so that \
             every depth is the same, lies along it, or is a thousandth as wide; an opaque square \
             above all; a camera that sees nothing, nothing translucent and nothing visible, which \
             must be refused",
            Values::Words(&CONTENT_WORDS),
            pushed(|loaded, value, _| {
                let (_, content) = CONTENTS.get(position(value)).unwrap_or(&CONTENTS[0]);
                both(loaded, content)
            }),
        )
    }
}

/// How a square lies to the light.
#[derive(Clone, Copy)]
pub(super) enum Pose {
    /// All of it at one depth.
    Facing,
    /// Seen by the light as a line.
    Along,
}

/// Half side of the squares over the scene's radius.
pub(super) const LEAF: f64 = 0.35;

/// A translucent square in the middle of the scene's bounds, `half` of their radius to each side,
/// over a floor of their width, seen from the light's side, aslant.
pub(super) fn one_square(mut scene: Scene, pose: Pose, half: f64) -> Scene {
    let (bounds, normal) = (scene.bounds(), towards_light(&scene));
    let (centre, radius) = (bounds.centre(), bounds.radius());
    let (across, _) = normal.any_orthonormal_pair();
    scene.meshes.clear();
    scene.instances.clear();
    let facing = match pose {
        Pose::Facing => normal,
        Pose::Along => across,
    };
    place_square(&mut scene, facing, half * radius, centre);
    if let Some(leaf) = scene.materials.last_mut() {
        leaf.opacity = generate::LEAF_OPACITY;
    }
    place_square(&mut scene, DVec3::Y, radius, DVec3::new(centre.x, bounds.min.y, centre.z));
    for camera in &mut scene.cameras {
        camera.target = centre;
        camera.position = centre + (normal + 0.5 * across) * (2.0 * radius);
        camera.up = across;
    }
    scene
}

/// An opaque square over the middle of the scene.
fn under_a_roof(mut scene: Scene) -> Scene {
    let (bounds, normal) = (scene.bounds(), towards_light(&scene));
    let above = bounds.centre() + normal * bounds.radius();
    place_square(&mut scene, normal, LEAF * bounds.radius(), above);
    scene
}

fn place_square(scene: &mut Scene, normal: DVec3, half: f64, centre: DVec3) {
    let turn = DQuat::from_rotation_arc(DVec3::Y, normal);
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(half), turn, centre);
    edit::add_square(scene, place);
}

fn towards_light(scene: &Scene) -> DVec3 {
    let travel = match scene.lights.first() {
        Some(Light::Directional { direction } | Light::Spot { direction, .. }) => *direction,
        Some(Light::Area { .. }) | None => DVec3::NEG_Y,
    };
    -travel.normalize_or(DVec3::NEG_Y)
}

/// Every translucent material given another opacity.
fn with_opacity(mut scene: Scene, opacity: f32) -> Scene {
    for material in scene.materials.iter_mut().filter(|m| m.opacity < 1.0) {
        material.opacity = opacity;
    }
    scene
}
