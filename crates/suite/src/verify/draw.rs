//! Random input of gates, the same for the same seed.

use crate::{
    SuiteError,
    knob::{self, Knob, Range},
    problem::{Form, Setting, Technique},
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

/// A generator of its own for each gate and case.
pub fn rng(seed: u64, gate: &str, case: u32) -> Pcg64 {
    let name = gate.bytes().fold(0_u64, |h, b| h.wrapping_mul(0x100_0000_01b3) ^ u64::from(b));
    Pcg64::seed_from_u64(seed ^ name ^ (u64::from(case) << 40))
}

/// A value of a knob's useful range, its ends and its least as likely as what is between.
pub fn anywhere(rng: &mut Pcg64, knob: &Knob) -> Value {
    let [least, greatest] = match (knob.useful, knob.range) {
        (Some(useful), _) => useful,
        (None, Range::Int { min, max, .. }) => [min as f64, max as f64],
        (None, Range::Float { min, max, .. }) => [min, max],
        (None, Range::Choice(words)) => return words[rng.random_range(0..words.len())].into(),
    };
    let between: f64 = match rng.random_range(0..4) {
        0 => 0.0,
        1 => 1.0,
        _ => rng.random_range(0.0..1.0),
    };
    let value = match knob.logarithmic && least > 0.0 {
        true => least * (greatest / least).powf(between),
        false => least + (greatest - least) * between,
    };
    match knob.range {
        Range::Int { min, .. } if rng.random_bool(0.1) => min.into(),
        Range::Int { .. } => (value.round() as i64).into(),
        _ => value.into(),
    }
}

/// The defaults of `technique`, but for the knobs given.
///
/// # Errors
/// A knob that there is not.
pub fn default_setting(
    technique: &Technique,
    form: Form,
    given: &[(&str, Value)],
) -> Result<Setting, SuiteError> {
    let given = given.iter().map(|(name, value)| ((*name).to_string(), value.clone())).collect();
    let knobs = knob::complete("knob", technique.knobs, &given)?;
    let variant = technique.variants[0].id.into();
    Ok(Setting { technique: technique.id.into(), variant, form, knobs })
}
