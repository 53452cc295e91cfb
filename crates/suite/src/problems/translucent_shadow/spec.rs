//! What the problem declares: metrics, parameters, techniques, knobs.

use crate::{
    knob::{Accuracy, Knob},
    problem::{
        Form, Metric, ONLY, Spec, Technique, Variant, metric, technique, technique_in, variant,
    },
};

/// The declaration.
pub static SPEC: Spec = Spec {
    id: "translucent-shadow",
    title: "Translucent shadows",
    question: "How much light reaches each visible point inside or behind translucent geometry?",
    truth: "Transmittance along light rays from the receiver, averaged over a fixed footprint.",
    metrics: METRICS,
    axis: "rmse",
    constraints: &[],
    levels: [0.03, 0.06, 0.12],
    pictures: true,
    parameters: PARAMETERS,
    default_scene: "grass",
    techniques: TECHNIQUES,
};

const METRICS: &[Metric] = &[
    metric("rmse", "root mean squared error of transmittance over all receivers"),
    metric("p95", "absolute error that 95 % of the receivers do not exceed"),
    metric("max", "largest absolute error"),
    metric("leak", "light too much: mean of the error where it is positive, 0 elsewhere"),
    metric("dark", "light too little: mean of -error where it is negative, 0 elsewhere"),
    metric("flip", "mean FLIP of the lit image, 67 pixels a degree"),
    metric("ssim_loss", "1 - structural similarity of the lit image"),
    metric(
        "layering_rmse",
        "error against the uncompressed deep shadow map of the same texels, taps and model: the \
         technique's own",
    ),
    metric(
        "model_rmse",
        "error of the setting's transmittance model: between deep shadow maps of its and the \
         truth's",
    ),
    metric("map_rmse", "error of the uncompressed deep shadow map at this resolution, one tap"),
    metric(
        "banding",
        "root mean squared step of the layering error along light rays, 128 steps a ray",
    ),
    metric(
        "idle_layers",
        "share of (ray, layer) cells without a fragment, over rays that meet one",
    ),
];

const PARAMETERS: &[Knob] = &[
    Knob::int("width", [16, 320, 7680], "image columns; rows are 9/16 of it")
        .unit("px")
        .log()
        .useful(160.0, 3840.0),
    Knob::float(
        "footprint",
        [0.0, 0.004, 0.5],
        "side of the window truth is averaged over, over the uncropped map's side; 0: one ray",
    )
    .useful(0.0, 0.05),
    Knob::int("truth_rays", [1, 3, 32], "truth: n x n stratified rays a receiver").log(),
    Knob::choice(
        "light",
        &["scene", "above", "slanted", "side"],
        "the scene's light, or straight down, at 45 degrees, 10 degrees above the horizon",
    ),
    Knob::choice("law", &["product", "exponential"], "truth multiplies 1 - alpha, or exp(-alpha)"),
    Knob::float(
        "opacity",
        [0.0, 0.0, 1.0],
        "opacity of all translucent surfaces; 0: the scene's own (alpha-tested leaves 176/255)",
    ),
    Knob::choice(
        "hair",
        &["lines", "ribbons"],
        "strands: lines as wide from the light as from the camera, or ribbons facing the camera",
    ),
];

const RESOLUTION: Knob = Knob::int("resolution", [16, 256, 4096], "side of the map")
    .unit("texels")
    .log()
    .useful(128.0, 2048.0)
    // Coarser ones blur more than the truth's window, finer ones less.
    .accuracy(Accuracy::Unimodal);
const TAPS: Knob = Knob::choice(
    "taps",
    &["3x3", "1", "4x4", "stochastic"],
    "texels read by a receiver; stochastic: 16 jittered",
);
const BLUR: Knob = Knob::choice(
    "blur",
    &["transmittance", "stored"],
    "whether taps are decoded and averaged, or averaged and decoded",
);
const BIAS: Knob = Knob::float("bias", [0.0, 1e-3, 0.1], "light depth taken from the receiver's")
    .log()
    .useful(1e-5, 1e-2);
