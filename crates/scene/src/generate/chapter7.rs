//! The test scenes of statistical shadow-map filtering, rebuilt from their description.
//!
//! Based on: J. Gumbau, "Real-time techniques for natural scenes", PhD thesis, 2011, section 7.3
//! and figures 7.3, 7.4 and 7.6.
//! Deviations: the models were not published. *Spheres*, *chairs* and *car* here share the traits
//! that the figures show (occluders in line with the light; thin slats above one another; a hull
//! with cavities and thin parts), not the shapes.

use super::builder::Builder;
use super::mesh;
use crate::{Mesh, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Four stacks of four spheres, each stack in line with the light but for a shift of up to 0.35 m,
/// so that each shadow falls partly into another. 20,482 triangles.
pub fn spheres(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let light = DVec3::new(-0.4, -1.0, -0.3).normalize();
    let mut b = Builder::new("spheres", light);
    b.floor(7.0);
    let material = b.material("sphere", [0.8, 0.35, 0.2]);
    let sphere = b.mesh("sphere", material, mesh::icosphere(Vec3::ZERO, 1.0, 3));
    let (across, along) = light.any_orthonormal_pair();
    for foot in [[-2.2, -2.0], [1.6, -2.4], [-1.8, 1.8], [2.0, 1.6]] {
        let foot = DVec3::new(foot[0], 0.0, foot[1]);
        for level in 0..4 {
            let mut shift = |by: f64| rng.random_range(-by..by);
            let up = 1.7 + 1.5 * f64::from(level) + shift(0.15);
            let centre = foot - light * up + across * shift(0.35) + along * shift(0.35);
            let radius = 0.72 - 0.07 * f64::from(level) + shift(0.12);
            let turn = DQuat::from_rotation_y(shift(3.0));
            b.place(
                sphere,
                DAffine3::from_scale_rotation_translation(DVec3::splat(radius), turn, centre),
            );
        }
    }
    let (eye, target) = (DVec3::new(-8.0, 5.5, -5.0), DVec3::new(-0.6, 0.4, -0.3));
    b.camera("shadows", eye, target, 38.0);
    b.camera("floor", DVec3::new(-6.5, 2.2, 1.0), DVec3::new(-1.0, 0.0, -0.4), 40.0);
    b.orbit(eye, target, 38.0, 30.0);
    b.0
}

/// One chair, about 0.45 m wide: legs, stretchers, a slatted seat and back. 26 boxes.
fn chair() -> Mesh {
    let slab = |c: [f32; 3], h: [f32; 3]| mesh::cuboid(Vec3::from_array(c), Vec3::from_array(h));
    let mut parts = vec![];
    for (x, z) in [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)] {
        parts.push(slab([x, 0.215, z], [0.018, 0.215, 0.018]));
    }
    for k in [-0.2, 0.2] {
        parts.push(slab([k, 0.15, 0.0], [0.01, 0.012, 0.18]));
        parts.push(slab([0.0, 0.22, k], [0.18, 0.012, 0.01]));
        parts.push(slab([k, 0.69, -0.215], [0.014, 0.235, 0.012]));
    }
    for i in 0..9 {
        let z = -0.2 + 0.05 * i as f32;
        parts.push(slab([0.0, 0.437, z], [0.215, 0.006, 0.016]));
    }
    for i in 0..7 {
        let y = 0.53 + 0.06 * i as f32;
        parts.push(slab([0.0, y, -0.198], [0.2, 0.018, 0.004]));
    }
    mesh::join(&parts)
}

/// Twelve chairs in rows, turned at random, and four more stacked onto some: 4,994 triangles.
pub fn chairs(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::new("chairs", DVec3::new(0.45, -1.0, 0.35));
    b.floor(3.5);
    let material = b.material("wood", [0.55, 0.36, 0.2]);
    let chair = b.mesh("chair", material, chair());
    for i in 0..12 {
        let turn: f64 = rng.random_range(-0.5..0.5);
        let mut near = |at: f64| at + rng.random_range(-0.08..0.08);
        let spot =
            DVec3::new(near(-1.35 + 0.9 * f64::from(i % 4)), 0.0, near(-1.0 + f64::from(i / 4)));
        let facing = DQuat::from_rotation_y(turn);
        b.place(chair, DAffine3::from_rotation_translation(facing, spot));
        if i % 3 == 1 {
            // Stacked: the seats lie 9 cm above one another.
            let lifted = spot + DVec3::new(0.0, 0.09, 0.0) + facing * (DVec3::Z * 0.045);
            b.place(chair, DAffine3::from_rotation_translation(facing, lifted));
        }
    }
    let (eye, target) = (DVec3::new(2.9, 2.3, 3.1), DVec3::new(0.3, 0.15, 0.25));
    b.camera("shadows", eye, target, 34.0);
    b.camera("under the seats", DVec3::new(2.6, 0.5, 1.4), DVec3::new(0.4, 0.15, 0.0), 40.0);
    b.orbit(eye, target, 34.0, 30.0);
    b.0
}

