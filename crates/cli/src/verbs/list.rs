//! `dapple list`.

use crate::{Outcome, args, output::Table};
use anyhow::Result;
use dapple_scene::generate;
use dapple_suite::{knob::Knob, problems, sweep};
use serde_json::Value;

/// Lists problems, or one problem's techniques and knobs.
pub fn run(args: &args::List) -> Result<Outcome> {
    match &args.problem {
        None => {
            let mut table = Table::new(&["kind", "name", "what"]);
            for problem in problems::ALL {
                let spec = problem.spec();
                let what = format!("{} ({} techniques)", spec.question, spec.techniques.len());
                table.row(["problem".into(), spec.id.into(), what.into()]);
            }
            for (name, _) in sweep::BUILT_IN {
                let (_, sweep) = sweep::load(name)?;
                table.row(["sweep".into(), (*name).into(), first_sentence(&sweep.about).into()]);
            }
            for (name, what) in generate::NAMES {
                table.row(["scene".into(), (*name).into(), (*what).into()]);
            }
            table.print(args.format)?;
        }
        Some(id) => {
            let spec = problems::find(id)?.spec();
            let mut table = Table::new(&["technique", "kind", "name", "default", "values", "what"]);
            for p in spec.parameters {
                table.row(knob_cells("-", "parameter", p));
            }
            for t in spec.techniques {
                let forms: Vec<_> = t.forms.iter().map(ToString::to_string).collect();
                table.row(
                    [t.id, "technique", t.title, "", &forms.join(" "), t.source].map(Into::into),
                );
                for (i, v) in t.variants.iter().enumerate() {
                    let default = if i == 0 { "default" } else { "" };
                    table.row([t.id, "variant", v.id, default, "", v.help].map(Into::into));
                }
                for k in t.knobs {
                    table.row(knob_cells(t.id, "knob", k));
                }
            }
            table.print(args.format)?;
        }
    }
    Ok(Outcome::Ok)
}

fn knob_cells(of: &str, kind: &str, knob: &Knob) -> [Value; 6] {
    let default = match knob.default_value() {
        Value::String(word) => word,
        number => number.to_string(),
    };
    [of, kind, knob.name, &default, &knob.limit(), knob.help].map(Into::into)
}

/// The first sentence, on one line.
fn first_sentence(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    text.split_once(". ").map_or(text.clone(), |(first, _)| format!("{first}."))
}
