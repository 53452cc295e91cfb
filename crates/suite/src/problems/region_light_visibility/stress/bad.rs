//! Settings and parameters that must be refused.

use super::USUAL;
use crate::problem::Problem;
use crate::stress::{
    Axis, Values,
    bad::{self, BadSetting, bad},
    settings::{Changes, position, typed, words},
};

/// The axes, each pushed alone.
pub fn axes() -> Vec<Axis> {
    vec![bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS), bad_truth()]
}

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("least-step-minus-1", &[("least_step", "-1.0")]),
    ("least-step-1e5", &[("least_step", "1e5")]),
    ("plane-distance-0", &[("plane_distance", "0.0")]),
    ("plane-distance-minus-1", &[("plane_distance", "-1.0")]),
    ("plane-distance-1e5", &[("plane_distance", "1e5")]),
    ("divisions-minus-2", &[("divisions", "-2")]),
    ("divisions-65", &[("divisions", "65")]),
    ("divisions-2^32", &[("divisions", "4294967296")]),
    ("edge-round", &[("edge", "round")]),
    ("occluders-guessed", &[("occluders", "guessed")]),
    ("planes-none", &[("planes", "none")]),
    ("projections-lost", &[("projections", "lost")]),
    ("texels-15", &[("texels", "15")]),
    ("texels-2^32+64", &[("texels", "4294967360")]),
    ("rays-0", &[("rays", "0")]),
    ("rays-2^32+1", &[("rays", "4294967297")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);

/// A word and the parameters that it sets to what no case can have.
type BadParameter = (&'static str, Changes);

const PARAMETERS: &[BadParameter] = &[
    ("good", &[]),
    ("no-faces", &[("truth_faces", "0")]),
    ("no-lights", &[("truth_lights", "0")]),
    ("threshold-1e30", &[("threshold", "1e30")]),
    ("split-atom", &[("most_split", "atom")]),
];
const PARAMETER_WORDS: [&str; PARAMETERS.len()] = words(PARAMETERS);

fn bad_truth() -> Axis {
    Axis {
        must_refuse: bad,
        prepare: Box::new(|case, value, gpu| {
            let mut case = case.clone();
            let (_, changes) = PARAMETERS.get(position(value)).unwrap_or(&PARAMETERS[0]);
            for (name, text) in *changes {
                case.parameters.insert((*name).into(), typed(text));
            }
            super::RegionLightVisibility.prepare(&case, gpu)
        }),
        ..USUAL.axis(
            "bad-truth",
            "a truth of nothing: no faces, no lights, none that matters, a part of a city that there \
             is not",
            Values::Words(&PARAMETER_WORDS),
            0.0,
        )
    }
}