/// A car 4.2 m long, front towards +x. About 10,000 triangles.
pub fn car(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::new("car", DVec3::new(-0.4, -1.0, -0.45));
    b.floor(5.5);
    let paint = b.material("paint", [0.6, 0.08, 0.06]);
    let metal = b.material("metal", [0.5, 0.5, 0.52]);
    let rubber = b.material("rubber", [0.06, 0.06, 0.06]);
    let fabric = b.material("fabric", [0.35, 0.3, 0.25]);
    b.add("hull", paint, hull());
    b.add("cabin", paint, cabin());
    b.add("fittings", metal, fittings());
    b.add("interior", fabric, interior());
    let luggage: Vec<Mesh> = (0..4)
        .map(|i| {
            let mut size = |least: f32, most: f32| 0.5 * rng.random_range(least..most);
            let half = Vec3::new(size(0.2, 0.34), size(0.04, 0.16), size(0.5, 1.0));
            let x = -0.68 + 0.38 * i as f32;
            mesh::cuboid(Vec3::new(x, 1.575 + half.y, 0.0), half)
        })
        .collect();
    b.add("luggage", fabric, mesh::join(&luggage));
    let tyre = b.mesh("tyre", rubber, mesh::torus(Vec3::ZERO, Vec3::Z, [0.235, 0.085], 40, 14));
    let rim = b.mesh("rim", metal, rim());
    for (x, z) in [(WHEEL_X, 0.74), (WHEEL_X, -0.74), (-WHEEL_X, 0.74), (-WHEEL_X, -0.74)] {
        let place = DAffine3::from_translation(DVec3::new(f64::from(x), 0.32, z));
        b.place(tyre, place);
        b.place(rim, place);
    }
    let (eye, target) = (DVec3::new(-3.6, 2.6, -4.6), DVec3::new(-0.3, 0.4, -0.5));
    b.camera("shadows", eye, target, 38.0);
    b.camera("under the car", DVec3::new(-2.4, 0.7, -4.4), DVec3::new(0.0, 0.2, 0.0), 36.0);
    b.orbit(eye, target, 38.0, 30.0);
    b.0
}

const WHEEL_X: f32 = 1.3;

/// The body up to the window line; its underside rises over the wheels.
fn hull() -> Mesh {
    let columns: Vec<[f32; 3]> = (0..=96)
        .map(|i| {
            let x = -2.1 + 4.2 * i as f32 / 96.0;
            let arch = [WHEEL_X, -WHEEL_X].map(|w| {
                let inside = 0.38 * 0.38 - (x - w) * (x - w);
                if inside > 0.0 { 0.32 + inside.sqrt() } else { 0.0 }
            });
            let low = arch[0].max(arch[1]).max(0.24);
            let bonnet = ((x - 0.7) / 1.4).clamp(0.0, 1.0);
            let tail = ((-x - 1.5) / 0.6).clamp(0.0, 1.0);
            [x, low, 0.92 - 0.16 * bonnet * bonnet - 0.06 * tail * tail]
        })
        .collect();
    mesh::extrusion(&columns, [-0.82, 0.82])
}

