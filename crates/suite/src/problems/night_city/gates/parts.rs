//! Errors taken apart (rows 15, 31, 44 and 48): nothing that is seen is lost, and what leaks leaks less
//! from smaller cells and lower points.

use super::cities::{SMALL, Seen, city, setting};
use crate::{
    SuiteError,
    problem::{Form, Setting, Technique},
    problems::{
        many_lights::port,
        night_city::{
            NightCase, SPEC,
            errors::{Apart, Causes},
            settings,
        },
    },
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::Shaded;
use dapple_night_city::Pipeline;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Greatest radiance by which clusters may differ from their lights.
const MOST_CUT: f64 = 2.0 / 255.0;

/// By how many times more nodes are visited from the roots than from precuts, where a street ends.
const MORE_VISITS: f64 = 5.0;

/// Pixels of a frame that may be lit otherwise than their parts sum up to, of few that are looked at.
const DIFFERING: usize = 2;

/// More pixels to be taken apart.
const APART: Seen = Seen { width: 40, frames: 4, truth_pixels: 24, ..SMALL };

pub fn gates() -> Vec<Gate> {
    let mut gates = Vec::new();
    for technique in SPEC.techniques.iter().filter(|t| t.id != "reservoirs") {
        let about =
            |name, statement, fault| About { technique: technique.id, name, statement, fault };
        gates.push(gate(
            about(
                "parts",
                "what a pixel gets less the truth is leak + cut - irradiance - cull - shadow, and what \
                 it gets is what the pixel shows",
                "what leaks is left out",
            ),
            |context, faulty| parts(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "E_cull",
                "no light that a pixel sees was taken for hidden from its cell",
                "a hidden light is one that gives the pixel most",
            ),
            |context, faulty| culled(technique, context, faulty),
        ));
        gates.push(gate(
            about(
                "E_cut",
                "clusters differ from their lights by 2/255 at most where bounds are held to 1/25500",
                "bounds are held to 1/5",
            ),
            |context, faulty| cut(technique, context, faulty),
        ));
    }
    let about =
        |name, statement, fault| About { technique: "facade-cluster", name, statement, fault };
    gates.push(gate(
        about(
            "boxes inside",
            "at any kind of occluders but the thesis's, no light that a pixel sees is taken for hidden",
            "boxes are around clusters of buildings (the thesis)",
        ),
        occluders,
    ));
    gates.push(gate(
        about(
            "finer cells",
            "less light leaks where cells are storeys than where they are facades, and less where \
             these are than where they are buildings",
            "storeys and buildings change places",
        ),
        finer,
    ));
    gates.push(gate(
        about(
            "heights",
            "what is left out below a height is seen by no pixel there, less light leaks, and no \
             precut is found more often",
            "no height is tried",
        ),
        heights,
    ));
    gates.push(gate(
        about(
            "visits",
            "where a street ends, pixels visit five times as many nodes from the roots as from precuts",
            "precuts are the roots",
        ),
        visits,
    ));
    gates
}

/// Takes a city's frames apart: the causes, and what pixels showed beside what their parts sum up to.
fn apart(case: &NightCase<'_>, setting: &Setting) -> Result<(Causes, [usize; 2]), SuiteError> {
    let mut method = case.method(setting)?;
    method.reset(super::cities::SEED)?;
    let internal = || SuiteError::Internal(format!("{setting} adds up no clusters"));
    let mut apart = Apart::of(case, setting)?.ok_or_else(internal)?;
    let (mut causes, mut shaded) = (Causes::default(), Shaded::default());
    let (mut pixels, mut differ) = (0, 0);
    for index in 0..case.night().town.views.len() {
        method.frame(index, false)?;
        method.read(&mut shaded)?;
        let starts = method.starts().ok_or_else(internal)?;
        let results = apart.add(case, index, starts, &mut causes)?;
        pixels += results.len();
        let alike = |pixel: u32, result: glam::DVec3| {
            port::alike(shaded.radiance[pixel as usize], result.as_vec3())
        };
        differ += results.iter().filter(|(pixel, result)| !alike(*pixel, *result)).count();
    }
    Ok((causes, [pixels, differ]))
}

fn errors(
    case: &NightCase<'_>,
    technique: &Technique,
    variant: &str,
    given: &[(&str, Value)],
) -> Result<BTreeMap<String, f64>, SuiteError> {
    let setting = setting(technique, variant, Form::Cpu, given)?;
    Ok(apart(case, &setting)?.0.errors())
}

fn parts(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    use dapple_many_lights::cut::Starts;
    use dapple_night_city::decompose::{PointStarts, decompose};
    let mut tally = Tally::default();
    let case = city(APART, context.seed, None)?;
    let town = &case.night().town;
    let lit = town.lit();
    for variant in technique.variants {
        let setting = setting(technique, variant.id, Form::Cpu, &[])?;
        let (_, [pixels, differ]) = apart(&case, &setting)?;
        tally.check(pixels > 0 && differ <= DIFFERING, || {
            format!("{setting}: {differ} of {pixels} pixels show something else")
        });
        let night = settings::night(&setting, case.seed())?;
        let mut method = case.method(&setting)?;
        method.frame(0, false)?;
        let roots = Starts::roots(&town.lights.roots);
        let starts = method.starts().unwrap_or(&roots);
        let points = &town.world(false).frames[0].points;
        for (pixel, truth) in case.truth().frame(0) {
            let point = &points[pixel as usize];
            // What is too weak counts as hidden here: the sum is the same.
            let used = starts.of(point.object);
            let of = PointStarts { used, seen: used, hidden: &[] };
            let parts = decompose(&lit, &town.lights, &night.cut, night.shadow_rays, point, of);
            let leak = if faulty { glam::DVec3::ZERO } else { parts.leak };
            let sum = leak + parts.cut - parts.irradiance - parts.cull - parts.shadow;
            let off = (parts.result - parts.truth - sum).abs().max_element();
            let size = parts.result.max_element() + truth.max_element() + leak.max_element();
            tally.within(off, 1e-9 * (1.0 + size), || format!("{setting}: pixel {pixel}"));
            let off = (parts.truth - truth).abs().max_element();
            tally.within(off, 1e-9 * (1.0 + size), || format!("{setting}: truth of pixel {pixel}"));
        }
    }
    Ok(tally)
}

fn culled(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(APART, context.seed, None)?;
    for variant in technique.variants {
        let mut errors = errors(&case, technique, variant.id, &[])?;
        if faulty {
            errors.insert("e_cull".into(), most_seen(&case));
        }
        for name in ["e_cull", "lost_lights"] {
            let lost = errors.get(name).copied().unwrap_or(f64::NAN);
            tally.within(lost, 0.0, || format!("{}: {name}", variant.id));
        }
    }
    Ok(tally)
}

/// What the strongest light that any pixel sees gives it.
fn most_seen(case: &NightCase<'_>) -> f64 {
    let lit = case.night().town.lit();
    let points = &case.night().town.world(false).frames[0].points;
    let of = |(pixel, _): (u32, glam::DVec3)| {
        let point = &points[pixel as usize];
        let gives = |light: &dapple_many_lights::Light| {
            dapple_many_lights::radiance(point, light, lit.clamp_m).max_element()
        };
        let seen = lit.lights.iter().filter(|light| gives(light) > 0.0 && lit.sees(point, light));
        seen.map(gives).fold(0.0, f64::max)
    };
    case.truth().frame(0).map(of).fold(0.0, f64::max)
}

fn cut(
    technique: &Technique,
    context: &GateContext<'_>,
    faulty: bool,
) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let case = city(APART, context.seed, None)?;
    let threshold = if faulty { 0.2 } else { 1.0 / 25_500.0 };
    for variant in technique.variants {
        let errors = errors(&case, technique, variant.id, &[("cut", json!(threshold))])?;
        let cut = errors.get("e_cut").copied().unwrap_or(f64::NAN);
        tally.within(cut, MOST_CUT, || variant.id.to_string());
    }
    Ok(tally)
}

