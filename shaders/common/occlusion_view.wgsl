// A camera as `camera::gpu` uploads it.
struct View {
    // From positions relative to the eye to clip space, depth reversed.
    clip: mat4x4<f32>,
    eye: vec3<f32>,
    // 1 for parallel rays, else 0.
    parallel: u32,
    // Unit view direction.
    forward: vec3<f32>,
    pad: u32,
}

@group(1) @binding(0) var<uniform> view: View;

fn project(p: vec3<f32>) -> vec4<f32> {
    return view.clip * vec4(p - view.eye, 1.0);
}
