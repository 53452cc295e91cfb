//! Primitive shapes. Solids are closed and wind outwards: where two faces meet, their corners are
//! shared or bit-equal copies, so that no ray can pass between them.

use crate::Mesh;
use glam::Vec3;
use std::collections::BTreeMap;
use std::f32::consts::{PI, TAU};

/// Appends the geometry of `part` (not its name or material).
pub fn append(mesh: &mut Mesh, part: &Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(&part.positions);
    mesh.normals.extend_from_slice(&part.normals);
    mesh.uvs.extend_from_slice(&part.uvs);
    mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
}

/// All parts in one mesh.
pub fn join(parts: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    parts.iter().for_each(|part| append(&mut all, part));
    all
}

/// Two triangles a-b-c, a-c-d, flat.
fn push_face(mesh: &mut Mesh, corners: [Vec3; 4]) {
    let [a, b, c, d] = corners;
    let normal = (c - a).cross(d - b).normalize_or(Vec3::Y);
    let n = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.normals.extend([normal; 4]);
    mesh.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
}

/// A parallelogram about `centre`, facing along `half_u` x `half_v`.
pub fn quad(centre: Vec3, half_u: Vec3, half_v: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |u: f32, v: f32| centre + half_u * u + half_v * v;
    push_face(&mut mesh, [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]);
    mesh
}

/// An axis-aligned box: 12 triangles.
pub fn cuboid(centre: Vec3, half: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    // Corner i has the upper x, y, z where bits 0, 1, 2 are set.
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        centre + half * Vec3::new(sign(0), sign(1), sign(2))
    };
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    faces.iter().for_each(|face| push_face(&mut mesh, face.map(corner)));
    mesh
}

/// A capped cylinder from `a` to `b`: 4 triangles a segment (at least 3).
pub fn cylinder(a: Vec3, b: Vec3, radius: f32, segments: u32) -> Mesh {
    let n = segments.max(3);
    let axis = (b - a).normalize_or(Vec3::Y);
    let (u, v) = axis.any_orthonormal_pair();
    // any_orthonormal_pair gives u x v = axis: angles turn counter-clockwise seen from b.
    let spoke = |i: u32| {
        let angle = TAU * (i % n) as f32 / n as f32;
        u * angle.cos() + v * angle.sin()
    };
    let mut mesh = Mesh::default();
    let mut vertex = |p: Vec3, normal: Vec3| {
        mesh.positions.push(p);
        mesh.normals.push(normal);
    };
    for (end, cap) in [(a, -axis), (b, axis)] {
        vertex(end, cap);
        (0..n).for_each(|i| vertex(end + spoke(i) * radius, cap));
    }
    for end in [a, b] {
        (0..n).for_each(|i| vertex(end + spoke(i) * radius, spoke(i)));
    }
    let (top, side) = (n + 1, 2 * (n + 1));
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.push([0, 1 + j, 1 + i]);
        mesh.triangles.push([top, top + 1 + i, top + 1 + j]);
        mesh.triangles.push([side + i, side + j, side + n + j]);
        mesh.triangles.push([side + i, side + n + j, side + n + i]);
    }
    mesh
}

