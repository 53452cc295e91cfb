//! Soundness probes: what an adapter really computes, before anything is believed of it.
//!
//! [`run`] takes raw readings on devices of their own (a probe that kills its device harms no
//! other), [`judge`] is a pure function from readings to a verdict. An adapter whose loops are
//! wrong is refused; any other fault takes the ability away that it breaks.

mod judge;
mod run;

use std::collections::HashMap;
use std::sync::Mutex;

use serde::Serialize;

pub use judge::judge;

use crate::device::lock;
use crate::{AdapterFacts, Gpu, GpuError};

/// Iterations of the two loops of the loop probe. Stock lavapipe 22.3 stops an invocation after
/// 65,535 iterations over all its loops, without an error.
pub const LOOP_ITERATIONS: [u32; 2] = [70_000, 1_000];

/// Fragments that the four occlusion queries let pass: two rectangles, one drawn again behind
/// itself, nothing drawn.
pub const OCCLUSION_COUNTS: [u64; 4] = [5000, 1000, 0, 0];

/// Values and their nearest f16 (ties to even), for both ways of rounding.
pub const F16_ROUNDING: [(f32, u16); 10] = [
    // 1 + 2^-11 is half way between 1 and the next f16: to even, down.
    (1.000_488_3, 0x3C00),
    // 1 + 3 * 2^-11 is half way: to even, up.
    (1.001_464_8, 0x3C02),
    // Just above half way: up.
    (1.000_489_2, 0x3C01),
    (0.1, 0x2E66),
    (0.7, 0x399A),
    (-0.7, 0xB99A),
    (1.0 / 3.0, 0x3555),
    (2049.0, 0x6800),
    (2051.0, 0x6802),
    (65504.0, 0x7BFF),
];

/// f16 subnormals, which a device may flush to zero.
pub const F16_SUBNORMAL: [(f32, u16); 2] = [(5.960_464_5e-8, 0x0001), (8.940_697e-8, 0x0002)];

/// What a device can do, as probes and features tell.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Abilities {
    /// Timestamps of passes are there and sound; else `FrameTimes::gpu_ns` is `None`.
    pub timestamps: bool,
    /// Loops run as often as asked. Always true of an open device: others are refused.
    pub loops_sound: bool,
    /// `pack2x16float` rounds to nearest even.
    pub f16_pack_rne: bool,
    /// A store to an f16 texture rounds to nearest even (lavapipe truncates).
    pub f16_store_rne: bool,
    /// `pack2x16float` keeps f16 subnormals.
    pub f16_subnormals: bool,
    /// Occlusion queries count fragments, not only say whether there were any.
    pub occlusion_exact_counts: bool,
    /// Occlusion queries tell none from some.
    pub occlusion_boolean: bool,
    /// f32 arithmetic keeps subnormals.
    pub f32_subnormals: bool,
    /// 1 / 3 is rounded to nearest.
    pub f32_division_rne: bool,
    /// `a * b - c` is computed with one rounding, so that results differ from the CPU's.
    pub mul_add_contracted: bool,
    /// Subgroup operations.
    pub subgroup: bool,
    /// Most invocations in a workgroup.
    pub max_workgroup: u32,
    /// The f16 type in shaders.
    pub shader_f16: bool,
    /// 32-bit float textures can be sampled with filtering.
    pub f32_filterable: bool,
    /// 32-bit float targets can be blended.
    pub f32_blendable: bool,
    /// Indirect draws may carry a first instance.
    pub indirect_first_instance: bool,
    /// Many indirect draws with a count from a buffer.
    pub multi_draw_indirect_count: bool,
    /// What probes found wrong or could not find out, a line each.
    pub notes: Vec<String>,
}

/// A probe that the adapter fails.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// The probe.
    pub probe: String,
    /// What a sound adapter answers.
    pub expected: String,
    /// What this one answered.
    pub found: String,
}