const CROP: Knob = Knob::choice(
    "crop",
    &["on", "off"],
    "whether the map covers what casts and receives, or the whole scene",
);
const MODEL: Knob = Knob::choice(
    "model",
    &["tau", "alpha"],
    "thickness of a surface: -ln(1 - alpha), or alpha itself (thesis)",
);
const OPAQUE: Knob = Knob::choice(
    "opaque",
    &["separate", "weight", "weight-in-bounds"],
    "opaque casters: a depth map of their own, or a fragment of a weight (that stretches bounds)",
);
const WEIGHT: Knob =
    Knob::float("opaque_weight", [0.1, 3.0, 100.0], "optical thickness of an opaque caster").log();
const LAYERS: Knob = Knob::int("layers", [1, 16, 256], "layers K")
    .log()
    .useful(2.0, 64.0)
    .accuracy(Accuracy::Monotone);
const LOOKUP: Knob =
    Knob::choice("lookup", &["lerp", "nearest", "exclusive"], "how a receiver reads layers");
const FORMAT: Knob = Knob::choice(
    "format",
    &["f32", "f16", "unorm8", "unorm8-scaled", "fixed"],
    "storage of a layer; scaled: 8 ln 2 is 1; fixed: 12.20 bits",
);
const FLOAT: Knob = Knob::choice("format", &["f32", "f16"], "storage of a coefficient");
const BLEND: Knob = Knob::choice(
    "blend",
    &["add", "over", "alpha", "premultiplied"],
    "blend state; in the last two channels are not independent",
);
const STORAGE: Knob = Knob::choice(
    "storage",
    &["blend", "atomic"],
    "gpu: who adds, the blending unit or integer atomics",
);
const SLICING: Knob =
    Knob::choice("slicing", &["uniform", "density", "growing"], "where planes lie");
const SPAN: Knob = Knob::float(
    "span",
    [0.0, 0.0, 10.0],
    "depth of all layers over the light's range; 0: the deepest ray of the map",
)
.useful(0.02, 1.5);
const GROWTH: Knob =
    Knob::float("growth", [1.0, 1.0, 4.0], "each layer is this many times as deep as the last")
        .useful(1.0, 2.0);
const LAMBDA: Knob = Knob::float("lambda", [0.0, 0.0, 1.0], "split: 0 uniform, 1 logarithmic");
const SPLIT: Knob = Knob::choice(
    "split",
    &["normalised", "listing", "table8", "table32", "positions"],
    "how the split function is evaluated",
);
const END_MAP: Knob = Knob::choice(
    "end_map",
    &["max-blend", "atomic", "greater", "swapped", "range-flip"],
    "gpu: how the farthest depth is found",
);
const BOUNDED: Knob = Knob::choice(
    "bounds",
    &["ray", "map"],
    "depths are taken within each ray's ends, or the map's",
);

/// The knobs that every code of opacity shares, then the given ones.
macro_rules! knobs {
    ($($more:expr),* $(,)?) => {
        &[RESOLUTION, TAPS, BIAS, CROP, MODEL, OPAQUE, WEIGHT, $($more),*]
    };
}

/// A variant that a device does not run.
const fn cpu_variant(id: &'static str, help: &'static str) -> Variant {
    Variant { id, help, not_in: &[Form::Gpu] }
}

const NO_GPU: &[Form] = &[Form::Reference, Form::Cpu];

const PACKINGS: &[Variant] = &[
    variant("plain", "as suits the form: sorted on a processor, targets on a device"),
    variant("targets", "four layers a texture, eight textures a pass"),
    variant("single", "one texture and one pass a layer"),
    variant("slabs", "four layers a texture, one pass a texture"),
    cpu_variant("sorted", "fragments sorted into slabs and touched once"),
];

