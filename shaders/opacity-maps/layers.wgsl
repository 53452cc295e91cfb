// Fragments into layers of opacity.
#import common/opacity_layers.wgsl
#import common/opacity_surface.wgsl
#import common/opacity_targets.wgsl

@group(1) @binding(0) var<uniform> layered: LayerParams;
@group(1) @binding(1) var bounds_map: texture_2d<f32>;
@group(1) @binding(2) var<storage, read> table: array<f32>;
// Fixed-point thickness of each bin, one map after the other.
@group(1) @binding(3) var<storage, read_write> bins: array<atomic<u32>>;
// 256 less the first bin of a texel that ran over, 0 where none did.
@group(1) @binding(4) var<storage, read_write> overrun: array<atomic<u32>>;

// Whether a target holds the fragments of its own layers alone.
override SLABS: bool = false;
// The masks as first printed: channels before a fragment's own are left out of every target.
override LISTING: bool = false;
// BLEND.
const ADD = 0u;
const OVER = 1u;
// Blend states that take one opacity for all channels.
const BY_ALPHA = 2u;
override BLEND: u32 = 0u;

// Same as Targets, with the depth for a test that must not be there.
struct TestedTargets {
    @location(0) t0: vec4<f32>,
    @location(1) t1: vec4<f32>,
    @location(2) t2: vec4<f32>,
    @location(3) t3: vec4<f32>,
    @location(4) t4: vec4<f32>,
    @location(5) t5: vec4<f32>,
    @location(6) t6: vec4<f32>,
    @location(7) t7: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

fn layer_at(z: f32, texel: vec2<u32>) -> u32 {
    let depth = z - layered.write_bias;
    return layer_of(layer_coordinate(depth, ends_of(texel), lambda_of(texel)));
}

// What target `target` of the pass gets of a fragment in `layer`.
fn output(target_index: u32, layer: u32) -> vec4<f32> {
    if target_index >= TARGETS {
        return vec4(0.0);
    }
    let first = layered.first + 4u * target_index;
    let channels = vec4(first, first + 1u, first + 2u, first + 3u);
    var inside = channels >= vec4(layer);
    if LISTING {
        inside = vec4(first / 4u >= layer / 4u) & (vec4(0u, 1u, 2u, 3u) >= vec4(layer % 4u));
    }
    let mask = select(vec4(0.0), vec4(1.0), inside);
    if BLEND == ADD {
        return surface.omega * layered.scale * mask;
    }
    if BLEND == OVER {
        return surface.opacity * mask;
    }
    // A target that the surface does not belong to is left alone; in one that it belongs to, its
    // opacity darkens channels that the mask would keep.
    return surface.opacity * vec4(mask.xyz, select(0.0, 1.0, any(inside)));
}

// Depth and layer of a fragment; a negative depth where it has no part in this pass.
fn part(in: Varyings) -> vec2<f32> {
    let texel = vec2<u32>(in.clip.xy);
    let z = taking_part(in.z, in.uv, texel);
    if z < 0.0 {
        return vec2(-1.0, 0.0);
    }
    let layer = layer_at(z, texel);
    let outside = layer >= layered.end || (SLABS && layer < layered.first);
    return vec2(select(z, -1.0, outside), f32(layer));
}

@fragment
fn targets(in: Varyings) -> Targets {
    let found = part(in);
    if found.x < 0.0 {
        discard;
    }
    let layer = u32(found.y);
    return Targets(
        output(0u, layer),
        output(1u, layer),
        output(2u, layer),
        output(3u, layer),
        output(4u, layer),
        output(5u, layer),
        output(6u, layer),
        output(7u, layer),
    );
}

@fragment
fn tested_targets(in: Varyings) -> TestedTargets {
    let found = part(in);
    if found.x < 0.0 {
        discard;
    }
    let layer = u32(found.y);
    return TestedTargets(
        output(0u, layer),
        output(1u, layer),
        output(2u, layer),
        output(3u, layer),
        output(4u, layer),
        output(5u, layer),
        output(6u, layer),
        output(7u, layer),
        found.x,
    );
}

// Each fragment into its own bin alone; `prefix` adds them up.
@fragment
fn add_to_bin(in: Varyings) {
    let found = part(in);
    if found.x < 0.0 {
        discard;
    }
    let texel = vec2<u32>(in.clip.xy);
    let place = texel.y * layered.width + texel.x;
    let layer = u32(found.y);
    let texels = layered.texels;
    // 20 binary digits; conversion clips at 2^32 - 1.
    let fixed = u32(round(surface.omega * 1048576.0));
    let before = atomicAdd(&bins[layer * texels + place], fixed);
    if before + fixed < before {
        atomicMax(&overrun[place], 256u - layer);
    }
}
