//! Settings that must be refused.

use super::USUAL;
use crate::stress::{
    Axis,
    bad::{self, BadSetting},
    settings::words,
};

const SETTINGS: &[BadSetting] = &[
    ("good", &[]),
    ("cut-minus-1", &[("cut", "-1.0")]),
    ("cut-1e10", &[("cut", "1e10")]),
    ("threshold-minus-1", &[("threshold", "-1.0")]),
    ("threshold-2", &[("threshold", "2.0")]),
    ("tau-minus-1", &[("tau", "-1")]),
    ("tau-2000001", &[("tau", "2000001")]),
    ("validity-minus-1", &[("validity", "-1")]),
    ("validity-2^32+50", &[("validity", "4294967346")]),
    ("heights-9", &[("heights", "9")]),
    ("budget-minus-1", &[("budget", "-1")]),
    ("budget-2^32+1", &[("budget", "4294967297")]),
    ("split-atom", &[("most_split", "atom")]),
    ("rays-maybe", &[("shadow_rays", "maybe")]),
    ("edge-round", &[("edge", "round")]),
    ("occluders-guessed", &[("occluders", "guessed")]),
    ("least-step-minus-1", &[("least_step", "-1.0")]),
    ("least-step-1e5", &[("least_step", "1e5")]),
    ("divisions-65", &[("divisions", "65")]),
    ("candidates-0", &[("candidates", "0")]),
    ("candidates-2^32+1", &[("candidates", "4294967297")]),
    ("neighbours-65", &[("neighbours", "65")]),
];
const SETTING_WORDS: [&str; SETTINGS.len()] = words(SETTINGS);

/// The axis.
pub fn bad_settings() -> Axis {
    bad::bad_settings(USUAL, SETTINGS, &SETTING_WORDS)
}
