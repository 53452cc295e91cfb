// One receiver an invocation: its cascade by view depth, then the share of its taps that are no
// nearer to the light. Decisions as in crates/shadows/src/cascades/lookup.rs: products are floored
// and compared as they are, so that fused operations change nothing.
// Based on: Zhang et al., Parallel-split shadow maps, VRCIA 2006.
#import common/index.wgsl

struct Receiver {
    u: f32,
    v: f32,
    depth: f32,
    slope_u: f32,
    slope_v: f32,
    view_depth: f32,
    flags: u32,
    pad: u32,
}

struct Region {
    offset_u: f32,
    offset_v: f32,
    // 0 where the cascade is empty.
    texels_per_unit: f32,
    texel: f32,
    far: f32,
    pad0: f32,
    pad1: f32,
    pad2: f32,
}

struct CascadeParams {
    side: u32,
    receivers: u32,
    cascades: u32,
    pad: u32,
    bias: f32,
    slope_bias: f32,
    max_slope: f32,
    pad0: f32,
}

// Along one axis: 1, 3 or 4.
override TAPS: u32 = 1u;
override PLANE_BIAS: bool = false;

@group(0) @binding(0) var<uniform> params: CascadeParams;
@group(0) @binding(1) var<storage, read> regions: array<Region>;
@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var maps: texture_depth_2d_array;
@group(0) @binding(4) var<storage, read_write> visibilities: array<f32>;

const VALID = 1u;
const INFINITY_BITS = 0x7f800000u;

// By its bits: shading languages may assume that there are no NaN.
fn finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) < INFINITY_BITS;
}

fn slope(x: f32) -> f32 {
    return select(0.0, clamp(x, -params.max_slope, params.max_slope), finite(x));
}

// A boundary belongs to the nearer cascade; what lies beyond all is in the last.
fn cascade_of(view_depth: f32) -> u32 {
    var i = 0u;
    while i + 1u < params.cascades && view_depth > regions[i].far {
        i++;
    }
    return i;
}

fn first(at: f32) -> i32 {
    let whole = floor(at);
    let texel = i32(whole);
    if TAPS == 1u {
        return texel;
    }
    if TAPS == 3u {
        return texel - 1;
    }
    return texel - 2 + select(0, 1, at >= whole + 0.5);
}

fn visibility(r: Receiver) -> f32 {
    let here = finite(r.u) && finite(r.v) && finite(r.depth) && finite(r.view_depth);
    if (r.flags & VALID) == 0u || !here {
        return 1.0;
    }
    let cascade = cascade_of(r.view_depth);
    let region = regions[cascade];
    let per_unit = region.texels_per_unit;
    let at_u = (r.u - region.offset_u) * per_unit;
    let at_v = (r.v - region.offset_v) * per_unit;
    let side = f32(params.side);
    let inside = at_u >= 0.0 && at_u <= side && at_v >= 0.0 && at_v <= side;
    if !inside || per_unit == 0.0 {
        return 1.0;
    }
    let su = slope(r.slope_u);
    let sv = slope(r.slope_v);
    let z = r.depth - params.bias - params.slope_bias * (abs(su) + abs(sv)) * region.texel;
    // The plane may run past the far plane; an empty texel hides nothing all the same.
    let most = max(z, 1.0);
    let last = i32(params.side) - 1;
    var lit = 0u;
    for (var j = 0; j < i32(TAPS); j++) {
        let y = clamp(first(at_v) + j, 0, last);
        for (var i = 0; i < i32(TAPS); i++) {
            let x = clamp(first(at_u) + i, 0, last);
            var limit = z;
            if PLANE_BIAS {
                let du = (f32(x) + 0.5 - at_u) * region.texel;
                let dv = (f32(y) + 0.5 - at_v) * region.texel;
                limit = min(z + su * du + sv * dv, most);
            }
            let stored = textureLoad(maps, vec2(x, y), cascade, 0);
            lit += select(0u, 1u, stored >= limit);
        }
    }
    return f32(lit) / f32(TAPS * TAPS);
}

@compute @workgroup_size(64)
fn shade_cascades(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let i = linear_index(id, groups, 64u);
    if i < params.receivers {
        visibilities[i] = visibility(receivers[i]);
    }
}
