//! Sweeps are data: TOML that says which problems, scenes, techniques and knobs to measure.
//!
//! ```toml
//! about = "what to look for"
//! repeats = 5
//!
//! [[measure]]
//! problem = "shadow-filtering"
//! scenes = ["spheres", "data:trees/crystalspace_tree.obj"]
//! parameters = { width = [320], footprint = [0.02, 0.05] }
//! forms = ["cpu", "gpu"]
//! knobs = { resolution = [256, 512] }      # for every technique that has the knob
//!
//! [[measure.technique]]                     # none: every technique at its defaults
//! id = "vsm"
//! variants = ["plain", "linstep"]
//! knobs = { format = ["f16", "f32"] }
//! ```

use crate::{
    SuiteError,
    case::Case,
    knob::{self, Knob, Knobs},
    plan::{Group, Plan},
    problem::{Form, Setting, Spec, Technique},
    problems,
};
use serde::Deserialize;
use serde_json::Value;
use std::{collections::BTreeMap, fs, path::Path};

/// Settings measured side by side in one process, the baseline among them: more would hold too
/// many buffers at a time.
const GROUP_LIMIT: usize = 24;

/// Values to try by knob name.
type Lists = BTreeMap<String, Vec<Value>>;

/// A sweep file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// What to look for, prose.
    pub about: String,
    /// Timed repeats of every case.
    #[serde(default = "default_repeats")]
    pub repeats: u32,
    /// Seconds one group may take before it is stopped.
    #[serde(default = "default_limit")]
    pub limit_s: u64,
    /// What to measure.
    pub measure: Vec<Measure>,
}

/// One block of a sweep: the product of its lists.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Problem id.
    pub problem: String,
    /// Scenes; none: the problem's default.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// Views; none: the first of each scene.
    #[serde(default)]
    pub views: Vec<String>,
    /// Seeds; none: 0.
    #[serde(default)]
    pub seeds: Vec<u64>,
    /// Case parameters.
    #[serde(default)]
    pub parameters: Lists,
    /// Forms; none: cpu and gpu.
    #[serde(default)]
    pub forms: Vec<Form>,
    /// Knobs for every technique that has them.
    #[serde(default)]
    pub knobs: Lists,
    /// Techniques; none: all.
    #[serde(default)]
    pub technique: Vec<Pick>,
}

/// A technique in a sweep.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pick {
    /// Technique id.
    pub id: String,
    /// Variants; none: the first; `["*"]`: all.
    #[serde(default)]
    pub variants: Vec<String>,
    /// Knobs of this technique.
    #[serde(default)]
    pub knobs: Lists,
}

fn default_repeats() -> u32 {
    5
}

fn default_limit() -> u64 {
    300
}

impl Sweep {
    /// Reads a sweep from TOML.
    ///
    /// # Errors
    /// [`SuiteError::Sweep`] naming file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, SuiteError> {
        toml::from_str(text)
            .map_err(|e| SuiteError::Sweep { path: path.into(), message: e.to_string() })
    }

    /// Expands the lists into groups of settings that share a case.
    ///
    /// # Errors
    /// Unknown names, values out of range, or a sweep that measures nothing.
    pub fn plan(&self, name: &str) -> Result<Plan, SuiteError> {
        let mut groups = Vec::new();
        for measure in &self.measure {
            let problem = problems::find(&measure.problem)?;
            let settings = settings(problem.spec(), measure)?;
            for case in cases(problem.spec(), measure)? {
                groups.extend(grouped(problem.spec(), &case, &settings));
            }
        }
        if groups.is_empty() {
            return Err(SuiteError::Usage(format!("sweep `{name}` measures nothing")));
        }
        Ok(Plan { name: name.into(), repeats: self.repeats.max(1), limit_s: self.limit_s, groups })
    }
}