/// A sphere by longitude and latitude, poles on y: 2 * slices * (stacks - 1) triangles. Slices
/// and stacks are at least 3 and 2. Every vertex is shared; there is no seam.
pub fn uv_sphere(centre: Vec3, radius: f32, slices: u32, stacks: u32) -> Mesh {
    let (n, m) = (slices.max(3), stacks.max(2));
    let mut normals = vec![Vec3::Y];
    for s in 1..m {
        let polar = PI * s as f32 / m as f32;
        for i in 0..n {
            let angle = TAU * i as f32 / n as f32;
            let ring = polar.sin();
            normals.push(Vec3::new(ring * angle.cos(), polar.cos(), -ring * angle.sin()));
        }
    }
    normals.push(Vec3::NEG_Y);
    let ring = |s: u32, i: u32| 1 + (s - 1) * n + i % n;
    let last = normals.len() as u32 - 1;
    let mut triangles = vec![];
    for i in 0..n {
        triangles.push([0, ring(1, i), ring(1, i + 1)]);
        triangles.push([last, ring(m - 1, i + 1), ring(m - 1, i)]);
        for s in 1..m - 1 {
            let [a, b, c, d] = [ring(s, i), ring(s + 1, i), ring(s + 1, i + 1), ring(s, i + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    ball(centre, radius, normals, triangles)
}

/// A sphere from an icosahedron, each triangle split in four `subdivisions` times (at most 8):
/// 20 * 4^subdivisions triangles, 10 * 4^subdivisions + 2 shared vertices.
pub fn icosphere(centre: Vec3, radius: f32, subdivisions: u32) -> Mesh {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = [[-1.0, g], [1.0, g], [-1.0, -g], [1.0, -g]]
        .into_iter()
        .flat_map(|[a, b]| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
        .map(Vec3::normalize)
        .collect();
    let mut triangles = hull_of_icosahedron(&points);
    for _ in 0..subdivisions.min(8) {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    ball(centre, radius, points, triangles)
}

/// The faces are the triples of mutually nearest corners, wound outwards.
fn hull_of_icosahedron(points: &[Vec3]) -> Vec<[u32; 3]> {
    // Neighbours on the unit sphere have a dot product of 1/sqrt(5) = 0.447, others -0.447 or -1.
    let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.4;
    let mut faces = vec![];
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in (b + 1..points.len()).filter(|&c| near(a, b) && near(b, c) && near(a, c)) {
                let outwards = points[a].dot(points[b].cross(points[c])) > 0.0;
                let (b, c) = if outwards { (b, c) } else { (c, b) };
                faces.push([a as u32, b as u32, c as u32]);
            }
        }
    }
    faces
}

fn ball(centre: Vec3, radius: f32, normals: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let positions = normals.iter().map(|n| centre + *n * radius).collect();
    Mesh { positions, normals, triangles, ..Mesh::default() }
}

/// A ring of `tube` radius about `centre`, its circle of `radius` perpendicular to `axis`:
/// 2 * segments * sides triangles (at least 3 of each).
pub fn torus(
    centre: Vec3,
    axis: Vec3,
    [radius, tube]: [f32; 2],
    segments: u32,
    sides: u32,
) -> Mesh {
    let (n, m) = (segments.max(3), sides.max(3));
    let axis = axis.normalize_or(Vec3::Y);
    let (u, v) = axis.any_orthonormal_pair();
    let mut mesh = Mesh::default();
    for i in 0..n {
        let angle = TAU * i as f32 / n as f32;
        let spoke = u * angle.cos() + v * angle.sin();
        for s in 0..m {
            let around = TAU * s as f32 / m as f32;
            let normal = spoke * around.cos() + axis * around.sin();
            mesh.positions.push(centre + spoke * radius + normal * tube);
            mesh.normals.push(normal);
            let at = |i: u32, s: u32| i % n * m + s % m;
            let [a, b, c, d] = [at(i, s), at(i + 1, s), at(i + 1, s + 1), at(i, s + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A side view drawn along x and extruded over z in `z_range`. Each column is (x, low y, high y),
/// x growing, low < high: 8 triangles between two columns, and 4 for the ends.
pub fn extrusion(columns: &[[f32; 3]], z_range: [f32; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    let [back, front] = z_range;
    let at = |[x, _, _]: [f32; 3], y: f32, z: f32| Vec3::new(x, y, z);
    for pair in columns.windows(2) {
        let (p, q) = (pair[0], pair[1]);
        let ([_, pl, ph], [_, ql, qh]) = (p, q);
        push_face(
            &mut mesh,
            [at(p, pl, front), at(q, ql, front), at(q, qh, front), at(p, ph, front)],
        );
        push_face(&mut mesh, [at(p, pl, back), at(p, ph, back), at(q, qh, back), at(q, ql, back)]);
        push_face(
            &mut mesh,
            [at(p, ph, front), at(q, qh, front), at(q, qh, back), at(p, ph, back)],
        );
        push_face(
            &mut mesh,
            [at(p, pl, front), at(p, pl, back), at(q, ql, back), at(q, ql, front)],
        );
    }
    if let [first, .., last] = *columns {
        let [_, l, h] = first;
        let end = |c, l, h| [at(c, l, front), at(c, h, front), at(c, h, back), at(c, l, back)];
        push_face(&mut mesh, end(first, l, h));
        let [_, l, h] = last;
        let [a, b, c, d] = end(last, l, h);
        push_face(&mut mesh, [d, c, b, a]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corners(mesh: &Mesh, t: [u32; 3]) -> [Vec3; 3] {
        t.map(|v| mesh.positions[v as usize])
    }

    /// Every directed edge, by the bits of its ends, has exactly one partner the other way round.
    fn assert_closed(mesh: &Mesh) {
        let bits = |p: Vec3| p.to_array().map(f32::to_bits);
        let mut edges: BTreeMap<_, i32> = BTreeMap::new();
        for &t in &mesh.triangles {
            let [a, b, c] = corners(mesh, t).map(bits);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                assert_ne!(p, q, "degenerate edge");
                *edges.entry((p, q)).or_default() += 1;
            }
        }
        for (&(p, q), &n) in &edges {
            assert_eq!((n, edges.get(&(q, p))), (1, Some(&1)), "edge {p:?} {q:?}");
        }
    }

    /// Divergence theorem; positive if wound outwards.
    fn volume(mesh: &Mesh) -> f64 {
        let six = |t: &[u32; 3]| {
            let [a, b, c] = corners(mesh, *t).map(|p| p.as_dvec3());
            a.dot(b.cross(c))
        };
        mesh.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    fn assert_normals_agree(mesh: &Mesh) {
        for &t in &mesh.triangles {
            let [a, b, c] = corners(mesh, t);
            let face = (b - a).cross(c - a).normalize();
            for v in t {
                let n = mesh.normals[v as usize];
                assert!((n.length() - 1.0).abs() < 1e-5 && n.dot(face) > 0.5, "{n} {face}");
            }
        }
    }

    fn solids() -> Vec<(&'static str, Mesh, usize, f64)> {
        let c = Vec3::new(0.3, -2.0, 1.0);
        let sphere = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        let tau = std::f64::consts::TAU;
        vec![
            ("cuboid", cuboid(c, Vec3::new(1.0, 2.0, 3.0)), 12, 48.0),
            ("cylinder", cylinder(c, c + Vec3::new(0.0, 3.0, 4.0), 2.0, 96), 384, tau * 2.0 * 5.0),
            ("uv_sphere", uv_sphere(c, 2.0, 64, 48), 2 * 64 * 47, sphere),
            ("icosphere", icosphere(c, 2.0, 4), 20 * 256, sphere),
            (
                "torus",
                torus(c, Vec3::new(1.0, 1.0, 0.0), [3.0, 0.5], 96, 48),
                2 * 96 * 48,
                tau * 3.0 * tau * 0.125,
            ),
            (
                "extrusion",
                extrusion(&[[0.0, 0.0, 1.0], [1.0, 0.5, 2.0], [3.0, 0.5, 1.0]], [-1.0, 1.0]),
                20,
                2.0 * (1.25 + 2.0),
            ),
        ]
    }

    #[test]
    fn solids_are_closed_and_wind_outwards() {
        for (name, mesh, triangles, expected) in solids() {
            assert_eq!(mesh.triangles.len(), triangles, "{name}");
            assert_closed(&mesh);
            assert_normals_agree(&mesh);
            let v = volume(&mesh);
            assert!((v / expected - 1.0).abs() < 0.01, "{name}: volume {v}, expected {expected}");
        }
    }

    #[test]
    #[should_panic(expected = "edge")]
    fn a_missing_triangle_opens_a_solid() {
        let mut mesh = icosphere(Vec3::ZERO, 1.0, 1);
        mesh.triangles.pop();
        assert_closed(&mesh);
    }

    #[test]
    fn icosphere_counts_are_eulers() {
        for n in 0..5 {
            let mesh = icosphere(Vec3::ZERO, 1.0, n);
            assert_eq!(mesh.triangles.len(), 20 << (2 * n));
            assert_eq!(mesh.positions.len(), (10 << (2 * n)) + 2);
        }
    }

    #[test]
    fn a_quad_faces_along_u_cross_v() {
        let mesh = quad(Vec3::Y, Vec3::Z * 2.0, Vec3::X);
        assert_eq!(mesh.normals, [Vec3::Y; 4]);
        assert_normals_agree(&mesh);
    }

    fn config() -> ProptestConfig {
        let cases = std::env::var("PROPTEST_CASES").ok().and_then(|c| c.parse().ok());
        ProptestConfig::with_cases(cases.unwrap_or(32))
    }

    proptest! {
        #![proptest_config(config())]
        #[test]
        fn solids_are_closed_at_every_size_and_axis(
            scale in -6.0f32..6.0, x in -1.0f32..1.0, y in -1.0f32..1.0, z in 0.1f32..1.0, n in 3u32..20,
        ) {
            let s = 10.0f32.powf(scale);
            let axis = Vec3::new(x, y, z) * s;
            assert_closed(&cylinder(Vec3::ZERO, axis, 0.1 * s, n));
            assert_closed(&torus(Vec3::ZERO, axis, [s, 0.2 * s], n, n));
            assert_closed(&uv_sphere(Vec3::ZERO, s, n, n));
            assert_closed(&cuboid(Vec3::ZERO, axis.abs().max(Vec3::splat(0.01 * s))));
        }
    }
}
