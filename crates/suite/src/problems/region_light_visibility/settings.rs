//! From knobs to settings of techniques.

use crate::{
    SuiteError,
    knob::{Get, Knobs, choice},
    problem::Setting,
};
use dapple_many_lights::region::{
    Edge, FacadeCluster, Fusion, OccluderMode, Planes, RegionTechnique, Sampled, Split,
};

/// How shadows are joined, by the name of a variant.
///
/// # Errors
/// A name that is none.
pub fn fusion(variant: &str) -> Result<Fusion, SuiteError> {
    match variant {
        "height-ordered" => Ok(Fusion::HeightOrdered),
        "insertion" => Ok(Fusion::Insertion),
        "no-fusion" => Ok(Fusion::None),
        name => Err(SuiteError::Internal(format!("no fusion for {name}"))),
    }
}

/// What stands for buildings.
///
/// # Errors
/// A word that is none.
pub fn occluders(knobs: &Knobs) -> Result<OccluderMode, SuiteError> {
    choice(
        knobs,
        "occluders",
        &[
            ("boxes", OccluderMode::Leaf),
            ("objects", OccluderMode::Leaf),
            ("runs", OccluderMode::ContiguousMin),
            ("bounding-boxes", OccluderMode::BoundingBoxes),
        ],
    )
}

/// The technique that a setting asks for; lights below `threshold` do not matter.
///
/// # Errors
/// A technique that there is not, or a knob out of range.
pub fn technique(
    setting: &Setting,
    threshold: f64,
    seed: u32,
) -> Result<RegionTechnique, SuiteError> {
    let knobs = &setting.knobs;
    let technique = match setting.technique.as_str() {
        "all-lights" => RegionTechnique::Everything,
        "facade-cluster" => RegionTechnique::FacadeCluster(FacadeCluster {
            fusion: fusion(&setting.variant)?,
            edge: choice(
                knobs,
                "edge",
                &[("flat", Edge::Flat), ("sloped", Edge::Sloped), ("hull", Edge::Hull)],
            )?,
            occluders: occluders(knobs)?,
            planes: planes(knobs)?,
            least_step_m: knobs.float("least_step")?,
            threshold,
            split: split(knobs)?,
            cached: knobs.word("projections")? == "kept",
        }),
        "extended-projection" => {
            RegionTechnique::ExtendedProjection { texels: knobs.int("texels")? as u32 }
        }
        "sampled" => RegionTechnique::Sampled(Sampled { rays: knobs.int("rays")? as u32, seed }),
        name => return Err(SuiteError::Internal(format!("no technique for {name}"))),
    };
    technique.check()?;
    Ok(technique)
}

/// How far clusters are divided.
///
/// # Errors
/// A knob that is not there.
pub fn split(knobs: &Knobs) -> Result<Split, SuiteError> {
    Ok(match knobs.int("divisions")? {
        -1 => Split::All,
        levels => Split::Levels(levels as u32),
    })
}

fn planes(knobs: &Knobs) -> Result<Planes, SuiteError> {
    let metres = knobs.float("plane_distance")?;
    choice(
        knobs,
        "planes",
        &[
            ("far-faces", Planes::FarFaces),
            ("behind", Planes::Behind(metres)),
            ("every", Planes::Every(metres)),
        ],
    )
}