/// Roof on pillars, with nothing between: the windows are open. A spoiler on the tail.
fn cabin() -> Mesh {
    let roof: Vec<[f32; 3]> = (0..=48)
        .map(|i| {
            let t = i as f32 / 38.0;
            let high = 1.38 + 0.1 * (t * std::f32::consts::PI).sin();
            [-1.25 + 1.7 * t, high - 0.03, high]
        })
        .collect();
    let wing: Vec<[f32; 3]> = (0..=24)
        .map(|i| {
            let t = i as f32 / 24.0;
            let thick = 0.006 + 0.02 * (t * (1.0 - t)).sqrt();
            [-2.2 + 0.3 * t, 1.12 - thick, 1.12 + thick]
        })
        .collect();
    let mut parts =
        vec![mesh::extrusion(&roof, [-0.68, 0.68]), mesh::extrusion(&wing, [-0.75, 0.75])];
    for z in [-1.0, 1.0] {
        let pillar = |foot: f32, top: f32, radius: f32| {
            let (a, b) = (Vec3::new(foot, 0.85, 0.76 * z), Vec3::new(top, 1.39, 0.65 * z));
            mesh::cylinder(a, b, radius, 12)
        };
        parts.extend([pillar(0.95, 0.4, 0.025), pillar(-0.15, -0.25, 0.03)]);
        parts.extend([pillar(-0.95, -0.9, 0.03), pillar(-1.6, -1.2, 0.035)]);
        let stand = Vec3::new(-2.0, 0.98, 0.6 * z);
        parts.push(mesh::cuboid(stand, Vec3::new(0.05, 0.13, 0.008)));
    }
    mesh::join(&parts)
}

/// Roof rack, mirrors, lamps, grille, bumpers and aerial: the thin parts.
fn fittings() -> Mesh {
    let rod = |a: [f32; 3], b: [f32; 3], r: f32| {
        mesh::cylinder(Vec3::from_array(a), Vec3::from_array(b), r, 16)
    };
    let ball = |c: [f32; 3], r: f32| mesh::icosphere(Vec3::from_array(c), r, 2);
    let mut parts = vec![];
    for z in [-0.58, 0.58] {
        parts.push(rod([-1.1, 1.56, z], [0.25, 1.56, z], 0.014));
        for x in [-1.0, 0.15] {
            parts.push(rod([x, 1.38, z], [x, 1.56, z], 0.012));
        }
        parts.push(ball([0.72, 1.0, 1.55 * z], 0.075));
        parts.push(ball([2.07, 0.62, z], 0.1));
        parts.push(ball([-2.08, 0.68, z], 0.09));
    }
    for i in 0..7 {
        let x = -1.04 + 0.2 * i as f32;
        parts.push(rod([x, 1.56, -0.6], [x, 1.56, 0.6], 0.01));
    }
    for i in 0..10 {
        let half = Vec3::new(0.012, 0.005, 0.4);
        parts.push(mesh::cuboid(Vec3::new(2.115, 0.4 + 0.03 * i as f32, 0.0), half));
    }
    parts.push(rod([2.14, 0.34, -0.8], [2.14, 0.34, 0.8], 0.05));
    parts.push(rod([-2.14, 0.36, -0.8], [-2.14, 0.36, 0.8], 0.05));
    parts.push(rod([-1.15, 1.4, 0.5], [-1.45, 2.05, 0.5], 0.006));
    mesh::join(&parts)
}

/// Four seats and a steering wheel, seen through the windows.
fn interior() -> Mesh {
    let mut parts = vec![];
    for (x, z) in [(0.1, 0.36), (0.1, -0.36), (-0.8, 0.36), (-0.8, -0.36)] {
        parts.push(mesh::cuboid(Vec3::new(x, 0.96, z), Vec3::new(0.22, 0.06, 0.24)));
        parts.push(mesh::cuboid(Vec3::new(x - 0.22, 1.14, z), Vec3::new(0.05, 0.2, 0.22)));
    }
    let wheel = Vec3::new(0.5, 1.06, 0.36);
    parts.push(mesh::torus(wheel, Vec3::new(-0.9, 0.45, 0.0), [0.16, 0.014], 24, 8));
    mesh::join(&parts)
}

/// Hub and five spokes, inside the tyre.
fn rim() -> Mesh {
    let mut parts = vec![mesh::cylinder(Vec3::Z * -0.05, Vec3::Z * 0.05, 0.06, 32)];
    for i in 0..5 {
        let angle = std::f32::consts::TAU * i as f32 / 5.0;
        let out = Vec3::new(angle.cos(), angle.sin(), 0.0);
        parts.push(mesh::cylinder(out * 0.03, out * 0.17, 0.02, 8));
    }
    mesh::join(&parts)
}
