//! Pictures for people: luminance as a display shows it.

use glam::Vec3;

/// Grey of a linear colour, sRGB-encoded, 0..=1.
pub fn grey(radiance: Vec3) -> f32 {
    encoded(f64::from(radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722)))) as f32
}

/// A linear channel as sRGB encodes it (IEC 61966-2-1), clamped to 0..=1.
pub fn encoded(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
