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
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// Settings measured side by side in one process, the baseline among them: more would hold too
/// many buffers at a time.
const GROUP_LIMIT: usize = 24;

/// Repeats and seconds (a week) beyond which a sweep is a mistake.
const MOST_REPEATS: u32 = 100_000;
const MOST_SECONDS: u64 = 7 * 24 * 3600;

/// Combinations that one block may multiply to.
const MOST_COMBINATIONS: usize = 100_000;

/// Measurements of a whole sweep: at half a second each more than a day, and some 250 MB of plan.
const MOST_MEASUREMENTS: usize = 250_000;

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
        let within = |name: &str, value: u64, most: u64| match value {
            value if (1..=most).contains(&value) => Ok(()),
            _ => Err(SuiteError::Value {
                what: "sweep's",
                name: name.into(),
                value: value.to_string(),
                limit: format!("must be an integer in 1..={most}"),
            }),
        };
        within("repeats", self.repeats.into(), MOST_REPEATS.into())?;
        within("limit_s", self.limit_s, MOST_SECONDS)?;
        let (mut groups, mut notes) = (Vec::new(), Vec::new());
        let mut measurements = 0_usize;
        for measure in &self.measure {
            let problem = problems::find(&measure.problem)?;
            let settings = settings(problem.spec(), measure, &mut notes)?;
            // Counted before it is made.
            let here = most_cases(measure).saturating_mul(settings.len());
            measurements = measurements.saturating_add(here);
            if measurements > MOST_MEASUREMENTS || most_cases(measure) > MOST_COMBINATIONS {
                return Err(SuiteError::Usage(format!(
                    "sweep `{name}` multiplies to {measurements} measurements of {} cases, more \
                     than {MOST_MEASUREMENTS} of {MOST_COMBINATIONS}",
                    most_cases(measure)
                )));
            }
            for case in cases(problem.spec(), measure)? {
                groups.extend(grouped(problem.spec(), &case, &settings));
            }
        }
        if groups.is_empty() {
            return Err(SuiteError::Usage(format!("sweep `{name}` measures nothing")));
        }
        groups.iter_mut().enumerate().for_each(|(index, group)| group.index = index);
        let (repeats, limit_s) = (self.repeats, self.limit_s);
        let shard = String::new();
        Ok(Plan { name: name.into(), repeats, limit_s, groups, notes, shard })
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
    ("translucency", include_str!("../../../benches/sweeps/translucency.toml")),
    ("visibility", include_str!("../../../benches/sweeps/visibility.toml")),
    ("many_lights", include_str!("../../../benches/sweeps/many_lights.toml")),
    ("night", include_str!("../../../benches/sweeps/night.toml")),
];

