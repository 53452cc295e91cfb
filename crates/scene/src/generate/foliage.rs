//! Grass, trees and leaves: translucent blades, quads and strips above an opaque ground, lit from
//! straight above.
//!
//! Based on: C. Voicu, "Real-time volumetric shadows for dynamic rendering", MSc thesis, Imperial
//! College London, 2011, section 6 (the scenes *Trees*, *Grass* and *Dense grass*).
//! Deviations: the models are rebuilt from the sizes and opacities that are known, not from their
//! files; leaves are quads and blades, without textures.
//!
//! Built from arithmetic and square roots alone, so that a seed gives the same bits everywhere.

use super::builder::Builder;
use super::mesh;
use super::random::{in_ball, on_circle};
use crate::{Mesh, Scene};
use glam::{DAffine3, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Opacity of grass and leaves.
pub const LEAF_OPACITY: f32 = 176.0 / 255.0;

/// Half the side of the square that grass grows on, metres.
const FIELD: f32 = 3.0;

/// `count` blades of 8 triangles over 6 x 6 m.
pub fn grass(name: &str, count: u32, seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::outdoors(name);
    let material = b.translucent("grass", [0.16, 0.34, 0.06], LEAF_OPACITY);
    b.add("grass", material, field(&mut rng, count, [-FIELD, FIELD]));
    field_views(&mut b);
    b.0
}

/// Dense grass (222 blades a square metre) on the left, sparse grass (14) on the right.
pub fn mixed(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::outdoors("mixed");
    let material = b.translucent("grass", [0.16, 0.34, 0.06], LEAF_OPACITY);
    b.add("dense grass", material, field(&mut rng, 4_000, [-FIELD, 0.0]));
    b.add("sparse grass", material, field(&mut rng, 250, [0.0, FIELD]));
    field_views(&mut b);
    b.0
}

fn field_views(b: &mut Builder) {
    let (eye, target) = (DVec3::new(0.0, 6.0, 13.0), DVec3::new(0.0, 0.0, 0.4));
    b.camera("front", eye, target, 28.0);
    b.camera("low", DVec3::new(1.6, 1.8, 5.2), DVec3::new(0.0, 0.3, 0.0), 45.0);
    b.orbit(eye, target, 28.0, 30.0);
}

/// Blades with their roots at `x` in the range and z over the field, leaning and drooping.
fn field(rng: &mut Pcg64, count: u32, x: [f32; 2]) -> Mesh {
    const SEGMENTS: u16 = 4;
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let root = Vec3::new(rng.random_range(x[0]..x[1]), 0.0, rng.random_range(-FIELD..FIELD));
        // A blade droops over its flat side, more or less.
        let lean = on_circle(rng);
        let across = (lean.cross(Vec3::Y) + 0.5 * on_circle(rng)).normalize_or(Vec3::X);
        let (height, reach) = (rng.random_range(0.5..1.1), rng.random_range(0.2..0.9));
        let half_width = rng.random_range(0.03..0.06);
        let at = |i: u16| {
            let t = f32::from(i) / f32::from(SEGMENTS);
            root + lean * (reach * t * t) + Vec3::Y * (height * t * (1.0 - 0.25 * t))
        };
        let half = |i: u16| across * (half_width * (1.0 - 0.2 * f32::from(i)));
        push_strip(&mut mesh, (0..=SEGMENTS).map(|i| (at(i), half(i))));
    }
    mesh
}

/// Appends a strip of quads through points with half of its width to each side: two triangles
/// between two points, which share their corners.
fn push_strip(mesh: &mut Mesh, points: impl Iterator<Item = (Vec3, Vec3)>) {
    let first = mesh.positions.len() as u32;
    for (at, half) in points {
        mesh.positions.extend([at - half, at + half]);
    }
    let last = mesh.positions.len() as u32;
    for a in (first + 2..last).step_by(2) {
        mesh.triangles.extend([[a - 2, a - 1, a + 1], [a - 2, a + 1, a]]);
    }
    // The direction at a point is that between its neighbours.
    for a in (first..last).step_by(2) {
        let (from, to) = (a.saturating_sub(2).max(first), (a + 2).min(last - 2));
        let along = mesh.positions[to as usize] - mesh.positions[from as usize];
        let across = mesh.positions[a as usize + 1] - mesh.positions[a as usize];
        mesh.normals.extend([across.cross(along).normalize_or(Vec3::Y); 2]);
    }
}

