//! `dapple scene inspect` and `dapple scene generate`.

use crate::{
    Outcome,
    args::{self, SceneVerb},
    output::{Table, note, put},
};
use anyhow::Result;
use dapple_scene::{Scene, generate, import, inspect, write_glb};
use dapple_suite::{
    SuiteError,
    case::{self, Source},
};

/// Runs the verb.
pub fn run(args: &args::Scene) -> Result<Outcome> {
    match &args.verb {
        SceneVerb::Inspect { scene, format } => {
            let (scene, warnings) = load(scene)?;
            for warning in warnings {
                note!("warning: {warning}");
            }
            let inspection = inspect::inspect(&scene);
            let mut table = Table::new(&["option", "needed", "because"]);
            for need in &inspection.needs {
                let needed = if need.needed { "yes" } else { "no" };
                table.row([need.option.into(), needed.into(), need.because.clone().into()]);
            }
            if *format == args::Format::Table {
                put!(
                    "{}: {} triangles ({} without area) in {} instances of {} meshes, {:.1} MiB, \
                     hash {}\n",
                    scene.name,
                    inspection.triangles,
                    inspection.degenerate_triangles,
                    inspection.instances,
                    inspection.meshes,
                    inspection.memory_bytes as f64 / (1024.0 * 1024.0),
                    scene.hash()
                )?;
            }
            table.print(*format)?;
        }
        SceneVerb::Generate { name, seed, output } => {
            if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("glb")) {
                let name = output.display();
                return Err(SuiteError::Usage(format!("{name}: the file must end in .glb")).into());
            }
            let scene = generated(name, *seed)?;
            for warning in write_glb(&scene, output).map_err(SuiteError::from)? {
                note!("warning: {warning}");
            }
            put!(
                "{}: {} triangles, hash {}",
                output.display(),
                scene.triangle_count(),
                scene.hash()
            )?;
        }
    }
    Ok(Outcome::Ok)
}

fn load(name: &str) -> Result<(Scene, Vec<String>), SuiteError> {
    match case::source(name)? {
        Source::Generated(name) => Ok((generated(&name, 0)?, Vec::new())),
        Source::File(path) => {
            let loaded = import::load(&path)?;
            Ok((loaded.scene, loaded.warnings))
        }
        Source::MissingData(path) => Err(case::missing_data(&path)),
    }
}

fn generated(name: &str, seed: u64) -> Result<Scene, SuiteError> {
    generate::by_name(name, seed)
        .ok_or_else(|| SuiteError::unknown("scene", name, generate::NAMES.iter().map(|n| n.0)))
}
