//! Lines of a block, and the whole ones inside damaged ones.

use std::ops::Range;

use memchr::{memchr, memmem};
use serde::de::IgnoredAny;

use crate::error::RecordError;
use crate::read::blocks::{Block, Part};
use crate::read::{LONGEST_LINE, START};

/// What a block holds, in its order.
#[derive(Debug)]
pub(crate) enum Found<T> {
    /// A line of ours.
    Line {
        /// Where its text begins in the file.
        offset: u64,
        /// Bytes of its text.
        length: usize,
        /// The line.
        item: T,
    },
    /// A line that was left out, or of which only whole ones inside were kept.
    Skipped {
        /// From 1.
        line: usize,
        /// Words that follow a number.
        kind: &'static str,
        /// Why, for people.
        reason: String,
    },
}

/// How a block ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Ending {
    /// With a line feed.
    #[default]
    Whole,
    /// With half a line, of which nothing was kept.
    Torn {
        /// Where it begins in the file.
        offset: u64,
        /// Its number.
        line: usize,
        /// Whether it was listed as skipped, and under which kind.
        skipped: Option<&'static str>,
    },
    /// With a line without line feed, of which something was kept or which is too long.
    Open,
}

/// Tells `visit` what `parse` makes of every line of a block. Of a line that is damaged, or longer
/// than [`LONGEST_LINE`], the whole ones inside are kept: what is left where a torn file was
/// concatenated with another, a line feed was lost, or two writers' bytes were mixed.
pub(crate) fn scan<'a, T>(
    block: &'a Block,
    parse: impl Fn(&'a [u8]) -> Result<T, RecordError>,
    visit: &mut impl FnMut(Found<T>),
) -> Ending {
    if let Part::Piece { first } = block.part {
        if first {
            let reason = format!("longer than {LONGEST_LINE} bytes");
            let kind = "longer than the limit";
            visit(Found::Skipped { line: block.line, kind, reason });
        }
        inside(&block.bytes, &parse, |range, item| visit(found(block.offset, range, item)));
        return if block.bytes.ends_with(b"\n") { Ending::Whole } else { Ending::Open };
    }
    let mut ending = Ending::Whole;
    let (mut start, mut number) = (0, block.line);
    while start < block.bytes.len() {
        let rest = &block.bytes[start..];
        let feed = memchr(b'\n', rest);
        let line = &rest[..feed.unwrap_or(rest.len())];
        let offset = block.offset + start as u64;
        let mut kept = 0;
        let mut skipped = None;
        if !line.iter().all(u8::is_ascii_whitespace) {
            match parse(line) {
                Ok(item) => {
                    kept = 1;
                    visit(found(offset, 0..line.len(), item));
                }
                Err(error) => {
                    let mut whole = Vec::new();
                    inside(line, &parse, |range, item| whole.push(found(offset, range, item)));
                    kept = whole.len();
                    let kind = kind_of_reason(&error, kept, feed.is_none());
                    let reason = match kept {
                        0 => error.to_string(),
                        count => format!("{error}; kept {count} whole inside it"),
                    };
                    visit(Found::Skipped { line: number, kind, reason });
                    skipped = Some(kind);
                    whole.into_iter().for_each(&mut *visit);
                }
            }
        }
        if feed.is_none() {
            ending = match kept {
                0 => Ending::Torn { offset, line: number, skipped },
                _ => Ending::Open,
            };
        }
        start += line.len() + 1;
        number += 1;
    }
    ending
}

fn found<T>(offset: u64, range: Range<usize>, item: T) -> Found<T> {
    Found::Line { offset: offset + range.start as u64, length: range.len(), item }
}

/// The kind of reason for a line that only a later program understands.
pub(crate) const LATER_SCHEMA: &str = "of a later schema";

/// Words that follow a number.
fn kind_of_reason(error: &RecordError, kept: usize, last: bool) -> &'static str {
    match error {
        _ if kept > 0 => "torn or mixed, with whole lines inside that were kept",
        RecordError::LaterSchema { .. } => LATER_SCHEMA,
        RecordError::Kind(_) => "of an unknown kind",
        RecordError::Missing(key) if key == "kind" => "not ours",
        RecordError::Missing(_) => "with a key missing",
        RecordError::Type { .. } => "with a key of the wrong type",
        _ if last => "torn at the end of a file",
        _ => "not a JSON object",
    }
}

/// Whole lines of ours inside other bytes. Each begins with [`START`] and is the first JSON value
/// there: a whole line holds that text only at its beginning, so none is searched beyond the next.
fn inside<'a, T>(
    bytes: &'a [u8],
    parse: impl Fn(&'a [u8]) -> Result<T, RecordError>,
    mut keep: impl FnMut(Range<usize>, T),
) {
    let starts: Vec<usize> = memmem::find_iter(bytes, START).collect();
    for (i, &start) in starts.iter().enumerate() {
        let end = starts.get(i + 1).copied().unwrap_or(bytes.len());
        let text = &bytes[start..end];
        let mut values = serde_json::Deserializer::from_slice(text).into_iter::<IgnoredAny>();
        if let Some(Ok(_)) = values.next() {
            let length = values.byte_offset();
            if let Ok(item) = parse(&text[..length]) {
                keep(start..start + length, item);
            }
        }
    }
}
