//! Micro-scenes with closed answers. In all but the last three the light falls along -y, so that a
//! point (x, z) of every plane has the same place in the map, and depth falls with height.

use super::builder::Builder;
use super::mesh;
use crate::Scene;
use glam::{DVec3, Vec3};

/// Occluder x in -3..=0, z in -3..=3 at y = 2, over a floor of 8 x 8 m at y = 0: the shadow's edge
/// is the line x = 0.
pub fn half_plane() -> Scene {
    let mut b = Builder::new("half_plane", DVec3::NEG_Y);
    b.floor(4.0);
    let material = b.material("occluder", [0.3, 0.4, 0.7]);
    let centre = Vec3::new(-1.5, 2.0, 0.0);
    b.add("occluder", material, mesh::quad(centre, Vec3::Z * 3.0, Vec3::X * 1.5));
    // From below the occluder's height, so that it hides none of its shadow.
    let (eye, target) = (DVec3::new(3.4, 1.9, 1.8), DVec3::new(-0.5, 0.0, -0.2));
    b.camera("edge", eye, target, 38.0);
    b.orbit(eye, target, 38.0, 20.0);
    b.0
}

/// Figure 2.9 of the thesis: receiver C at y = 0, B at y = 2 over x, z in -2..=2, A at y = 10 over
/// x in -3..=0, z in -3..=3. Under B everything is dark; A's edge at x = 0 falls on B alone, and
/// bleeds through to C where a filter keeps mean and variance only. The distances are A to B 8 m
/// and B to C 2 m, ratio 4 (Chebyshev leaks 0.308 there, specification 5.3).
pub fn three_planes() -> Scene {
    let mut b = Builder::new("three_planes", DVec3::NEG_Y);
    b.floor(4.0);
    let middle = b.material("B", [0.3, 0.6, 0.3]);
    b.add("B", middle, mesh::quad(Vec3::Y * 2.0, Vec3::Z * 2.0, Vec3::X * 2.0));
    let top = b.material("A", [0.3, 0.4, 0.7]);
    let centre = Vec3::new(-1.5, 10.0, 0.0);
    b.add("A", top, mesh::quad(centre, Vec3::Z * 3.0, Vec3::X * 1.5));
    let (eye, target) = (DVec3::new(3.4, 1.85, 2.4), DVec3::new(0.0, 0.0, 0.0));
    b.camera("under B", eye, target, 42.0);
    b.orbit(eye, target, 42.0, 20.0);
    b.0
}

/// A receiver of 6 x 6 m through the origin, tilted by 30 degrees about z (it rises towards +x),
/// and a quad of 2 x 2 m at y = 2.5 above the origin.
pub fn slanted_receiver() -> Scene {
    let mut b = Builder::new("slanted_receiver", DVec3::NEG_Y);
    let ground = b.material("receiver", [0.7; 3]);
    let (sin, cos) = 30.0_f32.to_radians().sin_cos();
    let uphill = Vec3::new(cos, sin, 0.0);
    b.add("receiver", ground, mesh::quad(Vec3::ZERO, Vec3::Z * 3.0, uphill * 3.0));
    let material = b.material("occluder", [0.3, 0.4, 0.7]);
    b.add("occluder", material, mesh::quad(Vec3::Y * 2.5, Vec3::Z, Vec3::X));
    let (eye, target) = (DVec3::new(-3.4, 2.2, 2.4), DVec3::new(0.1, 0.0, 0.0));
    b.camera("slope", eye, target, 38.0);
    b.orbit(eye, target, 38.0, 20.0);
    b.0
}

/// Radius 1 m about the origin, 1,280 triangles, slanted light: the terminator is its shadow.
pub fn closed_sphere() -> Scene {
    let mut b = Builder::new("closed_sphere", DVec3::new(-1.0, -0.6, -0.2));
    let material = b.material("sphere", [0.7; 3]);
    b.add("sphere", material, mesh::icosphere(Vec3::ZERO, 1.0, 3));
    let eye = DVec3::new(-1.2, 0.5, 2.8);
    b.camera("terminator", eye, DVec3::ZERO, 39.0);
    b.orbit(eye, DVec3::ZERO, 39.0, 40.0);
    b.0
}

/// Side 1 m, its underside 0.25 m above a floor of 5 x 5 m, slanted light.
pub fn cube() -> Scene {
    let mut b = Builder::new("cube", DVec3::new(-0.5, -1.0, -0.35));
    b.floor(2.5);
    let material = b.material("cube", [0.8, 0.35, 0.2]);
    b.add("cube", material, mesh::cuboid(Vec3::Y * 0.75, Vec3::splat(0.5)));
    let (eye, target) = (DVec3::new(-2.6, 2.0, 1.8), DVec3::new(-0.2, 0.25, -0.1));
    b.camera("shadow", eye, target, 36.0);
    b.orbit(eye, target, 36.0, 30.0);
    b.0
}

/// A floor of 8 x 8 m under light 20 degrees above the horizon: the hardest case for bias.
pub fn empty_plane() -> Scene {
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let mut b = Builder::new("empty_plane", DVec3::new(cos, -sin, 0.0));
    b.floor(4.0);
    let (eye, target) = (DVec3::new(3.0, 3.0, 3.0), DVec3::ZERO);
    b.camera("plane", eye, target, 45.0);
    b.orbit(eye, target, 45.0, 30.0);
    b.0
}
