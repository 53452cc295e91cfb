//! Random vectors from arithmetic and square roots alone: the same bits on every platform.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;

/// Uniform in the unit ball.
pub fn in_ball(rng: &mut Pcg64) -> Vec3 {
    loop {
        let mut along = || rng.random_range(-1.0..1.0f32);
        let p = Vec3::new(along(), along(), along());
        if p.length_squared() <= 1.0 {
            return p;
        }
    }
}

/// A horizontal unit vector in any direction.
pub fn on_circle(rng: &mut Pcg64) -> Vec3 {
    loop {
        let mut along = || rng.random_range(-1.0..1.0f32);
        let p = Vec3::new(along(), 0.0, along());
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}
