//! Extremes of settings and of the window.

use super::USUAL;
use crate::stress::{
    Axis, Criterion, Values,
    settings::{position, typed, with},
};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        footprint(),
        map(),
        precision(),
        bias(),
        exponent(),
        min_variance(),
        moment_bias(),
        layers(),
    ]
}

/// Texels a side of the map below windows of every size: checks read each texel of a window, and
/// the widest holds more than the map.
const SIDE_BELOW_WINDOWS: u32 = 128;

fn footprint() -> Axis {
    Axis {
        setting: Box::new(|setting, _| with(setting, "resolution", SIDE_BELOW_WINDOWS)),
        // A window of another size is another signal, not a worse one: a technique that keeps up
        // has no more error.
        ..USUAL.of_parameter(
            "footprint",
            "footprint-over-map",
            "side of the window over the map's side, at 128 texels: from a hundredth of a texel \
             to a window that is wider than the map",
            // At home 7 texels, as many as the default footprint has of the default map.
            Values::Log { least: 1e-4, greatest: 1.2, per_decade: 2 },
            0.05,
        )
    }
}

fn map() -> Axis {
    Axis {
        unit: "texels",
        ..USUAL.of_knob(
            "resolution",
            "map",
            "side of the map; what is past 16384 is on the axis bad-settings",
            Values::Whole { least: 1, greatest: 4096, per_decade: 2 },
            512.0,
        )
    }
}

fn precision() -> Axis {
    Axis {
        // The same answer with fewer bits: what they cost should not show in a front.
        criterion: Criterion { metric: "rmse", times: 1.1, plus: 0.01 },
        ..USUAL.of_knob(
            "format",
            "precision",
            "storage of a channel, for techniques that can store it so",
            Values::Words(&["f32", "f16", "u16"]),
            0.0,
        )
    }
}

fn bias() -> Axis {
    USUAL.of_knob(
        "bias",
        "bias",
        "normalised depth taken from the receiver's, from none",
        Values::FromZero { least: 1e-7, greatest: 0.1, per_decade: 1 },
        1e-3,
    )
}

fn exponent() -> Axis {
    USUAL.of_knob(
        "exponent",
        "exponent",
        "c of the exponential techniques; past the format's largest it is refused",
        Values::Log { least: 0.1, greatest: 1000.0, per_decade: 2 },
        10.0,
    )
}

fn min_variance() -> Axis {
    USUAL.of_knob(
        "min_variance",
        "min-variance",
        "least variance, squared normalised depth",
        Values::Log { least: 1e-12, greatest: 0.1, per_decade: 1 },
        1e-5,
    )
}

fn moment_bias() -> Axis {
    USUAL.of_knob(
        "moment_bias",
        "moment-bias",
        "pull of four moments towards safe ones",
        Values::Log { least: 1e-9, greatest: 0.5, per_decade: 1 },
        3e-6,
    )
}

/// Numbers of layers; the last two are none there are.
const LAYERS: [&str; 6] = ["4", "1", "2", "8", "3", "16"];

fn layers() -> Axis {
    Axis {
        must_refuse: |value| matches!(LAYERS.get(position(value)), Some(&("3" | "16"))),
        setting: Box::new(|setting, value| {
            with(setting, "layers", typed(LAYERS.get(position(value))?))
        }),
        ..USUAL.axis(
            "layers",
            "depth layers: 1, 2, 4 and 8 work; 3 and 16 must be refused",
            Values::Words(&LAYERS),
            0.0,
        )
    }
}
