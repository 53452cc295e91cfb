//! From a technique's knobs to the settings of whatever decides, draws and answers.

use crate::{
    SuiteError,
    knob::{Get, Knobs, choice},
    problem::{Form, Setting},
};
use dapple_occlusion::camera::{
    Coverage, Readiness, Results, Settings, Technique, TightBounds, gpu,
};

/// The settings of a technique that walks the tree and asks.
///
/// # Errors
/// A word that is none, or a knob out of range.
pub fn asks(
    setting: &Setting,
    technique: Technique,
    seed: u64,
) -> Result<Settings, SuiteError> {
    let knobs = &setting.knobs;
    let mut settings = Settings { seed, ..Settings::new(technique) };
    if setting.variant == "next-frame" {
        settings.results = Results::NextFrame;
    }
    if knobs.contains_key("tau") {
        settings.threshold_px = knobs.int("tau")? as u32;
    }
    if knobs.contains_key("coverage") {
        let known =
            [("stale", Coverage::Stale), ("summed", Coverage::Summed), ("exact", Coverage::Exact)];
        settings.coverage = choice(knobs, "coverage", &known)?;
    }
    if technique == Technique::ChcPlusPlus {
        settings.batch = knobs.int("batch")? as u32;
        settings.assumed_visible = knobs.int("assumed_visible")? as u32;
        settings.jitter = switch(knobs, "jitter")?;
        settings.visible_queue = switch(knobs, "v_queue")?;
        settings.multiqueries = switch(knobs, "multiqueries")?;
        settings.tight_bounds = TightBounds {
            depth: knobs.int("tight_depth")? as u32,
            area: knobs.float("tight_area")? as f32,
        };
    }
    settings.check()?;
    Ok(settings)
}

/// When answers are looked at. Techniques without the knob never ask.
///
/// # Errors
/// Polling what is no device.
pub fn readiness(setting: &Setting) -> Result<Readiness, SuiteError> {
    let knobs = &setting.knobs;
    if !knobs.contains_key("readiness") {
        return Ok(Readiness::Modelled(0));
    }
    match (knobs.word("readiness")?, setting.form) {
        ("polled", Form::Gpu) => Ok(Readiness::Polled),
        ("polled", form) => Err(SuiteError::Usage(format!(
            "knob `readiness` = polled: the {form} form has no device to ask; there is: modelled"
        ))),
        _ => Ok(Readiness::Modelled(knobs.int("latency")? as u32)),
    }
}

/// How a device draws and counts.
///
/// # Errors
/// A word that is none.
pub fn device(setting: &Setting) -> Result<gpu::Settings, SuiteError> {
    let knobs = &setting.knobs;
    let drawings = [
        ("instanced", gpu::Drawing::Instanced),
        ("object", gpu::Drawing::PerObject),
        ("quad", gpu::Drawing::PerQuad),
    ];
    let countings = [
        ("auto", gpu::Counting::Auto),
        ("query", gpu::Counting::Query),
        ("atomic", gpu::Counting::Atomic),
        ("boolean", gpu::Counting::Boolean),
    ];
    let counting = match knobs.contains_key("counting") {
        true => choice(knobs, "counting", &countings)?,
        false => gpu::Counting::Auto,
    };
    Ok(gpu::Settings {
        drawing: choice(knobs, "draws", &drawings)?,
        counting,
        readiness: readiness(setting)?,
    })
}

fn switch(knobs: &Knobs, name: &'static str) -> Result<bool, SuiteError> {
    choice(knobs, name, &[("on", true), ("off", false)])
}
