//! Pictures of the settings on a front, rendered anew: the run's command says which case and
//! setting a row was, and the scene's hash that it is still the same.

use crate::{
    args::{Args, Verb},
    pictures,
    verbs::measure,
};
use clap::Parser;
use dapple_gpu::{AdapterChoice, Gpu};
use dapple_records::{
    Read, Row,
    catalogue::ProblemInfo,
    front::{self, Front, Key},
    report::Triplet,
    text::{duration, significant},
};
use dapple_suite::{
    SuiteError,
    plan::{Group, Plan},
    problem::{Form, Prepared},
    problems,
};
use std::collections::{BTreeMap, BTreeSet};

/// Fronts with pictures, the newest first, and settings pictured a front.
const MOST_FRONTS: usize = 8;
const MOST_SETTINGS: usize = 6;
/// Columns of a picture.
const COLUMNS: u32 = 480;

/// Pictures, and what could not be made.
pub fn triplets(read: &Read, infos: &[ProblemInfo]) -> (Vec<Triplet>, Vec<String>) {
    let (mut triplets, mut notes) = (Vec::new(), BTreeSet::new());
    let mut plans: BTreeMap<&str, Result<Plan, String>> = BTreeMap::new();
    let mut wanted = wanted(read, infos);
    if wanted.len() > MOST_FRONTS {
        let more = wanted.len() - MOST_FRONTS;
        notes.insert(format!("Pictures of {more} more fronts are left out."));
        wanted.truncate(MOST_FRONTS);
    }
    let mut gpu = None;
    for (key, rows) in wanted {
        let mut prepared: Option<(Group, Box<dyn Prepared + '_>)> = None;
        // One device for all: opening takes longer than rendering.
        if gpu.is_none() && rows.iter().any(|(row, _)| row.form == "gpu") {
            gpu = Gpu::open(&AdapterChoice::Auto).ok();
        }
        for (row, error) in rows {
            let plan = plans.entry(&row.run).or_insert_with(|| plan_of(read, &row.run));
            let made = plan
                .as_ref()
                .map_err(Clone::clone)
                .and_then(|plan| setting_of(plan, row))
                .and_then(|(group, setting)| {
                    if prepared.as_ref().is_none_or(|(of, _)| of.case != group.case) {
                        let problem = problems::find(&group.case.problem).map_err(words)?;
                        let ready = problem.prepare(&group.case, gpu.as_ref()).map_err(words)?;
                        prepared = Some((group.clone(), ready));
                    }
                    // Just filled in.
                    let Some((_, ready)) = &prepared else { return Err("not prepared".into()) };
                    if ready.facts().scene_hash != row.scene_hash {
                        return Err("the scene has changed since it was measured".into());
                    }
                    let setting = &group.settings[setting];
                    if setting.form == Form::Gpu && gpu.is_none() {
                        return Err("no graphics adapter".into());
                    }
                    let mut subject = ready.subject(setting).map_err(words)?;
                    subject.check().map_err(words)?;
                    subject.picture().map_err(words)
                });
            match made {
                // A problem whose results are no pictures.
                Ok(None) => {}
                Ok(Some(picture)) => match pictures::png(&picture, COLUMNS) {
                    Ok((png, size)) => triplets.push(Triplet {
                        key: key.clone(),
                        setting: format!("{}/{} ({})", row.technique, row.variant, row.form),
                        figures: figures(row, error),
                        png,
                        size,
                    }),
                    Err(error) => drop(notes.insert(error.to_string())),
                },
                Err(reason) => {
                    notes.insert(format!("No pictures of {}, {}: {reason}.", key.case, key.size));
                }
            }
        }
    }
    (triplets, notes.into_iter().collect())
}

fn words(error: SuiteError) -> String {
    error.to_string()
}

fn figures(row: &Row, error: f64) -> String {
    let time = row.median_ns().map(duration).unwrap_or_default();
    format!("{time}, error {}", significant(error))
}

/// Fronts with the rows to be pictured: of each technique on the front its most accurate setting.
fn wanted<'a>(read: &'a Read, infos: &[ProblemInfo]) -> Vec<(Key, Vec<(&'a Row, f64)>)> {
    let mut wanted = Vec::new();
    for info in infos.iter().filter(|info| info.pictures) {
        let rows: Vec<&Row> = read.rows.iter().filter(|r| r.problem == info.id).collect();
        let constraints = info.front_constraints();
        for clock in ["gpu", "wall"] {
            let fronts = front::constrained(&rows, &info.axis, clock, &constraints).fronts;
            for front in fronts {
                let picked = picked(&front, &rows);
                if !picked.is_empty() {
                    wanted.push((front.key, picked));
                }
            }
        }
    }
    let newest = |rows: &[(&Row, f64)]| rows.iter().map(|(r, _)| r.time.clone()).max();
    wanted.sort_by_key(|(_, rows)| std::cmp::Reverse(newest(rows)));
    wanted
}

fn picked<'a>(front: &Front, rows: &[&'a Row]) -> Vec<(&'a Row, f64)> {
    // By time, so that the last of a technique is its most accurate.
    let mut of: BTreeMap<&str, (&Row, f64)> = BTreeMap::new();
    for point in front.points.iter().filter(|p| p.on_front) {
        let row = rows[point.index];
        of.insert(&row.technique, (row, point.error));
    }
    let mut picked: Vec<_> = of.into_values().collect();
    picked.sort_by(|a, b| b.1.total_cmp(&a.1));
    // The accurate end matters most.
    picked.split_off(picked.len().saturating_sub(MOST_SETTINGS))
}

/// The plan of a run, from the command it was started with.
fn plan_of(read: &Read, run: &str) -> Result<Plan, String> {
    let header = read.headers.iter().find(|h| h.run == run).ok_or("the run's header is missing")?;
    let arguments = shlex::split(&header.command).unwrap_or_default();
    let Ok(Args { verb: Some(Verb::Measure(args)) }) = Args::try_parse_from(arguments) else {
        return Err(format!("`{}` is no `dapple measure`", header.command));
    };
    measure::plan(&args).map_err(words)
}

/// The group and position in it that left a row.
fn setting_of<'p>(plan: &'p Plan, row: &Row) -> Result<(&'p Group, usize), String> {
    let places = plan
        .groups
        .iter()
        .flat_map(|group| (0..group.settings.len()).map(move |setting| (group, setting)));
    let mut places = places.into_iter();
    let found = places.find(|(group, setting)| {
        let chosen = &group.settings[*setting];
        group.key(*setting) == row.group
            && chosen.technique == row.technique
            && chosen.variant == row.variant
            && chosen.knobs == row.knobs
    });
    found.ok_or_else(|| "its command no longer expands to it".into())
}
