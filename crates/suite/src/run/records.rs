//! The record file of a run: a new one, or that of an unfinished run of the same work.

use super::Options;
use crate::{
    SuiteError,
    case::DATA_VARIABLE,
    environment::{environment, run_header},
};
use dapple_records::{Read, RunHeader, Writer};
use std::{fs::File, io};

/// A resumed run must be the same work on the same data by the same program on the same adapter
/// with the same threads. The program is known by its content: a revision would miss changes that
/// are not committed, and be moved by commits that change nothing in it.
///
/// `work` is a hash of all that decides which lines the run has.
pub(crate) fn resume_key(work: &str, options: &Options) -> String {
    let mut hash = blake3::Hasher::new();
    // A program that cannot be read cannot be started either.
    let _ = File::open(&options.program).and_then(|mut file| io::copy(&mut file, &mut hash));
    let (data, threads) = (std::env::var_os(DATA_VARIABLE), environment().threads);
    let rest = format!("{work} {:?} {threads} {data:?}", options.adapter);
    hash.update(rest.as_bytes());
    hash.finalize().to_hex()[..16].to_string()
}

/// Opens the records of a run under that name and key, with what an unfinished one left.
///
/// # Errors
/// A folder or file that cannot be written, or that another process is writing.
pub(crate) fn open(name: &str, key: &str, options: &Options) -> Result<(Writer, Read), SuiteError> {
    let machine = &environment().machine;
    if !options.fresh
        && let Some(path) = dapple_records::unfinished(&options.records, key, machine)
    {
        let writer = Writer::resume(&path)?;
        // Read under the writer's lock: another process may have ended the run just now.
        let mut read = dapple_records::read_file(&path)?;
        let run = writer.run();
        if !read.ended.contains(run) {
            read.rows.retain(|row| row.run == run);
            read.stress.retain(|point| point.run == run);
            return Ok((writer, read));
        }
    }
    let header =
        RunHeader { shard: options.shard.clone(), ..run_header(name, key, &options.command) };
    let writer = Writer::create(&options.records, &header)?;
    Ok((writer, Read::default()))
}
