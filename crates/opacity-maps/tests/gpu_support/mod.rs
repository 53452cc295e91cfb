//! Meshes, receivers, and what a frame of the graphics form gives.
#![allow(dead_code, reason = "each test file uses its share")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use dapple_gpu::Gpu;
use dapple_gpu::light_space::{AlphaTexture, LightSpaceMesh, LightSpaceVertex, TriangleGroup};
use dapple_gpu::testing::test_gpu;
use dapple_opacity_maps::gpu::{Counters, Renderer};
use dapple_opacity_maps::{
    Bins, Blend, Code, EndMap, Format, Layered, Layout, Lookup, Model, Packing, Receiver, Settings,
    Split, SplitKind, Storage,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Model of all tests.
pub const MODEL: Model = Model::ExpTau;

/// The adapter for one test at a time: they use both cores, and share one device.
pub fn exclusive_gpu() -> Option<(&'static Gpu, MutexGuard<'static, ()>)> {
    static ONE: Mutex<()> = Mutex::new(());
    let lock = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    test_gpu().map(|gpu| (gpu, lock))
}

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

pub fn vertex(u: f64, v: f64, w: f64, z: f64) -> LightSpaceVertex {
    LightSpaceVertex {
        position: [(u * w) as f32, (v * w) as f32, w as f32],
        z: z as f32,
        uv: [(3.0 * u) as f32, (3.0 * v) as f32],
    }
}

/// Adds triangles as a group.
pub fn add(
    mesh: &mut LightSpaceMesh,
    corners: Vec<LightSpaceVertex>,
    opacity: f32,
    alpha: Option<(u32, f32)>,
) {
    let first = mesh.indices.len() as u32;
    let count = corners.len() as u32;
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    mesh.indices.extend(base..base + count);
    mesh.groups.push(TriangleGroup { first, count, alpha, opacity });
}

/// `count` small triangles all over the map at depths within `depths`.
pub fn soup(seed: u64, count: usize, depths: std::ops::Range<f64>) -> Vec<LightSpaceVertex> {
    let mut rng = rng(seed);
    let mut corners = Vec::new();
    for _ in 0..count {
        let (u, v) = (rng.random_range(-0.1..1.1), rng.random_range(-0.1..1.1));
        for _ in 0..3 {
            let (du, dv) = (rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
            corners.push(vertex(u + du, v + dv, 1.0, rng.random_range(depths.clone())));
        }
    }
    corners
}

/// Leaves of three opacities (one with holes), and opaque scraps among them.
pub fn foliage(seed: u64, count: usize) -> LightSpaceMesh {
    let mut mesh = LightSpaceMesh::default();
    mesh.textures.push(AlphaTexture { width: 2, height: 2, alpha: vec![1.0, 0.2, 0.6, 0.9] });
    add(&mut mesh, soup(seed, count, 0.1..0.8), 0.3, None);
    add(&mut mesh, soup(seed + 1, count / 30, 0.3..0.95), 1.0, None);
    add(&mut mesh, soup(seed + 2, count, 0.2..0.9), 0.69, Some((0, 0.5)));
    add(&mut mesh, soup(seed + 3, count / 2, 0.4..0.6), 1.0 / 255.0, None);
    mesh
}

/// A rectangle of the map at one depth.
pub fn sheet(u: [f64; 2], v: [f64; 2], z: f64) -> Vec<LightSpaceVertex> {
    let corner = |i: usize, j: usize| vertex(u[i], v[j], 1.0, z);
    vec![corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 0), corner(1, 1), corner(0, 1)]
}

/// Receivers all over the map, some beyond it, some that are none.
pub fn receivers(seed: u64, count: usize) -> Vec<Receiver> {
    let mut rng = rng(seed);
    let mut out: Vec<Receiver> = (0..count)
        .map(|_| Receiver {
            slope_u: rng.random_range(-0.5..0.5),
            slope_v: rng.random_range(-0.5..0.5),
            ..Receiver::at(
                rng.random_range(-0.02..1.02),
                rng.random_range(-0.02..1.02),
                rng.random_range(0.0..1.05),
            )
        })
        .collect();
    out.push(Receiver::at(f32::NAN, 0.5, 0.5));
    out.push(Receiver::at(0.5, 0.5, f32::INFINITY));
    out.push(Receiver { slope_u: f32::NAN, ..Receiver::at(0.5, 0.5, 0.7) });
    out.push(Receiver { flags: 0, ..Receiver::at(0.5, 0.5, 0.9) });
    out.extend([Receiver::at(0.0, 0.0, 0.9), Receiver::at(1.0, 1.0, 0.9)]);
    out
}

pub fn bounded(layers: u32) -> Layered {
    let split = Split { lambda: 0.5, kind: SplitKind::Normalised, width: 512 };
    Layered {
        layout: Layout::Bounded { split, bins: Bins::Full },
        layers,
        lookup: Lookup::Lerp,
        write_bias: 0.0,
        soft_start: false,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Targets(8),
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
    }
}

pub fn plain(layered: Layered) -> Settings {
    Settings::plain(Code::Layered(layered))
}

/// What a frame gives.
pub struct Frame {
    pub transmittances: Vec<f32>,
    pub maps: Vec<Vec<f32>>,
    pub bounds: Vec<[f32; 2]>,
    pub counters: Counters,
    /// Passes by name; none where the device has no timestamps.
    pub passes: Vec<&'static str>,
}

/// Draws twice, so that what a frame leaves behind shows in the next, and reads everything.
pub fn draw(gpu: &Gpu, renderer: &Renderer) -> Frame {
    let mut passes = Vec::new();
    for _ in 0..2 {
        let mut frame = gpu.frame();
        renderer.record(&mut frame);
        passes = frame.finish().unwrap().passes.iter().map(|p| p.0).collect();
        gpu.check().unwrap();
    }
    Frame {
        transmittances: renderer.read(gpu).unwrap(),
        maps: renderer.read_maps(gpu).unwrap(),
        bounds: renderer.read_bounds(gpu).unwrap(),
        counters: renderer.counters(),
        passes,
    }
}

pub fn frame(
    gpu: &Gpu,
    mesh: &LightSpaceMesh,
    receivers: &[Receiver],
    size: [u32; 2],
    settings: &Settings,
) -> Frame {
    draw(gpu, &Renderer::new(gpu, mesh, MODEL, receivers, size, settings).unwrap())
}
