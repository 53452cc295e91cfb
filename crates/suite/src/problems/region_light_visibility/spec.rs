//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    city,
    knob::{Accuracy, Knob},
    problem::{
        Constraint, Form, Metric, ONLY, Spec, Technique, Variant, metric, technique_in, variant,
    },
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "region-light-visibility",
    title: "Which lights reach a facade",
    question: "Which of a city's lights does any point of a facade see, and what does it cost to \
               know it for all of them at once?",
    truth: "Rays from many points of each face (corners, at random, beside silhouettes) to a seeded \
            subset of the lights.",
    metrics: METRICS,
    axis: "kept_hidden",
    constraints: &[Constraint { metric: "false_hidden", limit: 0.0 }],
    levels: [0.1, 0.25, 0.5],
    pictures: true,
    parameters: PARAMETERS,
    default_scene: "city_small",
    techniques: TECHNIQUES,
};

const METRICS: &[Metric] = &[
    metric("kept_hidden", "share of the lights that no ray reaches which are kept all the same"),
    metric(
        "false_hidden",
        "share of the lights that a ray reaches which are left out: light that is lost",
    ),
    metric(
        "false_visible",
        "share of the lights kept that no ray reaches: light that leaks, where a pixel has no shadows \
         of its own",
    ),
    metric("precut_share", "lights kept over all lights, mean over faces"),
    metric("occluders_lost", "share of the buildings' boxes lost because cells are turned"),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [16, 300, 7680], "image columns that cells come from; rows are 3/4 of it")
        .unit("px")
        .log()
        .useful(75.0, 1200.0),
    Knob::int("frames", [1, 1, 10_000], "frames of the path, from its start").log(),
    Knob::int(
        "tau",
        [0, 16_384, 2_000_000],
        "a cell that covers more pixels is divided; pixels of an image of 1200 x 900",
    )
    .unit("px")
    .useful(256.0, 524_288.0),
    Knob::choice(
        "most_split",
        &["any", "storey", "facade", "building"],
        "cities: the smallest part of the city that is a cell of its own",
    ),
    Knob::int("truth_faces", [1, 12, 1_000_000], "truth: most faces of cells, by chance").log(),
    Knob::int("truth_lights", [1, 512, 1_000_000], "truth: most lights of a face, by chance").log(),
    Knob::int("truth_points", [8, 96, 1_000_000], "truth: points of a face for each light").log(),
    Knob::float(
        "threshold",
        [0.0, 1.0 / 1020.0, 1.0],
        "radiance of a white surface below which a light does not matter; linear, white is 1",
    )
    .log()
    .useful(1.0 / 25_500.0, 1.0 / 64.0),
    Knob::float("clamp", [1e-6, 0.1, 1e3], "distances to lights below this count as this")
        .unit("m")
        .log(),
    city::BLOCKS,
    city::HEIGHTS,
    city::LAYOUT,
    city::EMPTY,
    city::STREET,
];

const FUSION: &[Variant] = &[
    variant("height-ordered", "shadows are joined anew at each plane, the tallest first"),
    variant("insertion", "shadows are joined as they come (thesis)"),
    variant("no-fusion", "a cluster has to lie in one building's shadow"),
];

/// The upper edge of shadows.
pub const EDGE: Knob = Knob::choice(
    "edge",
    &["flat", "sloped", "hull"],
    "upper edge of a building's shadow: level, one line (thesis), or all of it",
);
/// What stands for buildings.
pub const OCCLUDERS: Knob = Knob::choice(
    "occluders",
    &["boxes", "runs", "bounding-boxes", "objects"],
    "what hides: boxes inside buildings; those and gap-free runs of them; boxes around clusters of \
     them (thesis, not sound); boxes and every facade's wall",
);
/// Distance of planes.
pub const LEAST_STEP: Knob = Knob::float(
    "least_step",
    [0.0, 5.0, 1e4],
    "planes lie at far faces of buildings, but at least so far apart",
)
.unit("m")
.useful(0.0, 50.0)
.accuracy(Accuracy::Unimodal);
/// Clusters hidden in part.
pub const DIVISIONS: Knob = Knob::int(
    "divisions",
    [-1, -1, 64],
    "levels that a cluster hidden in part is divided; -1: down to single lights",
)
.useful(0.0, 4.0);
const PLANES: Knob = Knob::choice(
    "planes",
    &["far-faces", "behind", "every"],
    "where planes lie: at far faces, `plane_distance` behind them, or every `plane_distance`",
);
const PLANE_DISTANCE: Knob = Knob::float("plane_distance", [0.001, 2.0, 1e4], "see `planes`")
    .unit("m")
    .log()
    .useful(1.0, 32.0);
const CACHED: Knob = Knob::choice(
    "projections",
    &["anew", "kept"],
    "a cluster's projection on a plane: computed for each test, or kept for the next",
);

/// On the processor: branches are what it is made of.
const HOST: &[Form] = &[Form::Reference, Form::Cpu];
const CPU: &[Form] = &[Form::Cpu];

const TECHNIQUES: &[Technique] = &[
    technique_in(CPU, "all-lights", "All lights, whatever hides them", "conte2018", ONLY, &[]),
    technique_in(
        HOST,
        "facade-cluster",
        "Facade-cluster visibility: clusters behind joined shadows on planes",
        "conte2018",
        FUSION,
        &[EDGE, OCCLUDERS, PLANES, PLANE_DISTANCE, LEAST_STEP, DIVISIONS, CACHED],
    ),
    technique_in(
        CPU,
        "extended-projection",
        "Extended projections on a raster",
        "durand2000",
        ONLY,
        &[Knob::int("texels", [16, 256, 4096], "texels a side of the plane's map")
            .log()
            .useful(64.0, 1024.0)
            .accuracy(Accuracy::Monotone)],
    ),
    technique_in(
        CPU,
        "sampled",
        "Rays from the face to each light: not sound",
        "wonka2006",
        ONLY,
        &[Knob::int("rays", [1, 16, 16_384], "rays a light").log().useful(1.0, 256.0)],
    ),
];
