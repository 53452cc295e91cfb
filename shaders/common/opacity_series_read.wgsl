// Numbers of a texel, or the mean over all taps, and what is decoded from them. The importer binds
// `maps` and defines `transmittance_before`.
#import common/opacity_each.wgsl

fn number(texel: vec2<u32>, index: u32, mean: bool) -> f32 {
    if !mean {
        return textureLoad(maps, texel, index / 4u, 0)[index % 4u];
    }
    var sum = 0.0;
    for (var i = 0u; i < tap_count; i++) {
        sum += textureLoad(maps, taps[i].texel, index / 4u, 0)[index % 4u];
    }
    return sum / f32(tap_count);
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
