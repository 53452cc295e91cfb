// One receiver an invocation: statistics of the window around it, then a visibility.
#import common/channels.wgsl
#import common/index.wgsl
#import common/moments.wgsl
#import common/precise.wgsl
#import common/visibility.wgsl

struct Receiver {
    u: f32,
    v: f32,
    z: f32,
    valid: f32,
    dz_du: f32,
    dz_dv: f32,
    pad0: f32,
    pad1: f32,
}

struct ShadeParams {
    width: u32,
    height: u32,
    receivers: u32,
    layers: u32,
    // Entries of `kernel`; comparisons of a window are its square.
    taps: u32,
    // Whether those entries are neighbouring texels.
    contiguous: u32,
    bias: f32,
    min_variance: f32,
    bleed_reduction: f32,
    exponent: f32,
    moment_bias: f32,
    moment_target: f32,
    degenerate_range: f32,
    pad0: f32,
    pad1: f32,
    pad2: f32,
}

const COMPARE = 0u;
const VSM = 1u;
const VSM_LINSTEP = 2u;
const VSM_MAX = 3u;
const GAUSSIAN_CDF = 4u;
const POWER_CDF = 5u;
const ESM_LINEAR = 6u;
const ESM_LOG = 7u;
const EVSM_2 = 8u;
const EVSM_4 = 9u;
const MSM = 10u;
override ESTIMATOR: u32 = 0u;
// Channels of a layer.
override CHANNELS: u32 = 1u;
override LAYERED: bool = false;
override BILINEAR: bool = false;
override PLANE_BIAS: bool = false;

@group(0) @binding(0) var<uniform> params: ShadeParams;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
// Planes of words as `pack` lays them out; f32 depths as they are serve COMPARE.
@group(0) @binding(2) var<storage, read> words: array<u32>;
// Offset from the window's middle and weight, for COMPARE.
@group(0) @binding(3) var<storage, read> kernel: array<vec2<f32>>;
// (first receiver, start of the warp, end, 0) of each layer.
@group(0) @binding(4) var<storage, read> layers: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> visibilities: array<f32>;

const INFINITY_BITS = 0x7f800000u;

// By its bits: shading languages may assume that there are no NaN.
fn finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) < INFINITY_BITS;
}

fn in_unit(x: f32) -> bool {
    let bits = bitcast<u32>(x);
    return bits <= bitcast<u32>(1.0) || bits == 0x80000000u;
}

fn in_map(r: Receiver) -> bool {
    return (bitcast<u32>(r.valid) & 0x7fffffffu) != 0u && in_unit(r.u) && in_unit(r.v) && finite(r.z);
}

// A map coordinate along an axis of `side` texels: a texel, the next one, and the weight of that
// one. In f32 as crates/shadows/src/filtering/lookup.rs: these are decisions.
struct Place {
    first: i32,
    second: i32,
    weight: f32,
}

fn place(u: f32, side: u32) -> Place {
    let last = i32(side) - 1;
    if !BILINEAR {
        let texel = min(i32(u * f32(side)), last);
        return Place(texel, texel, 0.0);
    }
    let at = u * f32(side) - 0.5;
    let whole = floor(at);
    if whole < 0.0 {
        return Place(0, 0, 0.0);
    }
    if i32(whole) >= last {
        return Place(last, last, 0.0);
    }
    return Place(i32(whole), i32(whole) + 1, at - whole);
}

// The border repeats.
fn clamped(x: i32, y: i32) -> vec2<u32> {
    let last = vec2(i32(params.width), i32(params.height)) - 1;
    return vec2<u32>(clamp(vec2(x, y), vec2(0), last));
}

// Tap k of the one or two windows along an axis: offset from the first window's middle, weight.
// With neighbouring taps, the two windows share all but their ends.
fn tap(k: u32, weight: f32, two: bool) -> vec2<f32> {
    if !two {
        return kernel[k];
    }
    if params.contiguous != 0u {
        var w = 0.0;
        if k < params.taps {
            w = (1.0 - weight) * kernel[k].y;
        }
        if k > 0u {
            w += weight * kernel[k - 1u].y;
        }
        return vec2(kernel[0].x + f32(k), w);
    }
    let entry = kernel[k / 2u];
    if (k & 1u) == 0u {
        return vec2(entry.x, (1.0 - weight) * entry.y);
    }
    return vec2(entry.x + 1.0, weight * entry.y);
}

fn taps(two: bool) -> u32 {
    if !two {
        return params.taps;
    }
    return select(2u * params.taps, params.taps + 1u, params.contiguous != 0u);
}

