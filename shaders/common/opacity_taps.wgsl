// Receivers, the texels they read, and what is averaged over them. The importer binds
// `opaque_map` and defines `decode` (transmittance of a texel in front of a depth) and
// `decode_mean` (the same of the stored numbers of all `taps`, averaged).
#import common/hash.wgsl

struct Receiver {
    u: f32,
    v: f32,
    depth: f32,
    slope_u: f32,
    slope_v: f32,
    flags: u32,
}

struct ShadeParams {
    receivers: u32,
    width: u32,
    height: u32,
    // ONE, BOX_3, BOX_4, STOCHASTIC_16.
    pattern: u32,
    // Whether stored numbers are averaged instead of transmittances.
    stored: u32,
    // Whether opaque depths are compared.
    separate: u32,
    bias: f32,
    pad0: u32,
}

const ONE = 0u;
const BOX_3 = 1u;
const BOX_4 = 2u;
const STOCHASTIC_16 = 3u;
// Flag of a receiver that is there.
const VALID = 1u;

@group(0) @binding(0) var<uniform> shading: ShadeParams;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read_write> transmittances: array<f32>;
@group(0) @binding(3) var opaque_map: texture_depth_2d;

struct Tap {
    texel: vec2<u32>,
    // Map coordinates from the receiver to the texel's centre, where it was written.
    offset: vec2<f32>,
}

var<private> taps: array<Tap, 16>;
var<private> tap_count: u32;

fn texel_at(receiver: Receiver, offset: vec2<f32>) -> vec2<u32> {
    let size = vec2(f32(shading.width), f32(shading.height));
    let place = floor(vec2(receiver.u, receiver.v) * size + offset);
    return vec2<u32>(clamp(place, vec2(0.0), size - 1.0));
}

fn find_taps(receiver: Receiver) {
    let size = vec2(f32(shading.width), f32(shading.height));
    var across = 1u;
    if shading.pattern == BOX_3 {
        across = 3u;
    } else if shading.pattern >= BOX_4 {
        across = 4u;
    }
    tap_count = across * across;
    let middle = 0.5 * f32(across - 1u);
    var state = hash(bitcast<u32>(receiver.u) ^ hash(bitcast<u32>(receiver.v)));
    for (var i = 0u; i < tap_count; i++) {
        var offset = vec2(f32(i % across), f32(i / across)) - middle;
        if shading.pattern == STOCHASTIC_16 {
            state = hash(state);
            let jitter = vec2(f32(state & 0xffffu), f32(state >> 16u));
            offset += jitter / 65536.0 - 0.5;
        }
        let texel = texel_at(receiver, offset);
        let centre = (vec2<f32>(texel) + 0.5) / size;
        taps[i] = Tap(texel, centre - vec2(receiver.u, receiver.v));
    }
}

// Whether no opaque surface lies in front of the receiver's plane at a tap.
fn is_lit(receiver: Receiver, at: Tap) -> bool {
    if shading.separate == 0u {
        return true;
    }
    let slope = vec2(receiver.slope_u, receiver.slope_v);
    let plane = receiver.depth + slope.x * at.offset.x + slope.y * at.offset.y;
    let stored = textureLoad(opaque_map, at.texel, 0);
    return plane - shading.bias <= select(stored, 2.0, stored >= 1.0);
}

fn transmittance(receiver: Receiver) -> f32 {
    if (receiver.flags & VALID) == 0u {
        return 1.0;
    }
    find_taps(receiver);
    let depth = receiver.depth - shading.bias;
    var sum = 0.0;
    for (var i = 0u; i < tap_count; i++) {
        if is_lit(receiver, taps[i]) {
            if shading.stored != 0u {
                sum += 1.0;
            } else {
                sum += decode(taps[i].texel, depth);
            }
        }
    }
    let mean = sum / f32(tap_count);
    if shading.stored != 0u {
        return mean * decode_mean(texel_at(receiver, vec2(0.0)), depth);
    }
    return mean;
}
