//! What axes of all problems do to settings.

use crate::problem::Setting;
use serde_json::Value;

/// Nothing is bad at any value.
pub fn never(_: f64) -> bool {
    false
}

pub fn as_it_is(setting: &Setting, _: f64) -> Option<Setting> {
    Some(setting.clone())
}

/// The setting with another value of a knob, where the technique has it. The knob's own range is
/// passed over: that is what extremes are.
pub fn with(setting: &Setting, knob: &str, value: impl Into<Value>) -> Option<Setting> {
    let mut changed = setting.clone();
    *changed.knobs.get_mut(knob)? = value.into();
    Some(changed)
}

/// Position of a word on an axis of words.
pub fn position(value: f64) -> usize {
    // Negative and not a number become 0, which is home on every such axis.
    value as usize
}
