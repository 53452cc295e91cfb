//! Opening an index of 100,000 rows as sweeps leave them, and what a dashboard asks of it.
//! `DAPPLE_RECORDS_ROWS` sets another count.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dapple_records::{Index, read_dir};
use std::{hint::black_box, io::Write};

#[path = "../../crates/records/tests/common/mod.rs"]
mod common;

fn count() -> u64 {
    let asked = std::env::var("DAPPLE_RECORDS_ROWS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(100_000)
}

fn index(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    common::write_folder(folder.path(), count()).expect("room for the rows");
    let mut group = criterion.benchmark_group(format!("records {}", count()));
    group.sample_size(10).throughput(Throughput::Elements(count()));
    group.bench_function("open", |bencher| bencher.iter(|| Index::open(folder.path())));
    let mut index = Index::open(folder.path()).expect("an index");
    assert_eq!(index.entries.len() as u64, count());
    group.bench_function("latest", |bencher| bencher.iter(|| black_box(index.latest())));
    group.bench_function("fronts", |bencher| {
        bencher.iter(|| black_box(index.fronts("rmse", "gpu", &[], |_| true)));
    });
    group.bench_function("refresh, nothing new", |bencher| {
        bencher.iter(|| black_box(index.refresh()));
    });
    let path = folder.path().join("live.jsonl");
    let mut next = count();
    group.bench_function("refresh, one row", |bencher| {
        bencher.iter(|| {
            let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&path)?;
            writeln!(file, "{}", common::row(next).to_line())?;
            next += 1;
            index.refresh().map_err(std::io::Error::other)
        });
    });
    // The control: the same rows held whole.
    group.bench_function("read whole rows", |bencher| bencher.iter(|| read_dir(folder.path())));
    group.finish();
}

criterion_group!(records, index);
criterion_main!(records);