fn compared(r: Receiver, slope: vec2<f32>, px: Place, py: Place) -> f32 {
    let two_x = px.second > px.first;
    let two_y = py.second > py.first;
    let size = vec2(f32(params.width), f32(params.height));
    let z = r.z - params.bias;
    var sum = 0.0;
    for (var j = 0u; j < taps(two_y); j++) {
        let row = tap(j, py.weight, two_y);
        let y = py.first + i32(row.x);
        var line = 0.0;
        for (var i = 0u; i < taps(two_x); i++) {
            let column = tap(i, px.weight, two_x);
            let texel = clamped(px.first + i32(column.x), y);
            var limit = z;
            if PLANE_BIAS {
                let centre = (vec2<f32>(texel) + 0.5) / size;
                // An empty texel hides nothing, also where the plane runs past the far plane.
                limit = min(limit + dot(slope, centre - vec2(r.u, r.v)), max(z, 1.0));
            }
            let depth = decode(words[texel.y * params.width + texel.x]).x;
            line += select(column.y, 0.0, depth < limit);
        }
        sum += row.y * line;
    }
    return min(sum, 1.0);
}

fn fetch(layer: u32, x: i32, y: i32) -> vec4<f32> {
    let plane = params.width * params.height;
    let per_layer = select((CHANNELS + 1u) / 2u, CHANNELS, FORMAT == FORMAT_F32);
    let at = layer * per_layer * plane + u32(y) * params.width + u32(x);
    var c = vec4(0.0);
    if FORMAT == FORMAT_F32 {
        for (var i = 0u; i < CHANNELS; i++) {
            c[i] = bitcast<f32>(words[at + i * plane]);
        }
        return c;
    }
    let low = decode(words[at]);
    if CHANNELS <= 2u {
        return vec4(low, 0.0, 0.0);
    }
    return vec4(low, decode(words[at + plane]));
}

fn blend(a: vec4<f32>, b: vec4<f32>, weight: f32) -> vec4<f32> {
    if ESTIMATOR == ESM_LOG {
        let most = max(a.x, b.x);
        let sum = (1.0 - weight) * exp(params.exponent * (a.x - most))
            + weight * exp(params.exponent * (b.x - most));
        return vec4(select(most, most + log(sum) / params.exponent, sum > 0.0), 0.0, 0.0, 0.0);
    }
    var c = a + (b - a) * weight;
    // Extremes stay conservative: those of both.
    if ESTIMATOR == POWER_CDF {
        c.y = min(a.y, b.y);
        c.z = max(a.z, b.z);
    } else if ESTIMATOR == VSM_MAX {
        c.z = max(a.z, b.z);
    }
    return c;
}

fn statistics(layer: u32, px: Place, py: Place) -> vec4<f32> {
    let a = fetch(layer, px.first, py.first);
    if !BILINEAR {
        return a;
    }
    let b = fetch(layer, px.second, py.first);
    let c = fetch(layer, px.first, py.second);
    let d = fetch(layer, px.second, py.second);
    return blend(blend(a, b, px.weight), blend(c, d, px.weight), py.weight);
}

fn estimated(c: vec4<f32>, z: f32) -> f32 {
    switch ESTIMATOR {
        case VSM: {
            return chebyshev(c.xy, z, params.min_variance);
        }
        case VSM_LINSTEP: {
            let v = chebyshev(c.xy, z, params.min_variance);
            return max((v - params.bleed_reduction) / (1.0 - params.bleed_reduction), 0.0);
        }
        case VSM_MAX: {
            return select(chebyshev(c.xy, z, params.min_variance), 0.0, z > c.z);
        }
        case GAUSSIAN_CDF: {
            return gaussian_cdf(c.xy, z, params.min_variance);
        }
        case POWER_CDF: {
            return power_cdf(c.x, c.y, c.z, z, params.degenerate_range);
        }
        case ESM_LINEAR: {
            return min(scaled_exp(c.x, -params.exponent, clamp(z, -1e6, 1e6)), 1.0);
        }
        case ESM_LOG: {
            return exp(params.exponent * min(c.x - z, 0.0));
        }
        case EVSM_2, EVSM_4: {
            let both = ESTIMATOR == EVSM_4;
            return warped_visibility(c, both, z, params.exponent, params.min_variance);
        }
        case MSM: {
            return moment_visibility(
                moments_of(c), z, params.moment_bias, params.moment_target);
        }
        default: {
            return 1.0;
        }
    }
}

fn visibility(r: Receiver) -> f32 {
    if !in_map(r) {
        return 1.0;
    }
    let px = place(r.u, params.width);
    let py = place(r.v, params.height);
    let slope = select(
        vec2(0.0),
        vec2(r.dz_du, r.dz_dv),
        vec2(finite(r.dz_du), finite(r.dz_dv)),
    );
    if ESTIMATOR == COMPARE {
        return compared(r, slope, px, py);
    }
    var z = r.z - params.bias;
    if PLANE_BIAS {
        z -= 0.5 * (abs(slope.x) / f32(params.width) + abs(slope.y) / f32(params.height));
    }
    var layer = 0u;
    if LAYERED {
        while layer + 1u < params.layers && z >= layers[layer + 1u].x {
            layer++;
        }
        z = (z - layers[layer].y) / (layers[layer].z - layers[layer].y);
    }
    return estimated(statistics(layer, px, py), z);
}

@compute @workgroup_size(64)
fn shade(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let i = linear_index(id, groups, 64u);
    if i < params.receivers {
        visibilities[i] = visibility(receivers[i]);
    }
}
