//! What a record says about the machine and the program.

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
            threads: rayon::current_num_threads() as u32,
            revision,
            dirty,
            shader_hash: dapple_shaders::hash(),
        }
    })
}

fn cpu_name() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    info.lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
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
