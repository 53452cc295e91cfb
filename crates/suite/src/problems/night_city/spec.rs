//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    city,
    knob::{Accuracy, Knob},
    problem::{
        Constraint, Form, Metric, ONLY, Spec, Technique, Variant, metric, technique_in, variant,
    },
    problems::region_light_visibility::spec::{DIVISIONS, EDGE, LEAST_STEP},
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "night-city",
    title: "A city at night",
    question: "What does a whole frame of a city lit by all its windows and lamps cost, and where does \
               light leak through walls?",
    truth: "All lights with shadow rays in f64, at a seeded subset of the pixels.",
    metrics: METRICS,
    axis: "error_p99",
    constraints: &[Constraint { metric: "lost_lights", limit: 0.0 }],
    levels: [2.0 / 255.0, 8.0 / 255.0, 32.0 / 255.0],
    pictures: true,
    parameters: PARAMETERS,
    default_scene: "city_small",
    techniques: TECHNIQUES,
};

const METRICS: &[Metric] = &[
    metric(
        "error_p99",
        "error of the worst channel that 99 % of the pixels do not exceed; linear, white is 1",
    ),
    metric("error_max", "the greatest such error"),
    metric("rmse", "root mean squared error of the channels, linear"),
    metric("error_8bit", "greatest difference of a channel in steps of 8-bit sRGB"),
    metric("e_cull", "greatest radiance lost by what was taken for hidden and is not"),
    metric("e_irr", "greatest radiance lost by what was taken for too weak"),
    metric("e_cut", "greatest radiance by which clusters differ from their lights"),
    metric(
        "e_leak",
        "greatest radiance of lights that are hidden from the pixel and added all the same",
    ),
    metric("leak", "mean radiance of such lights over the mean of the truth"),
    metric("lost_lights", "lights seen by a pixel, and taken for hidden; over pixels"),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [8, 120, 7680], "image columns; rows are 3/4 of it")
        .unit("px")
        .log()
        .useful(60.0, 1200.0),
    Knob::int("frames", [1, 6, 10_000], "frames of the path, from its start").log(),
    Knob::int(
        "truth_pixels",
        [1, 96, 100_000_000],
        "truth: most pixels of a frame that are summed, by chance",
    )
    .log(),
    Knob::float("clamp", [1e-6, 0.1, 1e3], "distances to lights below this count as this")
        .unit("m")
        .log(),
    city::BLOCKS,
    city::HEIGHTS,
    city::LAYOUT,
    city::EMPTY,
    city::STREET,
];

const CUT: Knob = Knob::float(
    "cut",
    [0.0, 1.0 / 25_500.0, 1e9],
    "radiance that a cluster's bound may reach before it is divided; linear, white is 1",
)
.log()
.useful(1.0 / 255_000.0, 1.0 / 255.0)
.accuracy(Accuracy::Unimodal);
const THRESHOLD: Knob = Knob::float(
    "threshold",
    [0.0, 1.0 / 1020.0, 1.0],
    "radiance of a white surface below which a cluster does not reach a cell",
)
.log()
.useful(1.0 / 25_500.0, 1.0 / 64.0)
.accuracy(Accuracy::Unimodal);
const TAU: Knob = Knob::int(
    "tau",
    [0, 16_384, 2_000_000],
    "a cell that covers more pixels is divided; pixels of an image of 1200 x 900",
)
.unit("px")
.useful(256.0, 524_288.0);
const MOST_SPLIT: Knob = Knob::choice(
    "most_split",
    &["any", "storey", "facade", "building"],
    "the smallest part of the city that is a cell of its own",
);
const VALIDITY: Knob = Knob::int(
    "validity",
    [0, 50, 1_000_000],
    "frames after which a cell's lights are found anew; 0: never again",
)
.useful(1.0, 100.0);
const HEIGHTS: Knob = Knob::int(
    "heights",
    [0, 0, 8],
    "heights of a cell up to which it is found what is hidden below them, beside its top",
)
.useful(0.0, 4.0);
const BUDGET: Knob = Knob::int(
    "budget",
    [0, 0, 1_000_000],
    "most cells and directions a frame whose lights are found; the rest wait, and leak more; 0: all",
)
.useful(0.0, 200.0);
const CAPACITY: Knob = Knob::int(
    "capacity",
    [0, 0, 1_000_000],
    "most that kept lists may take beside the frame's own, the longest unused go first; 0: any",
)
.unit("KiB")
.useful(16.0, 4096.0);
const RAYS: Knob = Knob::choice(
    "shadow_rays",
    &["off", "on"],
    "whether each cluster that a pixel adds up costs a shadow ray: what stops leaks",
);
const OCCLUDERS: Knob = Knob::choice(
    "occluders",
    &["boxes", "runs", "bounding-boxes"],
    "what hides: boxes inside buildings; those and gap-free runs of them; boxes around clusters of \
     them (thesis, not sound)",
);

const FUSION: &[Variant] = &[
    variant("height-ordered", "shadows are joined anew at each plane, the tallest first"),
    variant("insertion", "shadows are joined as they come (thesis)"),
    variant("no-fusion", "a cluster has to lie in one building's shadow"),
    variant("precomputed", "every facade's lights are found before the first frame"),
];

const FAST: &[Form] = &[Form::Cpu, Form::Gpu];
const CPU: &[Form] = &[Form::Cpu];

const TECHNIQUES: &[Technique] = &[
    technique_in(
        FAST,
        "full-tree",
        "Cuts of all lights: nothing hides anything",
        "conte2018",
        ONLY,
        &[CUT],
    ),
    technique_in(
        FAST,
        "facade-cluster",
        "Facade-cluster visibility, then cuts",
        "conte2018",
        FUSION,
        &[
            CUT, THRESHOLD, TAU, MOST_SPLIT, HEIGHTS, VALIDITY, CAPACITY, BUDGET, RAYS, EDGE,
            OCCLUDERS, LEAST_STEP, DIVISIONS,
        ],
    ),
    technique_in(
        FAST,
        "traced-cut",
        "Cuts of all lights, with a shadow ray for each cluster",
        "conte2018",
        ONLY,
        &[CUT],
    ),
    technique_in(
        CPU,
        "reservoirs",
        "Reservoir resampling with shadow rays (ReSTIR)",
        "bitterli2020",
        ONLY,
        &[
            Knob::int("candidates", [1, 32, 4096], "lights drawn a pixel and frame").log(),
            Knob::int("neighbours", [0, 5, 64], "neighbours looked at a pixel").useful(0.0, 10.0),
        ],
    ),
];