/// A named sweep (`quick`) of `benches/sweeps`, built in, or a file.
///
/// # Errors
/// [`SuiteError::Unknown`] or [`SuiteError::Io`] for what cannot be found, and parse errors.
pub fn load(name: &str) -> Result<(String, Sweep), SuiteError> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(n, _)| *n == name) {
        return Ok((name.to_string(), Sweep::parse(Path::new(name), text)?));
    }
    let path = Path::new(name);
    if path.extension().is_none() {
        return Err(SuiteError::unknown("sweep", name, BUILT_IN.iter().map(|(n, _)| *n)));
    }
    let text = fs::read_to_string(path).map_err(SuiteError::io(format!("sweep {name}")))?;
    let stem = path.file_stem().map_or_else(|| name.into(), |s| s.to_string_lossy().to_string());
    Ok((stem, Sweep::parse(path, &text)?))
}

/// The sweeps that come with the program.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("quick", include_str!("../../../benches/sweeps/quick.toml")),
    ("curated", include_str!("../../../benches/sweeps/curated.toml")),
    ("thesis", include_str!("../../../benches/sweeps/thesis.toml")),
];

/// Every combination of the lists, each completed with defaults. With no list, the defaults alone.
fn product(what: &'static str, knobs: &[Knob], lists: &Lists) -> Result<Vec<Knobs>, SuiteError> {
    let mut all = vec![Knobs::new()];
    for (name, values) in lists {
        if values.is_empty() {
            return Err(SuiteError::Usage(format!("{what} `{name}` has an empty list of values")));
        }
        all = all
            .into_iter()
            .flat_map(|chosen| {
                values.iter().map(move |value| {
                    let mut chosen = chosen.clone();
                    chosen.insert(name.clone(), value.clone());
                    chosen
                })
            })
            .collect();
    }
    all.iter().map(|given| knob::complete(what, knobs, given)).collect()
}

fn cases(spec: &Spec, measure: &Measure) -> Result<Vec<Case>, SuiteError> {
    let or = |list: &[String], other: &str| {
        if list.is_empty() { vec![other.to_string()] } else { list.to_vec() }
    };
    let seeds = if measure.seeds.is_empty() { &[0][..] } else { &measure.seeds };
    let parameters = product("parameter", spec.parameters, &measure.parameters)?;
    let mut cases = Vec::new();
    for scene in or(&measure.scenes, spec.default_scene) {
        for view in or(&measure.views, "") {
            for seed in seeds {
                cases.extend(parameters.iter().map(|parameters| Case {
                    problem: spec.id.into(),
                    scene: scene.clone(),
                    view: view.clone(),
                    seed: *seed,
                    parameters: parameters.clone(),
                }));
            }
        }
    }
    Ok(cases)
}

fn settings(spec: &'static Spec, measure: &Measure) -> Result<Vec<Setting>, SuiteError> {
    let every = || {
        spec.techniques.iter().map(|t| Pick {
            id: t.id.into(),
            variants: Vec::new(),
            knobs: Lists::new(),
        })
    };
    let picks: Vec<Pick> =
        if measure.technique.is_empty() { every().collect() } else { measure.technique.clone() };
    for name in measure.knobs.keys() {
        let mut names = spec.techniques.iter().flat_map(|t| t.knobs).map(|k| k.name);
        if !names.any(|known| known == name) {
            let known: std::collections::BTreeSet<_> =
                spec.techniques.iter().flat_map(|t| t.knobs).map(|k| k.name).collect();
            return Err(SuiteError::unknown("knob", name, known));
        }
    }
    let mut settings = Vec::new();
    for pick in picks {
        let technique = spec.technique(&pick.id)?;
        let mut lists = measure.knobs.clone();
        lists.retain(|name, _| technique.knobs.iter().any(|k| k.name == name));
        lists.extend(pick.knobs.clone());
        let forms =
            if measure.forms.is_empty() { &[Form::Cpu, Form::Gpu][..] } else { &measure.forms };
        for variant in variants(technique, &pick.variants)? {
            for knobs in product("knob", technique.knobs, &lists)? {
                settings.extend(forms.iter().filter(|f| technique.forms.contains(f)).map(|form| {
                    Setting {
                        technique: technique.id.into(),
                        variant: variant.into(),
                        form: *form,
                        knobs: knobs.clone(),
                    }
                }));
            }
        }
    }
    Ok(settings)
}

