//! What is turned on the live screen: technique, variant, form, knobs, case and camera.

use super::super::World;
use dapple_records::{
    Show, Value,
    catalogue::{KnobInfo, ProblemInfo, TechniqueInfo},
};
use std::collections::BTreeMap;

/// Degrees that one key turns or raises the camera.
const TURN_DEG: i32 = 10;

/// The camera is raised or lowered no further than this; the program clamps short of the poles.
const MOST_RAISED_DEG: i32 = 90;

/// Factors of the distance that keys step through.
const DISTANCES: [f64; 9] = [0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0];

/// The factor of no change.
const NEAR: usize = 4;

/// Something with values that left and right step through.
#[derive(Clone, Debug, PartialEq)]
pub enum Row {
    /// The technique.
    Technique,
    /// Its variant.
    Variant,
    /// Its form.
    Form,
    /// A knob of that name.
    Knob(String),
    /// The scene.
    Scene,
    /// A case parameter of that name.
    Parameter(String),
}

/// A direction to move the camera in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// About the up axis, this many steps.
    Around(i32),
    /// Up, this many steps.
    Up(i32),
    /// Away, this many steps.
    Away(i32),
}

/// Everything turned away from its default. Values are kept by name while a technique without them
/// is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The problem it belongs to.
    pub problem: String,
    /// Technique id.
    pub technique: String,
    variants: BTreeMap<String, String>,
    form: String,
    knobs: BTreeMap<String, Value>,
    scene: String,
    parameters: BTreeMap<String, Value>,
    azimuth_deg: i32,
    elevation_deg: i32,
    distance: usize,
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            problem: String::new(),
            technique: String::new(),
            variants: BTreeMap::new(),
            form: String::new(),
            knobs: BTreeMap::new(),
            scene: String::new(),
            parameters: BTreeMap::new(),
            azimuth_deg: 0,
            elevation_deg: 0,
            distance: NEAR,
        }
    }
}

impl Choice {
    /// The defaults of a problem; `technique` if it has one of that name, else its first.
    pub fn of(info: &ProblemInfo, technique: &str) -> Self {
        let mut choice = Self { problem: info.id.clone(), ..Self::default() };
        choice.set_technique(info, technique);
        choice
    }

    /// Shows another technique, or the first where there is none of that name.
    pub fn set_technique(&mut self, info: &ProblemInfo, id: &str) {
        let known = info.techniques.iter().find(|t| t.id == id);
        let chosen = known.or(info.techniques.first());
        self.technique = chosen.map(|t| t.id.clone()).unwrap_or_default();
    }

    /// The same technique and form with everything else at its default.
    pub fn reset(&mut self) {
        *self = Self {
            problem: std::mem::take(&mut self.problem),
            technique: std::mem::take(&mut self.technique),
            form: std::mem::take(&mut self.form),
            ..Self::default()
        };
    }