fn facade_cluster() -> Result<&'static Technique, SuiteError> {
    SPEC.technique("facade-cluster")
}

fn occluders(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let technique = facade_cluster()?;
    let seen = match faulty {
        true => Seen { width: 96, frames: 8, ..APART },
        false => APART,
    };
    let case = city(seen, context.seed, None)?;
    let modes: &[&str] = if faulty { &["bounding-boxes"] } else { &["boxes", "runs"] };
    for mode in modes {
        let given = [("occluders", json!(mode)), ("least_step", json!(0.0))];
        let lost = errors(&case, technique, "height-ordered", &given)?["lost_lights"];
        tally.within(lost, 0.0, || format!("{mode}: lights lost a pixel"));
    }
    Ok(tally)
}

fn finer(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (case, technique) = (city(APART, context.seed, None)?, facade_cluster()?);
    let mut leaks = Vec::new();
    for part in ["building", "facade", "storey"] {
        let given = [("most_split", json!(part)), ("tau", json!(0))];
        leaks.push(errors(&case, technique, "height-ordered", &given)?["leak"]);
    }
    if faulty {
        leaks.reverse();
    }
    for pair in leaks.windows(2) {
        tally.check(pair[1] <= pair[0], || format!("leaks: {leaks:?}"));
    }
    tally.check(leaks[2] < leaks[0], || format!("leaks: {leaks:?}"));
    Ok(tally)
}

