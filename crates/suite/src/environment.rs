//! What a record says about the machine and the program.

use dapple_records::RunHeader;
use std::{process::Command, sync::OnceLock};

/// Environment variable that makes a missing graphics adapter an error instead of a note.
pub const REQUIRE_GPU_VARIABLE: &str = "DAPPLE_REQUIRE_GPU";

/// Whether the environment demands a graphics adapter: the variable is set, and not to 0.
pub fn requires_gpu() -> bool {
    std::env::var_os(REQUIRE_GPU_VARIABLE).is_some_and(|value| !value.is_empty() && value != "0")
}

/// Facts that are the same for every row of a run.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Processor's model name.
    pub cpu: String,
    /// Threads the `cpu` forms use.
    pub threads: u32,
    /// Main memory; 0 where the system does not say.
    pub memory_bytes: u64,
    /// Host identity: a hash of the machine id where there is one, else of name and processor.
    pub machine: String,
    /// Git revision the program was built in, or `unknown`.
    pub revision: String,
    /// Whether the tree had changes.
    pub dirty: bool,
    /// Hash of all shaders.
    pub shader_hash: String,
}

/// The facts, read once a process.
pub fn environment() -> &'static Environment {
    static FACTS: OnceLock<Environment> = OnceLock::new();
    FACTS.get_or_init(|| {
        let cpu = cpu_name();
        let (revision, dirty) = revision();
        Environment {
            machine: machine(&cpu),
            cpu,
            memory_bytes: memory_bytes(),
            threads: rayon::current_num_threads() as u32,
            revision,
            dirty,
            shader_hash: dapple_shaders::hash(),
        }
    })
}

/// The header of a new run that begins now.
pub fn run_header(sweep: &str, sweep_hash: &str, command: &str) -> RunHeader {
    let facts = environment();
    RunHeader {
        run: dapple_records::new_run_id(),
        sweep: sweep.into(),
        sweep_hash: sweep_hash.into(),
        command: command.into(),
        time: dapple_records::now(),
        version: env!("CARGO_PKG_VERSION").into(),
        revision: facts.revision.clone(),
        dirty: facts.dirty,
        machine: facts.machine.clone(),
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        cpu: facts.cpu.clone(),
        threads: facts.threads,
        memory_bytes: facts.memory_bytes,
        ..RunHeader::default()
    }
}

fn cpu_name() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    info.lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
}

fn memory_bytes() -> u64 {
    total_memory(&std::fs::read_to_string("/proc/meminfo").unwrap_or_default())
}

/// `MemTotal:       16384 kB` of `/proc/meminfo`; its kB are 1024 bytes.
fn total_memory(text: &str) -> u64 {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.unwrap_or(0).saturating_mul(1024)
}

fn machine(cpu: &str) -> String {
    let id = std::fs::read_to_string("/etc/machine-id")
        .or_else(|_| std::fs::read_to_string("/etc/hostname"))
        .unwrap_or_default();
    // Hashed: a record that is shared should not carry the identity itself.
    let hash = blake3::hash(format!("{}\n{cpu}", id.trim()).as_bytes());
    hash.to_hex()[..8].to_string()
}

/// The revision of the checkout that holds the running program's sources, found at run time so
/// that a rebuild is not forced by every commit.
fn revision() -> (String, bool) {
    let git = |arguments: &[&str]| {
        Command::new("git")
            .arg("-C")
            .arg(env!("CARGO_MANIFEST_DIR"))
            .args(arguments)
            .output()
            .ok()
            .filter(|output| output.status.success())
            .map(|output| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    match git(&["rev-parse", "--short=12", "HEAD"]) {
        Some(revision) => {
            let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
            (revision, changes.is_none_or(|text| !text.is_empty()))
        }
        None => ("unknown".into(), false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read_in_bytes_and_is_zero_where_it_is_not_told() {
        let text = "MemFree:  17 kB\nMemTotal:       16384256 kB\nMemFree: 1 kB\n";
        assert_eq!(total_memory(text), 16_384_256 * 1024);
        for odd in ["", "MemTotal: many kB", "MemTotal: 3 MB", "MemTotal: -1 kB"] {
            assert_eq!(total_memory(odd), 0, "{odd}");
        }
        if cfg!(target_os = "linux") {
            assert!(memory_bytes() > 1 << 20);
        }
    }
}
