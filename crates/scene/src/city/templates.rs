//! The shapes that a city's scene places again and again: a storey of a facade, and a tree.

use crate::{Mesh, Texture};
use glam::{Vec2, Vec3};

/// Width and height of the storey's template, metres.
pub const STOREY: [f32; 2] = [10.0, 3.0];

/// Where a storey's upright strips end, metres from its left end, and whether each is a window:
/// five of wall, three of window. Exact in `f32`, also when placed kilometres away.
///
/// Every strip runs from floor to floor. A strip of wall below windows would meet corners within
/// its edge, and rasterisers, which move corners by parts of a pixel, leave gaps there through
/// which a building's inside shows.
pub const STRIPS: [(f32, bool); 8] = [
    (0.9375, false),
    (2.4375, true),
    (3.34375, false),
    (4.25, false),
    (5.75, true),
    (7.5625, false),
    (9.0625, true),
    (10.0, false),
];

/// One storey of a facade seen from outside: 8 quads side by side, facing +z, the left end at the
/// origin.
pub fn storey() -> Mesh {
    let mut mesh = Mesh { name: "storey".into(), ..Mesh::default() };
    let ends = std::iter::once(0.0).chain(STRIPS.iter().map(|s| s.0));
    for x in ends {
        mesh.positions.extend([Vec3::new(x, 0.0, 0.0), Vec3::new(x, STOREY[1], 0.0)]);
    }
    mesh.normals = vec![Vec3::Z; mesh.positions.len()];
    for strip in 0..STRIPS.len() as u32 {
        let [a, d, b, c] = [2 * strip, 2 * strip + 1, 2 * strip + 2, 2 * strip + 3];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// A tree of radius 1 and height 1: two upright quads that cross in the trunk.
pub fn tree() -> Mesh {
    let mut mesh = Mesh { name: "tree".into(), ..Mesh::default() };
    for (along, normal) in [(Vec3::X, Vec3::Z), (Vec3::NEG_Z, Vec3::X)] {
        let n = mesh.positions.len() as u32;
        for (u, v) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)] {
            mesh.positions.push(along * (2.0 * u - 1.0) + Vec3::Y * (1.0 - v));
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
        mesh.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    }
    mesh
}

/// Side of the tree's texture, texels.
const SIDE: u32 = 64;

/// A crown with holes on a thin trunk, cut out by its alpha.
pub fn foliage() -> Texture {
    let texel = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        // From -63 to 63, the crown's middle at a third of the height.
        let (dx, dy) = (2 * x as i32 + 1 - SIDE as i32, 2 * y as i32 + 1 - 2 * SIDE as i32 / 3);
        let crown = dx * dx + (3 * dy / 2) * (3 * dy / 2) < (SIDE * SIDE) as i32;
        let leaf = crown && scatter(x / 3, y / 3) % 100 < 72;
        let trunk = dx.abs() < 5 && y >= SIDE / 3;
        match (leaf, trunk) {
            (true, _) => [70, 104, 48, 255],
            (false, true) => [84, 66, 48, 255],
            (false, false) => [70, 104, 48, 0],
        }
    };
    let texels = (0..SIDE * SIDE).map(texel).collect();
    Texture { name: "foliage".into(), width: SIDE, height: SIDE, texels }
}

/// A number without visible order from two others.
fn scatter(x: u32, y: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}
