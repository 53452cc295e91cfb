//! Extremes of settings.

use super::{CITY, GIVEN_UP, STEPS, USUAL, of_cloud};
use crate::stress::{Axis, Criterion, Values, settings::Usual};

/// What is given up grows to all there is: the ends of what still pays are found.
const KNOBS: Usual = Usual { criterion: GIVEN_UP, ..USUAL };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    let lit_cloud = [
        threshold(),
        own_epsilon(),
        epsilon(),
        most(),
        samples(),
        cut(),
        candidates(),
        history(),
        neighbours(),
        radius(),
        cutoff(),
        tile(),
        slices(),
        spread(),
        bound(),
        selection(),
        temporal(),
    ];
    let lit_city = [fanout(), levels(), tree(), representative()];
    let on_cloud = |axis: Axis| Axis { prepare: of_cloud(|_, _| ()), ..axis };
    let on_city = |axis| Axis { parameters: CITY, ..axis };
    lit_cloud.into_iter().map(on_cloud).chain(lit_city.into_iter().map(on_city)).collect()
}

fn threshold() -> Axis {
    KNOBS.of_knob(
        "threshold",
        "threshold",
        "radiance that bounds may reach, from none, where every light is added, to all, where roots \
         are",
        Values::FromZero { least: 1e-12, greatest: 1e9, per_decade: 1 },
        1.0 / 25_500.0,
    )
}

fn own_epsilon() -> Axis {
    KNOBS.of_knob(
        "own_epsilon",
        "own-epsilon",
        "excess of a node's bound over its own estimate, over that estimate",
        Values::FromZero { least: 1e-6, greatest: 1e6, per_decade: 1 },
        0.5,
    )
}

fn epsilon() -> Axis {
    KNOBS.of_knob(
        "epsilon",
        "epsilon",
        "bound of a node over the estimate of the pixel, from none to far more than it",
        Values::FromZero { least: 1e-6, greatest: 100.0, per_decade: 1 },
        0.02,
    )
}

fn most() -> Axis {
    KNOBS.of_knob(
        "most",
        "most",
        "most nodes of a cut, most lights of a list, from one to more than there are",
        Values::Whole { least: 1, greatest: 16_384, per_decade: 2 },
        256.0,
    )
}

fn samples() -> Axis {
    Axis {
        parameters: FEW_PIXELS,
        ..KNOBS.of_knob(
            "samples",
            "samples",
            "lights drawn a pixel, from one to many times their number",
            Values::Whole { least: 1, greatest: 4096, per_decade: 1 },
            16.0,
        )
    }
}

/// Thousands of draws a pixel.
const FEW_PIXELS: &[(&str, &str)] = &[("width", "14"), ("frames", "1"), ("truth_pixels", "98")];

fn cut() -> Axis {
    KNOBS.of_knob(
        "cut",
        "cut",
        "nodes of a cut that lights are drawn in, from the root to every light",
        Values::Whole { least: 1, greatest: 1024, per_decade: 2 },
        16.0,
    )
}

fn candidates() -> Axis {
    KNOBS.of_knob(
        "candidates",
        "candidates",
        "lights drawn a pixel and frame to choose one of",
        Values::Whole { least: 1, greatest: 4096, per_decade: 1 },
        32.0,
    )
}

fn history() -> Axis {
    Axis {
        parameters: STEPS,
        unit: "frames",
        ..KNOBS.of_knob(
            "history",
            "history",
            "most frames' candidates that what is remembered stands for",
            Values::Whole { least: 1, greatest: 1000, per_decade: 1 },
            20.0,
        )
    }
}

fn neighbours() -> Axis {
    KNOBS.of_knob(
        "neighbours",
        "neighbours",
        "neighbours looked at a pixel, from none to most of a small image",
        Values::Whole { least: 0, greatest: 64, per_decade: 2 },
        5.0,
    )
}

fn radius() -> Axis {
    Axis {
        unit: "px",
        ..KNOBS.of_knob(
            "radius",
            "radius",
            "how far away neighbours are at most, up to far outside the image",
            Values::Log { least: 1.0, greatest: 1000.0, per_decade: 2 },
            30.0,
        )
    }
}

fn cutoff() -> Axis {
    KNOBS.of_knob(
        "cutoff",
        "cutoff",
        "radiance of a white surface below which a light is left out",
        Values::Log { least: 1e-9, greatest: 1.0, per_decade: 2 },
        1.0 / 1020.0,
    )
}

fn tile() -> Axis {
    Axis {
        unit: "px",
        // Which lights a pixel gets does not depend on how space is cut up.
        criterion: SAME_LIGHTS,
        ..KNOBS.of_knob(
            "tile",
            "tile",
            "pixels a side of a cluster, from one to more than the image",
            Values::Whole { least: 1, greatest: 1024, per_decade: 1 },
            32.0,
        )
    }
}

fn slices() -> Axis {
    Axis {
        criterion: SAME_LIGHTS,
        ..KNOBS.of_knob(
            "slices",
            "slices",
            "slices of depth",
            Values::Whole { least: 1, greatest: 1024, per_decade: 1 },
            24.0,
        )
    }
}

/// The same lights at every pixel, summed in another order.
const SAME_LIGHTS: Criterion = Criterion { metric: "error_p99", times: 1.0, plus: 1e-6 };

fn spread() -> Axis {
    KNOBS.of_knob(
        "spread",
        "spread",
        "weight of directions against distances where lights are clustered",
        Values::FromZero { least: 1e-3, greatest: 100.0, per_decade: 1 },
        1.0,
    )
}

fn bound() -> Axis {
    KNOBS.of_knob(
        "bound",
        "bound",
        "how a cosine over a box is bounded",
        Values::Words(&["cheap", "walter"]),
        0.0,
    )
}

fn selection() -> Axis {
    Axis {
        // The same cut.
        criterion: SAME_LIGHTS,
        ..KNOBS.of_knob(
            "selection",
            "selection",
            "how the worst node of a cut is found",
            Values::Words(&["heap", "scan"]),
            0.0,
        )
    }
}

fn temporal() -> Axis {
    KNOBS.of_knob(
        "temporal",
        "temporal",
        "whether the frame before is reused",
        Values::Words(&["on", "off"]),
        0.0,
    )
}

fn fanout() -> Axis {
    KNOBS.of_knob(
        "fanout",
        "fanout",
        "most children of a node of the city's hierarchy; 0: any; a node of one child is none",
        Values::Whole { least: 0, greatest: 10_000, per_decade: 1 },
        0.0,
    )
}

fn levels() -> Axis {
    KNOBS.of_knob(
        "levels",
        "levels",
        "the city's hierarchy without one of its levels",
        Values::Words(&["all", "no-storeys", "no-facades", "no-buildings", "no-blocks"]),
        0.0,
    )
}

fn tree() -> Axis {
    KNOBS.of_knob(
        "tree",
        "tree",
        "the clusters that are walked",
        Values::Words(&["original", "median", "city"]),
        0.0,
    )
}

fn representative() -> Axis {
    KNOBS.of_knob(
        "representative",
        "representative",
        "where a cluster shines from",
        Values::Words(&["weighted", "random", "nearest"]),
        0.0,
    )
}
