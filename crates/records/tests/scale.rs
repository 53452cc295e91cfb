//! Memory and losses at size. `DAPPLE_RECORDS_ROWS` and `DAPPLE_RECORDS_MB` raise the sizes
//! (1000000 and 1024 are what the documentation states); `--nocapture` prints the figures.
// Helpers of tests may panic as tests do.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::{Read, repeat};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

use common::{Damaged, row, write_folder};
use dapple_records::{Index, read::LONGEST_LINE, read_from};

/// Counts what is on the heap, and the most that ever was.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);
/// One measurement at a time: the counters belong to the whole process.
static ONE: Mutex<()> = Mutex::new(());

fn add(bytes: usize) {
    let now = NOW.fetch_add(bytes, Relaxed) + bytes;
    MOST.fetch_max(now, Relaxed);
}

// SAFETY: every call is the system allocator's; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        NOW.fetch_sub(layout.size(), Relaxed);
        add(size);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static HEAP: Counting = Counting;

/// What `work` leaves on the heap, and the most that it had there.
fn measured<T>(work: impl FnOnce() -> T) -> (T, usize, usize) {
    let before = NOW.load(Relaxed);
    MOST.store(before, Relaxed);
    let result = work();
    let left = NOW.load(Relaxed).saturating_sub(before);
    (result, left, MOST.load(Relaxed) - before)
}

fn size(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().map_or(otherwise, |text| text.parse().expect("a whole number"))
}

/// Greatest resident size of this process so far, where the system tells.
fn resident() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or_else(|| "unknown".into(), |line| line.trim().to_owned())
}

/// Seconds of processor time of this process so far, where the system tells.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    ticks.filter_map(|text| text.parse::<f64>().ok()).sum::<f64>() / 100.0
}

#[test]
fn an_index_takes_200_bytes_a_row() {
    let _one = ONE.lock();
    let count = size("DAPPLE_RECORDS_ROWS", 20_000);
    let folder = tempfile::tempdir().unwrap();
    write_folder(folder.path(), count).unwrap();
    let (start, busy) = (Instant::now(), processor());
    let (index, left, most) = measured(|| Index::open(folder.path()).unwrap());
    let (opened, busy) = (start.elapsed(), processor() - busy);
    let start = Instant::now();
    let latest = index.latest();
    let chosen = start.elapsed();
    let start = Instant::now();
    let fronts = index.fronts("rmse", "gpu", &[], |_| true);
    let drawn = start.elapsed();
    eprintln!(
        "{count} rows: opened in {opened:?} ({busy:.2} s of processor time), heap {left} B ({} a row), at most {most} B, \
         said {} B; latest in {chosen:?}, {} fronts in {drawn:?}; resident {}",
        left as u64 / count,
        index.heap_bytes(),
        fronts.fronts.len(),
        resident()
    );
    assert_eq!((index.entries.len() as u64, latest.len() as u64), (count, count));
    assert_eq!(fronts.fronts.iter().map(|f| f.points.len() as u64).sum::<u64>(), count);
    // What rows share does not grow with them: a quarter of a megabyte here.
    assert!(left as u64 <= 200 * count + (1 << 18), "{left} B for {count} rows");
    // Blocks being read come on top, whatever the count.
    assert!(most as u64 <= 200 * count + (32 << 20), "at most {most} B for {count} rows");
    let said = index.heap_bytes() as f64 / left as f64;
    assert!((0.7..1.3).contains(&said), "said {} B, has {left} B", index.heap_bytes());
    // The control: whole rows would not fit.
    let (rows, whole, _) = measured(|| (0..1000).map(row).collect::<Vec<_>>());
    assert!(whole / rows.len() > 1000, "{whole} B for {} rows", rows.len());
}

#[test]
fn no_good_row_is_lost_in_damage_of_any_size_and_only_rows_are_held() {
    let _one = ONE.lock();
    let megabytes = size("DAPPLE_RECORDS_MB", 64);
    let mut stream = Damaged::new(megabytes << 20);
    let start = Instant::now();
    let path = Path::new("stream.jsonl");
    let (read, left, most) = measured(|| read_from(path, &mut stream).unwrap());
    eprintln!(
        "{megabytes} MB: {} rows of {}, {} skipped of {}, in {:?}, heap at most {most} B, left \
         {left} B; resident {}\n{:?}",
        read.rows.len(),
        stream.good,
        read.skipped_count(),
        stream.bad,
        start.elapsed(),
        resident(),
        read.skipped_by_reason(),
    );
    assert!(stream.good > 1000 && stream.bad > 500);
    assert_eq!(read.rows.len() as u64, stream.good);
    assert_eq!(read.skipped_count() as u64, stream.bad);
    assert!(read.rows.iter().all(|row| row.row == row.identity()));
    // Sorting out what is there twice holds the keys of all rows for a moment.
    assert!(most <= left * 2 + (16 << 20), "at most {most} B, {left} B of rows");
}

#[test]
fn a_line_without_end_is_not_held_and_what_stands_in_it_is_found() {
    let _one = ONE.lock();
    let megabytes = size("DAPPLE_RECORDS_MB", 64);
    let (first, second, last) = (row(1).to_line(), row(2).to_line(), row(3).to_line() + "\n");
    let half = || repeat(b'x').take(megabytes << 20);
    let ends = format!("\n{last}");
    let stream = first
        .as_bytes()
        .chain(half())
        .chain(second.as_bytes())
        .chain(half())
        .chain(ends.as_bytes());
    let start = Instant::now();
    let (read, _, most) = measured(|| read_from(Path::new("stream.jsonl"), stream).unwrap());
    eprintln!(
        "a line of {} MB: {:?}, heap at most {most} B; resident {}",
        2 * megabytes,
        start.elapsed(),
        resident()
    );
    assert_eq!(read.rows, [row(1), row(2), row(3)]);
    assert_eq!(read.skipped_by_reason().get("longer than the limit"), Some(&1));
    assert_eq!((read.skipped_count(), read.skipped[0].line), (1, 1));
    assert!(most <= 3 * LONGEST_LINE, "at most {most} B");
}
