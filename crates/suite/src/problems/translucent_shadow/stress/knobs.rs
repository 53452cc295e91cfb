//! Extremes of settings and of the window.

use super::{CHEAP, FORMS, HARDER, LAYERING, TranslucentCase, unpushed};
use crate::{
    case::Case,
    problem::Setting,
    problems::translucent_shadow::SPEC,
    stress::{
        Axis, Criterion, Values,
        settings::{never, position, with},
    },
};

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
        parameters: CHEAP,
        forms: FORMS,
        criterion: LAYERING,
        must_refuse: never,
        prepare: unpushed(),
        setting,
    }
}

fn layers() -> Axis {
    of_settings(
        "layers",
        "layers K, from the total alone to the most there can be",
        Values::Whole { least: 1, greatest: 256, per_decade: 4 },
        16.0,
        |setting, value| with(setting, "layers", value as u32),
    )
}

fn nodes() -> Axis {
    of_settings(
        "nodes",
        "nodes of a texel; past 64 those that are searched at every fragment are refused",
        Values::Whole { least: 2, greatest: 1024, per_decade: 2 },
        16.0,
        |setting, value| with(setting, "nodes", value as u32),
    )
}

fn pairs() -> Axis {
    of_settings(
        "pairs",
        "pairs of cosine and sine",
        Values::Whole { least: 1, greatest: 15, per_decade: 4 },
        3.0,
        |setting, value| with(setting, "pairs", value as u32),
    )
}

fn samples() -> Axis {
    of_settings(
        "samples",
        "depths of a texel",
        Values::Whole { least: 1, greatest: 64, per_decade: 3 },
        8.0,
        |setting, value| with(setting, "samples", value as u32),
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
        criterion: HARDER,
        ..of_settings(
            "map",
            "side of the map, with four layers where there are layers; what is past 8192 is on the \
             axis bad-settings",
            // A search of eleven frames at 4096 takes longer than a point may.
            Values::Whole { least: 1, greatest: 2048, per_decade: 1 },
            256.0,
            |setting, value| {
                let few = with(setting, "layers", FEW_LAYERS);
                with(&few.unwrap_or_else(|| setting.clone()), "resolution", value as u32)
            },
        )
    }
}

fn footprint() -> Axis {
    Axis {
        // A wider window is another signal, not a worse one: a technique that keeps up has no more
        // error.
        criterion: HARDER,
        prepare: Box::new(|case, value, gpu| {
            let mut case: Case = case.clone();
            case.parameters.insert("footprint".into(), value.into());
            Ok(Box::new(TranslucentCase::prepare(&case, gpu)?))
        }),
        ..of_settings(
            "footprint-over-map",
            "side of the truth's window over the map's side: from a point to half of the map",
            Values::FromZero { least: 1e-4, greatest: 0.5, per_decade: 2 },
            0.004,
            |setting, _| Some(setting.clone()),
        )
    }
}

fn bias() -> Axis {
    Axis {
        // The uncompressed map has the same bias.
        criterion: HARDER,
        ..of_settings(
            "bias",
            "light depth taken from the receiver's, from none",
            Values::FromZero { least: 1e-7, greatest: 0.1, per_decade: 1 },
            1e-3,
            |setting, value| with(setting, "bias", value),
        )
    }
}

fn span() -> Axis {
    of_settings(
        "span",
        "depth of all of a deep opacity map's layers over the light's range, from a share of the \
         volume to many times it",
        Values::Log { least: 1e-3, greatest: 10.0, per_decade: 2 },
        0.5,
        |setting, value| with(setting, "span", value),
    )
}

fn lambda() -> Axis {
    of_settings(
        "lambda",
        "split of a bounding opacity map, from uniform to logarithmic",
        Values::Linear { least: 0.0, greatest: 1.0, steps: 8 },
        0.0,
        |setting, value| with(setting, "lambda", value),
    )
}

fn moment_bias() -> Axis {
    of_settings(
        "moment-bias",
        "pull of moments towards safe ones",
        Values::Log { least: 1e-9, greatest: 0.5, per_decade: 1 },
        1e-5,
        |setting, value| with(setting, "moment_bias", value),
    )
}

const FORMATS: [&str; 5] = ["f32", "f16", "unorm8", "unorm8-scaled", "fixed"];

fn precision() -> Axis {
    Axis {
        // The same answer with fewer bits: what they cost should not show in a front.
        criterion: Criterion { times: 1.1, plus: 0.01, ..LAYERING },
        ..of_settings(
            "precision",
            "storage of a layer or a coefficient, for techniques that can store it so",
            Values::Words(&FORMATS),
            0.0,
            |setting, value| {
                let format = *FORMATS.get(position(value))?;
                let technique = SPEC.technique(&setting.technique).ok()?;
                let knob = technique.knobs.iter().find(|knob| knob.name == "format")?;
                with(setting, "format", knob.check("knob", &format.into()).ok()?)
            },
        )
    }
}
