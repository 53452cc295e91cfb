//! Random occluders, ill-natured ones among them.

use super::truth::Case;
use glam::{Mat4, Vec3, Vec4};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub const NEAR: f32 = 0.1;

/// Odd sizes first: one pixel, a tile and a bit, a row, a column.
pub const SIZES: [[u32; 2]; 7] = [[1, 1], [33, 9], [67, 1], [1, 50], [64, 16], [37, 41], [96, 40]];

/// Looks along -z; reversed depth without a far plane.
pub fn perspective([width, height]: [u32; 2]) -> Mat4 {
    let aspect = width as f32 / height as f32;
    Mat4::from_cols(
        Vec4::new(1.0 / aspect.max(1.0), 0.0, 0.0, 0.0),
        Vec4::new(0.0, aspect.min(1.0), 0.0, 0.0),
        Vec4::new(0.0, 0.0, 0.0, -1.0),
        Vec4::new(0.0, 0.0, NEAR, 0.0),
    )
}

/// Takes positions in pixels, y down, z the depth.
pub fn pixels([width, height]: [u32; 2]) -> Mat4 {
    Mat4::from_cols(
        Vec4::new(2.0 / width as f32, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -2.0 / height as f32, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0, 0.0),
        Vec4::new(-1.0, 1.0, 0.0, 1.0),
    )
}

/// The kinds that [`case`] knows.
pub const KINDS: u64 = 6;

/// A case of one kind, by seed.
pub fn case(kind: u64, seed: u64) -> Case {
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ kind << 48);
    let size = SIZES[random.random_range(0..SIZES.len())];
    let count = random.random_range(1..24);
    let mut case = Case { size, clip: perspective(size), positions: vec![], triangles: vec![] };
    if kind >= 4 {
        case.clip = pixels(size);
    }
    for _ in 0..count {
        let triangle = match kind {
            0 => triangle(&mut random, 3.0, 3.0),
            1 => sliver(&mut random),
            // Through the near plane and behind the eye.
            2 => triangle(&mut random, 2.0, 0.0),
            // Far beyond the guard band.
            3 => triangle(&mut random, 1e6, 1.0),
            // Corners on centres and edges of pixels: every tie there is.
            4 => grid(&mut random, size),
            _ => return sheet(&mut random, size),
        };
        let first = case.positions.len() as u32;
        case.positions.extend(triangle);
        case.triangles.push([first, first + 1, first + 2]);
    }
    case
}

fn triangle(random: &mut impl Rng, extent: f32, distance: f32) -> [Vec3; 3] {
    let middle = Vec3::new(0.0, 0.0, -distance);
    std::array::from_fn(|_| {
        let p = Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        middle + p * extent * Vec3::new(1.0, 1.0, if extent > 10.0 { 1e-3 } else { 0.98 })
    })
}

fn sliver(random: &mut impl Rng) -> [Vec3; 3] {
    let [a, b, c] = triangle(random, 3.0, 3.1);
    let along = random.random_range(-0.5..1.5);
    [a, b, a + along * (b - a) + c * 10f32.powi(random.random_range(-8..-2))]
}

fn grid(random: &mut impl Rng, [width, height]: [u32; 2]) -> [Vec3; 3] {
    std::array::from_fn(|_| {
        let x = random.random_range(-4..2 * width as i32 + 4) as f32 * 0.5;
        let y = random.random_range(-4..2 * height as i32 + 4) as f32 * 0.5;
        Vec3::new(x, y, random.random_range(0.01..1.0))
    })
}

/// A bumpy sheet of joined triangles, in pixels.
fn sheet(random: &mut impl Rng, size: [u32; 2]) -> Case {
    let side = random.random_range(2..9u32);
    let [width, height] = size.map(|s| s as f32);
    let mut positions = Vec::new();
    for i in 0..side * side {
        let at = |k: u32| (k as f32 / (side - 1) as f32) * 1.2 - 0.1;
        let mut jitter = || random.random_range(-0.3..0.3) / side as f32;
        let (x, y) = (at(i % side) + jitter(), at(i / side) + jitter());
        positions.push(Vec3::new(x * width, y * height, 0.5 + jitter()));
    }
    let cells = (0..side * (side - 1)).filter(|i| i % side != side - 1);
    let triangles =
        cells.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    Case { size, clip: pixels(size), positions, triangles }
}
