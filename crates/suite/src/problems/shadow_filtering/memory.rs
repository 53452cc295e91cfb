//! How many bytes a setting needs, and whether there are so many: past them a machine swaps or the
//! program is killed, and neither says why.

use crate::{SuiteError, memory};
use dapple_shadows::filtering::Settings;

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
    let detail = format!("{} channels a texel", settings.channel_count());
    memory::check_host(resolution, &detail, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_shadows::filtering::{Estimator, Splits};

    #[test]
    fn bytes_are_those_of_the_layout_and_a_refusal_names_the_channels() {
        let splits = Splits::Uniform;
        let layered = Settings { layers: 8, ..Settings::new(Estimator::LayeredPower { splits }) };
        // 24 channels twice and the map itself, 4 bytes each, on 8192^2 texels.
        let bytes = host_bytes(8192, &layered);
        assert_eq!(bytes, 49 * 4 * 67_108_864);
        let error = check_host(8192, &layered, u64::MAX).unwrap_err();
        assert!(error.to_string().contains("24 channels"), "{error}");
        let hard = Settings::new(Estimator::Hard);
        assert_eq!(host_bytes(16384, &hard), 2 << 30);
        assert_eq!(device_bytes(1024, &hard), 8 << 20);
    }
}
