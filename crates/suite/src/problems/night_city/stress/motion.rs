//! Extremes of the camera's steps: cells come and go, and what is kept of them belongs to other frames.

use super::{POSED, STEPS, USUAL};
use crate::{
    case::Case,
    city::Loaded,
    stress::{
        Axis, Values,
        motion::{along, spin, walk},
    },
};
use dapple_scene::{Camera, Scene};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        Axis {
            unit: "m a frame",
            parameters: STEPS,
            prepare: POSED.pushed(|loaded, value, case| {
                Ok(with_path(loaded, case, |scene, i| walk(scene, value, i)))
            }),
            ..USUAL.axis(
                "speed",
                "the camera's way along the scene's path in a frame, from standing still to jumping \
                 about",
                Values::FromZero { least: 1e-3, greatest: 1e4, per_decade: 1 },
                1.0,
            )
        },
        Axis {
            unit: "degrees a frame",
            parameters: STEPS,
            prepare: POSED.pushed(|loaded, value, case| {
                Ok(with_path(loaded, case, |scene, i| spin(scene, value, i)))
            }),
            ..USUAL.axis(
                "turn",
                "the camera's turn about its up in a frame, on one spot",
                Values::FromZero { least: 1e-3, greatest: 180.0, per_decade: 1 },
                1.0,
            )
        },
    ]
}

/// The city with one path of the case's frames.
fn with_path(loaded: Loaded, case: &Case, at: impl Fn(&Scene, u32) -> Option<Camera>) -> Loaded {
    Loaded { scene: along(loaded.scene, case, at), ..loaded }
}
