//! Extremes of settings and of the window.

use super::{LAYERING, LAYERS, USUAL};
use crate::stress::{Axis, Criterion, Values, settings::with};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        layers(),
        nodes(),
        pairs(),
        samples(),
        map(),
        footprint(),
        bias(),
        span(),
        lambda(),
        moment_bias(),
        precision(),
    ]
}

fn layers() -> Axis {
    LAYERS.of_knob(
        "layers",
        "layers",
        "layers K, from the total alone to the most there can be",
        Values::Whole { least: 1, greatest: 256, per_decade: 4 },
        16.0,
    )
}

fn nodes() -> Axis {
    LAYERS.of_knob(
        "nodes",
        "nodes",
        "nodes of a texel; past 64 those that are searched at every fragment are refused",
        Values::Whole { least: 2, greatest: 1024, per_decade: 2 },
        16.0,
    )
}

fn pairs() -> Axis {
    LAYERS.of_knob(
        "pairs",
        "pairs",
        "pairs of cosine and sine",
        Values::Whole { least: 1, greatest: 15, per_decade: 4 },
        3.0,
    )
}

fn samples() -> Axis {
    LAYERS.of_knob(
        "samples",
        "samples",
        "depths of a texel",
        Values::Whole { least: 1, greatest: 64, per_decade: 3 },
        8.0,
    )
}

/// A point's truth, which finer texels only come closer to: a window would ask for more taps.
const POINT: &[(&str, &str)] = &[("width", "96"), ("truth_rays", "1"), ("footprint", "0")];

/// Layers of the largest maps: 16 of them would take gigabytes.
const FEW_LAYERS: u32 = 4;

fn map() -> Axis {
    Axis {
        unit: "texels",
        parameters: POINT,
        setting: Box::new(|setting, value| {
            let few = with(setting, "layers", FEW_LAYERS);
            with(&few.unwrap_or_else(|| setting.clone()), "resolution", value as u32)
        }),
        ..USUAL.axis(
            "map",
            "side of the map, with four layers where there are layers; what is past 8192 is on the \
             axis bad-settings",
            // A search of eleven frames at 4096 takes longer than a point may.
            Values::Whole { least: 1, greatest: 2048, per_decade: 1 },
            256.0,
        )
    }
}

fn footprint() -> Axis {
    // A wider window is another signal, not a worse one: a technique that keeps up has no more
    // error.
    USUAL.of_parameter(
        "footprint",
        "footprint-over-map",
        "side of the truth's window over the map's side: from a point to half of the map",
        Values::FromZero { least: 1e-4, greatest: 0.5, per_decade: 2 },
        0.004,
    )
}

fn bias() -> Axis {
    // Not against the uncompressed map, which has the same bias.
    USUAL.of_knob(
        "bias",
        "bias",
        "light depth taken from the receiver's, from none",
        Values::FromZero { least: 1e-7, greatest: 0.1, per_decade: 1 },
        1e-3,
    )
}

fn span() -> Axis {
    LAYERS.of_knob(
        "span",
        "span",
        "depth of all of a deep opacity map's layers over the light's range, from a share of the \
         volume to many times it",
        Values::Log { least: 1e-3, greatest: 10.0, per_decade: 2 },
        0.5,
    )
}

fn lambda() -> Axis {
    LAYERS.of_knob(
        "lambda",
        "lambda",
        "split of a bounding opacity map, from uniform to logarithmic",
        Values::Linear { least: 0.0, greatest: 1.0, steps: 8 },
        0.0,
    )
}

fn moment_bias() -> Axis {
    LAYERS.of_knob(
        "moment_bias",
        "moment-bias",
        "pull of moments towards safe ones",
        Values::Log { least: 1e-9, greatest: 0.5, per_decade: 1 },
        1e-5,
    )
}

fn precision() -> Axis {
    Axis {
        // The same answer with fewer bits: what they cost should not show in a front.
        criterion: Criterion { times: 1.1, plus: 0.01, ..LAYERING },
        ..LAYERS.of_knob(
            "format",
            "precision",
            "storage of a layer or a coefficient, for techniques that can store it so",
            Values::Words(&["f32", "f16", "unorm8", "unorm8-scaled", "fixed"]),
            0.0,
        )
    }
}
