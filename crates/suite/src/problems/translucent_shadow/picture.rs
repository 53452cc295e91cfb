//! The lit image: what the receivers of a pixel add up to.

use dapple_scene::Scene;
use dapple_trace::CameraLayers;
use glam::Vec3;

/// Light that reaches a surface whatever its shadow.
const AMBIENT: f32 = 0.15;

/// Grey of a pixel that nothing covers.
const BACKGROUND: f32 = 0.85;

/// Relative luminance of linear RGB (Rec. 709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// A pixel's grey is `base + Σ gain T` over its receivers: lighting is linear in transmittance.
pub struct Lighting {
    /// One a pixel: ambient light, and the background behind what is translucent.
    pub base: Vec<f32>,
    /// One a receiver: its share of the pixel.
    pub gain: Vec<f32>,
    /// First receiver of each pixel, and the end.
    pub starts: Vec<u32>,
}

impl Lighting {
    /// Composes the layers of each pixel, nearest first: a surface of opacity α hides that share of
    /// what lies behind. Opaque surfaces are lit by Lambert's cosine, translucent ones by T alone,
    /// as the thesis has it (section 5.3). `n_dot_l` has one cosine a receiver.
    pub fn of(scene: &Scene, layers: &CameraLayers, n_dot_l: &[f32]) -> Self {
        let pixels = layers.pixels();
        let mut base = Vec::with_capacity(pixels);
        let mut gain = Vec::with_capacity(layers.surfaces.len());
        for pixel in 0..pixels {
            let (mut through, mut grey) = (1.0_f32, 0.0_f32);
            for i in layers.range(pixel) {
                let alpha = layers.alpha[i];
                let material = &scene.materials[layers.surfaces[i].material as usize];
                let albedo = material.albedo.dot(LUMINANCE);
                let cosine = if alpha >= 1.0 { n_dot_l[i].max(0.0) } else { 1.0 };
                let share = through * alpha * albedo;
                grey += share * AMBIENT;
                gain.push(share * (1.0 - AMBIENT) * cosine);
                through *= 1.0 - alpha;
            }
            base.push(grey + through * BACKGROUND);
        }
        Self { base, gain, starts: layers.starts.clone() }
    }

    /// Grey of every pixel, 0..=1, as shown: the square root stands for the display's curve.
    pub fn image(&self, transmittance: &[f32]) -> Vec<f32> {
        let pixel = |(i, base): (usize, &f32)| {
            let range = self.starts[i] as usize..self.starts[i + 1] as usize;
            let direct: f32 = range.map(|r| self.gain[r] * transmittance[r]).sum();
            (base + direct).clamp(0.0, 1.0).sqrt()
        };
        self.base.iter().enumerate().map(pixel).collect()
    }
}
