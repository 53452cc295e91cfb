//! Rasterised depths against closed forms, and against a point-in-triangle test at texel centres.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::Gpu;
use dapple_gpu::light_space::{AlphaTexture, LightSpaceMesh, LightSpaceVertex, TriangleGroup};
use dapple_shadows::filtering::gpu::{DepthSource, Filter};
use dapple_shadows::filtering::gpu_depth::{DepthRaster, DepthRasterError};
use dapple_shadows::filtering::{DepthMap, Estimator, Settings};
use gpu_support::{exclusive_gpu, receivers, rng};
use rand::RngExt;

/// Interpolation of depths in f32 over a triangle that spans the map a few times.
const INTERPOLATION: f64 = 2e-6;
/// Rasterisers snap vertices to 1/256 texel; centres nearer to an edge may go either way.
const SNAP_TEXELS: f64 = 1.0 / 64.0;

fn vertex(u: f64, v: f64, w: f64, z: f64, uv: [f64; 2]) -> LightSpaceVertex {
    LightSpaceVertex {
        position: [(u * w) as f32, (v * w) as f32, w as f32],
        z: z as f32,
        uv: uv.map(|x| x as f32),
    }
}

fn opaque(vertices: Vec<LightSpaceVertex>) -> LightSpaceMesh {
    let count = vertices.len() as u32;
    LightSpaceMesh {
        vertices,
        indices: (0..count).collect(),
        groups: vec![TriangleGroup { first: 0, count, alpha: None, opacity: 1.0 }],
        textures: Vec::new(),
    }
}

fn draw(gpu: &Gpu, mesh: &LightSpaceMesh, width: u32, height: u32) -> Vec<f32> {
    let raster = DepthRaster::new(gpu, mesh, width, height).unwrap();
    let mut frame = gpu.frame();
    raster.record(&mut frame);
    let times = frame.finish().unwrap();
    gpu.check().unwrap();
    if gpu.abilities.timestamps {
        let names: Vec<_> = times.passes.iter().map(|p| p.0).collect();
        assert_eq!(names, ["depth", "depth-copy"]);
    }
    raster.read(gpu).unwrap()
}

fn centre(i: usize, width: u32, height: u32) -> (f64, f64) {
    let (x, y) = (i % width as usize, i / width as usize);
    ((x as f64 + 0.5) / f64::from(width), (y as f64 + 0.5) / f64::from(height))
}

/// Largest difference from a function of map coordinates.
fn worst(depths: &[f32], width: u32, height: u32, want: impl Fn(f64, f64) -> f64) -> f64 {
    assert_eq!(depths.len(), (width * height) as usize);
    depths.iter().enumerate().fold(0.0, |worst, (i, &z)| {
        let (u, v) = centre(i, width, height);
        worst.max((f64::from(z) - want(u, v)).abs())
    })
}

#[test]
fn a_tilted_plane_under_parallel_light() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let plane = |u: f64, v: f64| 0.2 + 0.3 * u + 0.15 * v;
    let corner = |u, v| vertex(u, v, 1.0, plane(u, v), [0.0; 2]);
    // Beyond the map on every side.
    let mesh = opaque(vec![corner(-0.5, -0.5), corner(3.0, -0.5), corner(-0.5, 3.5)]);
    for (w, h) in [(1, 1), (3, 5), (64, 64), (257, 129), (65, 300)] {
        let depths = draw(gpu, &mesh, w, h);
        let error = worst(&depths, w, h, plane);
        assert!(error < INTERPOLATION, "{w}x{h}: {error}");
        // The control: half a texel off is seen.
        let half = 0.5 / f64::from(w);
        assert!(worst(&depths, w, h, |u, v| plane(u + half, v)) > 10.0 * INTERPOLATION);
    }
}