const TECHNIQUES: &[Technique] = &[
    technique(
        "osm",
        "Opacity shadow maps",
        "kim2001",
        PACKINGS,
        knobs![BLUR, LAYERS, LOOKUP, SLICING, BLEND, FORMAT, STORAGE],
    ),
    technique("unshadowed", "No shadow", "voicu2011", ONLY, &[RESOLUTION]),
    technique(
        "shadow-map",
        "Binary shadow map of all geometry",
        "williams1978",
        ONLY,
        &[RESOLUTION, TAPS, BIAS, CROP],
    ),
    technique(
        "pssm",
        "Parallel-split shadow maps of all geometry",
        "zhang2006",
        ONLY,
        &[
            RESOLUTION,
            Knob::choice("taps", &["3x3", "1", "4x4"], "texels compared for a receiver"),
            BIAS,
            Knob::int("splits", [1, 2, 8], "slices of the camera's view").useful(1.0, 4.0),
            Knob::float("split_lambda", [0.0, 0.5, 1.0], "slices: 0 even, 1 logarithmic"),
        ],
    ),
    technique(
        "dom",
        "Deep opacity maps",
        "yuksel2008",
        &[
            variant("repaired", "a fragment is added to its own and all later layers"),
            variant("listing", "the printed masks: later textures miss it in their first channels"),
        ],
        knobs![
            BLUR,
            LAYERS.accuracy(Accuracy::Unimodal),
            LOOKUP,
            SPAN,
            GROWTH,
            BLEND,
            FORMAT,
            STORAGE
        ],
    ),
    technique(
        "bom",
        "Bounding opacity maps",
        "voicu2011",
        &[
            variant("full", "K layers between each ray's ends"),
            variant("thesis", "K - 1 layers, the last for the end itself; fragments biased too"),
        ],
        knobs![BLUR, LAYERS, LOOKUP, LAMBDA, SPLIT, BLEND, FORMAT, STORAGE, END_MAP],
    ),
    technique_in(
        &[Form::Cpu, Form::Gpu],
        "bom-search",
        "Bounding opacity maps, split searched for",
        "voicu2011",
        &[
            variant("correlation", "least correlation of neighbouring maps (thesis)"),
            variant("sad", "greatest sum of absolute differences (thesis)"),
            cpu_variant("mutual-information", "least mutual information of neighbouring maps"),
            variant("equal-opacity", "layers of equal opacity"),
            variant("equal-transmittance", "layers of equal steps of transmittance"),
            cpu_variant("oracle", "least error against the deep shadow map: a bound, not a method"),
        ],
        knobs![
            BLUR,
            LAYERS,
            LOOKUP,
            FORMAT,
            Knob::int("tile", [0, 0, 4096], "texels a side that share a split; 0: all")
                .useful(0.0, 64.0),
            Knob::choice(
                "scoring",
                &["float", "bytes"],
                "maps as they are, or read back in 8 bits"
            ),
            Knob::float("lambda_step", [0.05, 0.1, 0.25], "step of the trial values, a part of 1"),
        ],
    ),
    technique(
        "fourier",
        "Fourier opacity maps",
        "jansen2010",
        ONLY,
        knobs![
            BLUR,
            Knob::int("pairs", [1, 3, 15], "pairs of cosine and sine")
                .useful(1.0, 7.0)
                .accuracy(Accuracy::Monotone),
            BOUNDED,
            FLOAT,
        ],
    ),
    technique_in(
        NO_GPU,
        "avsm",
        "Adaptive volumetric shadow maps",
        "salvi2010",
        &[variant("drawn", "fragments as they are drawn"), variant("sorted", "fragments by depth")],
        knobs![
            Knob::int("nodes", [2, 8, 64], "nodes a texel")
                .log()
                .useful(4.0, 32.0)
                .accuracy(Accuracy::Monotone)
        ],
    ),
    technique(
        "moments",
        "Moment-based transmittance",
        "muenstermann2018",
        &[variant("four", "four power moments"), variant("six", "six power moments")],
        knobs![
            BLUR,
            Knob::float(
                "moment_bias",
                [0.0, 0.0, 0.5],
                "pull towards safe moments; 0: the format's default",
            )
            .log()
            .useful(1e-7, 1e-2),
            Knob::float(
                "overestimation",
                [0.0, 0.6, 1.0],
                "0 the least, 1 the greatest transmittance the moments allow",
            ),
            BOUNDED,
            FLOAT,
        ],
    ),
    technique(
        "stochastic",
        "Stochastic shadow map",
        "enderton2010",
        ONLY,
        knobs![
            Knob::int("samples", [1, 8, 64], "depths a texel")
                .log()
                .useful(1.0, 32.0)
                .accuracy(Accuracy::Monotone),
        ],
    ),
    technique_in(
        NO_GPU,
        "deep",
        "Deep shadow map, compressed",
        "lokovic2000",
        ONLY,
        knobs![
            Knob::float("tolerance", [0.0, 0.02, 0.5], "greatest error of a stored transmittance")
                .useful(0.0, 0.1),
            Knob::int("nodes", [2, 64, 1024], "most nodes a texel")
                .log()
                .useful(8.0, 256.0)
                .accuracy(Accuracy::Monotone),
        ],
    ),
];
