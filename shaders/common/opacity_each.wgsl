// The mean transmittance over all taps, for what cannot be averaged before it is decoded.
fn decode_each(depth: f32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < tap_count; i++) {
        sum += decode(taps[i].texel, depth);
    }
    return sum / f32(tap_count);
}
