// The rasterised depths as a plain buffer: row-major, no padding between rows.
@group(0) @binding(0) var drawn: texture_depth_2d;
@group(0) @binding(1) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(64)
fn copy_depth(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(drawn);
    if id.x < size.x && id.y < size.y {
        depths[id.y * size.x + id.x] = textureLoad(drawn, vec2(id.x, id.y), 0);
    }
}
