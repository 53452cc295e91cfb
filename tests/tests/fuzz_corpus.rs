//! The fuzz targets' functions on every seed, and on some mutations of each; `PROPTEST_CASES`
//! raises their number.

use dapple_records::{Read, read_from};
use dapple_tests::inputs;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::{
    fs, panic,
    path::{Path, PathBuf},
};

const SEEDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/fuzz");

fn seeds(kind: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(SEEDS).join(kind);
    let mut paths: Vec<PathBuf> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

/// Mutations of each seed.
fn rounds(few: u64) -> u64 {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(few)
}

/// Some bytes changed, cut, doubled, or replaced by what means something to a parser.
fn mutated(seed: &[u8], number: u64) -> Vec<u8> {
    const TOKENS: [&[u8]; 16] = [
        b"\n",
        b"{",
        b"}",
        b"[",
        b"]",
        b"\"",
        b"\\",
        b",",
        b":",
        b"\0",
        b"\xff",
        b"1e999",
        b"null",
        br#"{"kind":""#,
        b"-",
        b"99999999999999999999",
    ];
    let mut random = Pcg64::seed_from_u64(number);
    let mut bytes = seed.to_vec();
    for _ in 0..random.random_range(1..6) {
        let at = random.random_range(0..=bytes.len());
        let end = (at + random.random_range(0..40)).min(bytes.len());
        match random.random_range(0..5) {
            0 if at < bytes.len() => bytes[at] = random.random(),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let copy = bytes[at..end].to_vec();
                let to = random.random_range(0..=bytes.len());
                bytes.splice(to..to, copy);
            }
            3 => bytes.truncate(at.max(bytes.len() / 2)),
            _ => {
                let token = TOKENS[random.random_range(0..TOKENS.len())];
                bytes.splice(at..end.min(at + 1), token.iter().copied());
            }
        }
    }
    bytes
}

fn run(kind: &str, least_seeds: usize, rounds: u64, check: fn(&[u8])) {
    let seeds = seeds(kind);
    assert!(seeds.len() >= least_seeds, "only {} seeds of {kind}", seeds.len());
    for (path, seed) in &seeds {
        let inputs = std::iter::once(seed.clone()).chain((0..rounds).map(|n| mutated(seed, n)));
        for (round, input) in inputs.enumerate() {
            let done = panic::catch_unwind(|| check(&input));
            assert!(done.is_ok(), "{}, round {round} (0 is the seed itself)", path.display());
        }
    }
}

#[test]
fn the_reader_holds_on_every_seed_and_its_mutations() {
    run("records", 20, rounds(60), inputs::records);
}

#[test]
fn sweeps_hold_on_every_seed_and_its_mutations() {
    run("sweeps", 15, rounds(6), inputs::sweep);
}

#[test]
fn the_feed_holds_on_every_seed_and_its_mutations() {
    run("feed", 6, rounds(60), inputs::feed);
}

/// Rows that each seed of records holds whole, by the last digit of their identity.
const GOOD: [(&str, &str); 20] = [
    ("beginnings.jsonl", "12"),
    ("byte-order-mark.jsonl", "12"),
    ("deep-nesting.jsonl", "13"),
    ("duplicate-keys.jsonl", "124"),
    ("empty.jsonl", ""),
    ("huge-numbers.jsonl", "26"),
    ("interleaved.jsonl", "12345"),
    ("kinds.jsonl", "1"),
    ("later-schema.jsonl", "25"),
    ("line-feeds.jsonl", "1"),
    ("long-line.jsonl", "12"),
    ("lost-line-feeds.jsonl", "123"),
    ("not-finite.jsonl", "24"),
    ("not-unicode.jsonl", "13"),
    ("surrogates.jsonl", "23"),
    ("torn-then-joined.jsonl", "23"),
    ("torn.jsonl", "1"),
    ("whole.jsonl", "12"),
    ("wrong-types.jsonl", "356"),
    ("zero-bytes.jsonl", "123"),
];

fn found(read: &Read) -> String {
    let mut ids: Vec<&str> = read.rows.iter().map(|row| row.row.as_str()).collect();
    ids.sort_unstable();
    ids.iter().map(|id| id.strip_prefix("600d00000000000").unwrap_or("?")).collect()
}

#[test]
fn every_seed_gives_the_rows_that_stand_whole_in_it() {
    let seeds = seeds("records");
    let names: Vec<_> = seeds.iter().map(|(path, _)| path.file_name().unwrap()).collect();
    assert_eq!(names, GOOD.map(|(name, _)| name), "each seed has its expectation");
    for ((path, seed), (name, rows)) in seeds.iter().zip(GOOD) {
        let read = read_from(path, &seed[..]).unwrap();
        assert_eq!(found(&read), rows, "{name}: {:?}", read.skipped_by_reason());
    }
}

/// Size bombs are refused by name of the limit, before they take memory or time.
#[test]
fn products_beyond_all_bounds_are_refused() {
    for (name, limit) in [
        ("product-of-10-to-the-12.toml", "more than 250000"),
        ("product-of-knobs.toml", "more than 100000"),
    ] {
        let text = fs::read_to_string(Path::new(SEEDS).join("sweeps").join(name)).unwrap();
        let start = std::time::Instant::now();
        let sweep = dapple_suite::sweep::Sweep::parse(Path::new(name), &text).unwrap();
        let error = sweep.plan(name).unwrap_err().to_string();
        assert!(error.contains(limit), "{name}: {error}");
        assert!(start.elapsed().as_secs() < 10, "{name}: {:?}", start.elapsed());
    }
}

/// The control: a reader that stops at the first bad line loses a row, and the check notices.
#[test]
fn a_reader_that_stops_at_the_first_bad_line_is_caught() {
    let stopping = |bytes: &[u8]| {
        let whole = |line: &&[u8]| {
            line.is_empty() || read_from(Path::new("x"), *line).unwrap().skipped.is_empty()
        };
        let kept: Vec<&[u8]> = bytes.split(|&b| b == b'\n').take_while(whole).collect();
        read_from(Path::new("x"), &kept.join(&b"\n"[..])[..]).unwrap()
    };
    inputs::records_by(stopping, b"");
    let caught = panic::catch_unwind(|| inputs::records_by(stopping, b"noise"));
    let said = *caught.unwrap_err().downcast::<String>().unwrap();
    assert!(said.contains("600d000000000002 was lost"), "{said}");
}
