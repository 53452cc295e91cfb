//! `dapple doctor`: adapters, what the probes found, and what that rules out.

use crate::{Outcome, args, output::put, verbs::choice};
use anyhow::Result;
use dapple_gpu::{Abilities, Gpu, GpuError};
use dapple_suite::environment::environment;

/// Prints what there is. Exit 3 if the adapter that would be used is unsound or refuses.
pub fn run(args: &args::Doctor) -> Result<Outcome> {
    let facts = environment();
    put!("processor: {}, {} threads", facts.cpu, facts.threads)?;
    put!("program:   {}{}", facts.revision, if facts.dirty { " with changes" } else { "" })?;
    let adapters = dapple_gpu::adapters();
    put!("adapters:  {}", if adapters.is_empty() { "none" } else { "" })?;
    for adapter in &adapters {
        put!("  {}", adapter.line())?;
    }
    match Gpu::open(&choice(args.adapter.as_ref())) {
        Ok(gpu) => {
            put!("in use:    {}", gpu.facts.line())?;
            print_abilities(&gpu.abilities)?;
            let limits = gpu.limits();
            put!(
                "limits:    storage binding {} MiB, buffer {} MiB, texture side {}, workgroup {}",
                limits.max_storage_buffer_binding_size >> 20,
                limits.max_buffer_size >> 20,
                limits.max_texture_dimension_2d,
                limits.max_compute_invocations_per_workgroup
            )?;
            Ok(Outcome::Ok)
        }
        // A machine without an adapter is a machine where the cpu forms run: nothing is broken.
        Err(error @ GpuError::NoAdapter { .. }) => {
            put!("in use:    none; gpu forms are reported as not run")?;
            put!("  {error}")?;
            Ok(Outcome::Ok)
        }
        Err(error) => {
            put!("in use:    none: {error}")?;
            Ok(Outcome::Code(3))
        }
    }
}

/// Each finding with what it means for the measurements.
fn print_abilities(abilities: &Abilities) -> std::io::Result<()> {
    let findings = [
        ("loops", abilities.loops_sound, "long loops run to their end"),
        ("timestamps", abilities.timestamps, "device times are recorded; without, wall times"),
        ("f16 packing", abilities.f16_pack_rne, "16-bit maps round as on the processor"),
        ("f16 stores", abilities.f16_store_rne, "16-bit textures round; ours are packed buffers"),
        ("f16 subnormals", abilities.f16_subnormals, "16-bit maps keep depths below 6e-5"),
        ("f32 subnormals", abilities.f32_subnormals, "tiny scenes keep their arithmetic"),
        ("division", abilities.f32_division_rne, "quotients are rounded to nearest"),
        ("fused multiply-add", abilities.mul_add_contracted, "port errors include one rounding"),
        ("occlusion counts", abilities.occlusion_exact_counts, "queries count fragments"),
        ("occlusion queries", abilities.occlusion_boolean, "queries tell none from some"),
        ("subgroups", abilities.subgroup, "subgroup operations"),
        ("f16 in shaders", abilities.shader_f16, "the f16 type"),
        ("f32 filtering", abilities.f32_filterable, "32-bit textures can be filtered"),
        ("f32 blending", abilities.f32_blendable, "32-bit targets can be blended"),
        ("multi-draw count", abilities.multi_draw_indirect_count, "counts from a buffer"),
    ];
    for (name, there, meaning) in findings {
        put!("  {:<4} {name:<20} {meaning}", if there { "yes" } else { "no" })?;
    }
    for note in &abilities.notes {
        put!("  note: {note}")?;
    }
    Ok(())
}
