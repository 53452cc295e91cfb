//! Reading files into an index: blocks in order, parsed side by side, a few at a time.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Take};

use rayon::prelude::*;

use super::brief::Brief;
use super::table::Table;
use super::{Entry, Index, Place};
use crate::error::RecordError;
use crate::line::Line;
use crate::read::blocks::{Block, Blocks};
use crate::read::scan::{Ending, Found, scan};
use crate::read::{MOST_SKIPPED, Skipped, UNREADABLE, skip};

/// Blocks held at a time.
const AT_ONCE: usize = 8;

/// A file to read on from a place.
pub(crate) struct Job {
    /// Which of the index's files.
    pub file: u32,
    blocks: Blocks<Take<File>>,
}

impl Job {
    /// Reads `file` from `offset`, the beginning of line number `line`, up to `length`.
    pub(crate) fn new(
        number: u32,
        mut file: File,
        (offset, line): (u64, usize),
        length: u64,
    ) -> io::Result<Self> {
        file.seek(SeekFrom::Start(offset))?;
        let reader = io::Read::take(file, length.saturating_sub(offset));
        Ok(Self { file: number, blocks: Blocks::new(reader, offset, line) })
    }
}

/// What one block holds.
#[derive(Default)]
struct Part {
    table: Table,
    entries: Vec<Entry>,
    lines: Vec<(u64, Line)>,
    /// Number and reason, as many as are listed.
    skipped: Vec<(usize, &'static str, String)>,
    /// The others, counted.
    more: BTreeMap<&'static str, usize>,
    ending: Ending,
    feeds: usize,
}

enum Item<'a> {
    Row(Box<Brief<'a>>),
    Line(Line),
}

fn item(line: &[u8]) -> Result<Item<'_>, RecordError> {
    match Brief::parse(line) {
        Some(row) => Ok(Item::Row(Box::new(row))),
        None => Line::parse(line).map(Item::Line),
    }
}

fn part(file: u32, block: &Block) -> Part {
    let mut part = Part::default();
    let ending = scan(block, item, &mut |found| match found {
        Found::Line { offset, length, item } => {
            let length = u32::try_from(length).unwrap_or(u32::MAX);
            match item {
                Item::Row(row) => part.entries.push(part.table.entry(&row, file, offset, length)),
                Item::Line(Line::Row(row)) => {
                    let row = Brief::of(&row);
                    part.entries.push(part.table.entry(&row, file, offset, length));
                }
                Item::Line(line) => part.lines.push((offset, line)),
            }
        }
        Found::Skipped { line, kind, reason } if part.skipped.len() < MOST_SKIPPED => {
            part.skipped.push((line, kind, reason));
        }
        Found::Skipped { kind, .. } => *part.more.entry(kind).or_default() += 1,
    });
    part.ending = ending;
    part.feeds = memchr::memchr_iter(b'\n', &block.bytes).count();
    part
}

impl Index {
    /// Reads the jobs, in their order; gives the lines that are no rows.
    pub(crate) fn load(&mut self, jobs: Vec<Job>) -> Vec<(Place, Line)> {
        let mut lines = Vec::new();
        let mut jobs = jobs.into_iter();
        let mut job = jobs.next();
        loop {
            let mut blocks = Vec::new();
            while let Some(Job { file, blocks: source }) = &mut job {
                match source.next() {
                    Ok(Some(block)) => blocks.push((*file, block)),
                    Ok(None) => job = jobs.next(),
                    Err(error) => {
                        self.unreadable(*file, &error);
                        job = jobs.next();
                    }
                }
                if blocks.len() == AT_ONCE {
                    break;
                }
            }
            if blocks.is_empty() {
                return lines;
            }
            let parse = |(file, block): (u32, Block)| (file, part(file, &block));
            // A thread pool for a handful of lines would cost more than it saves.
            let parts: Vec<(u32, Part)> = match blocks.len() {
                1 => blocks.into_iter().map(parse).collect(),
                _ => blocks.into_par_iter().map(parse).collect(),
            };
            for (file, part) in parts {
                self.absorb(file, part, &mut lines);
            }
        }
    }

    fn absorb(&mut self, file: u32, part: Part, lines: &mut Vec<(Place, Line)>) {
        self.table.absorb(part.table, part.entries, &mut self.entries);
        lines.extend(part.lines.into_iter().map(|(offset, line)| (Place { file, offset }, line)));
        let Some(known) = self.files.get_mut(file as usize) else { return };
        known.lines += part.feeds;
        known.ending = part.ending;
        for (line, kind, reason) in part.skipped {
            let skipped = Skipped { path: known.path.clone(), line, reason };
            skip(&mut self.skipped, &mut self.reasons, kind, skipped);
        }
        for (kind, count) in part.more {
            *self.reasons.entry(kind).or_default() += count;
        }
    }

    fn unreadable(&mut self, file: u32, error: &io::Error) {
        if let Some(known) = self.files.get_mut(file as usize) {
            // Read anew once it changes.
            known.ending = Ending::Open;
            let skipped = Skipped { path: known.path.clone(), line: 0, reason: error.to_string() };
            skip(&mut self.skipped, &mut self.reasons, UNREADABLE, skipped);
        }
    }
}
