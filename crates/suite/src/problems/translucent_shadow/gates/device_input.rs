//! Meshes that the gates of the graphics form rasterise, and what a frame of them gives.

pub use super::super::subject_gpu::refused;
use super::About;
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_gpu::{
    Gpu,
    light_space::{AlphaTexture, LightSpaceMesh, LightSpaceVertex, TriangleGroup},
};
use dapple_opacity_maps::{
    EndMap, Fragments, Model, Receiver, Settings,
    gpu::{self, Counters, Fault, OpacityGpuError, Renderer},
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Model of all meshes.
pub const MODEL: Model = Model::ExpTau;

/// Columns and rows of the maps: not a power of two.
pub const SIZE: [u32; 2] = [33, 27];

/// Foliage with the fragments that the device makes of it.
pub struct Mesh {
    /// What is drawn.
    pub mesh: LightSpaceMesh,
    /// What it covers, by depth.
    pub own: Fragments,
}

impl Mesh {
    /// Random foliage.
    ///
    /// # Errors
    /// A device that is too small or lost.
    pub fn new(gpu: &Gpu, rng: &mut Pcg64) -> Result<Self, SuiteError> {
        let mesh = mesh(rng);
        let own = gpu::fragments(gpu, &mesh, MODEL, SIZE).map_err(refused)?;
        Ok(Self { mesh, own })
    }
}

/// Leaves of three opacities, one kind with holes, and opaque scraps among them.
pub fn mesh(rng: &mut Pcg64) -> LightSpaceMesh {
    let mut mesh = LightSpaceMesh::default();
    let alpha = vec![1.0, 0.2, 0.6, 0.9];
    mesh.textures.push(AlphaTexture { width: 2, height: 2, alpha });
    add(&mut mesh, scraps(rng, 60, [0.1, 0.8]), 0.3, None);
    add(&mut mesh, scraps(rng, 3, [0.4, 0.95]), 1.0, None);
    add(&mut mesh, scraps(rng, 40, [0.2, 0.9]), 0.69, Some((0, 0.5)));
    add(&mut mesh, scraps(rng, 20, [0.4, 0.6]), 1.0 / 255.0, None);
    mesh
}

/// Texture coordinates are moved aside, so that no texel's centre lies on a hole's border.
fn vertex(u: f32, v: f32, z: f32) -> LightSpaceVertex {
    LightSpaceVertex { position: [u, v, 1.0], z, uv: [3.0 * u + 0.0137, 3.0 * v + 0.0071] }
}

/// Small triangles all over the map at depths within a range.
fn scraps(rng: &mut Pcg64, count: usize, depths: [f32; 2]) -> Vec<LightSpaceVertex> {
    let mut corners = Vec::new();
    for _ in 0..count {
        let (u, v) = (rng.random_range(-0.1..1.1_f32), rng.random_range(-0.1..1.1_f32));
        for _ in 0..3 {
            let (du, dv) = (rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
            corners.push(vertex(u + du, v + dv, rng.random_range(depths[0]..depths[1])));
        }
    }
    corners
}

/// Adds triangles as a group.
fn add(
    mesh: &mut LightSpaceMesh,
    corners: Vec<LightSpaceVertex>,
    opacity: f32,
    alpha: Option<(u32, f32)>,
) {
    let (first, count) = (mesh.indices.len() as u32, corners.len() as u32);
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    mesh.indices.extend(base..base + count);
    mesh.groups.push(TriangleGroup { first, count, alpha, opacity });
}

/// Level sheets over the whole map, front to back, one a group.
pub fn sheets(alphas: &[f32]) -> LightSpaceMesh {
    let mut mesh = LightSpaceMesh::default();
    for (i, &alpha) in alphas.iter().enumerate() {
        let corner = |u: f32, v: f32| vertex(u, v, 0.2 + 0.1 * i as f32);
        let (a, b, c, d) = (corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0));
        add(&mut mesh, vec![a, b, c, b, d, c], alpha, None);
    }
    mesh
}

/// The same triangles drawn from the last to the first.
pub fn reversed(mesh: &LightSpaceMesh) -> LightSpaceMesh {
    let mut turned = mesh.clone();
    turned.groups.reverse();
    for group in &turned.groups {
        let range = group.first as usize..(group.first + group.count) as usize;
        let triangles: Vec<[u32; 3]> = turned.indices[range.clone()]
            .chunks_exact(3)
            .rev()
            .map(|t| [t[0], t[1], t[2]])
            .collect();
        turned.indices[range].copy_from_slice(triangles.as_flattened());
    }
    turned
}

/// What a frame gives.
pub struct Shown {
    /// One a receiver.
    pub transmittances: Vec<f32>,
    /// Stored numbers, map after map.
    pub maps: Vec<Vec<f32>>,
    /// First and last depth of each texel, where there are any.
    pub bounds: Vec<[f32; 2]>,
    /// As declared.
    pub counters: Counters,
    /// Passes over the geometry as timed.
    pub geometry_passes: usize,
}

/// Draws one frame and reads everything.
///
/// # Errors
/// Settings that are refused or have no graphics form; a device that is too small or lost.
pub fn frame(
    gpu: &Gpu,
    mesh: &LightSpaceMesh,
    receivers: &[Receiver],
    settings: &Settings,
    fault: Option<Fault>,
) -> Result<Shown, OpacityGpuError> {
    let renderer = match fault {
        None => Renderer::new(gpu, mesh, MODEL, receivers, SIZE, settings)?,
        Some(fault) => Renderer::with_fault(gpu, mesh, MODEL, receivers, SIZE, settings, fault)?,
    };
    let mut frame = gpu.frame();
    renderer.record(&mut frame);
    let passes = frame.finish()?.passes;
    let geometry = |pass: &&(&str, u64)| ["bounds", "bounds-far", "opacity"].contains(&pass.0);
    Ok(Shown {
        transmittances: renderer.read(gpu)?,
        maps: renderer.read_maps(gpu)?,
        bounds: renderer.read_bounds(gpu)?,
        counters: renderer.counters(),
        geometry_passes: passes.iter().filter(geometry).count(),
    })
}

/// Whether a route finds the last depth in a mirrored range.
pub fn is_mirrored(end_map: EndMap) -> bool {
    matches!(end_map, EndMap::Swapped | EndMap::RangeFlip)
}

/// A gate that needs a device.
pub fn gate(
    about: About,
    check: impl Fn(&Gpu, &GateContext<'_>, bool) -> Result<Tally, SuiteError>
    + Copy
    + Send
    + Sync
    + 'static,
) -> Gate {
    let with = move |context: &GateContext<'_>, faulty: bool| match context.gpu {
        Some(gpu) => check(gpu, context, faulty),
        // Not called without a device; an empty tally fails the gate.
        None => Ok(Tally::default()),
    };
    Gate { needs_gpu: true, ..super::gate(about, with) }
}