    /// The technique's declaration.
    pub fn info<'a>(&self, info: &'a ProblemInfo) -> Option<&'a TechniqueInfo> {
        info.techniques.iter().find(|t| t.id == self.technique)
    }

    /// The form shown: the chosen one where the technique has it, else the processor's, else its
    /// first.
    pub fn form<'a>(&'a self, technique: &'a TechniqueInfo) -> &'a str {
        let has = |form: &str| technique.forms.iter().any(|f| f == form);
        let first = technique.forms.first().map_or("", String::as_str);
        if has(&self.form) {
            &self.form
        } else if has("cpu") {
            "cpu"
        } else {
            first
        }
    }

    fn variant<'a>(&'a self, technique: &'a TechniqueInfo) -> &'a str {
        let chosen = self.variants.get(&technique.id).map(String::as_str);
        let first = technique.variants.first().map(|v| v.0.as_str());
        chosen.or(first).unwrap_or_default()
    }

    /// What can be turned, in the order shown.
    pub fn rows(&self, info: &ProblemInfo) -> Vec<Row> {
        let Some(technique) = self.info(info) else { return Vec::new() };
        let mut rows = vec![Row::Technique];
        if technique.variants.len() > 1 {
            rows.push(Row::Variant);
        }
        if technique.forms.len() > 1 {
            rows.push(Row::Form);
        }
        rows.extend(technique.knobs.iter().map(|k| Row::Knob(k.name.clone())));
        rows.push(Row::Scene);
        rows.extend(info.parameters.iter().map(|k| Row::Parameter(k.name.clone())));
        rows
    }

    fn knob_info<'a>(&self, info: &'a ProblemInfo, row: &Row) -> Option<&'a KnobInfo> {
        match row {
            Row::Knob(name) => self.info(info)?.knobs.iter().find(|k| k.name == *name),
            Row::Parameter(name) => info.parameters.iter().find(|k| k.name == *name),
            _ => None,
        }
    }

    /// A row's name, its value and whether that is not the default.
    pub fn text(&self, info: &ProblemInfo, row: &Row) -> (String, String, bool) {
        let Some(technique) = self.info(info) else { return Default::default() };
        match row {
            Row::Technique => ("technique".into(), self.technique.clone(), false),
            Row::Variant => {
                let variant = self.variant(technique);
                let turned = technique.variants.first().is_none_or(|v| v.0 != variant);
                ("variant".into(), variant.into(), turned)
            }
            Row::Form => ("form".into(), self.form(technique).into(), false),
            Row::Scene => {
                let scene = if self.scene.is_empty() { &info.default_scene } else { &self.scene };
                ("scene".into(), scene.clone(), *scene != info.default_scene)
            }
            Row::Knob(name) | Row::Parameter(name) => {
                let Some(knob) = self.knob_info(info, row) else { return Default::default() };
                let value = self.value(row, knob);
                let unit = if knob.unit.is_empty() { "" } else { " " };
                let text = format!("{}{unit}{}", plain(value), knob.unit);
                (name.clone(), text, *value != knob.default)
            }
        }
    }

    /// One line about a row and what it may be.
    pub fn help(&self, info: &ProblemInfo, row: &Row) -> String {
        let technique = self.info(info);
        match row {
            Row::Technique => technique.map(|t| t.title.clone()).unwrap_or_default(),
            Row::Variant => {
                let variants = technique.into_iter().flat_map(|t| {
                    let now = self.variant(t);
                    t.variants.iter().filter(move |v| v.0 == now)
                });
                variants.map(|v| v.1.clone()).collect()
            }
            Row::Form => "where and how it runs".into(),
            Row::Scene => "what is looked at".into(),
            Row::Knob(_) | Row::Parameter(_) => {
                let knob = self.knob_info(info, row);
                knob.map(|k| format!("{}; {}", k.help, k.limit)).unwrap_or_default()
            }
        }
    }

    /// The value that counts: the chosen one where it is one of the knob's, else the default.
    fn value<'a>(&'a self, row: &Row, knob: &'a KnobInfo) -> &'a Value {
        let chosen = match row {
            Row::Parameter(name) => self.parameters.get(name),
            _ => self.knobs.get(&knob.name),
        };
        chosen.filter(|v| knob.steps.contains(v)).unwrap_or(&knob.default)
    }

    /// Steps a row up or down. Words go round, numbers stop at their ends. False if nothing changed.
    pub fn step(&mut self, world: &World, row: &Row, up: bool) -> bool {
        let Some(info) = world.info() else { return false };
        let before = self.clone();
        let Some(technique) = self.info(info) else { return false };
        match row {
            Row::Technique => {
                let ids: Vec<_> = info.techniques.iter().map(|t| t.id.as_str()).collect();
                self.technique = around(&ids, &self.technique, up);
            }
            Row::Variant => {
                let ids: Vec<_> = technique.variants.iter().map(|v| v.0.as_str()).collect();
                let next = around(&ids, self.variant(technique), up);
                self.variants.insert(technique.id.clone(), next);
            }
            Row::Form => {
                let forms: Vec<_> = technique.forms.iter().map(String::as_str).collect();
                self.form = around(&forms, self.form(technique), up);
            }
            Row::Scene => {
                let mut scenes = vec![info.default_scene.as_str()];
                let known = world.catalogue.iter().flat_map(|c| &c.scenes);
                scenes.extend(known.map(|s| s.0.as_str()).filter(|s| *s != info.default_scene));
                let now = if self.scene.is_empty() { scenes[0] } else { self.scene.as_str() };
                self.scene = around(&scenes, now, up);
                if self.scene == info.default_scene {
                    self.scene.clear();
                }
            }
            Row::Knob(name) | Row::Parameter(name) => {
                let Some(knob) = self.knob_info(info, row) else { return false };
                let next = stepped(knob, self.value(row, knob), up);
                let chosen = match row {
                    Row::Parameter(_) => &mut self.parameters,
                    _ => &mut self.knobs,
                };
                chosen.insert(name.clone(), next);
            }
        }
        *self != before
    }

    /// Moves the camera. False if nothing changed: nearest, farthest, highest.
    pub fn turn(&mut self, turn: Turn) -> bool {
        let before = (self.azimuth_deg, self.elevation_deg, self.distance);
        match turn {
            Turn::Around(steps) => {
                let turned = (self.azimuth_deg + steps * TURN_DEG).rem_euclid(360);
                self.azimuth_deg = if turned > 180 { turned - 360 } else { turned };
            }
            Turn::Up(steps) => {
                let raised = self.elevation_deg + steps * TURN_DEG;
                self.elevation_deg = raised.clamp(-MOST_RAISED_DEG, MOST_RAISED_DEG);
            }
            Turn::Away(steps) => {
                let last = DISTANCES.len() as i32 - 1;
                self.distance = (self.distance as i32 + steps).clamp(0, last) as usize;
            }
        }
        before != (self.azimuth_deg, self.elevation_deg, self.distance)
    }

    /// The view as the command line takes it; empty for the first camera.
    pub fn view(&self) -> String {
        if (self.azimuth_deg, self.elevation_deg, self.distance) == (0, 0, NEAR) {
            return String::new();
        }
        let distance = DISTANCES.get(self.distance).copied().unwrap_or(1.0);
        format!("orbit:{},{},{distance}", self.azimuth_deg, self.elevation_deg)
    }

    /// As a request.
    pub fn show(&self, info: &ProblemInfo, request: u64) -> Show {
        let technique = self.info(info);
        let knobs = technique.map_or(&[][..], |t| &t.knobs);
        let turned = |knobs: &[KnobInfo], row: fn(String) -> Row| {
            let values = knobs.iter().map(|k| (k, self.value(&row(k.name.clone()), k).clone()));
            let turned = values.filter(|(k, v)| *v != k.default);
            turned.map(|(k, v)| (k.name.clone(), v)).collect()
        };
        Show {
            request,
            problem: info.id.clone(),
            scene: self.scene.clone(),
            view: self.view(),
            seed: 0,
            parameters: turned(&info.parameters, Row::Parameter),
            technique: self.technique.clone(),
            variant: technique.map(|t| self.variant(t).into()).unwrap_or_default(),
            form: technique.map(|t| self.form(t).into()).unwrap_or_default(),
            knobs: turned(knobs, Row::Knob),
        }
    }
}

