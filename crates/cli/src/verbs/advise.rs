//! `dapple advise`.

use super::measure::{form, measure_block, pick, progress_bar};
use crate::{
    Outcome,
    args::{self, Format},
    die_of_closed_pipes,
    output::{Table, note, put},
    runner,
};
use anyhow::Result;
use dapple_gpu::AdapterKind;
use dapple_records::{Row, text::duration};
use dapple_suite::{
    SuiteError,
    advise::{Advice, Candidate, Found, Goal, Live, Request, Space, advise, parse_time},
    case::{self, Case, Source},
    problem::{Form, Setting, Spec},
    problems,
    run::{Options, Progress},
    shell::quoted,
    sweep::Sweep,
};
use serde_json::Value;
use std::{sync::Arc, time::Instant};

/// Searches and prints the choice with what the next steps would cost.
pub fn run(args: &args::Advise) -> Result<Outcome> {
    let begun = Instant::now();
    let spec = problems::find(&args.problem)?.spec();
    let request = request(spec, args)?;
    let time = parse_time(&args.time)?;
    let (case, space) = choices(spec, args)?;
    let stop = runner::stop_flag();
    let options = Options {
        fresh: true,
        ..runner::options(&args.records, args.adapter.as_ref(), "run-group")?
    };
    let bar = progress_bar(0);
    let mut notes: Vec<String> = Vec::new();
    let mut tell = |progress: Progress<'_>| match progress {
        Progress::Note(text) if !notes.iter().any(|n| n == text) => notes.push(text.into()),
        Progress::Stage { setting, stage } => bar.set_message(format!("{stage} {setting}")),
        Progress::Row(_) => bar.inc(1),
        _ => {}
    };
    let mut live = Live::new(case.clone(), options, Arc::clone(&stop), begun + time, &mut tell);
    // A measuring process that dies at its start must not take the search along.
    die_of_closed_pipes(false);
    let advice = advise(&space, &request, &mut live);
    die_of_closed_pipes(true);
    bar.finish_and_clear();
    let (rows, preparing) = (std::mem::take(&mut live.rows), live.preparing);
    for text in &notes {
        note!("note: {text}");
    }
    let advice = advice?;
    let shown = Shown { spec, case: &case, request: &request, advice: &advice, args };
    shown.print(&rows)?;
    let spent = begun.elapsed().as_secs_f64();
    note!(
        "{} of {} settings measured in {spent:.1} s, {:.0} % of it spent on preparing the case; \
         records: {}",
        advice.asked,
        advice.of,
        100.0 * preparing.as_secs_f64() / spent,
        args.records.display()
    );
    if advice.cut_short {
        note!(
            "the time was over before the search was: --time {} was too short to be sure",
            args.time
        );
    }
    Ok(if advice.choice.is_some() && advice.met { Outcome::Ok } else { Outcome::CheckFailed })
}

/// What is asked for; errors name flag and limit.
fn request(spec: &Spec, args: &args::Advise) -> Result<Request, SuiteError> {
    let metric = args.metric.as_deref().unwrap_or(spec.axis);
    if !spec.metrics.iter().any(|m| m.name == metric) {
        return Err(SuiteError::unknown("metric", metric, spec.metrics.iter().map(|m| m.name)));
    }
    let refused = |name: &str, value: f64, limit: &str| SuiteError::Value {
        what: "flag",
        name: name.into(),
        value: value.to_string(),
        limit: limit.into(),
    };
    let goal = match (args.error, args.budget_ms) {
        (Some(at_most), _) if at_most.is_finite() && at_most >= 0.0 => Goal::Error { at_most },
        (Some(error), _) => {
            return Err(refused("--error", error, "must be a finite number of at least 0"));
        }
        (None, Some(ms)) if ms.is_finite() && ms > 0.0 => Goal::Budget { ns: 1e6 * ms },
        (None, Some(ms)) => {
            return Err(refused("--budget-ms", ms, "must be a finite number above 0"));
        }
        (None, None) => Goal::Knee,
    };
    Ok(Request { metric: metric.into(), goal, constraints: spec.front_constraints() })
}

