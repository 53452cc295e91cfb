// First and last depth of each texel, by five routes.
#import common/opacity_surface.wgsl

struct BoundsParams {
    width: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(1) @binding(0) var<uniform> bounds: BoundsParams;
// (1 - first, last) of each texel as bits, which order as the numbers do where they are not
// negative; both start as 0: nothing there.
@group(1) @binding(1) var<storage, read_write> ends: array<atomic<u32>>;

// Depths come negated: near and far plane have changed places.
override SWAPPED: bool = false;
// Written as depths from the far plane backwards.
override REVERSED: bool = false;

// Both ends at once, for MAX blending: (-d, d).
@fragment
fn both_ends(in: Varyings) -> @location(0) vec4<f32> {
    let z = taking_part(in.z, in.uv, vec2<u32>(in.clip.xy));
    if z < 0.0 {
        discard;
    }
    return vec4(-z, z, 0.0, 0.0);
}

// Both ends at once, by atomic maxima.
@fragment
fn atomic_ends(in: Varyings) {
    let texel = vec2<u32>(in.clip.xy);
    let z = taking_part(in.z, in.uv, texel);
    if z < 0.0 {
        discard;
    }
    let at = 2u * (texel.y * bounds.width + texel.x);
    // Bits of a depth in 0..=1 are at most those of 1: what is left grows towards the light.
    atomicMax(&ends[at], bitcast<u32>(1.0) - bitcast<u32>(z));
    atomicMax(&ends[at + 1u], bitcast<u32>(z));
}

// One end, for a depth test.
@fragment
fn one_end(in: Varyings) -> @builtin(frag_depth) f32 {
    let depth = select(in.z, -in.z, SWAPPED && (surface.flags & FROM_OPAQUE_MAP) == 0u);
    let z = taking_part(depth, in.uv, vec2<u32>(in.clip.xy));
    if z < 0.0 {
        discard;
    }
    return select(z, 1.0 - z, REVERSED || SWAPPED);
}
