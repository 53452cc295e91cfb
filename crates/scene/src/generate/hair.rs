//! Hair on a sphere: strands as data and as ribbons.
//!
//! Built from arithmetic and square roots alone, so that a seed gives the same bits everywhere.

use super::builder::Builder;
use super::mesh;
use super::random::in_ball;
use crate::strands::{Facing, Strands};
use crate::{Material, Scene};
use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Opacity of hair.
pub const HAIR_OPACITY: f32 = 70.0 / 255.0;

/// Segments of every strand.
pub const SEGMENTS: u32 = 16;

/// Most strands that are generated at once.
pub const MAX_STRANDS: u32 = 1 << 20;

/// Centre of the head.
const HEAD: Vec3 = Vec3::new(0.0, 3.2, 0.0);

/// Radius of the head, metres: a giant's, so that hair compares with trees and grass.
const HEAD_RADIUS: f32 = 1.5;

/// Where the camera of [`hair`] stands, which its ribbons face.
const EYE: DVec3 = DVec3::new(0.0, 5.5, 10.0);

/// Brown hair: 8-bit sRGB 130, 87, 64.
pub fn hair_material() -> Material {
    Material {
        name: "hair".into(),
        albedo: Vec3::new(0.223_227_96, 0.095_307_47, 0.051_269_46),
        opacity: HAIR_OPACITY,
        ..Material::default()
    }
}

/// `count` strands (clamped to 1..=[`MAX_STRANDS`]) of [`SEGMENTS`] segments, 1.2 to 2 m long, that
/// grow out of a sphere of radius 1.5 m about (0, 3.2, 0) and fall. Their radius is 4 mm for 5,000
/// strands and goes with 1 / sqrt(count), at most 2 cm, so that more strands are finer but cover
/// more in all.
pub fn hair_strands(count: u32, seed: u64) -> Strands {
    let mut rng = Pcg64::seed_from_u64(seed);
    let count = count.clamp(1, MAX_STRANDS);
    let radius = (4e-3 * (5_000.0 / count as f32).sqrt()).min(2e-2);
    let mut points = Vec::with_capacity(count as usize * (SEGMENTS as usize + 1));
    for _ in 0..count {
        let root = loop {
            let out = in_ball(&mut rng).normalize_or(Vec3::Y);
            if out.y > -0.25 {
                break out;
            }
        };
        let step = rng.random_range(1.2..2.0) / SEGMENTS as f32;
        let (mut at, mut along) = (HEAD + root * HEAD_RADIUS, root);
        points.push(at);
        for _ in 0..SEGMENTS {
            along = (along - Vec3::Y * 0.14 + in_ball(&mut rng) * 0.15).normalize_or(Vec3::NEG_Y);
            at += along * step;
            // Hair lies on the head, not in it.
            let out = at - HEAD;
            let least = 1.01 * HEAD_RADIUS;
            if out.length() < least {
                at = HEAD + out.normalize_or(root) * least;
            }
            points.push(at);
        }
    }
    let starts = (0..count).map(|i| i * (SEGMENTS + 1)).collect();
    Strands { name: "hair".into(), starts, points, radius: vec![radius] }
}

/// `count` strands as ribbons that face the first camera, on an opaque head above the ground.
pub fn hair(name: &str, count: u32, seed: u64) -> Scene {
    let mut b = Builder::outdoors(name);
    let skin = b.material("skin", [0.55, 0.38, 0.3]);
    b.add("head", skin, mesh::icosphere(HEAD, HEAD_RADIUS, 4));
    b.0.materials.push(hair_material());
    let material = b.0.materials.len() as u32 - 1;
    b.add("hair", material, hair_strands(count, seed).ribbons(Facing::Point(EYE)).mesh);
    let target = DVec3::new(0.0, 2.7, 0.0);
    b.camera("front", EYE, target, 46.0);
    b.orbit(EYE, target, 46.0, 30.0);
    b.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Light;

    #[test]
    fn the_colour_is_the_one_of_8_bits_in_linear_light() {
        for (byte, linear) in
            [130.0, 87.0, 64.0f64].into_iter().zip(hair_material().albedo.to_array())
        {
            let expected = ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
            assert!((f64::from(linear) - expected).abs() < 1e-7, "{linear} {expected}");
        }
    }

    #[test]
    fn strands_are_as_many_as_asked_and_stay_outside_the_head() {
        for (count, strands) in [(0, 1), (1, 1), (300, 300)] {
            let s = hair_strands(count, 5);
            s.validate().unwrap();
            assert_eq!((s.starts.len(), s.segment_count()), (strands, 16 * strands));
            assert!(s.points.iter().all(|p| p.distance(HEAD) > 0.999 * HEAD_RADIUS));
            assert!(s.bounds().min.y > 0.0);
        }
        assert_eq!(hair_strands(50, 1), hair_strands(50, 1));
        assert_ne!(hair_strands(50, 1), hair_strands(50, 2));
        assert_eq!(hair_strands(5_000, 1).radius, [4e-3]);
        assert_eq!(hair_strands(1, 1).radius, [2e-2]);
    }

    #[test]
    fn ribbons_face_the_scenes_camera_under_light_from_above() {
        let s = hair("hair", 1_000, 1);
        assert_eq!(s.cameras[0].position, EYE);
        let Light::Directional { direction } = s.lights[0] else { panic!("no sun") };
        assert_eq!(direction, DVec3::NEG_Y);
        let mesh = s.meshes.last().unwrap();
        assert_eq!(mesh.triangles.len(), 1_000 * 16 * 2);
        let away = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
            (b - a).cross(c - a).dot(EYE - a) <= 0.0
        };
        // A few fold over, where a strand lands on the head.
        let folded = mesh.triangles.iter().filter(away).count();
        assert!(100 * folded < mesh.triangles.len(), "{folded} are turned away");
    }
}
