//! From knobs to settings of whole frames.

use crate::{
    SuiteError,
    knob::{Get, Knobs, choice},
    night::part,
    problem::Setting,
    problems::region_light_visibility::settings::{fusion, occluders, split},
};
use dapple_many_lights::{
    Absolute,
    region::{Edge, FacadeCluster, RegionTechnique},
};
use dapple_night_city::{Night, Part, coherence::Keeping};

/// The settings of a frame.
///
/// # Errors
/// A technique that is none of these, or a knob out of range.
pub fn night(setting: &Setting, seed: u64) -> Result<Night, SuiteError> {
    let knobs = &setting.knobs;
    let default = Night::default();
    let all = Night { region: RegionTechnique::Everything, ..default };
    let night = match setting.technique.as_str() {
        "full-tree" => Night { cut: cut(knobs)?, ..all },
        "traced-cut" => Night { cut: cut(knobs)?, shadow_rays: true, ..all },
        // What is seen is found alike; how pixels are lit is another matter.
        "reservoirs" => all,
        "facade-cluster" => facade_cluster(setting, seed, default)?,
        name => return Err(SuiteError::Internal(format!("no frames by {name}"))),
    };
    night.check()?;
    Ok(night)
}

fn cut(knobs: &Knobs) -> Result<Absolute, SuiteError> {
    Ok(Absolute { threshold: knobs.float("cut")?, ..Night::default().cut })
}

fn facade_cluster(setting: &Setting, seed: u64, default: Night) -> Result<Night, SuiteError> {
    let knobs = &setting.knobs;
    let precomputed = setting.variant == "precomputed";
    let joined = if precomputed { "height-ordered" } else { &setting.variant };
    let smallest = match (part(knobs.word("most_split")?)?, precomputed) {
        // Every storey of a city before the first frame would be all of its objects.
        (Part::Any, true) => Part::Facade,
        (part, _) => part,
    };
    let region = FacadeCluster {
        fusion: fusion(joined)?,
        edge: choice(
            knobs,
            "edge",
            &[("flat", Edge::Flat), ("sloped", Edge::Sloped), ("hull", Edge::Hull)],
        )?,
        occluders: occluders(knobs)?,
        least_step_m: knobs.float("least_step")?,
        threshold: knobs.float("threshold")?,
        split: split(knobs)?,
        ..FacadeCluster::default()
    };
    let validity = match knobs.int("validity")? {
        0 => None,
        frames => Some(frames as u32),
    };
    let capacity_bytes = match knobs.int("capacity")? {
        0 => None,
        kib => Some(1024 * kib as u64),
    };
    Ok(Night {
        tau_px: knobs.int("tau")? as f64,
        split: smallest,
        keeping: Keeping { validity, capacity_bytes, seed },
        budget: match knobs.int("budget")? {
            0 => None,
            most => Some(most as u32),
        },
        heights: knobs.int("heights")? as u32,
        precomputed,
        region: RegionTechnique::FacadeCluster(region),
        cut: cut(knobs)?,
        shadow_rays: knobs.word("shadow_rays")? == "on",
        ..default
    })
}
