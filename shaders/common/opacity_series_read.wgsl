// Numbers of a texel, or the mean over all taps, and what is decoded from them. The importer binds
// `maps` and defines `transmittance_before`.
#import common/opacity_each.wgsl

var<private> stored: array<vec4<f32>, 8>;

fn read_stored(texel: vec2<u32>, mean: bool) {
    for (var i = 0u; i < (NUMBERS + 3u) / 4u; i++) {
        if !mean {
            stored[i] = textureLoad(maps, texel, i, 0);
            continue;
        }
        var sum = vec4(0.0);
        for (var tap = 0u; tap < tap_count; tap++) {
            sum += textureLoad(maps, taps[tap].texel, i, 0);
        }
        stored[i] = sum / f32(tap_count);
    }
}

fn number(index: u32) -> f32 {
    return stored[index / 4u][index % 4u];
}

fn decode(texel: vec2<u32>, depth: f32) -> f32 {
    return transmittance_before(texel, depth, false);
}

// Rays with bounds of their own cannot be averaged: each is decoded.
fn decode_mean(own: vec2<u32>, depth: f32) -> f32 {
    if !BOUNDED {
        return transmittance_before(own, depth, true);
    }
    return decode_each(depth);
}
