// Transmittance from layers of opacity. The importer defines `stored_layer`, the number that a
// texel keeps for a layer, and binds `layered`, `table` and `bounds_map`.
#import common/opacity_number.wgsl

// LOOKUP.
const LERP = 0u;
const NEAREST = 1u;
const EXCLUSIVE = 2u;
override LOOKUP: u32 = 0u;
// Whether a texture holds the fragments of its own layers alone.
override SLABS: bool = false;
// Thickness is multiplied by the share of taps whose first fragment lies in front.
override SOFT_START: bool = false;

// Number stored for a layer: of a texel, or the mean over all taps.
fn number(texel: vec2<u32>, layer: u32, mean: bool) -> f32 {
    if !mean {
        return stored_layer(texel, layer);
    }
    var sum = 0.0;
    for (var i = 0u; i < tap_count; i++) {
        sum += stored_layer(taps[i].texel, layer);
    }
    return sum / f32(tap_count);
}

// Thickness up to and including a layer.
fn thickness(texel: vec2<u32>, layer: u32, mean: bool) -> f32 {
    var sum = thickness_of(number(texel, layer, mean), layered.scale);
    if SLABS {
        for (var slab = 0u; slab < layer / 4u; slab++) {
            sum += thickness_of(number(texel, 4u * slab + 3u, mean), layered.scale);
        }
    }
    return sum;
}

fn thickness_before(texel: vec2<u32>, depth: f32, mean: bool) -> f32 {
    let ends = ends_of(texel);
    if depth < ends.x {
        return 0.0;
    }
    let last = layered.layers - 1u;
    let open_ended = LAYOUT == DEEP || LAYOUT == DEEP_UNIFORM;
    if !open_ended && depth > ends.y {
        return thickness(texel, last, mean);
    }
    let coordinate = layer_coordinate(depth, ends, lambda_of(texel));
    let layer = layer_of(coordinate);
    if LOOKUP == NEAREST {
        return thickness(texel, layer, mean);
    }
    var before = 0.0;
    if layer > 0u {
        before = thickness(texel, layer - 1u, mean);
    }
    if LOOKUP == EXCLUSIVE {
        return before;
    }
    return mix(before, thickness(texel, layer, mean), clamp(coordinate - f32(layer), 0.0, 1.0));
}

fn decode(texel: vec2<u32>, depth: f32) -> f32 {
    return exp(-thickness_before(texel, depth, false));
}

fn decode_mean(own: vec2<u32>, depth: f32) -> f32 {
    var behind_start = 1.0;
    if SOFT_START {
        behind_start = 0.0;
        for (var i = 0u; i < tap_count; i++) {
            behind_start += select(0.0, 1.0 / f32(tap_count), depth > ends_of(taps[i].texel).x);
        }
    }
    return exp(-thickness_before(own, depth, true) * behind_start);
}
