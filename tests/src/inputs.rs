//! What must hold for any bytes: run by the fuzz targets, and on the seeds by a test.
#![allow(dead_code)]

use dapple_records::{FeedLine, Read, read_from};
use dapple_suite::sweep::Sweep;
use std::path::Path;

/// Plans are refused beyond this.
const MOST_MEASUREMENTS: usize = 250_000;

/// A whole row as a line; equal for equal numbers.
pub fn good_row(number: u8) -> String {
    format!(
        r#"{{"kind":"row","schema":1,"run":"600d","row":"600d0000000000{number:02x}","problem":"p","technique":"t","form":"cpu","case":"c","status":"not_run","reason":"a good row","group":"around"}}"#
    )
}

fn read(bytes: &[u8]) -> Read {
    read_from(Path::new("input.jsonl"), bytes).unwrap_or_default()
}

/// The reader keeps a row before and one behind any bytes, and counts what it skips.
pub fn records(bytes: &[u8]) {
    records_by(read, bytes);
}

/// [`records`] for any reader, so that a wrong one can be shown to fail.
pub fn records_by(read: impl Fn(&[u8]) -> Read, bytes: &[u8]) {
    let (before, behind) = (good_row(1), good_row(2));
    let all = [before.as_bytes(), b"\n", bytes, b"\n", behind.as_bytes(), b"\n"].concat();
    let read = read(&all);
    for id in ["600d000000000001", "600d000000000002"] {
        let found = read.rows.iter().any(|row| row.row == id && row.group == "around");
        assert!(found, "the row {id} was lost");
    }
    assert!(read.skipped.len() <= read.skipped_count());
    for skipped in &read.skipped {
        assert!(!skipped.reason.is_empty() && skipped.line > 1, "{skipped:?}");
    }
}

/// A sweep is planned within its bounds, or refused with a reason.
pub fn sweep(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let plan = Sweep::parse(Path::new("input.toml"), &text).and_then(|sweep| sweep.plan("input"));
    match plan {
        Ok(plan) => assert!((1..=MOST_MEASUREMENTS).contains(&plan.rows()), "{}", plan.rows()),
        Err(error) => {
            assert_eq!(error.exit_code(), 2, "{error}");
            assert!(!error.to_string().is_empty());
        }
    }
}

/// Every line of a child's output is an event, a record, noise or an error.
pub fn feed(bytes: &[u8]) {
    for line in String::from_utf8_lossy(bytes).lines() {
        if let Ok(Some(FeedLine::Event(event))) = FeedLine::parse(line) {
            let again = FeedLine::parse(&event.to_line());
            assert!(matches!(again, Ok(Some(FeedLine::Event(_)))), "{line}");
        }
    }
}