/// The case, and every technique and variant there is to choose from.
fn choices(spec: &'static Spec, args: &args::Advise) -> Result<(Case, Space), SuiteError> {
    for scene in &args.case.scene {
        if let Source::MissingData(path) = case::source(scene)? {
            return Err(case::missing_data(&path));
        }
    }
    let form = match &args.form {
        Some(name) => form(name)?,
        None => default_form(spec, args.adapter.as_ref()),
    };
    if form == Form::Reference {
        return Err(SuiteError::Usage(
            "form `reference` is never timed; there is: cpu, gpu".into(),
        ));
    }
    let mut measure = measure_block(spec, &args.case)?;
    measure.forms = vec![form];
    let all = spec.techniques.iter().map(|t| t.id.to_string());
    let asked: Vec<String> =
        if args.technique.is_empty() { all.collect() } else { args.technique.clone() };
    measure.technique = asked
        .iter()
        .map(|text| {
            let mut pick = pick(text);
            if pick.variants.is_empty() {
                pick.variants.push("*".into());
            }
            pick
        })
        .collect();
    let sweep = Sweep { about: String::new(), repeats: 1, limit_s: 600, measure: vec![measure] };
    let plan = sweep.plan("advise")?;
    let case = plan.groups[0].case.clone();
    if plan.groups.iter().any(|group| group.case != case) {
        return Err(SuiteError::Usage(
            "advise works on one case: give one scene and one value of each parameter".into(),
        ));
    }
    let mut space = Space::default();
    for setting in plan.groups.iter().flat_map(|g| &g.settings) {
        let known =
            |c: &Candidate| c.technique == setting.technique && c.variant == setting.variant;
        if !space.candidates.iter().any(known) {
            let technique = spec.technique(&setting.technique)?;
            space.candidates.push(Candidate::of(technique, &setting.variant, form));
        }
    }
    Ok((case, space))
}

/// The graphics card where there is one; a program that imitates one only for those who ask.
fn default_form(spec: &Spec, adapter: Option<&String>) -> Form {
    let hardware = || dapple_gpu::adapters().iter().any(|a| a.kind == AdapterKind::Hardware);
    let has = |form| spec.techniques.iter().any(|t| t.forms.contains(&form));
    if has(Form::Gpu) && (adapter.is_some() || hardware() || !has(Form::Cpu)) {
        Form::Gpu
    } else {
        Form::Cpu
    }
}

struct Shown<'a> {
    spec: &'a Spec,
    case: &'a Case,
    request: &'a Request,
    advice: &'a Advice,
    args: &'a args::Advise,
}

