//! How many bytes a setting needs, and whether there are so many: past them a machine swaps or the
//! program is killed, and neither says why.

use crate::SuiteError;
use dapple_shadows::filtering::Settings;
use std::{fs, sync::OnceLock};

/// Allowed where the machine does not say how much memory it has.
const ALLOWED_UNKNOWN: u64 = 8 << 30;

/// Bytes of the form on the processor but for receivers: the map, and two sets of f32 planes
/// whatever the format; one plane where nothing is filtered.
pub fn host_bytes(resolution: u32, settings: &Settings) -> u64 {
    let channels = u64::from(settings.channel_count());
    let planes = if settings.prefiltered() { 2 * channels } else { 1 };
    4 * texels(resolution) * (1 + planes)
}

/// Bytes on a graphics device but for receivers: depth target and depth buffer, and two sets of
/// channels in whole words.
pub fn device_bytes(resolution: u32, settings: &Settings) -> u64 {
    let layers = if settings.splits().is_some() { settings.layers } else { 1 };
    let words = (settings.bytes_per_texel() / layers).div_ceil(4) * layers;
    let stored = if settings.prefiltered() { 2 * 4 * u64::from(words) } else { 0 };
    texels(resolution) * (8 + stored)
}

fn texels(resolution: u32) -> u64 {
    u64::from(resolution) * u64::from(resolution)
}

/// Refuses a setting that needs `bytes` of the machine's own memory if that is more than half of
/// it.
///
/// # Errors
/// [`SuiteError::Value`] with the bytes and the limit.
pub fn check_host(resolution: u32, settings: &Settings, bytes: u64) -> Result<(), SuiteError> {
    static ALLOWED: OnceLock<u64> = OnceLock::new();
    check(resolution, settings, bytes, *ALLOWED.get_or_init(allowed))
}

fn check(resolution: u32, settings: &Settings, bytes: u64, allowed: u64) -> Result<(), SuiteError> {
    if bytes <= allowed {
        return Ok(());
    }
    Err(SuiteError::Value {
        what: "knob",
        name: "resolution".into(),
        value: resolution.to_string(),
        limit: format!(
            "with {} channels a texel it takes {bytes} bytes; half of the machine's memory, \
             {allowed} bytes, is allowed",
            settings.channel_count()
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
    use dapple_shadows::filtering::{Estimator, Splits};

    #[test]
    fn the_refusal_names_bytes_and_limit() {
        let splits = Splits::Uniform;
        let layered = Settings { layers: 8, ..Settings::new(Estimator::LayeredPower { splits }) };
        // 24 channels twice and the map itself, 4 bytes each, on 8192^2 texels.
        let bytes = host_bytes(8192, &layered);
        assert_eq!(bytes, 49 * 4 * 67_108_864);
        assert!(check(8192, &layered, bytes, bytes).is_ok());
        let error = check(8192, &layered, bytes, 8 << 30).unwrap_err();
        for part in ["`resolution` = 8192", "24 channels", "13153337344", "8589934592"] {
            assert!(error.to_string().contains(part), "{error}");
        }
        assert_eq!(error.exit_code(), 2);
        let hard = Settings::new(Estimator::Hard);
        assert_eq!(host_bytes(16384, &hard), 2 << 30);
        assert_eq!(device_bytes(1024, &hard), 8 << 20);
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
