//! Extremes of settings.

use super::{GIVEN_UP, SEEN, STEPS, USUAL};
use crate::stress::{Axis, Values, settings::Usual};

/// What is given up grows to all there is: the ends of what still pays are found.
const KNOBS: Usual = Usual { criterion: GIVEN_UP, ..USUAL };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        cut(),
        threshold(),
        tau(),
        most_split(),
        heights(),
        validity(),
        budget(),
        shadow_rays(),
        candidates(),
        neighbours(),
    ]
}

fn cut() -> Axis {
    KNOBS.of_knob(
        "cut",
        "cut",
        "radiance that bounds may reach, from none, where every light is added, to all, where precuts \
         are",
        Values::FromZero { least: 1e-9, greatest: 1e9, per_decade: 1 },
        1.0 / 25_500.0,
    )
}

fn threshold() -> Axis {
    KNOBS.of_knob(
        "threshold",
        "threshold",
        "radiance of a white surface below which a cluster does not reach a cell, from none to white",
        Values::FromZero { least: 1e-9, greatest: 1.0, per_decade: 1 },
        1.0 / 1020.0,
    )
}

fn tau() -> Axis {
    Axis {
        unit: "px",
        criterion: SEEN,
        ..KNOBS.of_knob(
            "tau",
            "tau",
            "pixels of an image of 1200 x 900 beyond which a cell is divided: from cells of one object \
             to one that holds the city",
            Values::Whole { least: 0, greatest: 2_000_000, per_decade: 1 },
            16_384.0,
        )
    }
}

fn most_split() -> Axis {
    Axis {
        criterion: SEEN,
        ..KNOBS.of_knob(
            "most_split",
            "most-split",
            "the smallest part of the city that is a cell of its own",
            Values::Words(&["any", "storey", "facade", "building"]),
            0.0,
        )
    }
}

fn validity() -> Axis {
    Axis {
        unit: "frames",
        parameters: STEPS,
        // The same images, whenever lights are found.
        criterion: super::UNCHANGED,
        ..KNOBS.of_knob(
            "validity",
            "validity",
            "frames after which a cell's lights are found anew; 0: never again",
            Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
            50.0,
        )
    }
}

fn heights() -> Axis {
    Axis {
        criterion: SEEN,
        ..KNOBS.of_knob(
            "heights",
            "cell-heights",
            "heights of a cell up to which it is found what is hidden below them",
            Values::Whole { least: 0, greatest: 8, per_decade: 3 },
            0.0,
        )
    }
}

fn budget() -> Axis {
    Axis {
        parameters: STEPS,
        // What waits leaks, and nothing else.
        criterion: SEEN,
        ..KNOBS.of_knob(
            "budget",
            "budget",
            "most cells and directions a frame whose lights are found, from one; 0: all",
            Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
            0.0,
        )
    }
}

fn shadow_rays() -> Axis {
    KNOBS.of_knob(
        "shadow_rays",
        "shadow-rays",
        "whether each cluster that a pixel adds up costs a shadow ray",
        Values::Words(&["off", "on"]),
        0.0,
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

fn neighbours() -> Axis {
    KNOBS.of_knob(
        "neighbours",
        "neighbours",
        "neighbours looked at a pixel, from none to most of a small image",
        Values::Whole { least: 0, greatest: 64, per_decade: 2 },
        5.0,
    )
}
