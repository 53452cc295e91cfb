//! Axes of scenes that most problems have. What they do to a case is the problem's.

use super::{
    Axis, Prepare, Values,
    settings::{Usual, position},
};
use dapple_scene::Scene;

/// A word, and what becomes of a scene by it; what is random takes the seed.
pub type Kind = (&'static str, fn(Scene, u64) -> Scene);

/// The scene as the word at `value` has it.
pub fn changed(kinds: &[Kind], scene: Scene, value: f64, seed: u64) -> Scene {
    match kinds.get(position(value)) {
        Some((_, change)) => change(scene, seed),
        None => scene,
    }
}

/// All lengths times the value.
pub fn scale(usual: Usual, help: &'static str, prepare: Prepare) -> Axis {
    let values = Values::Log { least: 1e-6, greatest: 1e6, per_decade: 1 };
    Axis { prepare, ..usual.axis("scale", help, values, 1.0) }
}

/// Distance from the origin in radii of the scene.
pub fn offset(usual: Usual, help: &'static str, prepare: Prepare) -> Axis {
    let values = Values::FromZero { least: 1.0, greatest: 1e7, per_decade: 1 };
    Axis { prepare, unit: "radii", ..usual.axis("offset", help, values, 0.0) }
}

/// Depth range of a map over the one that fits the scene.
pub fn depth_range(usual: Usual, help: &'static str, prepare: Prepare) -> Axis {
    let values = Values::Log { least: 1e-3, greatest: 1e6, per_decade: 1 };
    Axis { prepare, ..usual.axis("depth-range", help, values, 1.0) }
}

/// Triangles without area.
pub fn degenerate(usual: Usual, help: &'static str, prepare: Prepare) -> Axis {
    let values = Values::Whole { least: 0, greatest: 100_000, per_decade: 1 };
    Axis { prepare, unit: "triangles", ..usual.axis("degenerate", help, values, 0.0) }
}
