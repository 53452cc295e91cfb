// Probe: rounding of f32 -> f16 by textureStore. The texture is one row, a value a texel.
@group(0) @binding(0) var<storage, read_write> values: array<f32>;
@group(0) @binding(1) var image: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(1)
fn store_f16() {
    for (var i = 0u; i < arrayLength(&values); i++) {
        textureStore(image, vec2(i, 0u), vec4(values[i]));
    }
}