#[test]
fn a_tilted_plane_under_perspective_light() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    // Light at the origin looking along +d, half angle of tangent 1, near 1, far 9. The plane
    // d = 4 + 0.8 x + 0.5 y in world space; a ray through (u, v) has x = (2 u - 1) d.
    let distance = |u: f64, v: f64| 4.0 / (1.0 - 0.8 * (2.0 * u - 1.0) - 0.5 * (2.0 * v - 1.0));
    let z = |d: f64| (d - 1.0) / 8.0;
    let corner = |x: f64, y: f64| {
        let d = 4.0 + 0.8 * x + 0.5 * y;
        vertex(0.5 + 0.5 * x / d, 0.5 + 0.5 * y / d, d, z(d), [0.0; 2])
    };
    // The third corner lies behind the light.
    let mesh = opaque(vec![
        corner(-3.0, -60.0),
        corner(60.0, 60.0),
        corner(-3.0, 60.0),
        corner(-3.0, -60.0),
        corner(60.0, -60.0),
        corner(60.0, 60.0),
    ]);
    assert!(mesh.vertices.iter().any(|v| v.position[2] < 0.0));
    let (w, h) = (129, 65);
    let depths = draw(gpu, &mesh, w, h);
    let mut compared = 0;
    let mut largest = 0.0f64;
    for (i, &got) in depths.iter().enumerate() {
        let (u, v) = centre(i, w, h);
        let d = distance(u, v);
        let x = (2.0 * u - 1.0) * d;
        if x < -2.9 {
            continue;
        }
        let want = if d > 0.0 && (0.0..=1.0).contains(&z(d)) { z(d) } else { 1.0 };
        largest = largest.max((f64::from(got) - want).abs());
        compared += 1;
    }
    eprintln!("perspective plane: {largest:.1e} over {compared} texels");
    assert!(compared > 4000, "{compared}");
    // Ten times coarser than parallel light: 1/w is interpolated over a triangle whose corners
    // lie 20 times as far out as the map's.
    assert!(largest < 10.0 * INTERPOLATION, "{largest}");
}

#[test]
fn a_soup_is_a_point_in_triangle_test_at_texel_centres() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let mut rng = rng(5);
    let mut corners = Vec::new();
    for _ in 0..200 {
        let (u, v) = (rng.random_range(-0.1..1.1), rng.random_range(-0.1..1.1));
        for _ in 0..3 {
            let (du, dv) = (rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
            corners.push(vertex(u + du, v + dv, 1.0, rng.random_range(0.05..0.95), [0.0; 2]));
        }
    }
    let mesh = opaque(corners.clone());
    for (w, h) in [(64, 64), (257, 129)] {
        let depths = draw(gpu, &mesh, w, h);
        let (mut near_edges, mut wrong, mut shifted) = (0, 0, 0);
        for (i, &got) in depths.iter().enumerate() {
            let (u, v) = centre(i, w, h);
            let (z, close) = soup(&corners, u, v, w, h);
            let off = (f64::from(got) - z).abs() > SOUP;
            let (moved, _) = soup(&corners, u + 0.5 / f64::from(w), v, w, h);
            shifted += usize::from((f64::from(got) - moved).abs() > SOUP);
            if close { near_edges += 1 } else { wrong += usize::from(off) }
        }
        let share = near_edges as f64 / depths.len() as f64;
        eprintln!("{w}x{h}: {wrong} wrong, {:.1} % near edges", 100.0 * share);
        assert_eq!(wrong, 0);
        assert!(share < 0.25, "{share}");
        assert!(shifted > depths.len() / 20, "half a texel off is not seen: {shifted}");
    }
}

/// Depth of a small triangle as steep as any here: its slope may be a depth of 1 a few texels,
/// times the 1/256 texel of vertex snapping.
const SOUP: f64 = 2e-2;

/// Smallest depth over (u, v), and whether an edge that matters passes within [`SNAP_TEXELS`].
fn soup(corners: &[LightSpaceVertex], u: f64, v: f64, w: u32, h: u32) -> (f64, bool) {
    let (w, h) = (f64::from(w), f64::from(h));
    let (mut least, mut close) = (1.0f64, false);
    for t in corners.chunks(3) {
        let p: Vec<[f64; 2]> = t
            .iter()
            .map(|c| [f64::from(c.position[0]) * w, f64::from(c.position[1]) * h])
            .collect();
        let q = [u * w, v * h];
        let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let area = cross(p[0], p[1], p[2]);
        // Barycentric coordinates, and the signed distance to the nearest edge, positive inside.
        let (mut z, mut nearest) = (0.0, f64::INFINITY);
        for (k, corner) in t.iter().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let share = cross(p[i], p[j], q) / area;
            let length = (p[j][0] - p[i][0]).hypot(p[j][1] - p[i][1]);
            z += share * f64::from(corner.z);
            nearest = nearest.min(share * area.abs() / length);
        }
        if nearest.abs() < SNAP_TEXELS {
            close = true;
        }
        if nearest >= 0.0 {
            least = least.min(z);
        }
    }
    (least, close)
}

