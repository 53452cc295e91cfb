//! Seeded scenes: the three of the shadow-filtering chapter, analytic micro-scenes, and translucent
//! foliage, hair and clouds.
//!
//! The same name and seed give the same bits on one platform (sines differ between libraries); the
//! geometry of the translucent scenes does on all.

mod builder;
mod chapter7;
mod cities;
mod clouds;
mod foliage;
mod hair;
pub mod mesh;
mod micro;
mod random;

use crate::Scene;
use crate::city::City;

pub use clouds::{BALL_OPACITY, Ball, QuadCloud, SLAB, SPHERE_CLOUD, Volume, metaball_balls};
pub use foliage::LEAF_OPACITY;
pub use hair::{HAIR_OPACITY, MAX_STRANDS, SEGMENTS, hair_material, hair_strands};

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
    ("grass", "2,000 translucent blades, light from straight above: thin layers of uneven depth"),
    ("grass_sparse", "500 blades: most rays meet one or none"),
    ("grass_dense", "8,000 blades: several layers on every ray"),
    ("mixed", "dense grass beside sparse grass: no one split suits both"),
    ("tree", "an opaque trunk under 4,000 translucent leaves"),
    (
        "willow",
        "an opaque trunk under 20,000 translucent quads in strips that hang along the light",
    ),
    ("trees", "the tree, the willow and a low plant: objects of different heights under one light"),
    (
        "two_far",
        "two clusters of leaves far apart along the light: layers spread over the gap are wasted",
    ),
    ("hair", "5,000 translucent strands on an opaque head, as ribbons that face the camera"),
    ("hair_50k", "50,000 finer strands, 1.6 million triangles: a full head of hair"),
    ("slab", "small translucent squares anywhere in a box: the mean thickness is linear in depth"),
    (
        "sphere_cloud",
        "small translucent squares anywhere in a ball: the mean thickness is a chord's",
    ),
    ("metaballs", "30 overlapping translucent balls drawn as surfaces, where a volume is meant"),
    ("city", "6 x 6 blocks of 44 buildings with 1 to 7 storeys: a camera sees little of them"),
    ("city_small", "2 x 2 blocks of such a city: small enough for software"),
    ("city_trees", "the small city with 12 trees a block: what has holes must hide nothing"),
    ("city_flat", "the city with 7 storeys everywhere: every roof hides what lies behind"),
    ("city_9", "9 x 9 blocks"),
    ("city_15", "15 x 15 blocks, 2.8 million triangles: work must grow with what is seen"),
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
        "grass" => foliage::grass(name, 2_000, seed),
        "grass_sparse" => foliage::grass(name, 500, seed),
        "grass_dense" => foliage::grass(name, 8_000, seed),
        "mixed" => foliage::mixed(seed),
        "tree" => foliage::tree(seed),
        "willow" => foliage::willow(seed),
        "trees" => foliage::trees(seed),
        "two_far" => foliage::two_far(seed),
        "hair" => hair::hair(name, 5_000, seed),
        "hair_50k" => hair::hair(name, 50_000, seed),
        "slab" => clouds::quad_cloud(name, &SLAB, seed),
        "sphere_cloud" => clouds::quad_cloud(name, &SPHERE_CLOUD, seed),
        "metaballs" => clouds::metaballs(seed),
        _ => return city_of(name, seed).map(|city| city.scene().scene),
    })
}

/// The city that scene `name` is made of, under the same seed; `None` for a scene without.
pub fn city_of(name: &str, seed: u64) -> Option<City> {
    cities::by_name(name, seed)
}

/// What the generator is asked for where scene `name` is a city; `None` for a scene that is none.
pub fn city_knobs(name: &str) -> Option<crate::city::Knobs> {
    cities::knobs(name)
}

/// The strands that the hair of scene `name` is made of, under the same seed; `None` for a scene
/// without. The mesh of their ribbons bears their name.
pub fn strands_of(name: &str, seed: u64) -> Option<crate::Strands> {
    match name {
        "hair" => Some(hair_strands(5_000, seed)),
        "hair_50k" => Some(hair_strands(50_000, seed)),
        _ => None,
    }
}
