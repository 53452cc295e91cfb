//! Extremes of the scene and its light.

use super::{Given, HARDER, SAME, TranslucentCase, USUAL, both, load, pushed};
use crate::{
    case::Case,
    knob::Get,
    problem::Setting,
    problems::translucent_shadow::scene::{self, Loaded, Wishes},
    stress::{
        Axis, Criterion, Prepare, Values, edit,
        settings::{position, with, words},
        world::{self, Kind, changed},
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

fn scale() -> Axis {
    let help = "all lengths of the scene times this; the light inside it is the same";
    world::scale(SAME, help, pushed(|loaded, value, _| scaled(loaded, value)))
}

/// All lengths times `scale`.
pub(super) fn scaled(loaded: Loaded, scale: f64) -> Loaded {
    let lift_m = loaded.lift_m * scale;
    Loaded { lift_m, ..both(loaded, |scene| edit::scaled(scene, scale)) }
}

fn offset() -> Axis {
    let help = "distance of the scene from the origin in its own radii, by placements in f64; \
                vertices keep their bits";
    world::offset(SAME, help, pushed(|loaded, value, _| moved(loaded, value)))
}

/// Moved by so many radii: what casts by the same metres as what is seen.
pub(super) fn moved(loaded: Loaded, radii: f64) -> Loaded {
    let away = edit::away(&loaded.seen, radii);
    both(loaded, |scene| edit::moved_by(scene, away))
}

fn depth_range() -> Axis {
    let help = "depth range of the map over the scene's own: the near plane moves towards the sun, \
                as for a distant caster; below 1 it clips. Bias and span stay the same length";
    let ranged: Prepare = Box::new(|case, value, gpu| {
        let given = Given { depth_range: value, ..Given::default() };
        Ok(Box::new(TranslucentCase::given(load(case)?, &given, case, gpu)?))
    });
    Axis { setting: Box::new(depths_of_one_length), ..world::depth_range(USUAL, help, ranged) }
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
    Axis {
        unit: "degrees",
        prepare: lit(),
        ..USUAL.axis(
            "light-angle",
            "angle between the light and the vertical, from straight above to level",
            Values::Linear { least: 0.0, greatest: 90.0, steps: 9 },
            30.0,
        )
    }
}

fn lit() -> Prepare {
    Box::new(|case, value, gpu| Ok(Box::new(TranslucentCase::of(lit_at(case, value)?, case, gpu)?)))
}

/// The scene under a light at `degrees` from the vertical; lines of hair face it.
pub(super) fn lit_at(case: &Case, degrees: f64) -> Result<Loaded, crate::SuiteError> {
    let wishes = Wishes { degrees: Some(degrees), ..Wishes::of(&case.parameters)? };
    scene::load(&case.scene, &case.view, case.seed, &wishes)
}

fn off_vertical() -> Axis {
    Axis {
        unit: "degrees",
        prepare: lit(),
        ..SAME.axis(
            "off-vertical",
            "angle between the light and the world's up, from parallel: no basis of the map may \
             degenerate, and nothing may change",
            Values::FromZero { least: 1e-9, greatest: 0.1, per_decade: 1 },
            0.0,
        )
    }
}

/// The faintest that an 8-bit opacity can be.
const FAINTEST: f64 = 1.0 / 255.0;

fn opacity() -> Axis {
    Axis {
        must_refuse: |value| value >= 1.0,
        ..USUAL.of_parameter(
            "opacity",
            "opacity",
            "opacity of every translucent surface, from a 255th; at 1 nothing is translucent, which \
             must be refused",
            Values::Log { least: FAINTEST, greatest: 1.0, per_decade: 4 },
            0.5,
        )
    }
}

fn degenerate() -> Axis {
    let help = "triangles without area added to the largest mesh: a corner three times, a corner \
                twice, corners on a line; nothing may change";
    let added = pushed(|loaded, value, case| {
        both(loaded, |scene| edit::with_degenerate_triangles(scene, value as u32, case.seed))
    });
    world::degenerate(SAME, help, added)
}

const CONTENTS: &[Kind] = &[
    ("as-it-is", |scene, _| scene),
    ("one-depth", |scene, _| one_square(scene, Pose::Facing, LEAF)),
    ("edge-on", |scene, _| one_square(scene, Pose::Along, LEAF)),
    ("speck", |scene, _| one_square(scene, Pose::Facing, 1e-3 * LEAF)),
    ("opaque-above", |scene, _| under_a_roof(scene)),
    ("empty-view", |scene, _| edit::seen_from_behind(scene)),
    ("all-opaque", |scene, _| with_opacity(scene, 1.0)),
    ("all-clear", |scene, _| with_opacity(scene, 0.0)),
];
const CONTENT_WORDS: [&str; CONTENTS.len()] = words(CONTENTS);

/// The first of [`CONTENTS`] that must be refused.
const EMPTY_VIEW: usize = 5;

fn content() -> Axis {
    Axis {
        // Much harder where it is not much easier: twice the error still says where light falls.
        criterion: Criterion { times: 2.0, ..HARDER },
        must_refuse: |value| position(value) >= EMPTY_VIEW,
        prepare: pushed(|loaded, value, case| {
            both(loaded, |scene| changed(CONTENTS, scene, value, case.seed))
        }),
        ..USUAL.axis(
            "content",
            "the scene; one translucent square above the ground, which faces the light so that \
             every depth is the same, lies along it, or is a thousandth as wide; an opaque square \
             above all; a camera that sees nothing, nothing translucent and nothing visible, which \
             must be refused",
            Values::Words(&CONTENT_WORDS),
            0.0,
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
