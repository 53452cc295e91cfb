//! Seeded scenes: the three of the shadow-filtering chapter and analytic micro-scenes.
//!
//! The same name and seed give the same bits on one platform (sines differ between libraries).

mod builder;
mod chapter7;
pub mod mesh;
mod micro;

use crate::Scene;

/// Every name that [`by_name`] knows, with one line on what it is for.
pub const NAMES: &[(&str, &str)] = &[
    (
        "spheres",
        "floating spheres stacked along the light over a floor: many occluders in one filter window",
    ),
    (
        "chairs",
        "chairs of thin slats, some stacked, on a floor: slats just above one another, where light bleeds",
    ),
    (
        "car",
        "a car with open cabin, wheel arches, roof rack and spoiler above a floor: cavities and thin parts",
    ),
    (
        "half_plane",
        "a half-plane above a plane, light along the normal: one straight shadow edge at x = 0",
    ),
    (
        "three_planes",
        "planes A, B, C one below the other: C lies wholly under B, and A's edge must not show on it",
    ),
    (
        "slanted_receiver",
        "a plane tilted by 30 degrees under a thin occluder: depth varies within the filter window",
    ),
    ("closed_sphere", "a closed icosphere alone: no ray may pass through it"),
    ("cube", "a cube above a floor: the smallest scene with a shadow"),
    ("empty_plane", "a plane under slanted light, nothing above it: everything is lit"),
];

/// Generates a scene of [`NAMES`]; `None` for an unknown name. Every one validates, has a
/// directional light, a camera that sees the shadow the scene is about, and a camera path.
/// Micro-scenes do not depend on the seed.
pub fn by_name(name: &str, seed: u64) -> Option<Scene> {
    Some(match name {
        "spheres" => chapter7::spheres(seed),
        "chairs" => chapter7::chairs(seed),
        "car" => chapter7::car(seed),
        "half_plane" => micro::half_plane(),
        "three_planes" => micro::three_planes(),
        "slanted_receiver" => micro::slanted_receiver(),
        "closed_sphere" => micro::closed_sphere(),
        "cube" => micro::cube(),
        "empty_plane" => micro::empty_plane(),
        _ => return None,
    })
}
