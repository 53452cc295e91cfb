//! Meshes and scenes built here, independent of the generators.

use dapple_scene::{Instance, Material, Mesh, Scene};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::HashMap;

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

pub fn unit_vector(rng: &mut Pcg64) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if (0.1..=1.0).contains(&v.length()) {
            return v.normalize();
        }
    }
}

pub fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { positions, triangles, ..Mesh::default() }
}

pub fn scene(meshes: Vec<(Mesh, DAffine3)>) -> Scene {
    let instance = |(i, t): (usize, DAffine3)| Instance { mesh: i as u32, transform: t };
    let (meshes, transforms): (Vec<_>, Vec<_>) = meshes.into_iter().unzip();
    Scene {
        meshes,
        materials: vec![Material::default()],
        instances: transforms.into_iter().enumerate().map(instance).collect(),
        ..Scene::default()
    }
}

pub fn placed(mesh: Mesh) -> Scene {
    scene(vec![(mesh, DAffine3::IDENTITY)])
}

/// A unit sphere of 20 * 4^levels triangles with shared vertices.
#[rustfmt::skip]
pub fn icosphere(levels: u32) -> Mesh {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = [
        (-1.0, g, 0.0), (1.0, g, 0.0), (-1.0, -g, 0.0), (1.0, -g, 0.0),
        (0.0, -1.0, g), (0.0, 1.0, g), (0.0, -1.0, -g), (0.0, 1.0, -g),
        (g, 0.0, -1.0), (g, 0.0, 1.0), (-g, 0.0, -1.0), (-g, 0.0, 1.0),
    ]
    .map(|(x, y, z)| Vec3::new(x, y, z).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
        [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let m = positions[p as usize] + positions[q as usize];
                    positions.push(m.normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    mesh(positions, triangles)
}

/// The cube -1..=1 of 12 triangles and 8 shared vertices.
#[rustfmt::skip]
pub fn cube() -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    let triangles = vec![
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ];
    mesh((0..8).map(corner).collect(), triangles)
}

/// A closed mesh, star-shaped from its origin, with radii in 0.5..1.5.
pub fn star(levels: u32, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let mut star = icosphere(levels);
    for p in &mut star.positions {
        *p *= rng.random_range(0.5..1.5_f32);
    }
    star
}

/// A quadrilateral of n × n cells between four corners a, b, c, d in order; uv 0..1 from a.
pub fn patch(corners: [DVec3; 4], n: u32) -> Mesh {
    let [a, b, c, d] = corners;
    let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..=n {
        for x in 0..=n {
            let (s, t) = (f64::from(x) / f64::from(n), f64::from(y) / f64::from(n));
            positions.push(a.lerp(b, s).lerp(d.lerp(c, s), t).as_vec3());
            uvs.push(Vec2::new(s as f32, t as f32));
        }
    }
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x;
            triangles.extend([[i, i + 1, i + n + 1], [i + 1, i + n + 2, i + n + 1]]);
        }
    }
    Mesh { uvs, ..mesh(positions, triangles) }
}

/// The rectangle x0..x1 × z0..z1 at height y.
pub fn level_patch(x: [f64; 2], y: f64, z: [f64; 2], n: u32) -> Mesh {
    let corner = |i: usize, j: usize| DVec3::new(x[i], y, z[j]);
    patch([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], n)
}
