//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    city,
    knob::{Accuracy, Knob},
    problem::{Metric, ONLY, Spec, Technique, Variant, metric, technique, variant},
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "many-lights",
    title: "Many lights",
    question: "What do thousands of lights give each pixel, and what does it cost to add them up?",
    truth: "Sum over all lights in f64, shadow rays included where asked, at a seeded subset of the \
            pixels.",
    metrics: METRICS,
    axis: "error_p99",
    constraints: &[],
    levels: [0.5 / 255.0, 2.0 / 255.0, 8.0 / 255.0],
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
    metric(
        "bias",
        "error of the mean over pixels and repetitions, over the mean of the truth: what more \
         samples do not cure",
    ),
    metric(
        "noise",
        "root mean squared deviation between repetitions, over the mean of the truth: what more \
         samples cure; 0 for what does nothing by chance",
    ),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [8, 128, 7680], "image columns; rows are 9/16 of it")
        .unit("px")
        .log()
        .useful(64.0, 1920.0),
    Knob::int("frames", [1, 4, 10_000], "frames of the path, from its start").log(),
    Knob::int(
        "truth_pixels",
        [1, 1024, 100_000_000],
        "truth: most pixels of a frame that are summed, by chance",
    )
    .log(),
    Knob::choice("visibility", &["off", "on"], "whether the scene casts shadows (by rays)"),
    Knob::float("clamp", [1e-6, 0.1, 1e3], "distances to lights below this count as this")
        .unit("m")
        .log(),
    Knob::int(
        "lights",
        [0, 0, 1_000_000],
        "scenes that are no cities: random lights; 0: the scene's own",
    )
    .log()
    .useful(1.0, 100_000.0),
    Knob::choice("lit", &["all", "windows", "lamps"], "cities: which lights burn"),
    Knob::choice(
        "emission",
        &["scene", "omni", "oriented", "spot", "directional"],
        "how lights depend on the direction: as they are, or all alike (spots: 45 degrees)",
    ),
    city::BLOCKS,
    city::HEIGHTS,
    city::LAYOUT,
    city::EMPTY,
    city::STREET,
];

const TREE: Knob = Knob::choice(
    "tree",
    &["auto", "city", "original", "median"],
    "clusters of lights: the city's hierarchy where there is one, Walter's, or halves",
);
/// Nodes of a binary tree can be split one by one: the city's wide ones take a small cut at once.
const BINARY_TREE: Knob = Knob::choice(
    "tree",
    &["original", "median", "city"],
    "clusters of lights: Walter's, halves, or the city's hierarchy (wide: for large cuts)",
);
const REPRESENTATIVE: Knob = Knob::choice(
    "representative",
    &["weighted", "random", "nearest"],
    "where a cluster shines from: its weighted middle, a child's by chance, the nearest light",
);
const LEVELS: Knob = Knob::choice(
    "levels",
    &["all", "no-storeys", "no-facades", "no-buildings", "no-blocks"],
    "the city's hierarchy without one of its levels",
);
const FANOUT: Knob =
    Knob::int("fanout", [0, 0, 10_000], "most children of a node of the city's hierarchy; 0: any")
        .useful(2.0, 64.0);
const SPREAD: Knob = Knob::float(
    "spread",
    [0.0, 1.0, 100.0],
    "weight of directions against distances where Walter's tree merges lights",
)
.useful(0.1, 10.0);
const BOUND: Knob = Knob::choice(
    "bound",
    &["cheap", "walter"],
    "bound of a cosine over a box: by its farthest corner, or exact (Walter)",
);
const EPSILON: Knob = Knob::float(
    "epsilon",
    [0.0, 0.02, 100.0],
    "allowed bound of a node, over the estimate of the pixel",
)
.useful(0.002, 0.5)
.accuracy(Accuracy::Unimodal);

const PER: &[Variant] = &[
    variant("pixel", "every pixel makes its own cut (thesis)"),
    variant("tile", "one cut for 8 x 8 pixels, bounded over all of them"),
];
const SHARED: &[Variant] = &[
    variant("offline", "every pixel makes its own cut (Yuksel)"),
    variant("real-time", "one cut for 8 x 8 pixels, made at one of them (Lin and Yuksel)"),
];
const REUSE: &[Variant] = &[
    variant("unbiased", "only candidates that could have been drawn are counted"),
    variant("biased", "all candidates are counted: faster, darker at edges"),
];
const ENDS: &[Variant] = &[
    variant("window", "a light fades to 0 at the end of its reach"),
    variant("cut", "a light ends abruptly"),
];