/// Every combination of the lists once, each completed with defaults. With no list, the defaults
/// alone.
fn product(what: &'static str, knobs: &[Knob], lists: &Lists) -> Result<Vec<Knobs>, SuiteError> {
    let mut all = vec![Knobs::new()];
    for (name, values) in lists {
        if values.is_empty() {
            return Err(SuiteError::Usage(format!("{what} `{name}` has an empty list of values")));
        }
        if all.len().saturating_mul(values.len()) > MOST_COMBINATIONS {
            return Err(SuiteError::Usage(format!(
                "the {what} lists multiply to more than {MOST_COMBINATIONS} combinations"
            )));
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
    let all: Result<Vec<Knobs>, SuiteError> =
        all.iter().map(|given| knob::complete(what, knobs, given)).collect();
    Ok(unique(all?))
}

/// The first of each: a value listed twice is measured once.
fn unique<T: Serialize>(mut items: Vec<T>) -> Vec<T> {
    let mut seen = BTreeSet::new();
    // Plain data to memory: serialising it cannot fail.
    items.retain(|item| seen.insert(serde_json::to_string(item).unwrap_or_default()));
    items
}

/// Cases that a block has if none is there twice.
fn most_cases(measure: &Measure) -> usize {
    let lists = [measure.scenes.len(), measure.views.len(), measure.seeds.len()];
    let parameters = measure.parameters.values().map(Vec::len);
    lists.into_iter().chain(parameters).fold(1, |all, one| all.saturating_mul(one.max(1)))
}

pub(crate) fn cases(spec: &Spec, measure: &Measure) -> Result<Vec<Case>, SuiteError> {
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
    Ok(unique(cases))
}

pub(crate) fn settings(
    spec: &'static Spec,
    measure: &Measure,
    notes: &mut Vec<String>,
) -> Result<Vec<Setting>, SuiteError> {
    let every = || {
        spec.techniques.iter().map(|t| Pick {
            id: t.id.into(),
            variants: Vec::new(),
            knobs: Lists::new(),
        })
    };
    let picks: Vec<Pick> =
        if measure.technique.is_empty() { every().collect() } else { measure.technique.clone() };
    let picked: Vec<&Technique> =
        picks.iter().map(|pick| spec.technique(&pick.id)).collect::<Result<_, _>>()?;
    // A knob that none of these techniques has would change nothing, silently.
    let known: BTreeSet<_> = picked.iter().flat_map(|t| t.knobs).map(|k| k.name).collect();
    if let Some(name) = measure.knobs.keys().find(|name| !known.contains(name.as_str())) {
        return Err(SuiteError::unknown("knob", name, known));
    }
    for (name, values) in &measure.knobs {
        if values.is_empty() {
            return Err(SuiteError::Usage(format!("knob `{name}` has an empty list of values")));
        }
        for value in values {
            accepted_by_one(&picked, name, value)?;
        }
    }
    let mut settings = Vec::new();
    for (pick, technique) in picks.iter().zip(picked) {
        let mut lists = accepted(technique, &measure.knobs);
        lists.extend(pick.knobs.clone());
        if let Some((name, _)) = lists.iter().find(|(_, values)| values.is_empty()) {
            notes.push(format!("{}: left out, it takes none of the values of {name}", pick.id));
            continue;
        }
        let forms =
            if measure.forms.is_empty() { &[Form::Cpu, Form::Gpu][..] } else { &measure.forms };
        for variant in variants(technique, &pick.variants)? {
            let each = lists.values().fold(1, |all: usize, l| all.saturating_mul(l.len()));
            if settings.len().saturating_add(each) > MOST_COMBINATIONS {
                return Err(SuiteError::Usage(format!(
                    "the knob lists multiply to more than {MOST_COMBINATIONS} combinations"
                )));
            }
            for knobs in product("knob", technique.knobs, &lists)? {
                settings.extend(forms.iter().filter(|f| technique.has(variant, **f)).map(|form| {
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
    Ok(unique(settings))
}

/// A value for all techniques must fit at least one of them.
fn accepted_by_one(picked: &[&Technique], name: &str, value: &Value) -> Result<(), SuiteError> {
    let knobs = picked.iter().flat_map(|t| t.knobs).filter(|k| k.name == name);
    let checks: Vec<_> = knobs.map(|k| k.check("knob", value)).collect();
    match checks.iter().any(Result::is_ok) {
        true => Ok(()),
        false => checks.into_iter().next().map_or(Ok(()), |first| first.map(|_| ())),
    }
}

/// Of the lists for all techniques what this one has and takes: formats differ between techniques.
fn accepted(technique: &Technique, lists: &Lists) -> Lists {
    let mut own = Lists::new();
    for knob in technique.knobs {
        if let Some(values) = lists.get(knob.name) {
            let fit = values.iter().filter(|v| knob.check("knob", v).is_ok()).cloned();
            own.insert(knob.name.into(), fit.collect());
        }
    }
    own
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

/// Groups by form, in chunks that each begin with the baseline, so that ratios pair up. Their
/// position in the sweep is not yet known.
fn grouped(spec: &Spec, case: &Case, settings: &[Setting]) -> Vec<Group> {
    let mut groups = Vec::new();
    for form in [Form::Reference, Form::Cpu, Form::Gpu] {
        let of_form: Vec<_> = settings.iter().filter(|s| s.form == form).cloned().collect();
        // Without the problem's own baseline the first setting: all chunks refer to one.
        let own = of_form.iter().find(|s| s.technique == spec.techniques[0].id);
        let baseline = own.or(of_form.first()).cloned();
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
                index: 0,
                case: case.clone(),
                settings,
                repeated_baseline: i > 0 && baseline.is_some(),
                skipped: 0,
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
    fn a_variant_is_not_planned_in_a_form_that_it_lacks() {
        let block = "about = 't'\n[[measure]]\nproblem = 'translucent-shadow'\n";
        let all = format!("{block}[[measure.technique]]\nid = 'bom-search'\nvariants = ['*']");
        let plan = plan(&all).unwrap();
        let has = |variant: &str, form: Form| {
            let mut settings = plan.groups.iter().flat_map(|group| &group.settings);
            settings.any(|s| s.variant == variant && s.form == form)
        };
        assert!(has("oracle", Form::Cpu) && !has("oracle", Form::Gpu));
        assert!(has("correlation", Form::Cpu) && has("correlation", Form::Gpu));
    }

    #[test]
    fn what_is_listed_twice_is_measured_once() {
        let block = "about = 't'\n[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\n";
        let once = format!("{block}seeds = [1]\n[[measure.technique]]\nid = 'vsm'");
        let twice = format!(
            "{block}seeds = [1, 1]\nparameters = {{ width = [320, 320] }}\n\
             knobs = {{ resolution = [512, 512] }}\n\
             [[measure.technique]]\nid = 'vsm'\n[[measure.technique]]\nid = 'vsm'"
        );
        assert_eq!(plan(&once).unwrap(), plan(&twice).unwrap());
    }

    #[test]
    fn chunks_without_the_problems_baseline_share_their_first_setting() {
        let values: Vec<_> = (16..16 + 60).map(|v| v.to_string()).collect();
        let plan = plan(&format!(
            "about = 't'\n[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\n\
             knobs = {{ resolution = [{}] }}\n[[measure.technique]]\nid = 'vsm'",
            values.join(",")
        ))
        .unwrap();
        assert!(plan.groups.len() > 1);
        assert!(plan.groups.iter().all(|g| g.settings[0] == plan.groups[0].settings[0]));
        assert_eq!(plan.rows(), 60);
    }

    #[test]
    fn an_absurd_product_is_refused_before_it_is_made() {
        let values: Vec<_> = (16..1016).map(|v| v.to_string()).collect();
        let error = plan(&format!(
            "about = 't'\n[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\n\
             knobs = {{ resolution = [{0}], taps = [{0}] }}\n\
             [[measure.technique]]\nid = 'pcf'",
            values.join(",")
        ))
        .unwrap_err();
        assert!(error.to_string().contains("more than 100000 combinations"), "{error}");
    }

    #[test]
    fn products_over_lists_of_all_kinds_are_counted_before_they_are_made() {
        let list = |count: usize| (0..count).map(|v| v.to_string()).collect::<Vec<_>>().join(",");
        let names = |count: usize| (0..count).map(|v| format!("'s{v}'")).collect::<Vec<_>>();
        let block = "[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\n";
        let seeds = format!("{block}seeds = [{}]\n", list(600));
        let some = |technique: &str| format!("{seeds}[[measure.technique]]\nid = '{technique}'\n");
        assert!(plan(&format!("about = 't'\n{}", some("hard"))).is_ok(), "the control");
        let ten_to_the_twelve = format!(
            "about = 't'\n{block}scenes = [{0}]\nviews = [{0}]\nseeds = [{1}]\n",
            names(10_000).join(","),
            list(10_000)
        );
        let knobs = format!(
            "knobs = {{ resolution = [{}] }}",
            list(616).replacen("0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,", "", 1)
        );
        let many_techniques: String =
            (0..300).map(|_| format!("[[measure.technique]]\nid = 'vsm'\n{knobs}\n")).collect();
        for (text, limit) in [
            (ten_to_the_twelve, "more than 250000 of 100000"),
            (format!("about = 't'\n{}", seeds.repeat(1000)), "more than 250000 of 100000"),
            (format!("about = 't'\n{block}{many_techniques}"), "more than 100000 combinations"),
        ] {
            let start = std::time::Instant::now();
            let error = plan(&text).unwrap_err();
            assert!(error.to_string().contains(limit), "{error}");
            assert_eq!(error.exit_code(), 2);
            assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
        }
    }

    #[test]
    fn a_value_reaches_the_techniques_that_take_it_and_the_others_are_named() {
        let block = "about = 't'\n[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\n";
        let formats = |list: &str| plan(&format!("{block}knobs = {{ format = {list} }}"));
        let of = |plan: &Plan, id: &str| {
            plan.groups.iter().flat_map(|g| &g.settings).filter(|s| s.technique == id).count()
        };
        let both = formats("['f32', 'u16']").unwrap();
        assert_eq!((of(&both, "msm"), of(&both, "evsm")), (2, 1));
        assert!(both.notes.is_empty());
        let unorm = formats("['u16']").unwrap();
        assert_eq!((of(&unorm, "msm"), of(&unorm, "evsm")), (1, 0));
        assert!(unorm.notes.iter().any(|n| n.starts_with("evsm: left out")), "{:?}", unorm.notes);
        assert!(formats("['u8']").is_err());
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
            (&format!("repeats = 0\n{block}"), "`repeats` = 0: must be an integer in 1..="),
            (&format!("limit_s = 0\n{block}"), "`limit_s` = 0: must be an integer in 1..="),
            (
                &format!("limit_s = 9000000000000000000\n{block}"),
                "must be an integer in 1..=604800",
            ),
            (
                &format!("{block}knobs = {{ layers = [1] }}\n[[measure.technique]]\nid = 'hard'"),
                "no knob `layers`; there is: ",
            ),
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