fn variants(technique: &Technique, asked: &[String]) -> Result<Vec<&'static str>, SuiteError> {
    let known = technique.variants.iter().map(|v| v.id);
    match asked {
        [] => Ok(known.take(1).collect()),
        [all] if all == "*" => Ok(known.collect()),
        asked => asked
            .iter()
            .map(|id| {
                known.clone().find(|k| k == id).ok_or_else(|| {
                    SuiteError::unknown("variant", &format!("{}/{id}", technique.id), known.clone())
                })
            })
            .collect(),
    }
}

/// Groups by form, in chunks that each begin with the baseline, so that ratios pair up.
fn grouped(spec: &Spec, case: &Case, settings: &[Setting]) -> Vec<Group> {
    let mut groups = Vec::new();
    for form in [Form::Reference, Form::Cpu, Form::Gpu] {
        let of_form: Vec<_> = settings.iter().filter(|s| s.form == form).cloned().collect();
        let baseline = of_form.iter().find(|s| s.technique == spec.techniques[0].id).cloned();
        let others: Vec<_> = of_form.into_iter().filter(|s| Some(s) != baseline.as_ref()).collect();
        let room = GROUP_LIMIT - usize::from(baseline.is_some());
        let mut chunks: Vec<Vec<Setting>> = others.chunks(room).map(<[_]>::to_vec).collect();
        if chunks.is_empty() && baseline.is_some() {
            chunks.push(Vec::new());
        }
        for (i, mut settings) in chunks.into_iter().enumerate() {
            if let Some(baseline) = &baseline {
                settings.insert(0, baseline.clone());
            }
            // The baseline of a later chunk is measured again for its ratios, and recorded once.
            groups.push(Group {
                case: case.clone(),
                settings,
                repeated_baseline: i > 0 && baseline.is_some(),
            });
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str) -> Result<Plan, SuiteError> {
        Sweep::parse(Path::new("test.toml"), text)?.plan("test")
    }

    #[test]
    fn every_built_in_sweep_expands() {
        for (name, _) in BUILT_IN {
            let (_, sweep) = load(name).unwrap();
            assert!(!sweep.plan(name).unwrap().groups.is_empty(), "{name}");
            assert!(!sweep.about.is_empty());
        }
    }

    #[test]
    fn lists_multiply_and_only_reach_techniques_that_have_the_knob() {
        let plan = plan(
            r#"
            about = "t"
            [[measure]]
            problem = "shadow-filtering"
            scenes = ["spheres", "chairs"]
            forms = ["cpu"]
            knobs = { resolution = [128, 256] }
            [[measure.technique]]
            id = "hard"
            [[measure.technique]]
            id = "vsm"
            variants = ["*"]
            knobs = { format = ["f16", "f32"] }
            "#,
        )
        .unwrap();
        assert_eq!(plan.groups.len(), 2);
        let vsm = problems::find("shadow-filtering").unwrap().spec().technique("vsm").unwrap();
        assert_eq!(plan.groups[0].settings.len(), 2 + 2 * 2 * vsm.variants.len());
    }

    #[test]
    fn mistakes_are_named() {
        let block = "about = 't'\n[[measure]]\nproblem = 'shadow-filtering'\n";
        for (text, expect) in [
            ("about = 3", "test.toml"),
            ("about = 't'\nmeasure = []", "measures nothing"),
            ("about = 't'\n[[measure]]\nproblem = 'nothing'", "no problem `nothing`"),
            (&format!("{block}typo = 1"), "typo"),
            (&format!("{block}knobs = {{ size = [1] }}"), "no knob `size`"),
            (&format!("{block}knobs = {{ resolution = [0] }}"), "must be an integer"),
            (&format!("{block}knobs = {{ resolution = [] }}"), "empty list"),
            (&format!("{block}[[measure.technique]]\nid = 'wsm'"), "no technique `wsm`"),
            (
                &format!("{block}[[measure.technique]]\nid = 'vsm'\nvariants = ['x']"),
                "no variant `vsm/x`",
            ),
        ] {
            let error = plan(text).unwrap_err();
            assert!(error.to_string().contains(expect), "{text}: {error}");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
