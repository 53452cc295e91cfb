//! Extremes of settings and of the window.

use super::{CHEAP, FORMS, HARDER, unpushed};
use crate::{
    case::Case,
    problem::Setting,
    problems::shadow_filtering::{SPEC, ShadowCase},
    stress::{
        Axis, Criterion, Values,
        settings::{never, position, with},
    },
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
        criterion: HARDER,
        must_refuse: never,
        prepare: unpushed(),
        setting,
    }
}

/// Texels a side of the map below windows of every size: checks read each texel of a window, and
/// the widest holds more than the map.
const SIDE_BELOW_WINDOWS: u32 = 128;

fn footprint() -> Axis {
    Axis {
        id: "footprint-over-map",
        help: "side of the window over the map's side, at 128 texels: from a hundredth of a texel \
               to a window that is wider than the map",
        // At home 7 texels, as many as the default footprint has of the default map.
        values: Values::Log { least: 1e-4, greatest: 1.2, per_decade: 2 },
        home: 0.05,
        // A window of another size is another signal, not a worse one: a technique that keeps up
        // has no more error.
        prepare: Box::new(|case, value, gpu| {
            let mut case: Case = case.clone();
            case.parameters.insert("footprint".into(), value.into());
            Ok(Box::new(ShadowCase::prepare(&case, gpu)?))
        }),
        ..of_settings("", "", Values::Words(&[]), 0.0, |setting, _| {
            with(setting, "resolution", SIDE_BELOW_WINDOWS)
        })
    }
}

fn map() -> Axis {
    Axis {
        unit: "texels",
        ..of_settings(
            "map",
            "side of the map; what is past 16384 is on the axis bad-settings",
            Values::Whole { least: 1, greatest: 4096, per_decade: 2 },
            512.0,
            |setting, value| with(setting, "resolution", value.round() as u32),
        )
    }
}

const FORMATS: &[&str] = &["f32", "f16", "u16"];

fn precision() -> Axis {
    Axis {
        // The same answer with fewer bits: what they cost should not show in a front.
        criterion: Criterion { metric: "rmse", times: 1.1, plus: 0.01 },
        ..of_settings(
            "precision",
            "storage of a channel, for techniques that can store it so",
            Values::Words(FORMATS),
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

fn bias() -> Axis {
    of_settings(
        "bias",
        "normalised depth taken from the receiver's, from none",
        Values::FromZero { least: 1e-7, greatest: 0.1, per_decade: 1 },
        1e-3,
        |setting, value| with(setting, "bias", value),
    )
}

fn exponent() -> Axis {
    of_settings(
        "exponent",
        "c of the exponential techniques; past the format's largest it is refused",
        Values::Log { least: 0.1, greatest: 1000.0, per_decade: 2 },
        10.0,
        |setting, value| with(setting, "exponent", value),
    )
}

fn min_variance() -> Axis {
    of_settings(
        "min-variance",
        "least variance, squared normalised depth",
        Values::Log { least: 1e-12, greatest: 0.1, per_decade: 1 },
        1e-5,
        |setting, value| with(setting, "min_variance", value),
    )
}

fn moment_bias() -> Axis {
    of_settings(
        "moment-bias",
        "pull of four moments towards safe ones",
        Values::Log { least: 1e-9, greatest: 0.5, per_decade: 1 },
        3e-6,
        |setting, value| with(setting, "moment_bias", value),
    )
}

/// Layers by the position of the word; the last two are no layers there are.
const LAYERS: &[u32] = &[4, 1, 2, 8, 3, 16];

fn layers() -> Axis {
    Axis {
        must_refuse: |value| matches!(LAYERS.get(position(value)), Some(3 | 16)),
        ..of_settings(
            "layers",
            "depth layers: 1, 2, 4 and 8 work; 3 and 16 must be refused",
            Values::Words(&["4", "1", "2", "8", "3", "16"]),
            0.0,
            |setting, value| with(setting, "layers", *LAYERS.get(position(value))?),
        )
    }
}