/// One run of the timestamp probe: a small raster pass, then a compute pass of about 10 ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimestampReading {
    /// Begin and end of the raster pass, ns.
    pub raster: [u64; 2],
    /// Begin and end of the compute pass, ns.
    pub compute: [u64; 2],
    /// The same submission by the host's clock, ns.
    pub wall_ns: u64,
}

/// Count and generator state after each loop of the loop probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoopReading {
    /// Iterations counted.
    pub counted: u32,
    /// State of the generator `x -> 1664525 x + 1013904223` that started at 1.
    pub state: u32,
}

/// Bits of what the arithmetic probe computes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArithmeticReading {
    /// `pack2x16float` of [`F16_ROUNDING`], then of [`F16_SUBNORMAL`].
    pub packed: Vec<u16>,
    /// The smallest normal f32, halved.
    pub halved: u32,
    /// (1 + 2^-12)^2 - (1 + 2^-11).
    pub square_difference: u32,
    /// 1 / 3.
    pub third: u32,
}

/// Everything the probes read. `None` where a probe could not run; `notes` says why.
#[derive(Debug, Clone)]
pub struct Readings {
    /// The loop probe; the adapter is useless without it.
    pub loops: [LoopReading; 2],
    /// Several runs of the timestamp probe.
    pub timestamps: Option<Vec<TimestampReading>>,
    /// The arithmetic probe.
    pub arithmetic: Option<ArithmeticReading>,
    /// f16 bits that `textureStore` made of [`F16_ROUNDING`].
    pub stored: Option<Vec<u16>>,
    /// Results of the four occlusion queries.
    pub occlusion: Option<[u64; 4]>,
    /// Features of the adapter.
    pub features: wgpu::Features,
    /// Most invocations in a workgroup.
    pub max_workgroup: u32,
    /// Why a probe could not run.
    pub notes: Vec<String>,
}

/// Probes an adapter on devices of its own.
///
/// # Errors
/// What the driver says where not even the loop probe can run.
pub fn run(adapter: &wgpu::Adapter, facts: &AdapterFacts) -> Result<Readings, GpuError> {
    let mut notes = Vec::new();
    let device = || Gpu::bare(adapter, facts.clone());
    let mut note = |probe: &str, error: GpuError| notes.push(format!("{probe}: {error}"));
    let loops = run::loops(&device()?)?;
    let arithmetic =
        device().and_then(|g| run::arithmetic(&g)).map_err(|e| note("arithmetic", e)).ok();
    let stored = device().and_then(|g| run::f16_store(&g)).map_err(|e| note("f16 store", e)).ok();
    let occlusion =
        device().and_then(|g| run::occlusion(&g)).map_err(|e| note("occlusion", e)).ok();
    let timestamps = device().and_then(run::timestamps).map_err(|e| note("timestamps", e)).ok();
    Ok(Readings {
        loops,
        timestamps,
        arithmetic,
        stored,
        occlusion,
        features: adapter.features(),
        max_workgroup: adapter.limits().max_compute_invocations_per_workgroup,
        notes,
    })
}

/// The verdict on an adapter; probes run once a process.
pub(crate) fn abilities(
    adapter: &wgpu::Adapter,
    facts: &AdapterFacts,
) -> Result<Abilities, GpuError> {
    static CACHE: Mutex<Option<HashMap<String, Result<Abilities, GpuError>>>> = Mutex::new(None);
    let key = format!("{} {}", facts.line(), adapter.get_info().device_pci_bus_id);
    // Held while probing, so that threads that open the same adapter wait for one probe.
    let mut cache = lock(&CACHE);
    let known = cache.get_or_insert_default();
    if let Some(verdict) = known.get(&key) {
        return verdict.clone();
    }
    let verdict = run(adapter, facts).and_then(|readings| {
        judge(&readings).map_err(|fault| GpuError::Unsound {
            adapter: facts.line(),
            probe: fault.probe,
            expected: fault.expected,
            found: fault.found,
        })
    });
    known.insert(key, verdict.clone());
    verdict
}
