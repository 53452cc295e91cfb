// Each sample of a texel keeps the nearest fragment that survives a random test of its opacity;
// source and reference in crates/opacity-maps/src/stochastic.rs, which gives the same bits.
#import common/hash.wgsl
#import common/opacity_surface.wgsl

struct SurvivorParams {
    samples: u32,
    // Hash of the seed.
    seed: u32,
    width: u32,
    pad0: u32,
}

@group(1) @binding(0) var<uniform> sampling: SurvivorParams;
// Bits of 2 less those of the depth: they grow towards the light, and 0 is no survivor.
@group(1) @binding(1) var<storage, read_write> survivors: array<atomic<u32>>;

@fragment
fn keep(in: Varyings) {
    let texel = vec2<u32>(in.clip.xy);
    let z = taking_part(in.z, in.uv, texel);
    if z < 0.0 {
        discard;
    }
    let place = texel.y * sampling.width + texel.x;
    let mine = 0x40000000u - bitcast<u32>(z);
    let fragment = hash(hash(place ^ sampling.seed) ^ bitcast<u32>(z));
    // The opacity in steps of 2^-24.
    let below = u32(round(surface.opacity * 16777216.0));
    for (var sample = 0u; sample < sampling.samples; sample++) {
        let at = place * sampling.samples + sample;
        // Behind a survivor nothing matters: most fragments draw few numbers.
        if atomicLoad(&survivors[at]) < mine
            && hash(fragment + sample * 0x9e3779b9u) >> 8u < below {
            atomicMax(&survivors[at], mine);
        }
    }
}
