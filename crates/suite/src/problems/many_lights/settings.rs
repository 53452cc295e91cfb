//! From a technique's knobs to the technique and to the tree it walks.

use super::SPEC;
use crate::{
    SuiteError,
    knob::{Get, choice},
    problem::{Form, Setting},
};
use dapple_many_lights::{
    Absolute, BoundForm, Capped, Clustered, Form as LightsForm, LightBvh, Lightcuts, Per, Relative,
    Reservoirs, Selection, StochasticLightcuts, Technique,
};

/// Holds every knob to its declared range, whoever set it.
///
/// # Errors
/// A technique that there is not, or a knob out of range.
pub fn check(setting: &Setting) -> Result<(), SuiteError> {
    for knob in SPEC.technique(&setting.technique)?.knobs {
        if let Some(value) = setting.knobs.get(knob.name) {
            knob.check("knob", value)?;
        }
    }
    Ok(())
}

/// The form by its other name.
pub fn form(form: Form) -> LightsForm {
    match form {
        Form::Reference => LightsForm::Reference,
        Form::Cpu => LightsForm::Cpu,
        Form::Gpu => LightsForm::Gpu,
    }
}

/// The technique that a setting asks for.
///
/// # Errors
/// A technique that there is not, or a knob out of range.
pub fn technique(setting: &Setting) -> Result<Technique, SuiteError> {
    let knobs = &setting.knobs;
    let bound =
        || choice(knobs, "bound", &[("cheap", BoundForm::Cheap), ("walter", BoundForm::Walter)]);
    let technique = match setting.technique.as_str() {
        "brute-force" => Technique::BruteForce,
        "lightcuts" => Technique::Lightcuts(Lightcuts {
            epsilon: knobs.float("epsilon")?,
            most: knobs.int("most")? as u32,
            selection: choice(
                knobs,
                "selection",
                &[("heap", Selection::Heap), ("scan", Selection::Scan)],
            )?,
            bound: bound()?,
        }),
        "relative-cut" => {
            Technique::Relative(Relative { epsilon: knobs.float("own_epsilon")?, bound: bound()? })
        }
        "absolute-cut" => Technique::Absolute(Absolute {
            threshold: knobs.float("threshold")?,
            bound: bound()?,
            per: if setting.variant == "tile" { Per::Tile } else { Per::Pixel },
        }),
        "light-bvh" => Technique::LightBvh(LightBvh { samples: knobs.int("samples")? as u32 }),
        "stochastic-lightcuts" => Technique::StochasticLightcuts(StochasticLightcuts {
            cut: knobs.int("cut")? as u32,
            real_time: setting.variant == "real-time",
        }),
        "reservoirs" => Technique::Reservoirs(Reservoirs {
            candidates: knobs.int("candidates")? as u32,
            temporal: knobs.word("temporal")? == "on",
            history: knobs.int("history")? as u32,
            neighbours: knobs.int("neighbours")? as u32,
            radius_px: knobs.float("radius")?,
            unbiased: setting.variant == "unbiased",
        }),
        "clustered" => Technique::Clustered(Clustered {
            cutoff: knobs.float("cutoff")?,
            tile: knobs.int("tile")? as u32,
            slices: knobs.int("slices")? as u32,
            window: setting.variant == "window",
        }),
        "capped" => Technique::Capped(Capped { most: knobs.int("most")? as u32 }),
        name => return Err(SuiteError::Internal(format!("no technique for {name}"))),
    };
    technique.check()?;
    Ok(technique)
}

/// Whether a technique draws lights by chance.
pub fn is_random(technique: &Technique) -> bool {
    matches!(
        technique,
        Technique::LightBvh(_) | Technique::StochasticLightcuts(_) | Technique::Reservoirs(_)
    )
}

/// Whether its mean over many runs must be the truth.
pub fn is_unbiased(technique: &Technique) -> bool {
    match technique {
        Technique::BruteForce | Technique::LightBvh(_) | Technique::StochasticLightcuts(_) => true,
        Technique::Reservoirs(settings) => settings.unbiased,
        _ => false,
    }
}

/// A level of a city's hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// All buildings of a block.
    Block,
    /// All facades of a building.
    Building,
    /// All storeys of a facade.
    Facade,
    /// All windows of a storey.
    Storey,
}

/// What stands for a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stands {
    /// Its weighted middle.
    Weighted,
    /// A child's, by chance.
    Random,
    /// The nearest real light.
    Nearest,
}

/// Which tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TreeKind {
    /// The technique walks none.
    None,
    /// Halves.
    Median,
    /// By surfaces and orientations, for sampling.
    SurfaceArea,
    /// Walter's.
    Original {
        /// Weight of directions against distances.
        spread: f64,
    },
    /// The city's hierarchy.
    City {
        /// A level that is left out.
        without: Option<Level>,
        /// Most children of a node; 0: any.
        fanout: u32,
    },
}

/// A tree to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Which.
    pub kind: TreeKind,
    /// What stands for its clusters.
    pub representative: Stands,
}

impl Plan {
    /// The tree that a setting asks for, of a scene with or without a hierarchy.
    ///
    /// # Errors
    /// A word that is none.
    pub fn of(
        technique: &Technique,
        setting: &Setting,
        has_hierarchy: bool,
    ) -> Result<Self, SuiteError> {
        let knobs = &setting.knobs;
        let representative = match knobs.contains_key("representative") {
            false => Stands::Weighted,
            true => choice(
                knobs,
                "representative",
                &[
                    ("weighted", Stands::Weighted),
                    ("random", Stands::Random),
                    ("nearest", Stands::Nearest),
                ],
            )?,
        };
        let original = || {
            Ok::<_, SuiteError>(TreeKind::Original {
                spread: if knobs.contains_key("spread") { knobs.float("spread")? } else { 1.0 },
            })
        };
        let city = || {
            let has = knobs.contains_key("levels");
            let levels = [
                ("all", None),
                ("no-storeys", Some(Level::Storey)),
                ("no-facades", Some(Level::Facade)),
                ("no-buildings", Some(Level::Building)),
                ("no-blocks", Some(Level::Block)),
            ];
            Ok::<_, SuiteError>(TreeKind::City {
                without: if has { choice(knobs, "levels", &levels)? } else { None },
                fanout: if has { knobs.int("fanout")? as u32 } else { 0 },
            })
        };
        let kind = match technique {
            Technique::LightBvh(_) => TreeKind::SurfaceArea,
            // Its strongest lights are found by walking down bounds.
            Technique::Capped(_) => TreeKind::Median,
            _ if !knobs.contains_key("tree") => TreeKind::None,
            _ => match (knobs.word("tree")?, has_hierarchy) {
                ("city", _) | ("auto", true) => city()?,
                ("median", _) => TreeKind::Median,
                _ => original()?,
            },
        };
        Ok(Self { kind, representative })
    }
}