impl Shown<'_> {
    fn print(&self, rows: &[Row]) -> Result<()> {
        let named = [
            (if self.advice.met { "choice" } else { "nearest" }, &self.advice.choice),
            ("runner-up", &self.advice.runner_up),
            ("cheaper", &self.advice.cheaper),
            ("more accurate", &self.advice.better),
        ];
        let named = named.iter().filter_map(|(role, found)| Some((*role, found.as_ref()?)));
        match self.args.format {
            Format::Table => self.people(rows, named.collect()),
            format => self.programs(named.collect(), format),
        }
    }

    fn people(&self, rows: &[Row], named: Vec<(&str, &Found)>) -> Result<()> {
        let (spec, request) = (self.spec, self.request);
        let goal = match request.goal {
            Goal::Error { at_most } => format!("the cheapest with {} <= {at_most}", request.metric),
            Goal::Budget { ns } => format!("the least {} within {}", request.metric, duration(ns)),
            Goal::Knee => format!("the knee of {} against time", request.metric),
        };
        put!("{}: {}: {goal}", spec.id, self.case.name())?;
        if let Some(row) = rows.iter().find(|r| r.device != "none" && r.device != "unknown") {
            let device = match row.device.as_str() {
                "cpu" => row.cpu.clone(),
                device => format!("{} ({device})", row.adapter),
            };
            put!("  error against {}", row.truth)?;
            put!("  time: {} form on {device}, {} clock, {}", row.form, row.clock, row.size)?;
        }
        match &self.advice.choice {
            Some(_) if self.advice.met => {}
            Some(_) => put!("  nothing that was measured meets this; the nearest is shown")?,
            None => put!("  nothing passed its check in the time there was")?,
        }
        let choice = self.advice.choice.as_ref();
        let mut table = Table::new(&["", "technique", "time", "±", "error", "price", "knobs"]);
        for (role, found) in named {
            let spread = 100.0 * found.mad_ns / found.time_ns;
            table.row([
                role.into(),
                format!("{}/{}", found.setting.technique, found.setting.variant).into(),
                duration(found.time_ns).into(),
                format!("{spread:.0}%").into(),
                Value::from(found.error),
                choice.map(|choice| price(choice, found)).into(),
                turned(spec, &found.setting).join(" ").into(),
            ]);
        }
        if let Some(choice) = choice {
            table.print(Format::Table)?;
            put!("measure it: {}", self.command(&choice.setting))?;
        }
        if !self.advice.dropped.is_empty() {
            put!("not chosen:")?;
            for (name, reason) in &self.advice.dropped {
                put!("  {name}: {reason}")?;
            }
        }
        Ok(())
    }

    fn programs(&self, named: Vec<(&str, &Found)>, format: Format) -> Result<()> {
        let mut table = Table::new(&[
            "role",
            "problem",
            "case",
            "technique",
            "variant",
            "form",
            "knobs",
            "time_ns",
            "mad_ns",
            "metric",
            "error",
            "met",
            "cut_short",
            "command",
        ]);
        for (role, found) in named {
            let setting = &found.setting;
            table.row([
                role.into(),
                self.spec.id.into(),
                self.case.name().into(),
                setting.technique.as_str().into(),
                setting.variant.as_str().into(),
                setting.form.to_string().into(),
                turned(self.spec, setting).join(" ").into(),
                found.time_ns.into(),
                found.mad_ns.into(),
                self.request.metric.as_str().into(),
                found.error.into(),
                self.advice.met.into(),
                self.advice.cut_short.into(),
                self.command(setting).into(),
            ]);
        }
        table.print(format)
    }

    /// What measures a setting again, as a shell takes it.
    fn command(&self, setting: &Setting) -> String {
        let case = &self.args.case;
        let mut words = vec!["dapple".to_string(), "measure".into(), self.spec.id.into()];
        let mut flag = |name: &str, value: &str| words.extend([name.into(), quoted(value)]);
        flag("--scene", &self.case.scene);
        if let Some(view) = &case.view {
            flag("--view", view);
        }
        if let Some(seed) = case.seed {
            flag("--seed", &seed.to_string());
        }
        case.parameters.iter().for_each(|p| flag("--param", p));
        flag("--technique", &format!("{}/{}", setting.technique, setting.variant));
        turned(self.spec, setting).iter().for_each(|knob| flag("--knob", knob));
        flag("--form", &setting.form.to_string());
        if let Some(adapter) = &self.args.adapter {
            flag("--adapter", adapter);
        }
        words.join(" ")
    }
}

/// A result over the choice: the factors in time and error.
fn price(choice: &Found, found: &Found) -> String {
    if choice == found {
        return String::new();
    }
    let factor = |a: f64, b: f64| match a / b {
        factor if factor.is_finite() && factor < 10.0 => format!("x{factor:.2}"),
        factor if factor.is_finite() => format!("x{factor:.0}"),
        _ => "-".into(),
    };
    let (time, error) = (factor(found.time_ns, choice.time_ns), factor(found.error, choice.error));
    format!("time {time}, error {error}")
}

/// The knobs that differ from the technique's defaults, `NAME=VALUE`.
fn turned(spec: &Spec, setting: &Setting) -> Vec<String> {
    let technique = spec.technique(&setting.technique).ok();
    let default =
        |name: &str| technique?.knobs.iter().find(|k| k.name == name).map(|k| k.default_value());
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), Into::into);
    setting
        .knobs
        .iter()
        .filter(|(name, value)| default(name).as_ref() != Some(value))
        .map(|(name, value)| format!("{name}={}", text(value)))
        .collect()
}
