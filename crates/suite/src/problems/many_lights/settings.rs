//! From a technique's knobs to the technique and to the tree it walks.

use crate::{
    SuiteError,
    knob::{Get, choice},
    problem::{Form, Setting},
};
use dapple_many_lights::{
    Absolute, BoundForm, Capped, Clustered, Form as LightsForm, LightBvh, Lightcuts, Per, Relative,
    Reservoirs, Selection, StochasticLightcuts, Technique,
    tree::{Build, Representative, city::Levels},
};

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

/// A tree to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TreeKind {
    /// The technique walks none.
    None,
    /// Made from the lights alone.
    Of(Build<'static>),
    /// The scene's hierarchy.
    Hierarchy {
        /// Those of a city.
        levels: Levels,
        /// Most children of a node; 0: any.
        fanout: u32,
    },
}

/// The tree that a setting asks for, of a scene with or without a hierarchy, and what stands for its
/// clusters.
///
/// # Errors
/// A word that is none.
pub fn tree(
    technique: &Technique,
    setting: &Setting,
    has_hierarchy: bool,
    seed: u64,
) -> Result<(TreeKind, Representative), SuiteError> {
    let knobs = &setting.knobs;
    match technique {
        Technique::LightBvh(_) => {
            return Ok((TreeKind::Of(Build::SurfaceArea), Representative::Weighted));
        }
        // Its strongest lights are found by walking down bounds.
        Technique::Capped(_) => return Ok((TreeKind::Of(Build::Median), Representative::Weighted)),
        _ if !knobs.contains_key("tree") => {
            return Ok((TreeKind::None, Representative::Weighted));
        }
        _ => {}
    }
    let kind = match (knobs.word("tree")?, has_hierarchy) {
        ("city", _) | ("auto", true) => hierarchy(setting)?,
        ("median", _) => TreeKind::Of(Build::Median),
        _ => {
            let spread = if knobs.contains_key("spread") { knobs.float("spread")? } else { 1.0 };
            TreeKind::Of(Build::Original { spread })
        }
    };
    let representatives = [
        ("weighted", Representative::Weighted),
        ("random", Representative::Random { seed }),
        ("nearest", Representative::Nearest),
    ];
    let has = knobs.contains_key("representative");
    let representative = match has {
        true => choice(knobs, "representative", &representatives)?,
        false => Representative::Weighted,
    };
    Ok((kind, representative))
}

fn hierarchy(setting: &Setting) -> Result<TreeKind, SuiteError> {
    let knobs = &setting.knobs;
    let all = Levels::default();
    if !knobs.contains_key("levels") {
        return Ok(TreeKind::Hierarchy { levels: all, fanout: 0 });
    }
    let known = [
        ("all", all),
        ("no-storeys", Levels { storey: false, ..all }),
        ("no-facades", Levels { facade: false, ..all }),
        ("no-buildings", Levels { building: false, ..all }),
        ("no-blocks", Levels { block: false, ..all }),
    ];
    let levels = choice(knobs, "levels", &known)?;
    Ok(TreeKind::Hierarchy { levels, fanout: knobs.int("fanout")? as u32 })
}
