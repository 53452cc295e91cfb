//! Whether the machine has the bytes that a setting needs: past them it swaps or the program is
//! killed, and neither says why.

use crate::SuiteError;
use std::{fs, sync::OnceLock};

/// Allowed where the machine does not say how much memory it has.
const ALLOWED_UNKNOWN: u64 = 8 << 30;

/// Refuses a map of that `resolution` if its `bytes`, made up as `detail` says, are more than half
/// of the machine's memory.
///
/// # Errors
/// [`SuiteError::Value`] with the bytes and the limit.
pub fn check_host(resolution: u32, detail: &str, bytes: u64) -> Result<(), SuiteError> {
    static ALLOWED: OnceLock<u64> = OnceLock::new();
    check(resolution, detail, bytes, *ALLOWED.get_or_init(allowed))
}

fn check(resolution: u32, detail: &str, bytes: u64, allowed: u64) -> Result<(), SuiteError> {
    if bytes <= allowed {
        return Ok(());
    }
    Err(SuiteError::Value {
        what: "knob",
        name: "resolution".into(),
        value: resolution.to_string(),
        limit: format!(
            "with {detail} it takes {bytes} bytes; half of the machine's memory, {allowed} bytes, \
             is allowed"
        ),
    })
}

/// Half of what the machine, or the control group the program runs in, has.
fn allowed() -> u64 {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| machine_bytes(&text));
    let group = fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let group = group.and_then(|text| text.trim().parse::<u64>().ok());
    machine.into_iter().chain(group).min().map_or(ALLOWED_UNKNOWN, |bytes| bytes / 2)
}

fn machine_bytes(meminfo: &str) -> Option<u64> {
    let rest = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_refusal_names_bytes_and_limit() {
        assert!(check(8192, "24 channels a texel", 5, 5).is_ok());
        let error = check(8192, "24 channels a texel", 13_153_337_344, 8 << 30).unwrap_err();
        for part in ["`resolution` = 8192", "24 channels", "13153337344", "8589934592"] {
            assert!(error.to_string().contains(part), "{error}");
        }
        assert_eq!(error.exit_code(), 2);
    }

    #[test]
    fn the_machines_memory_is_read_as_the_kernel_writes_it() {
        let text = "MemTotal:       24602944 kB\nMemFree:        1 kB\n";
        assert_eq!(machine_bytes(text), Some(24_602_944 * 1024));
        for odd in ["", "MemTotal: many kB", "MemTotal: 5", "MemTotal: 18446744073709551615 kB"] {
            assert_eq!(machine_bytes(odd), None, "{odd}");
        }
        assert!(allowed() > 0);
    }
}
