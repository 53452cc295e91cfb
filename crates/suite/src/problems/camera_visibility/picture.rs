//! Pictures for people: what is drawn, lit by a moon.

use dapple_occlusion::camera::Objects;
use glam::Vec3;

/// Towards the moon.
const MOON: Vec3 = Vec3::new(0.48, 0.74, 0.47);

/// Light of nothing: the sky.
pub const SKY: f32 = 0.05;

/// Grey of a triangle of an object: its albedo under the moon on both sides, with a shade of its own
/// for every two triangles, so that neighbours, walls and windows are told apart.
pub fn shade(objects: &Objects, object: u32, triangle: u32) -> f32 {
    let placed = &objects.objects[object as usize];
    let template = &objects.templates[placed.template as usize];
    let Some(corners) = template.triangles.get(triangle as usize) else {
        return SKY;
    };
    let [a, b, c] = corners.map(|i| placed.place(template.positions[i as usize]));
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let albedo = template.albedo.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let own = 0.85
        + 0.15
            * ((object.wrapping_mul(31).wrapping_add(triangle / 2).wrapping_mul(0x9e37_79b9) >> 24)
                as f32
                / 255.0);
    (albedo * own * (0.3 + 0.9 * normal.dot(MOON).abs())).clamp(0.0, 1.0)
}
