//! From a technique's knobs to the settings of whatever decides, draws and answers.

use crate::{
    SuiteError,
    knob::{Get, Knobs, choice},
    problem::{Form, Setting},
};
use dapple_occlusion::camera::{
    Coverage, Readiness, Results, Settings, Technique, TightBounds, gpu,
    hierarchical_depth::{self, Traversal},
    masked,
};

/// The settings of a technique that walks the tree and asks.
///
/// # Errors
/// A word that is none, or a knob out of range.
pub fn asks(setting: &Setting, technique: Technique, seed: u64) -> Result<Settings, SuiteError> {
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

/// The settings of two passes with a pyramid of depths.
///
/// # Errors
/// A word that is none, a knob out of range, or a walk of the tree on a device.
pub fn hierarchical(setting: &Setting) -> Result<hierarchical_depth::Settings, SuiteError> {
    let traversals = [("flat", Traversal::Flat), ("tree", Traversal::Tree)];
    let settings = hierarchical_depth::Settings {
        traversal: choice(&setting.knobs, "traversal", &traversals)?,
        across: setting.knobs.int("across")? as u32,
    };
    settings.check()?;
    if settings.traversal == Traversal::Tree && setting.form == Form::Gpu {
        return Err(SuiteError::Usage(
            "knob `traversal` = tree: the gpu form asks every object; there is: flat".into(),
        ));
    }
    Ok(settings)
}

/// The settings of masked culling: the image's size for 0 columns.
///
/// # Errors
/// A knob out of range.
pub fn masked(setting: &Setting) -> Result<masked::Settings, SuiteError> {
    let knobs = &setting.knobs;
    let columns = knobs.int("buffer")? as u32;
    Ok(masked::Settings {
        form: match setting.form {
            Form::Reference => masked::Form::Reference,
            Form::Cpu | Form::Gpu => masked::Form::Fast,
        },
        occluders: match setting.variant.as_str() {
            "boxes" => masked::Occluders::InnerBoxes,
            _ => masked::Occluders::Meshes,
        },
        columns: (columns > 0).then_some(columns),
        most_triangles: knobs.int("occluder_triangles")? as u64,
    })
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
