// Depth to the channels an estimator filters, rounded to the format. Planes of width * height
// words; layer l holds planes l * words .. (l + 1) * words.
#import common/channels.wgsl
#import common/index.wgsl
#import common/precise.wgsl
#import common/moments.wgsl

struct PackParams {
    texels: u32,
    channels: u32,
    layers: u32,
    exponent: f32,
}

// (z, z^2), and z again for a maximum.
const PACK_MOMENTS = 0u;
// (z, z, z): mean, minimum, maximum.
const PACK_EXTREMES = 1u;
// exp(c z).
const PACK_EXPONENTIAL = 2u;
// z, filtered as a logarithm.
const PACK_DEPTH = 3u;
// exp(c x), its square, -exp(-c x), its square; x = 2 z - 1.
const PACK_WARPED = 4u;
// Four power moments.
const PACK_FOUR_MOMENTS = 5u;
override PACK: u32 = 0u;
override LAYERED: bool = false;

@group(0) @binding(0) var<uniform> params: PackParams;
// (first receiver, start of the warp, end, 0) of each layer.
@group(0) @binding(1) var<storage, read> layers: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> depths: array<f32>;
@group(0) @binding(3) var<storage, read_write> words: array<u32>;

fn channels_of(z: f32) -> vec4<f32> {
    switch PACK {
        case PACK_MOMENTS: {
            return vec4(z, z * z, z, 0.0);
        }
        case PACK_EXPONENTIAL: {
            return vec4(scaled_exp(1.0, params.exponent, z), 0.0, 0.0, 0.0);
        }
        case PACK_WARPED: {
            let x = 2.0 * z - 1.0;
            let positive = scaled_exp(1.0, params.exponent, x);
            let negative = -scaled_exp(1.0, -params.exponent, x);
            return vec4(positive, positive * positive, negative, negative * negative);
        }
        case PACK_FOUR_MOMENTS: {
            return stored_moments(z);
        }
        default: {
            return vec4(z, z, z, 0.0);
        }
    }
}

@compute @workgroup_size(64)
fn pack(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let texel = linear_index(id, groups, 64u);
    if texel >= params.texels {
        return;
    }
    let z = depths[texel];
    var plane = texel;
    for (var layer = 0u; layer < params.layers; layer++) {
        var t = z;
        if LAYERED {
            let range = layers[layer].yz;
            t = clamp((z - range.x) / (range.y - range.x), 0.0, 1.0);
        }
        let c = channels_of(t);
        if FORMAT == FORMAT_F32 {
            for (var i = 0u; i < params.channels; i++) {
                words[plane] = encode(vec2(c[i], 0.0));
                plane += params.texels;
            }
        } else {
            words[plane] = encode(c.xy);
            plane += params.texels;
            if params.channels > 2u {
                words[plane] = encode(c.zw);
                plane += params.texels;
            }
        }
    }
}
