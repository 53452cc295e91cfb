//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    knob::{Accuracy, Knob},
    problem::{Metric, ONLY, Spec, Technique, Variant, metric, technique, variant},
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "shadow-filtering",
    title: "Shadow-map filtering",
    question: "Which share of a fixed footprint around each receiver is lit, from one depth map?",
    truth: "Ray-traced visibility of the receiver's own surface averaged over the footprint, \
            stratified rays.",
    metrics: METRICS,
    axis: "rmse",
    constraints: &[],
    levels: [0.02, 0.05, 0.1],
    pictures: true,
    parameters: PARAMETERS,
    default_scene: "spheres",
    techniques: TECHNIQUES,
};

const METRICS: &[Metric] = &[
    metric("rmse", "root mean squared error of visibility over the lit-facing receivers"),
    metric("p99", "absolute error that 99 % of these receivers do not exceed"),
    metric("max", "largest absolute error"),
    metric("flip", "mean FLIP of the shadow image, 67 pixels a degree"),
    metric("ssim_loss", "1 - structural similarity of the shadow image"),
    metric("leak", "light leaking: mean visibility where truth is exactly 0"),
    metric("dark", "light lost: mean of 1 - visibility where truth is exactly 1"),
    metric(
        "estimator_rmse",
        "root mean squared error against the exact share of the same stored texels at the same \
         bias (a seeded subset of receivers)",
    ),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [16, 320, 7680], "image columns; rows are 9/16 of it")
        .unit("px")
        .log()
        .useful(160.0, 3840.0),
    Knob::float("footprint", [1e-4, 0.015, 0.5], "side of the window over the map's side")
        .log()
        .useful(2e-3, 0.1),
    Knob::int("truth_rays", [1, 8, 64], "truth: n x n stratified rays a receiver").log(),
];

const RESOLUTION: Knob = Knob::int("resolution", [16, 512, 8192], "side of the map")
    .unit("texels")
    .log()
    .useful(128.0, 4096.0)
    .accuracy(Accuracy::Unimodal);
const FORMAT: Knob = Knob::choice("format", &["f32", "f16", "u16"], "storage of a channel");
const FLOAT: Knob = Knob::choice("format", &["f32", "f16"], "storage of a channel");
const KERNEL: Knob =
    Knob::choice("kernel", &["box", "gaussian"], "window weights, of equal variance");
const LOOKUP: Knob =
    Knob::choice("lookup", &["bilinear", "nearest"], "how a receiver reads the filtered map");
const HARD_LOOKUP: Knob =
    Knob::choice("lookup", &["nearest", "bilinear"], "how a receiver reads the map");
const BIAS: Knob =
    Knob::float("bias", [0.0, 1e-3, 0.1], "normalised depth taken from the receiver's")
        .log()
        .useful(1e-4, 2e-2)
        .accuracy(Accuracy::Unimodal);
const PLANE_BIAS: Knob = Knob::choice(
    "plane_bias",
    &["on", "off"],
    "whether the receiver's slope moves the comparison (a half texel's worth for filtered maps)",
);
const MIN_VARIANCE: Knob = Knob::float(
    "min_variance",
    [0.0, 0.0, 0.1],
    "least variance, squared normalised depth; 0: the default (1e-5 in f32, 1e-4 in 16 bits; evsm 1e-8, 1e-5)",
)
.log()
.useful(1e-7, 1e-2)
.accuracy(Accuracy::Unimodal);
const BLEED: Knob =
    Knob::float("bleed_reduction", [0.0, 0.2, 0.95], "visibility that linstep cuts off");
const ESM_EXPONENT: Knob = Knob::float(
    "exponent",
    [0.0, 0.0, 500.0],
    "c; 0: the format's default (80; 11 for linear f16); refused where the format overflows",
)
.log()
.useful(10.0, 500.0)
.accuracy(Accuracy::Unimodal);
const EVSM_EXPONENT: Knob = Knob::float(
    "exponent",
    [0.0, 0.0, 44.0],
    "c; 0: the format's default (10 in f32, 5.54 in f16); refused where the format overflows",
)
.log()
.useful(2.0, 40.0)
.accuracy(Accuracy::Unimodal);
const LAYERS: Knob = Knob::int("layers", [1, 4, 8], "depth layers: 1, 2, 4 or 8").log();
const TAPS: Knob = Knob::int("taps", [0, 0, 4095], "n x n texels read of the window; 0: every one")
    .log()
    .useful(2.0, 16.0)
    .accuracy(Accuracy::Monotone);
const MOMENT_BIAS: Knob = Knob::float(
    "moment_bias",
    [0.0, 0.0, 0.5],
    "pull towards safe moments; 0: the format's default (3e-6 f32, 6e-5 u16, 2e-3 f16)",
)
.log()
.useful(1e-7, 1e-2)
.accuracy(Accuracy::Unimodal);

const VARIANCE: &[Knob] = &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, MIN_VARIANCE];
const LAYERED: &[Knob] =
    &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, MIN_VARIANCE, LAYERS];

const SPLITS: &[Variant] = &[
    variant("uniform", "layers of equal depth range"),
    variant("lloyd", "splits by Lloyd relaxation over the map's depths"),
];

const TECHNIQUES: &[Technique] = &[
    technique(
        "vsm",
        "Variance shadow map",
        "donnelly2006",
        &[
            variant("min-variance", "variance raised to a minimum"),
            variant("plain", "Chebyshev's bound as it is"),
            variant("linstep", "min-variance, then low visibilities cut and the rest stretched"),
            variant("max", "min-variance, and dark beyond the window's largest depth"),
        ],
        &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, MIN_VARIANCE, BLEED],
    ),
    technique(
        "hard",
        "Hard shadow map",
        "williams1978",
        ONLY,
        &[RESOLUTION, FORMAT, HARD_LOOKUP, BIAS, PLANE_BIAS],
    ),
    technique(
        "pcf",
        "Percentage-closer filtering",
        "reeves1987",
        ONLY,
        &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, TAPS],
    ),
    technique("gaussian-cdf", "Gaussian CDF shadow map", "gumbau2011", ONLY, VARIANCE),
    technique(
        "power-cdf",
        "Power CDF shadow map",
        "gumbau2011",
        ONLY,
        &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS],
    ),
    technique(
        "esm",
        "Exponential shadow map",
        "annen2008",
        &[
            variant("log", "stored and filtered in log space: no overflow"),
            variant("linear", "stored and filtered as exp(c z)"),
        ],
        &[RESOLUTION, FLOAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, ESM_EXPONENT],
    ),
    technique("lvsm", "Layered variance shadow map", "lauritzen2008", SPLITS, LAYERED),
    technique("layered-gaussian", "Layered Gaussian CDF", "gumbau2011", SPLITS, LAYERED),
    technique(
        "layered-power",
        "Layered power CDF",
        "gumbau2011",
        SPLITS,
        &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, LAYERS],
    ),
    technique(
        "evsm",
        "Exponential variance shadow map",
        "lauritzen2008",
        &[variant("four", "both warps, the smaller bound"), variant("two", "positive warp alone")],
        &[RESOLUTION, FLOAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, MIN_VARIANCE, EVSM_EXPONENT],
    ),
    technique(
        "msm",
        "Moment shadow map",
        "peters2015",
        &[variant("hamburger", "four moments of depth")],
        &[RESOLUTION, FORMAT, KERNEL, LOOKUP, BIAS, PLANE_BIAS, MOMENT_BIAS],
    ),
];
