//! `dapple list`.

use crate::{Outcome, args, output::Table};
use anyhow::Result;
use dapple_scene::generate;
use dapple_suite::{knob::Accuracy, problems, sweep};

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
                let about = sweep.about.lines().next().unwrap_or_default().to_string();
                table.row(["sweep".into(), (*name).into(), about.into()]);
            }
            for (name, what) in generate::NAMES {
                table.row(["scene".into(), (*name).into(), (*what).into()]);
            }
            table.print(args.format)?;
        }
        Some(id) => {
            let spec = problems::find(id)?.spec();
            let mut table =
                Table::new(&["technique", "kind", "name", "values", "accuracy", "what"]);
            for p in spec.parameters {
                let cells = ["-", "parameter", p.name].map(Into::into).to_vec();
                let rest = [p.limit().into(), accuracy(p.accuracy).into(), p.help.into()];
                table.row([cells, rest.to_vec()].concat());
            }
            for t in spec.techniques {
                let forms: Vec<_> = t.forms.iter().map(ToString::to_string).collect();
                let cells = [t.id, "technique", t.title].map(Into::into).to_vec();
                table.row(
                    [cells, vec![forms.join(" ").into(), "".into(), t.source.into()]].concat(),
                );
                for v in t.variants {
                    table.row([t.id, "variant", v.id, "", "", v.help].map(Into::into));
                }
                for k in t.knobs {
                    let cells = [t.id, "knob", k.name].map(Into::into).to_vec();
                    let limit = format!("{} [{}]", k.limit(), k.default_value());
                    let rest = [limit.into(), accuracy(k.accuracy).into(), k.help.into()];
                    table.row([cells, rest.to_vec()].concat());
                }
            }
            table.print(args.format)?;
        }
    }
    Ok(Outcome::Ok)
}

fn accuracy(accuracy: Accuracy) -> &'static str {
    match accuracy {
        Accuracy::Monotone => "monotone",
        Accuracy::Unimodal => "unimodal",
        Accuracy::None => "",
    }
}