const TECHNIQUES: &[Technique] = &[
    technique("brute-force", "All lights at every pixel (R0)", "conte2018", ONLY, &[]),
    technique(
        "lightcuts",
        "Lightcuts: the worst node is split (R1; on a GPU R2)",
        "walter2005",
        ONLY,
        &[
            EPSILON,
            Knob::int("most", [1, 1000, 16_384], "most nodes of a cut").log().useful(16.0, 1000.0),
            Knob::choice("selection", &["heap", "scan"], "how the worst node is found (gpu: scan)"),
            BOUND,
            TREE,
            REPRESENTATIVE,
            LEVELS,
            FANOUT,
            SPREAD,
        ],
    ),
    technique(
        "relative-cut",
        "A node is split by its own relative error (R3, rejected by its author)",
        "conte2018",
        ONLY,
        &[
            Knob::float(
                "own_epsilon",
                [0.0, 0.5, 1e6],
                "allowed excess of a node's bound over its own estimate, over that estimate",
            )
            .log()
            .useful(0.01, 10.0),
            BOUND,
            TREE,
            REPRESENTATIVE,
            LEVELS,
            FANOUT,
            SPREAD,
        ],
    ),
    technique(
        "absolute-cut",
        "A node is split while its bound exceeds a fixed radiance (R4)",
        "conte2018",
        PER,
        &[
            Knob::float(
                "threshold",
                [0.0, 1.0 / 25_500.0, 1e9],
                "that radiance; linear, white is 1",
            )
            .log()
            .useful(1.0 / 255_000.0, 1.0 / 255.0)
            .accuracy(Accuracy::Unimodal),
            BOUND,
            TREE,
            REPRESENTATIVE,
            LEVELS,
            FANOUT,
            SPREAD,
        ],
    ),
    technique(
        "light-bvh",
        "Lights drawn down a tree by importance",
        "conty2018",
        ONLY,
        &[Knob::int("samples", [1, 16, 4096], "lights drawn a pixel")
            .log()
            .useful(1.0, 256.0)
            .accuracy(Accuracy::Monotone)],
    ),
    technique(
        "stochastic-lightcuts",
        "Stochastic lightcuts: a light drawn in every node of a cut",
        "yuksel2019",
        SHARED,
        &[
            Knob::int("cut", [1, 16, 1024], "nodes of the cut: lights drawn a pixel")
                .log()
                .useful(1.0, 128.0)
                .accuracy(Accuracy::Monotone),
            BINARY_TREE,
        ],
    ),
    technique(
        "reservoirs",
        "Reservoir resampling with reuse over space and time (ReSTIR)",
        "bitterli2020",
        REUSE,
        &[
            Knob::int("candidates", [1, 32, 4096], "lights drawn a pixel and frame").log(),
            Knob::choice("temporal", &["on", "off"], "whether the frame before is reused"),
            Knob::int("history", [1, 20, 1000], "most frames' candidates that it stands for").log(),
            Knob::int("neighbours", [0, 5, 64], "neighbours looked at a pixel").useful(0.0, 10.0),
            Knob::float("radius", [1.0, 30.0, 1000.0], "how far away they are at most")
                .unit("px")
                .log(),
        ],
    ),
    technique(
        "clustered",
        "Clustered shading: lights of finite reach in boxes of space",
        "olsson2012",
        ENDS,
        &[
            Knob::float(
                "cutoff",
                [1e-9, 1.0 / 1020.0, 1.0],
                "radiance of a white surface below which a light is left out",
            )
            .log()
            .useful(1.0 / 25_500.0, 1.0 / 25.5)
            .accuracy(Accuracy::Unimodal),
            Knob::int("tile", [1, 32, 1024], "pixels a side of a cluster").unit("px").log(),
            Knob::int("slices", [1, 24, 1024], "slices of depth").log(),
        ],
    ),
    technique(
        "capped",
        "A fixed most number: the strongest lights of 8 x 8 pixels",
        "conte2018",
        ONLY,
        &[Knob::int("most", [1, 256, 1_000_000], "most lights a pixel")
            .log()
            .useful(16.0, 4096.0)
            .accuracy(Accuracy::Monotone)],
    ),
];