/// An upright column of eight sides through rings of (centre, radius), closed at the top.
fn trunk(rings: &[(Vec3, f32)]) -> Mesh {
    const H: f32 = std::f32::consts::FRAC_1_SQRT_2;
    // Counter-clockwise seen from above: from +x towards -z.
    const SPOKES: [[f32; 2]; 8] =
        [[1.0, 0.0], [H, -H], [0.0, -1.0], [-H, -H], [-1.0, 0.0], [-H, H], [0.0, 1.0], [H, H]];
    let spokes = SPOKES.map(|[x, z]| Vec3::new(x, 0.0, z));
    let mut mesh = Mesh::default();
    for &(centre, radius) in rings {
        mesh.positions.extend(spokes.map(|s| centre + s * radius));
        mesh.normals.extend(spokes);
    }
    for ring in 1..rings.len() as u32 {
        for i in 0..8 {
            let (low, high, next) = (8 * (ring - 1), 8 * ring, (i + 1) % 8);
            mesh.triangles.push([low + i, low + next, high + next]);
            mesh.triangles.push([low + i, high + next, high + i]);
        }
    }
    if let Some(&(centre, radius)) = rings.last() {
        let top = mesh.positions.len() as u32;
        mesh.positions.extend(spokes.map(|s| centre + s * radius));
        mesh.normals.extend([Vec3::Y; 8]);
        mesh.triangles.extend((1..7).map(|i| [top, top + i, top + i + 1]));
    }
    mesh
}

/// `count` square leaves in all orientations, anywhere in an ellipsoid.
fn leaves(rng: &mut Pcg64, count: u32, centre: Vec3, radii: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let at = centre + in_ball(rng) * radii;
        let facing = in_ball(rng).normalize_or(Vec3::Y);
        let (u, v) = facing.any_orthonormal_pair();
        let half = rng.random_range(0.05..0.1);
        mesh::append(&mut mesh, &mesh::quad(at, u * half, v * half));
    }
    mesh
}

