//! Reading records for a verb: a file or a folder, and a word on what was skipped.

use crate::output::note;
use dapple_records::{Read, Skipped, stream::LeftOut};
use dapple_suite::SuiteError;
use std::{collections::BTreeMap, path::Path};

/// Reads a file or a folder and says on standard error what was skipped, and why.
pub fn read(path: &Path) -> Result<Read, SuiteError> {
    let read = if path.is_dir() {
        dapple_records::read_dir(path)?
    } else {
        dapple_records::read_file(path)?
    };
    if let Some(text) = skipped(&read) {
        note!("{text}");
    }
    Ok(read)
}

/// What was skipped by reason, with the place of the first; none if nothing was.
pub fn skipped(read: &Read) -> Option<String> {
    words(&read.skipped, read.skipped_by_reason())
}

/// The same of a merge or an export.
pub fn left_out(left_out: &LeftOut) -> Option<String> {
    words(&left_out.skipped, &left_out.reasons)
}

fn words(skipped: &[Skipped], by_reason: &BTreeMap<&'static str, usize>) -> Option<String> {
    let first = skipped.first()?;
    let count: usize = by_reason.values().sum();
    let reasons: Vec<String> =
        by_reason.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
    // The folder is what the user named.
    let file = first.path.file_name().unwrap_or(first.path.as_os_str());
    Some(format!(
        "lines skipped: {count} ({}); the first is line {} of {}: {}",
        reasons.join(", "),
        first.line,
        file.display(),
        first.reason
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_skipped_is_counted_by_reason_with_the_first_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        let later = r#"{"kind":"row","schema":9}"#;
        std::fs::write(&path, format!("noise\n{later}\nmore noise\n")).unwrap();
        let said = skipped(&read(&path).unwrap()).unwrap();
        assert!(
            said.starts_with("lines skipped: 3 (2 not a JSON object, 1 of a later schema); "),
            "{said}"
        );
        assert!(said.contains("line 1 of a.jsonl: "), "{said}");
        std::fs::write(&path, "").unwrap();
        assert_eq!(skipped(&read(&path).unwrap()), None);
    }
}