fn heights(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (case, technique) = (city(APART, context.seed, None)?, facade_cluster()?);
    let of = |heights: i64| -> Result<_, SuiteError> {
        let setting =
            setting(technique, "height-ordered", Form::Cpu, &[("heights", json!(heights))])?;
        let night = settings::night(&setting, case.seed())?;
        let mut pipeline = Pipeline::new(&case.night().town, &night, None)?;
        let mut evaluations = 0;
        for index in 0..case.night().town.views.len() {
            evaluations += pipeline.frame(index, false)?.counts.evaluations;
        }
        Ok((apart(&case, &setting)?.0.errors(), evaluations))
    };
    let ((plain, expected), (below, evaluations)) = (of(0)?, of(if faulty { 0 } else { 4 })?);
    tally.within(below["lost_lights"], 0.0, || "lights lost a pixel".into());
    tally.within(below["e_cull"], 0.0, || "radiance lost".into());
    tally.check(below["leak"] < plain["leak"], || {
        format!("leak {} with heights, {} without", below["leak"], plain["leak"])
    });
    tally.check(evaluations == expected, || format!("{evaluations} evaluations for {expected}"));
    Ok(tally)
}

fn visits(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let seen = Seen { scene: "city", view: "close_ended", width: 32, frames: 1, truth_pixels: 1 };
    let case = city(seen, context.seed, None)?;
    let technique = SPEC.technique(if faulty { "full-tree" } else { "facade-cluster" })?;
    let setting = setting(technique, technique.variants[0].id, Form::Cpu, &[])?;
    let night = settings::night(&setting, case.seed())?;
    let mut pipeline = Pipeline::new(&case.night().town, &night, None)?;
    let mut shaded = Shaded::default();
    pipeline.frame(0, true)?;
    pipeline.read(&mut shaded)?;
    let from_precuts = shaded.work.visits;
    pipeline.whole_tree(0)?;
    pipeline.read(&mut shaded)?;
    let ratio = shaded.work.visits as f64 / from_precuts as f64;
    tally.within(MORE_VISITS / ratio, 1.0, || format!("{ratio} times as many visits"));
    Ok(tally)
}
