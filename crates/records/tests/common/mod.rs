//! Rows as real sweeps leave them, in any number, and streams of them in every state of damage.
// Each test uses its part of these.
#![allow(dead_code)]

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use dapple_records::{Row, RunHeader, time::rfc3339};

/// SplitMix64, of a seed: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators",
/// 2014.
pub fn mixed(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A valid row with 8 errors, 7 counters and 5 repeats of 24 frames: some 1.9 kB. Rows share
/// cases and settings as those of a sweep do; each has its own place in its run's plan.
pub fn row(n: u64) -> Row {
    let random = |salt: u64| mixed(n.wrapping_mul(64) + salt);
    let part = |salt: u64| random(salt) as f64 / u64::MAX as f64;
    let errors = ["rmse", "leak", "max_abs", "flip", "ssim_loss", "edge_width", "edge_shift"];
    let mut errors: BTreeMap<String, f64> =
        errors.iter().enumerate().map(|(i, name)| ((*name).into(), part(i as u64))).collect();
    errors.insert("wrong".into(), 0.0);
    let counters = ["bytes_read", "bytes_written", "dispatches", "draws", "texels", "taps", "kept"];
    let counters = counters
        .iter()
        .enumerate()
        .map(|(i, name)| ((*name).into(), random(10 + i as u64) >> (36 + 3 * i)));
    let repeat =
        |repeat: u64| (0..24).map(|f| 50_000 + (mixed(random(20 + repeat) + f) >> 47)).collect();
    Row {
        run: format!("{:016x}", n / 20_000),
        group: format!("{:04}.{:03}", n % 20_000 / 480, n % 480),
        problem: "shadow-filtering".into(),
        technique: format!("technique-{}", n % 24),
        variant: "plain".into(),
        form: "gpu".into(),
        knobs: [("resolution".into(), (256 + n / 9_600).into()), ("bias".into(), 0.002.into())]
            .into(),
        case: format!("spheres seed {}", n / 24 % 400),
        scene: "spheres".into(),
        scene_hash: format!("{:016x}", mixed(n / 24 % 400)),
        view: "front".into(),
        size: "640x480".into(),
        truth: "64 stratified rays a receiver".into(),
        adapter: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
        driver: "llvmpipe Mesa 25.0.7".into(),
        device: "software".into(),
        cpu: "a processor".into(),
        threads: 2,
        revision: "0123456789ab".into(),
        shader_hash: "5ade200000000000".into(),
        machine: "c418af26".into(),
        time: rfc3339(std::time::Duration::from_millis(1_790_000_000_000 + 137 * n)),
        clock: "gpu".into(),
        samples_ns: (0..5).map(repeat).collect(),
        passes_ns: [("filter-x".into(), 20_000), ("shade".into(), 30_000)].into(),
        baseline: "technique-0/plain".into(),
        ratio: Some(0.5 + part(30)),
        errors,
        port_errors: [("max_abs".into(), part(31) * 1e-6)].into(),
        counters: counters.collect(),
        memory_bytes: random(32) >> 40,
        ..Row::default()
    }
    .identified()
}

/// Writes the rows `0..count`, 20,000 a file, each file a run.
pub fn write_folder(folder: &Path, count: u64) -> std::io::Result<()> {
    for first in (0..count).step_by(20_000) {
        let path = folder.join(format!("{first:09}.jsonl"));
        let mut out = BufWriter::new(fs::File::create(path)?);
        let run = format!("{:016x}", first / 20_000);
        let header = RunHeader {
            run,
            sweep: "many".into(),
            sweep_hash: "f0".into(),
            ..RunHeader::default()
        };
        writeln!(out, "{}", header.to_line())?;
        for n in first..count.min(first + 20_000) {
            writeln!(out, "{}", row(n).to_line())?;
        }
        out.flush()?;
    }
    Ok(())
}

/// A stream of whole rows between damage of every kind, at least `bytes` long, never in memory.
pub struct Damaged {
    bytes: u64,
    given: u64,
    next: u64,
    /// Rows that a reader must find.
    pub good: u64,
    /// Lines that it must skip or find damaged.
    pub bad: u64,
    text: Vec<u8>,
    at: usize,
}

impl Damaged {
    /// A stream of about that many bytes.
    pub fn new(bytes: u64) -> Self {
        Self { bytes, given: 0, next: 0, good: 0, bad: 0, text: Vec::new(), at: 0 }
    }

    fn line(&mut self) -> String {
        self.next += 1;
        row(self.next).to_line()
    }

    /// One kind of damage with the rows around it.
    fn more(&mut self) {
        let kind = mixed(self.given) % 12;
        let whole = self.line();
        let (good, bad, text) = match kind {
            0 => (1, 1, whole.clone() + "\n" + &self.line()[..777] + "\n"),
            1 => {
                // One writer's line in the middle of another's.
                let other = self.line();
                (1, 2, format!("{}{whole}\n{}\n", &other[..500], &other[500..]))
            }
            2 => (2, 1, whole + &self.line() + "\n"),
            3 => (1, 1, format!("warning: a driver speaks\n{whole}\n")),
            4 => (1, 1, whole.replace("\"schema\":1", "\"schema\":7") + "\n" + &self.line() + "\n"),
            5 => (1, 1, format!("{}{whole}\n", "\0".repeat(4096))),
            6 => (1, 1, format!("{{\"a\":{}\n{whole}\n", "[".repeat(500))),
            7 => (
                1,
                1,
                whole.replace("\"threads\":2", "\"threads\":-2") + "\n" + &self.line() + "\n",
            ),
            8 => (1, 1, format!("{whole} and more\n")),
            _ => (2, 0, whole + "\n" + &self.line() + "\r\n"),
        };
        self.good += good;
        self.bad += bad;
        self.given += text.len() as u64;
        self.text = text.into_bytes();
        if kind == 3 {
            // Not Unicode.
            self.text.splice(0..2, [0xff, 0xfe]);
        }
        self.at = 0;
    }
}

impl Read for Damaged {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.at == self.text.len() {
            if self.given >= self.bytes {
                return Ok(0);
            }
            self.more();
        }
        let count = out.len().min(self.text.len() - self.at);
        out[..count].copy_from_slice(&self.text[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}
