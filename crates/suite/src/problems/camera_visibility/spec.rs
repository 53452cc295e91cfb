//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    city,
    knob::{Accuracy, Knob},
    problem::{Constraint, Metric, ONLY, Spec, Technique, Variant, metric, technique, variant},
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "camera-visibility",
    title: "Camera visibility",
    question: "Which objects does the camera see, and what does it cost to find out and draw them?",
    truth: "Item buffer by rays along a camera path: an object is seen if it owns a pixel.",
    metrics: METRICS,
    axis: "overdraw",
    constraints: &[
        Constraint { metric: "missed", limit: 0.0 },
        Constraint { metric: "foreknowledge", limit: 0.0 },
    ],
    levels: [3.0, 10.0, 30.0],
    pictures: true,
    parameters: PARAMETERS,
    default_scene: "city_small",
    techniques: TECHNIQUES,
};

const METRICS: &[Metric] = &[
    metric(
        "overdraw",
        "triangles drawn that own no ray, over triangles that own one; summed over the path",
    ),
    metric("overdraw_objects", "objects drawn that own no ray, over objects that own one"),
    metric(
        "missed",
        "share of the pixels whose owner was not drawn, where rounding cannot change the owner",
    ),
    metric(
        "missed_samples",
        "the same by the finer grid of rays: objects smaller than a pixel too",
    ),
    metric("wrong_pixels", "share of pixels that lie deeper than when everything is drawn"),
    metric(
        "coverage_excess",
        "stored coverage of the objects that own pixels, over the pixels they own, minus 1",
    ),
    metric("foreknowledge", "1 where the truth itself says what to draw: a bound, not a method"),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [16, 256, 7680], "image columns; rows are 9/16 of it")
        .unit("px")
        .log()
        .useful(128.0, 3840.0),
    Knob::int("frames", [1, 24, 10_000], "frames of the path, from its start").log(),
    Knob::int("truth_samples", [1, 2, 16], "truth: n x n rays a pixel beside its centre's").log(),
    Knob::int(
        "object_triangles",
        [1, 128, 1_048_576],
        "meshes of more triangles are cut into objects of at most so many",
    )
    .log()
    .useful(16.0, 4096.0),
    city::BLOCKS,
    city::HEIGHTS,
    city::LAYOUT,
    city::EMPTY,
    city::STREET,
];

const DRAWS: Knob = Knob::choice(
    "draws",
    &["instanced", "object", "quad"],
    "gpu: one draw call a template, an object, or two triangles (thesis)",
);
const TREE: Knob = Knob::choice(
    "tree",
    &["auto", "bottom-up", "city"],
    "hierarchy: the city's where there is one, smallest surface first, or the city's",
);
const COUNTING: Knob = Knob::choice(
    "counting",
    &["auto", "query", "atomic", "boolean"],
    "gpu: how pixels are counted; auto: by what the probes found",
);
const READINESS: Knob = Knob::choice(
    "readiness",
    &["modelled", "polled"],
    "when answers are looked at: after `latency` operations, or (gpu) when the device says so",
);
const LATENCY: Knob = Knob::int(
    "latency",
    [0, 64, 1_000_000],
    "modelled: objects drawn and boxes asked before an answer is there",
)
.log()
.useful(1.0, 1024.0);
const TAU: Knob = Knob::int("tau", [0, 0, 1000], "pixels up to which a node counts as invisible")
    .unit("px")
    .useful(0.0, 100.0);
const COVERAGE: Knob = Knob::choice(
    "coverage",
    &["summed", "stale", "exact"],
    "stored coverage of inner nodes: children summed, as last asked, or by the id histogram",
);

const fn switch(name: &'static str, help: &'static str) -> Knob {
    Knob::choice(name, &["on", "off"], help)
}

const RESULTS: &[Variant] = &[
    variant("exact", "answers are waited for: nothing seen is culled"),
    variant("next-frame", "answers count from the next frame on: approximate (thesis, Fig. 2.4)"),
];

const TECHNIQUES: &[Technique] = &[
    technique("none", "Everything is drawn", "conte2018", ONLY, &[DRAWS]),
    technique("frustum", "Hierarchical frustum culling", "clark1976", ONLY, &[TREE, DRAWS]),
    technique(
        "stop-and-wait",
        "Hierarchical stop-and-wait occlusion queries",
        "bittner2004",
        ONLY,
        &[TREE, TAU, COVERAGE, DRAWS, COUNTING, READINESS, LATENCY],
    ),
    technique(
        "chc",
        "Coherent hierarchical culling",
        "bittner2004",
        RESULTS,
        &[TREE, TAU, COVERAGE, DRAWS, COUNTING, READINESS, LATENCY],
    ),
    technique(
        "chcpp",
        "Coherent hierarchical culling revisited (CHC++)",
        "mattausch2008",
        RESULTS,
        &[
            Knob::int("assumed_visible", [0, 5, 60], "frames a visible node is assumed to stay so")
                .useful(0.0, 20.0)
                .accuracy(Accuracy::None),
            Knob::int("batch", [1, 50, 200], "queries of invisible nodes asked at once").log(),
            switch("jitter", "the first interval of assumed visibility is random"),
            switch("v_queue", "visible nodes are asked while waiting, for the next frame"),
            switch("multiqueries", "nodes likely to stay invisible are asked together"),
            Knob::int(
                "tight_depth",
                [0, 3, 4],
                "levels below a node whose boxes are asked instead",
            ),
            Knob::float(
                "tight_area",
                [1.0, 1.4, 4.0],
                "most summed surface of those boxes, over the node's own",
            ),
            TREE,
            TAU,
            COVERAGE,
            DRAWS,
            COUNTING,
            READINESS,
            LATENCY,
        ],
    ),
    technique(
        "hierarchical-depth",
        "Two-pass culling by hierarchical depth",
        "haar2015",
        ONLY,
        &[
            Knob::choice(
                "traversal",
                &["flat", "tree"],
                "boxes asked: every object's, or (not gpu) from the root of the hierarchy",
            ),
            Knob::int("across", [1, 2, 64], "texels across that a box is asked at, at most")
                .log()
                .useful(1.0, 16.0)
                .accuracy(Accuracy::Monotone),
            TREE,
        ],
    ),
    technique(
        "masked",
        "Masked software occlusion culling",
        "hasselgren2016",
        &[
            variant("meshes", "occluders are the objects themselves, largest first"),
            variant("boxes", "occluders are boxes inscribed in buildings: cities only"),
        ],
        &[
            Knob::int("buffer", [0, 0, 8192], "columns of the occlusion buffer; 0: the image's")
                .unit("px")
                .useful(64.0, 2048.0),
            Knob::int("occluder_triangles", [0, 8192, 16_777_216], "most triangles of occluders")
                .useful(256.0, 65536.0),
            TREE,
            DRAWS,
        ],
    ),
    technique(
        "oracle",
        "What the truth says is seen: a bound, not a method",
        "conte2018",
        ONLY,
        &[DRAWS],
    ),
];
