// Shows which leaves a draw draws: leaf `id` covers texel `id` of a target TARGET_WIDTH wide, and
// adds one 255th to it. Tests and gates compare the image with the kept set.
override TARGET_WIDTH: u32 = 1024u;
override TARGET_HEIGHT: u32 = 1024u;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let id = index / 4u;
    let corner = index % 4u;
    // Corners 0..3 go around the texel.
    let u = select(0u, 1u, corner == 1u || corner == 2u);
    let v = select(0u, 1u, corner >= 2u);
    let x = f32(id % TARGET_WIDTH + u) / f32(TARGET_WIDTH);
    let y = f32(id / TARGET_WIDTH + v) / f32(TARGET_HEIGHT);
    return vec4(2.0 * x - 1.0, 1.0 - 2.0 * y, 0.5, 1.0);
}

@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4(1.0 / 255.0, 0.0, 0.0, 0.0);
}
