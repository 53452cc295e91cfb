// One triangle that covers clip space (vertices beyond it on two sides), at depth 0.5, constant
// red. Probes and tests cut it with scissor rectangles, or draw `lower_left` for the lower left half.
@vertex
fn full(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32((i & 1u) << 2u), f32((i & 2u) << 1u)) - 1.0;
    return vec4(corner, 0.5, 1.0);
}

@vertex
fn lower_left(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32((i & 1u) << 1u), f32(i & 2u)) - 1.0;
    return vec4(corner, 0.5, 1.0);
}

@fragment
fn red() -> @location(0) vec4<f32> {
    return vec4(1.0, 0.0, 0.0, 1.0);
}
