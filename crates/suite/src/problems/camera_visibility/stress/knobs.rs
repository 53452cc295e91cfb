//! Extremes of settings.

use super::{FORMS, PAYS, SEEN, unpushed};
use crate::{
    problem::Setting,
    stress::{
        Axis, Values,
        settings::{never, position, with},
    },
};

/// Enough frames for what is remembered to matter.
const FRAMES: &[(&str, &str)] = &[("width", "64"), ("frames", "10"), ("truth_samples", "1")];

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

/// An axis of settings alone: the case stays as it is.
fn of_settings(
    id: &'static str,
    help: &'static str,
    values: Values,
    home: f64,
    setting: fn(&Setting, f64) -> Option<Setting>,
) -> Axis {
    Axis {
        id,
        unit: "",
        help,
        values,
        home,
        parameters: FRAMES,
        forms: FORMS,
        criterion: PAYS,
        must_refuse: never,
        prepare: unpushed(),
        setting,
    }
}

fn latency() -> Axis {
    of_settings(
        "latency",
        "objects drawn and boxes asked before an answer is there, from none to more than there are",
        Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
        64.0,
        |setting, value| with(setting, "latency", value as u32),
    )
}

fn batch() -> Axis {
    of_settings(
        "batch",
        "queries of a batch, at most",
        Values::Whole { least: 1, greatest: 200, per_decade: 3 },
        50.0,
        |setting, value| with(setting, "batch", value as u32),
    )
}

fn assumed_visible() -> Axis {
    Axis {
        unit: "frames",
        ..of_settings(
            "assumed-visible",
            "frames that what was seen is drawn without being asked",
            Values::Whole { least: 0, greatest: 60, per_decade: 3 },
            5.0,
            |setting, value| with(setting, "assumed_visible", value as u32),
        )
    }
}

fn threshold() -> Axis {
    Axis {
        unit: "px",
        // What is given up, not what is bought.
        criterion: SEEN,
        ..of_settings(
            "tau",
            "pixels up to which a node counts as invisible: the share of pixels whose owner is not \
             drawn grows",
            Values::Whole { least: 0, greatest: 1000, per_decade: 2 },
            0.0,
            |setting, value| with(setting, "tau", value as u32),
        )
    }
}

fn tight_depth() -> Axis {
    of_settings(
        "tight-depth",
        "levels below a node whose boxes are asked instead of its own",
        Values::Whole { least: 0, greatest: 4, per_decade: 10 },
        3.0,
        |setting, value| with(setting, "tight_depth", value as u32),
    )
}

fn tight_area() -> Axis {
    of_settings(
        "tight-area",
        "most surface of those boxes, over the node's own",
        Values::Linear { least: 1.0, greatest: 4.0, steps: 5 },
        1.4,
        |setting, value| with(setting, "tight_area", value),
    )
}

fn across() -> Axis {
    of_settings(
        "across",
        "texels across that a box is asked at, at most",
        Values::Whole { least: 1, greatest: 64, per_decade: 3 },
        2.0,
        |setting, value| with(setting, "across", value as u32),
    )
}

fn buffer() -> Axis {
    Axis {
        unit: "px",
        ..of_settings(
            "buffer",
            "columns of the occlusion buffer before an image of 64, from one to many times it",
            Values::Whole { least: 1, greatest: 4096, per_decade: 2 },
            64.0,
            |setting, value| with(setting, "buffer", value as u32),
        )
    }
}

fn occluders() -> Axis {
    Axis {
        unit: "triangles",
        ..of_settings(
            "occluders",
            "most triangles of occluders, from none to all",
            Values::Whole { least: 0, greatest: 1_000_000, per_decade: 1 },
            8192.0,
            |setting, value| with(setting, "occluder_triangles", value as u32),
        )
    }
}

/// Knobs that each word turns off.
const OPTIONS: &[(&str, &[&str])] = &[
    ("all", &[]),
    ("no-jitter", &["jitter"]),
    ("no-v-queue", &["v_queue"]),
    ("no-multiqueries", &["multiqueries"]),
    ("none", &["jitter", "v_queue", "multiqueries"]),
];

fn options() -> Axis {
    of_settings(
        "options",
        "what a technique of several parts goes without",
        Values::Words(&["all", "no-jitter", "no-v-queue", "no-multiqueries", "none"]),
        0.0,
        |setting, value| {
            let (_, off) = OPTIONS.get(position(value))?;
            let mut changed = with(setting, "jitter", "on")?;
            for knob in *off {
                changed = with(&changed, knob, "off")?;
            }
            Some(changed)
        },
    )
}

const TREES: [&str; 3] = ["auto", "bottom-up", "city"];

fn tree() -> Axis {
    of_settings(
        "tree",
        "the hierarchy that is walked",
        Values::Words(&TREES),
        0.0,
        |setting, value| with(setting, "tree", *TREES.get(position(value))?),
    )
}

const COVERAGES: [&str; 3] = ["summed", "stale", "exact"];

fn coverage() -> Axis {
    of_settings(
        "coverage",
        "where the stored coverage of nodes comes from: with no threshold it decides nothing",
        Values::Words(&COVERAGES),
        0.0,
        |setting, value| with(setting, "coverage", *COVERAGES.get(position(value))?),
    )
}
