//! Seeded random input of the gates: windows of depths, whole maps, receivers, settings.

pub use crate::verify::rng;

use super::super::{SPEC, settings};
use crate::{
    SuiteError,
    knob::{self, Knobs},
    problem::{Form, Setting},
};
use dapple_shadows::filtering::{DepthMap, KernelShape, Lookup, Receiver, Settings};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Depths of one window: two depths, a few, a ramp or noise, spread over at least 1e-3.
pub fn window(rng: &mut Pcg64) -> Vec<f64> {
    let count = rng.random_range(2..60_usize);
    let near: f64 = rng.random_range(0.0..0.9);
    let spread = rng.random_range(1e-3..(1.0 - near));
    let kind = rng.random_range(0..4);
    let share: f64 = rng.random_range(0.05..0.95);
    let mut depths: Vec<f64> = (0..count)
        .map(|i| {
            let t = match kind {
                0 => f64::from(rng.random_range(0.0..1.0) < share),
                1 => f64::from(rng.random_range(0..4_u8)) / 3.0,
                2 => i as f64 / count as f64,
                _ => rng.random_range(0.0..1.0),
            };
            near + spread * t
        })
        .collect();
    // Both ends are there, so that the window has a variance.
    depths[0] = near;
    depths[count - 1] = near + spread;
    depths
}

/// Receiver depths around a window's: its own depths, between them, and beyond both ends.
pub fn receiver_depths(rng: &mut Pcg64, window: &[f64]) -> Vec<f64> {
    let mut depths: Vec<f64> = (0..12).map(|_| rng.random_range(0.0..1.0)).collect();
    depths.extend(window.iter().take(4));
    depths.sort_by(f64::total_cmp);
    depths
}

/// Share of a window that is not nearer than `z`.
pub fn exact(window: &[f64], z: f64) -> f64 {
    window.iter().filter(|d| **d >= z).count() as f64 / window.len() as f64
}

/// Mean of a function over a window.
pub fn mean(window: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    window.iter().map(|d| f(*d)).sum::<f64>() / window.len() as f64
}

/// A map of a few planes, steps and holes: what scenes give.
pub fn map(rng: &mut Pcg64) -> DepthMap {
    let (width, height) = (rng.random_range(5..40_u32), rng.random_range(5..40_u32));
    let mut depths = vec![0.0_f32; (width * height) as usize];
    let (base, du, dv) = (
        rng.random_range(0.5..0.8_f32),
        rng.random_range(-0.2..0.2_f32),
        rng.random_range(-0.2..0.2_f32),
    );
    for (i, z) in depths.iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        *z = (base + du * (x as f32 / width as f32 - 0.5) + dv * (y as f32 / height as f32 - 0.5))
            .clamp(0.0, 1.0);
    }
    for _ in 0..rng.random_range(1..6) {
        let (x0, y0) = (rng.random_range(0..width), rng.random_range(0..height));
        let (w, h) = (rng.random_range(1..=width), rng.random_range(1..=height));
        let depth = if rng.random_range(0..5) == 0 { 1.0 } else { rng.random_range(0.05..0.6_f32) };
        for y in y0..(y0 + h).min(height) {
            for x in x0..(x0 + w).min(width) {
                depths[(y * width + x) as usize] = depth;
            }
        }
    }
    DepthMap { width, height, depths }
}

/// Receivers over a map, all inside, slightly sloped, in front of, on and behind its depths.
pub fn receivers(rng: &mut Pcg64, map: &DepthMap, count: usize) -> Vec<Receiver> {
    (0..count)
        .map(|_| {
            let (u, v) = (rng.random_range(0.0..1.0_f32), rng.random_range(0.0..1.0_f32));
            let x = ((u * map.width as f32) as u32).min(map.width - 1);
            let y = ((v * map.height as f32) as u32).min(map.height - 1);
            let stored = map.depths[(y * map.width + x) as usize];
            let z = stored + rng.random_range(-0.2..0.4_f32);
            Receiver::new(u, v, z)
                .with_slope(rng.random_range(-0.2..0.2_f32), rng.random_range(-0.2..0.2_f32))
        })
        .collect()
}

/// Settings of a technique with random variant, format, kernel, lookup and width.
///
/// # Errors
/// Those of the settings' own check.
pub fn settings_of(rng: &mut Pcg64, technique: &str) -> Result<Settings, SuiteError> {
    let technique = SPEC.technique(technique)?;
    let mut given = Knobs::new();
    for knob in technique.knobs {
        if let knob::Range::Choice(words) = knob.range {
            given.insert(knob.name.into(), words[rng.random_range(0..words.len())].into());
        }
    }
    if technique.knobs.iter().any(|k| k.name == "layers") {
        given.insert("layers".into(), (1 << rng.random_range(0..4)).into());
    }
    let variant = technique.variants[rng.random_range(0..technique.variants.len())].id.into();
    let knobs = knob::complete("knob", technique.knobs, &given)?;
    let setting = Setting { technique: technique.id.into(), variant, form: Form::Cpu, knobs };
    let mut settings = settings::settings(&setting, 0.01)?;
    settings.width_texels = 2 * rng.random_range(0..6) + 1;
    Ok(settings)
}

/// The default settings of a technique's variant: f32, box, and the nearest texel.
///
/// # Errors
/// An unknown technique.
pub fn plain(technique: &str, variant: &str, width_texels: u32) -> Result<Settings, SuiteError> {
    let technique = SPEC.technique(technique)?;
    let knobs = knob::complete("knob", technique.knobs, &Knobs::new())?;
    let variant = variant.into();
    let setting = Setting { technique: technique.id.into(), variant, form: Form::Cpu, knobs };
    let settings = settings::settings(&setting, 0.01)?;
    Ok(Settings { width_texels, lookup: Lookup::Nearest, kernel: KernelShape::Box, ..settings })
}
