// The windows of one strip: STRIP neighbouring outputs, whose windows overlap in all but STRIP - 1
// texels, made by one invocation. The importing file declares
//   const STRIP: u32;
//   fn fetch(j: u32) -> vec2<f32>    texel j of the strip, 0 <= j < taps + STRIP - 1, clamped
//   fn emit(i: u32, v: vec2<f32>)    takes output i
//
// Long boxes, minima and maxima combine a suffix of the first STRIP - 1 texels, the core that all
// windows share, and a prefix of the last ones: 1 + taps / STRIP combinations an output, none of
// them a subtraction, so large warped depths leave no residue behind as a running sum would.
#import common/channels.wgsl

struct FilterParams {
    width: u32,
    height: u32,
    taps: u32,
    // Power of two that keeps sums of large channels finite, and what a sum is divided by.
    scale: f32,
    norm: f32,
    // c of the log-sum-exp mean.
    exponent: f32,
    pad0: u32,
    pad1: u32,
}

// What a plane's low and high channel are: 4 bits each.
const OP_MEAN = 0u;
const OP_MEAN_WIDE = 1u;
const OP_MIN = 2u;
const OP_MAX = 3u;
// A mean of exp(c z), stored as its logarithm over c. Has its plane to itself.
const OP_MEAN_LOG = 4u;

override GAUSSIAN: bool = false;

@group(0) @binding(0) var<uniform> params: FilterParams;
@group(0) @binding(1) var<storage, read> ops: array<u32>;
// params.taps weights, 1 for a box.
@group(0) @binding(2) var<storage, read> weights: array<f32>;
@group(0) @binding(3) var<storage, read> source_words: array<u32>;
@group(0) @binding(4) var<storage, read_write> target_words: array<u32>;

// Beyond any channel, yet c times it is finite.
const FAR = 1e30;

var<private> is_extreme: vec2<bool>;
var<private> is_log: bool;
// 1 or scale for sums; -1 and 1 turn a minimum into a maximum.
var<private> gain: vec2<f32>;
// A texel of the strip, subtracted from bounded channels: the mean of equal depths is then exact.
var<private> pivot: vec2<f32>;
var<private> neutral: vec2<f32>;

fn begin_strip(op: u32) {
    let kinds = vec2(op & 15u, (op >> 4u) & 15u);
    is_log = kinds.x == OP_MEAN_LOG;
    is_extreme = (kinds == vec2(OP_MIN)) | (kinds == vec2(OP_MAX));
    let wide = kinds == vec2(OP_MEAN_WIDE);
    gain = select(select(vec2(1.0), vec2(params.scale), wide), vec2(-1.0), kinds == vec2(OP_MIN));
    pivot = vec2(0.0);
    neutral = select(vec2(0.0), vec2(-FAR), is_extreme);
    if is_log {
        neutral = vec2(-FAR, 0.0);
    } else {
        pivot = select(vec2(0.0), fetch(params.taps / 2u), kinds == vec2(OP_MEAN));
    }
}

// A texel as an accumulator with weight 1. Logarithmic: largest depth, and the sum of
// exp(c (z - largest)).
fn enter(j: u32) -> vec2<f32> {
    let v = fetch(j);
    if is_log {
        return vec2(v.x, 1.0);
    }
    return (v - pivot) * gain;
}

fn weigh(v: vec2<f32>, weight: f32) -> vec2<f32> {
    if is_log {
        return vec2(v.x, weight);
    }
    return select(v * weight, v, is_extreme);
}

fn combine(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    if is_log {
        let m = max(a.x, b.x);
        let far = exp(params.exponent * (min(a.x, b.x) - m));
        return vec2(m, select(b.y + a.y * far, a.y + b.y * far, a.x >= b.x));
    }
    return select(a + b, max(a, b), is_extreme);
}

fn finish(acc: vec2<f32>) -> vec2<f32> {
    if is_log {
        return vec2(acc.x + log(acc.y / params.norm) / params.exponent, 0.0);
    }
    let wide_norm = select(vec2(params.norm), vec2(params.norm * params.scale), gain != vec2(1.0));
    return select(pivot + acc / wide_norm, acc * gain, is_extreme);
}

// taps >= STRIP, equal weights.
fn strip_shared() {
    var suffix: array<vec2<f32>, STRIP>;
    var acc = neutral;
    suffix[STRIP - 1u] = acc;
    for (var i = STRIP - 1u; i > 0u; i--) {
        acc = combine(enter(i - 1u), acc);
        suffix[i - 1u] = acc;
    }
    // Blocks keep the rounding error of a long sum near that of a short one.
    var core = neutral;
    var j = STRIP - 1u;
    while j < params.taps {
        var part = neutral;
        let end = min(j + 32u, params.taps);
        for (; j < end; j++) {
            part = combine(part, enter(j));
        }
        core = combine(core, part);
    }
    emit(0u, finish(combine(suffix[0], core)));
    for (var i = 1u; i < STRIP; i++) {
        core = combine(core, enter(params.taps + i - 1u));
        emit(i, finish(combine(suffix[i], core)));
    }
}

// Any weights: each texel is read once and added to every window that holds it.
fn strip_direct() {
    var acc: array<vec2<f32>, STRIP>;
    var lag: array<f32, STRIP>;
    for (var i = 0u; i < STRIP; i++) {
        acc[i] = neutral;
        lag[i] = 0.0;
    }
    for (var j = 0u; j < params.taps + STRIP - 1u; j++) {
        for (var i = STRIP - 1u; i > 0u; i--) {
            lag[i] = lag[i - 1u];
        }
        lag[0] = 0.0;
        if j < params.taps {
            lag[0] = weights[j];
        }
        let v = enter(j);
        for (var i = 0u; i < STRIP; i++) {
            // j - i wraps to a large number for windows that begin later.
            if j - i < params.taps {
                acc[i] = combine(acc[i], weigh(v, lag[i]));
            }
        }
    }
    for (var i = 0u; i < STRIP; i++) {
        emit(i, finish(acc[i]));
    }
}

fn filter_strip(op: u32) {
    begin_strip(op);
    if !GAUSSIAN && params.taps >= STRIP {
        strip_shared();
    } else {
        strip_direct();
    }
}
