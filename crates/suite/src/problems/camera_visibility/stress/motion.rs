//! Extremes of the camera's steps.

use super::{SEEN, of_scene, pushed};
use crate::{
    case::Case,
    city::Loaded,
    stress::{
        Axis, Criterion, Values,
        motion::{along, spin, walk},
    },
};
use dapple_scene::{Camera, Scene};

/// Enough for what a technique remembers to grow old.
const FRAMES: &[(&str, &str)] = &[("width", "64"), ("frames", "10"), ("truth_samples", "1")];

/// Other places along the way show less: drawing everything alone has 2.4 times the overdraw there.
const HARDER: Criterion = Criterion { metric: "overdraw", times: 3.0, plus: 1.0 };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        speed("speed", SEEN),
        speed("speed-overdraw", HARDER),
        turn("turn", SEEN),
        turn("turn-overdraw", HARDER),
    ]
}

fn speed(id: &'static str, criterion: Criterion) -> Axis {
    Axis {
        unit: "m a frame",
        criterion,
        parameters: FRAMES,
        ..of_scene(
            id,
            "the camera's way along the scene's path in a frame, from standing still to jumping \
             about; past the path's end it starts again, and a step longer than the path leads \
             anywhere",
            Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 },
            1.0,
            pushed(|loaded, value, case| with_path(loaded, case, |scene, i| walk(scene, value, i))),
        )
    }
}

fn turn(id: &'static str, criterion: Criterion) -> Axis {
    Axis {
        unit: "degrees a frame",
        criterion,
        parameters: FRAMES,
        ..of_scene(
            id,
            "the camera's turn about its up in a frame, on one spot",
            Values::FromZero { least: 1e-3, greatest: 180.0, per_decade: 1 },
            1.0,
            pushed(|loaded, value, case| with_path(loaded, case, |scene, i| spin(scene, value, i))),
        )
    }
}

/// The city with one path of the case's frames.
fn with_path(loaded: Loaded, case: &Case, at: impl Fn(&Scene, u32) -> Option<Camera>) -> Loaded {
    Loaded { scene: along(loaded.scene, case, at), ..loaded }
}