/// The command that makes the same pictures; what stands at its default is left out.
pub fn command(show: &Show, default_variant: &str) -> String {
    let technique = match show.variant.as_str() {
        variant if variant.is_empty() || variant == default_variant => show.technique.clone(),
        variant => format!("{}/{variant}", show.technique),
    };
    let mut words = format!("dapple render {} {technique} --form {}", show.problem, show.form);
    if !show.scene.is_empty() {
        words += &format!(" --scene {}", show.scene);
    }
    if !show.view.is_empty() {
        words += &format!(" --view {}", show.view);
    }
    for (name, value) in &show.parameters {
        words += &format!(" --param {name}={}", plain(value));
    }
    for (name, value) in &show.knobs {
        words += &format!(" --knob {name}={}", plain(value));
    }
    words
}

/// What is different between two requests, in words.
pub fn difference(old: &Show, new: &Show) -> String {
    let mut changes = Vec::new();
    let mut changed = |name: &str, old: &str, new: &str| {
        if old != new {
            let word =
                |text: &str| if text.is_empty() { "default".into() } else { text.to_string() };
            changes.push(format!("{name} {} → {}", word(old), word(new)));
        }
    };
    changed("technique", &old.technique, &new.technique);
    if old.technique == new.technique {
        changed("variant", &old.variant, &new.variant);
    }
    changed("form", &old.form, &new.form);
    changed("scene", &old.scene, &new.scene);
    changed("view", &old.view, &new.view);
    for (old, new) in [(&old.knobs, &new.knobs), (&old.parameters, &new.parameters)] {
        let names: std::collections::BTreeSet<_> = old.keys().chain(new.keys()).collect();
        for name in names {
            let text = |values: &BTreeMap<String, Value>| values.get(name).map(plain);
            changed(name, &text(old).unwrap_or_default(), &text(new).unwrap_or_default());
        }
    }
    changes.join(", ")
}

/// A value without the quotes of JSON.
pub fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), Into::into)
}

fn around(ids: &[&str], now: &str, up: bool) -> String {
    let at = ids.iter().position(|id| *id == now);
    let next = match at {
        Some(at) if up => at + 1,
        Some(at) => at + ids.len() - 1,
        None => 0,
    };
    ids.get(next % ids.len().max(1)).map(ToString::to_string).unwrap_or_default()
}

fn stepped(knob: &KnobInfo, now: &Value, up: bool) -> Value {
    let words: Option<Vec<&str>> = knob.steps.iter().map(Value::as_str).collect();
    if let (Some(words), Some(now)) = (words, now.as_str()) {
        return around(&words, now, up).into();
    }
    let last = knob.steps.len().saturating_sub(1);
    let at = knob.steps.iter().position(|v| v == now).unwrap_or_default();
    let next = if up { (at + 1).min(last) } else { at.saturating_sub(1) };
    knob.steps.get(next).unwrap_or(now).clone()
}
