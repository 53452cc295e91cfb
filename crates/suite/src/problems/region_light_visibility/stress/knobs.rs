//! Extremes of settings, and of how cells are cut.

use super::{GIVEN_UP, SOUND, USUAL};
use crate::stress::{
    Axis, Values,
    settings::{Usual, with},
};

/// What is given up grows to all there is: the ends of what still pays are found.
const KNOBS: Usual = Usual { criterion: GIVEN_UP, ..USUAL };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        tau(),
        most_split(),
        threshold(),
        points(),
        planes(),
        plane_distance(),
        projections(),
        texels(),
        rays(),
    ]
}

fn tau() -> Axis {
    Axis {
        unit: "px",
        ..USUAL.of_parameter(
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
    USUAL.of_parameter(
        "most_split",
        "most-split",
        "the smallest part of the city that is a cell of its own",
        Values::Words(&["any", "storey", "facade", "building"]),
        0.0,
    )
}

fn threshold() -> Axis {
    USUAL.of_parameter(
        "threshold",
        "threshold",
        "radiance of a white surface below which a light does not matter, from none to white",
        Values::FromZero { least: 1e-9, greatest: 1.0, per_decade: 1 },
        1.0 / 1020.0,
    )
}

fn points() -> Axis {
    USUAL.of_parameter(
        "truth_points",
        "points",
        "points of a face that are tried for each light: more of them find what few do not",
        Values::Whole { least: 8, greatest: 3_000, per_decade: 1 },
        32.0,
    )
}

fn planes() -> Axis {
    KNOBS.of_knob(
        "planes",
        "planes",
        "where planes lie",
        Values::Words(&["far-faces", "behind", "every"]),
        0.0,
    )
}

fn plane_distance() -> Axis {
    Axis {
        unit: "m",
        setting: Box::new(|setting, value| {
            with(&with(setting, "planes", "every")?, "plane_distance", value)
        }),
        ..KNOBS.axis(
            "plane-distance",
            "distance of planes that lie at equal distances",
            Values::Log { least: 0.1, greatest: 1e4, per_decade: 2 },
            10.0,
        )
    }
}

fn projections() -> Axis {
    KNOBS.of_knob(
        "projections",
        "projections",
        "whether a cluster's projections are computed for each test or kept",
        Values::Words(&["anew", "kept"]),
        0.0,
    )
}

fn texels() -> Axis {
    KNOBS.of_knob(
        "texels",
        "texels",
        "texels a side of a plane's map",
        Values::Whole { least: 16, greatest: 1024, per_decade: 2 },
        256.0,
    )
}

fn rays() -> Axis {
    Axis {
        criterion: SOUND,
        ..KNOBS.of_knob(
            "rays",
            "rays",
            "rays from a face to each light: what few do not find is lost",
            Values::Whole { least: 1, greatest: 1024, per_decade: 1 },
            16.0,
        )
    }
}
