//! A request as problem, case and setting, all complete.

use crate::verbs::measure::form;
use dapple_records::Show;
use dapple_suite::{
    SuiteError,
    case::Case,
    knob,
    problem::{Problem, Setting},
    problems,
};

/// A request that can be carried out.
pub struct Asked {
    /// Its number.
    pub request: u64,
    /// What it asks for.
    pub wanted: Wanted,
}

/// What is to be shown.
pub struct Wanted {
    /// The problem.
    pub problem: &'static dyn Problem,
    /// The case, its parameters complete.
    pub case: Case,
    /// The setting, its knobs complete.
    pub setting: Setting,
}

impl Wanted {
    /// Fills in what the request leaves open.
    ///
    /// # Errors
    /// A name that nothing has, a value out of range, a form that the technique has not got.
    pub fn of(show: &Show) -> Result<Self, SuiteError> {
        let problem = problems::find(&show.problem)?;
        let spec = problem.spec();
        let technique = spec.technique(&show.technique)?;
        let variants = technique.variants.iter().map(|v| v.id);
        let variant = match show.variant.as_str() {
            "" => variants.clone().next(),
            name => variants.clone().find(|v| *v == name),
        };
        let variant =
            variant.ok_or_else(|| SuiteError::unknown("variant", &show.variant, variants))?;
        let form = form(&show.form)?;
        if !technique.has(variant, form) {
            let forms = technique.forms.iter().filter(|form| technique.has(variant, **form));
            let forms: Vec<_> = forms.map(ToString::to_string).collect();
            let forms = forms.iter().map(String::as_str);
            return Err(SuiteError::unknown("form", &show.form, forms));
        }
        let scene = if show.scene.is_empty() { spec.default_scene } else { &show.scene };
        Ok(Self {
            problem,
            case: Case {
                problem: spec.id.into(),
                scene: scene.into(),
                view: show.view.clone(),
                seed: show.seed,
                parameters: knob::complete("parameter", spec.parameters, &show.parameters)?,
            },
            setting: Setting {
                technique: technique.id.into(),
                variant: variant.into(),
                form,
                knobs: knob::complete("knob", technique.knobs, &show.knobs)?,
            },
        })
    }

    /// Whether both ask for the same.
    pub fn is(&self, other: &Self) -> bool {
        self.case == other.case && self.setting == other.setting
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn show() -> Show {
        Show {
            request: 1,
            problem: "shadow-filtering".into(),
            technique: "vsm".into(),
            form: "cpu".into(),
            ..Show::default()
        }
    }

    #[test]
    fn what_is_left_open_is_filled_in() {
        let wanted = Wanted::of(&show()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(wanted.case.scene, wanted.problem.spec().default_scene);
        assert_eq!(wanted.setting.variant, "min-variance");
        assert_eq!(wanted.setting.knobs["resolution"], 512);
        assert_eq!(wanted.case.parameters["width"], 320);
        let knobs = BTreeMap::from([("resolution".to_string(), 512.into())]);
        let same = Wanted::of(&Show { knobs, ..show() }).unwrap_or_else(|e| panic!("{e}"));
        assert!(wanted.is(&same), "a default that is spelt out changes nothing");
    }

    #[test]
    fn what_there_is_not_is_refused_by_name() {
        let value = |name: &str, value: i64| BTreeMap::from([(name.to_string(), value.into())]);
        for (bad, expect) in [
            (Show { problem: "none".into(), ..show() }, "no problem `none`"),
            (Show { technique: "none".into(), ..show() }, "no technique `none`"),
            (Show { variant: "none".into(), ..show() }, "no variant `none`"),
            (Show { form: "quantum".into(), ..show() }, "no form `quantum`"),
            (Show { form: String::new(), ..show() }, "no form ``"),
            (Show { knobs: value("resolution", -1), ..show() }, "16..=8192"),
            (Show { knobs: value("colour", 1), ..show() }, "no knob `colour`"),
            (Show { parameters: value("width", 0), ..show() }, "16..=7680"),
        ] {
            let Err(error) = Wanted::of(&bad) else { panic!("{bad:?} was accepted") };
            assert!(error.to_string().contains(expect), "{error}");
        }
        let reference = Show {
            problem: "partition-offsets".into(),
            technique: "cpu-thread".into(),
            form: "gpu".into(),
            ..show()
        };
        let Err(error) = Wanted::of(&reference) else { panic!("it has no such form") };
        assert!(error.to_string().contains("no form `gpu`"), "{error}");
    }
}
