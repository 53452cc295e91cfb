//! Pictures for people: luminance as a display shows it.

use glam::Vec3;

/// Grey of a linear colour, sRGB-encoded, 0..=1.
pub fn grey(radiance: Vec3) -> f32 {
    let luminance = radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722)).clamp(0.0, 1.0);
    if luminance <= 0.003_130_8 {
        12.92 * luminance
    } else {
        1.055 * luminance.powf(1.0 / 2.4) - 0.055
    }
}