#[test]
fn holes_follow_the_nearest_texel_and_repeat() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let texture = AlphaTexture { width: 2, height: 3, alpha: vec![1.0, 0.0, 0.4, 0.6, 0.1, 0.5] };
    // uv from -1 to 2 over the map: the texture repeats three times.
    let uv = |u: f64| 3.0 * u - 1.0;
    let corner = |u: f64, v: f64| vertex(u, v, 1.0, 0.25, [uv(u), uv(v)]);
    let mut mesh = opaque(vec![
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(0.0, 1.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ]);
    mesh.groups[0].alpha = Some((0, 0.5));
    mesh.textures.push(texture.clone());
    // An opaque floor in a second group.
    let floor = |u: f64, v: f64| vertex(u, v, 1.0, 0.75, [0.0; 2]);
    mesh.vertices.extend([floor(-1.0, -1.0), floor(3.0, -1.0), floor(-1.0, 3.0)]);
    mesh.indices.extend(6..9);
    mesh.groups.push(TriangleGroup { first: 6, count: 3, alpha: None, opacity: 1.0 });
    // 50 and 52 texels: no texel centre lies on a border between alphas.
    let (w, h) = (50, 52);
    let depths = draw(gpu, &mesh, w, h);
    let want = |u: f64, v: f64, flip: bool| {
        let x = (uv(u).rem_euclid(1.0) * 2.0) as usize;
        let y = (uv(v).rem_euclid(1.0) * 3.0) as usize;
        let y = if flip { 2 - y } else { y };
        if texture.alpha[y * 2 + x] >= 0.5 { 0.25 } else { 0.75 }
    };
    assert!(worst(&depths, w, h, |u, v| want(u, v, false)) < INTERPOLATION);
    // The control: a texture upside down is seen.
    assert!(worst(&depths, w, h, |u, v| want(u, v, true)) > 0.4);
}

#[test]
fn depths_outside_the_range_are_dropped_fragment_by_fragment() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let plane = |u: f64| 3.0 * u - 1.0;
    let corner = |u, v| vertex(u, v, 1.0, plane(u), [0.0; 2]);
    let mesh = opaque(vec![corner(-0.5, -0.5), corner(2.5, -0.5), corner(-0.5, 2.5)]);
    let depths = draw(gpu, &mesh, 64, 4);
    let want = |u: f64, _: f64| if (0.0..=1.0).contains(&plane(u)) { plane(u) } else { 1.0 };
    assert!(worst(&depths, 64, 4, want) < 4.0 * INTERPOLATION);
    // An empty mesh leaves an empty map.
    assert_eq!(draw(gpu, &LightSpaceMesh::default(), 3, 2), [1.0; 6]);
    let refused = DepthRaster::new(gpu, &mesh, 0, 4);
    assert!(matches!(refused, Err(DepthRasterError::EmptyMap { .. })));
    let refused = DepthRaster::new(gpu, &mesh, 1 << 17, 1);
    assert!(matches!(refused, Err(DepthRasterError::Gpu(_))));
}

#[test]
fn filters_read_rasterised_depths_without_a_copy() {
    let Some((gpu, _lock)) = exclusive_gpu() else { return };
    let corner = |u, v, z| vertex(u, v, 1.0, z, [0.0; 2]);
    let mesh = opaque(vec![
        corner(0.2, 0.2, 0.3),
        corner(0.8, 0.3, 0.4),
        corner(0.4, 0.9, 0.5),
        corner(-1.0, -1.0, 0.8),
        corner(3.0, -1.0, 0.8),
        corner(-1.0, 3.0, 0.8),
    ]);
    let raster = DepthRaster::new(gpu, &mesh, 65, 43).unwrap();
    let mut frame = gpu.frame();
    raster.record(&mut frame);
    frame.finish().unwrap();
    let map = DepthMap { width: 65, height: 43, depths: raster.read(gpu).unwrap() };
    let receivers = receivers(&map, 300, 3);
    let s = Settings::new(Estimator::PowerCdf);
    let source = DepthSource::Buffer(raster.depths());
    let shared = Filter::with_depths(gpu, 65, 43, &receivers, &s, source).unwrap();
    let own = Filter::new(gpu, 65, 43, &receivers, &s).unwrap();
    own.upload_depths(gpu, &map).unwrap();
    let mut frame = gpu.frame();
    raster.record(&mut frame);
    shared.record(&mut frame);
    own.record(&mut frame);
    let times = frame.finish().unwrap();
    if gpu.abilities.timestamps {
        assert_eq!(times.passes.len(), 2 + 4 + 4);
    }
    let visibilities = shared.read(gpu).unwrap();
    assert_eq!(visibilities, own.read(gpu).unwrap());
    assert!(visibilities.iter().any(|&v| v < 0.1) && visibilities.contains(&1.0));
}
