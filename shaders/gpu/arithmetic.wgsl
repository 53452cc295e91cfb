// Probe: rounding of f32 -> f16 by pack2x16float, subnormals, contraction of a * b + c.
// values: n pairs for pack2x16float, then [tiny, half, a, c, one, three].
@group(0) @binding(0) var<storage, read_write> values: array<f32>;
@group(0) @binding(1) var<storage, read_write> bits: array<u32>;

@compute @workgroup_size(1)
fn round_f32() {
    let tail = arrayLength(&values) - 6u;
    let pairs = tail / 2u;
    for (var i = 0u; i < pairs; i++) {
        bits[i] = pack2x16float(vec2(values[2u * i], values[2u * i + 1u]));
    }
    bits[pairs] = bitcast<u32>(values[tail] * values[tail + 1u]);
    let a = values[tail + 2u];
    bits[pairs + 1u] = bitcast<u32>(a * a - values[tail + 3u]);
    bits[pairs + 2u] = bitcast<u32>(values[tail + 4u] / values[tail + 5u]);
}