/// The parts of a plant: name, whether they let light through, geometry with the foot at the origin.
type Plant = Vec<(&'static str, bool, Mesh)>;

/// A trunk and a crown of 4,000 leaves, 6 m high.
fn tree_parts(rng: &mut Pcg64) -> Plant {
    let rings = [(0.0, 0.34), (0.3, 0.24), (2.0, 0.19), (4.6, 0.07)];
    let stem = rings.map(|(y, r)| (Vec3::new(0.04 * y, y, 0.02 * y), r));
    let crown = leaves(rng, 4_000, Vec3::new(0.0, 4.3, 0.0), Vec3::new(2.0, 1.7, 2.0));
    vec![("tree trunk", false, trunk(&stem)), ("tree leaves", true, crown)]
}

/// A trunk and 2,500 strips of 8 quads that hang from a dome, 5.6 m high.
fn willow_parts(rng: &mut Pcg64) -> Plant {
    const QUADS: u16 = 8;
    let rings = [(0.0, 0.5), (0.4, 0.34), (2.4, 0.3), (4.9, 0.12)];
    let stem = rings.map(|(y, r)| (Vec3::new(0.0, y, 0.0), r));
    let mut hanging = Mesh::default();
    for _ in 0..2_500 {
        let out = in_ball(rng) * Vec3::new(1.0, 0.0, 1.0);
        let dome = (1.0 - out.length_squared()).max(0.0).sqrt();
        let start = out * 1.9 + Vec3::Y * (3.8 + 1.7 * dome * rng.random_range(0.6..1.0));
        let length = rng.random_range(0.4..0.95) * (start.y - 0.2);
        let (across, half_width) = (on_circle(rng), rng.random_range(0.012..0.03));
        let swing = out.normalize_or(Vec3::X) * rng.random_range(0.1..0.5);
        let at = |i: u16| {
            let t = f32::from(i) / f32::from(QUADS);
            start + swing * (t * (2.0 - t)) - Vec3::Y * (length * t)
        };
        push_strip(&mut hanging, (0..=QUADS).map(|i| (at(i), across * half_width)));
    }
    vec![("willow trunk", false, trunk(&stem)), ("willow leaves", true, hanging)]
}

/// 90 arching leaves of 16 triangles from one root, 1.3 m high.
fn plant_parts(rng: &mut Pcg64) -> Plant {
    const QUADS: u16 = 8;
    let mut fronds = Mesh::default();
    for _ in 0..90 {
        let out = on_circle(rng);
        let across = out.cross(Vec3::Y);
        let (reach, height) = (rng.random_range(0.4..1.3), rng.random_range(0.8..1.4));
        let half_width = rng.random_range(0.04..0.09);
        let at = |i: u16| {
            let t = f32::from(i) / f32::from(QUADS);
            out * (0.05 + reach * t) + Vec3::Y * (height * t * (1.9 - 1.2 * t))
        };
        // Widest at a third of its length.
        let half = |i: u16| {
            let t = f32::from(i) / f32::from(QUADS);
            across * (half_width * (0.35 + 2.0 * t) * (1.03 - t))
        };
        push_strip(&mut fronds, (0..=QUADS).map(|i| (at(i), half(i))));
    }
    vec![("plant", true, fronds)]
}

/// Adds a plant with its foot at `at`.
fn plant(b: &mut Builder, [bark, leaf]: [u32; 2], parts: Plant, at: [f64; 3]) {
    for (name, translucent, part) in parts {
        let mesh = b.mesh(name, if translucent { leaf } else { bark }, part);
        b.place(mesh, DAffine3::from_translation(DVec3::from_array(at)));
    }
}

fn bark_and_leaf(b: &mut Builder) -> [u32; 2] {
    let bark = b.material("bark", [0.2, 0.13, 0.08]);
    [bark, b.translucent("leaf", [0.14, 0.3, 0.06], LEAF_OPACITY)]
}

fn wood_views(b: &mut Builder, fov_y_deg: f64) {
    let (eye, target) = (DVec3::new(0.0, 6.0, 13.0), DVec3::new(0.0, 2.6, 0.0));
    b.camera("front", eye, target, fov_y_deg);
    b.camera("from above", DVec3::new(5.0, 11.0, 7.0), DVec3::new(0.0, 1.5, 0.0), fov_y_deg);
    b.orbit(eye, target, fov_y_deg, 30.0);
}

/// One tree: an opaque trunk under 4,000 leaf quads.
pub fn tree(seed: u64) -> Scene {
    let mut b = Builder::outdoors("tree");
    let materials = bark_and_leaf(&mut b);
    let parts = tree_parts(&mut Pcg64::seed_from_u64(seed));
    plant(&mut b, materials, parts, [0.0; 3]);
    wood_views(&mut b, 32.0);
    b.0
}

/// One willow: an opaque trunk under 20,000 quads in hanging strips.
pub fn willow(seed: u64) -> Scene {
    let mut b = Builder::outdoors("willow");
    let materials = bark_and_leaf(&mut b);
    let parts = willow_parts(&mut Pcg64::seed_from_u64(seed));
    plant(&mut b, materials, parts, [0.0; 3]);
    wood_views(&mut b, 32.0);
    b.0
}

/// The tree, the willow and a low plant in front of them.
pub fn trees(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::outdoors("trees");
    let materials = bark_and_leaf(&mut b);
    plant(&mut b, materials, tree_parts(&mut rng), [-2.75, 0.0, -1.0]);
    plant(&mut b, materials, willow_parts(&mut rng), [2.75, 0.0, -0.5]);
    plant(&mut b, materials, plant_parts(&mut rng), [0.0, 0.0, 3.0]);
    wood_views(&mut b, 40.0);
    b.0
}

/// Two clusters of leaves, 2 m across, one 10 m above the other and a little aside: between them
/// lies five times their own depth of nothing.
pub fn two_far(seed: u64) -> Scene {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut b = Builder::outdoors("two_far");
    let [_, leaf] = bark_and_leaf(&mut b);
    for (name, x, y) in [("upper leaves", -0.4, 11.2), ("lower leaves", 0.4, 1.2)] {
        b.add(name, leaf, leaves(&mut rng, 1_500, Vec3::new(x, y, 0.0), Vec3::ONE));
    }
    let (eye, target) = (DVec3::new(0.0, 7.0, 19.0), DVec3::new(0.0, 5.6, 0.0));
    b.camera("front", eye, target, 44.0);
    b.camera("lower", DVec3::new(0.0, 4.0, 5.5), DVec3::new(0.2, 0.8, 0.0), 42.0);
    b.orbit(eye, target, 44.0, 30.0);
    b.0
}
