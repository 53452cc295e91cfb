//! `dapple report`: one HTML page; its pictures are rendered anew from the cases.

mod rendered;

use crate::{
    Outcome, args,
    output::{note, put},
    records,
    runner::command_line,
    verbs::catalogue,
};
use anyhow::Result;
use dapple_records::report::{self, Input};
use dapple_suite::{SuiteError, problem::Problem, problems};
use std::fs;

/// Writes the page.
pub fn run(args: &args::Report) -> Result<Outcome> {
    let chosen: Vec<&'static dyn Problem> = match &args.problem {
        Some(id) => vec![problems::find(id)?],
        None => problems::ALL.to_vec(),
    };
    let mut read = records::read(&args.records)?;
    if args.problem.is_some() {
        // A page about one problem does not count the others' rows as lost.
        let kept = |id: &str| chosen.iter().any(|p| p.spec().id == id);
        read.rows.retain(|row| kept(&row.problem));
    }
    let infos: Vec<_> = chosen.iter().map(|p| catalogue::problem(*p)).collect();
    let (triplets, notes) = if args.no_pictures {
        (Vec::new(), vec!["Pictures were left out.".to_string()])
    } else {
        rendered::triplets(&read, &infos)
    };
    for text in &notes {
        note!("note: {text}");
    }
    let page = report::page(&Input {
        read: &read,
        problems: &infos,
        triplets: &triplets,
        notes: &notes,
        time: &dapple_records::now(),
        command: &command_line(),
    });
    fs::write(&args.output, &page)
        .map_err(SuiteError::io(format!("writing {}", args.output.display())))?;
    put!(
        "{}: {} rows, {} pictures, {:.1} MB",
        args.output.display(),
        read.rows.len(),
        3 * triplets.len(),
        page.len() as f64 / 1e6
    )?;
    Ok(Outcome::Ok)
}
