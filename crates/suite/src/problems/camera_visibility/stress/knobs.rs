//! Extremes of settings.

use super::{PAYS, SEEN, USUAL};
use crate::stress::{
    Axis, Values,
    settings::{Changes, Usual, position, with_all, words},
};

/// Enough frames for what is remembered to matter.
const FRAMES: &[(&str, &str)] = &[("width", "64"), ("frames", "10"), ("truth_samples", "1")];

const KNOBS: Usual = Usual { parameters: FRAMES, criterion: PAYS, ..USUAL };

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![
        latency(),
        batch(),
        assumed_visible(),
        threshold(),
        tight_depth(),
        tight_area(),
        across(),
        buffer(),
        occluders(),
        options(),
        tree(),
        coverage(),
    ]
}

fn latency() -> Axis {
    KNOBS.of_knob(
        "latency",
        "latency",
        "objects drawn and boxes asked before an answer is there, from none to more than there are",
        Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
        64.0,
    )
}

fn batch() -> Axis {
    KNOBS.of_knob(
        "batch",
        "batch",
        "queries of a batch, at most",
        Values::Whole { least: 1, greatest: 200, per_decade: 3 },
        50.0,
    )
}

fn assumed_visible() -> Axis {
    Axis {
        unit: "frames",
        ..KNOBS.of_knob(
            "assumed_visible",
            "assumed-visible",
            "frames that what was seen is drawn without being asked",
            Values::Whole { least: 0, greatest: 60, per_decade: 3 },
            5.0,
        )
    }
}

fn threshold() -> Axis {
    Axis {
        unit: "px",
        // What is given up, not what is bought.
        criterion: SEEN,
        ..KNOBS.of_knob(
            "tau",
            "tau",
            "pixels up to which a node counts as invisible: the share of pixels whose owner is not \
             drawn grows",
            Values::Whole { least: 0, greatest: 1000, per_decade: 2 },
            0.0,
        )
    }
}

fn tight_depth() -> Axis {
    KNOBS.of_knob(
        "tight_depth",
        "tight-depth",
        "levels below a node whose boxes are asked instead of its own",
        Values::Whole { least: 0, greatest: 4, per_decade: 10 },
        3.0,
    )
}

fn tight_area() -> Axis {
    KNOBS.of_knob(
        "tight_area",
        "tight-area",
        "most surface of those boxes, over the node's own",
        Values::Linear { least: 1.0, greatest: 4.0, steps: 5 },
        1.4,
    )
}

fn across() -> Axis {
    KNOBS.of_knob(
        "across",
        "across",
        "texels across that a box is asked at, at most",
        Values::Whole { least: 1, greatest: 64, per_decade: 3 },
        2.0,
    )
}

fn buffer() -> Axis {
    Axis {
        unit: "px",
        ..KNOBS.of_knob(
            "buffer",
            "buffer",
            "columns of the occlusion buffer before an image of 64, from one to many times it",
            Values::Whole { least: 1, greatest: 4096, per_decade: 2 },
            64.0,
        )
    }
}

fn occluders() -> Axis {
    Axis {
        unit: "triangles",
        ..KNOBS.of_knob(
            "occluder_triangles",
            "occluders",
            "most triangles of occluders, from none to all",
            Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
            8192.0,
        )
    }
}

/// What each word sets, with all parts on by default.
const OPTIONS: &[(&str, Changes)] = &[
    ("all", &[("jitter", "on")]),
    ("no-jitter", &[("jitter", "off")]),
    ("no-v-queue", &[("jitter", "on"), ("v_queue", "off")]),
    ("no-multiqueries", &[("jitter", "on"), ("multiqueries", "off")]),
    ("none", &[("jitter", "off"), ("v_queue", "off"), ("multiqueries", "off")]),
];
const OPTION_WORDS: [&str; OPTIONS.len()] = words(OPTIONS);

fn options() -> Axis {
    Axis {
        setting: Box::new(|setting, value| with_all(setting, OPTIONS.get(position(value))?.1)),
        ..KNOBS.axis(
            "options",
            "what a technique of several parts goes without",
            Values::Words(&OPTION_WORDS),
            0.0,
        )
    }
}

fn tree() -> Axis {
    KNOBS.of_knob(
        "tree",
        "tree",
        "the hierarchy that is walked",
        Values::Words(&["auto", "bottom-up", "city"]),
        0.0,
    )
}

fn coverage() -> Axis {
    KNOBS.of_knob(
        "coverage",
        "coverage",
        "where the stored coverage of nodes comes from: with no threshold it decides nothing",
        Values::Words(&["summed", "stale", "exact"]),
        0.0,
    )
}
