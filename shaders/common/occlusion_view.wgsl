// A camera as `camera::gpu` uploads it.
struct View {
    // Eye-relative local space to clip space, depth reversed.
    clip: mat4x4<f32>,
    // The eye is the sum of both parts: near it, coordinates far from the origin keep their bits.
    eye_high: vec3<f32>,
    // 1 for a camera with an eye, 0 for parallel rays.
    perspective: f32,
    eye_low: vec3<f32>,
    pad: f32,
    // Unit view direction.
    forward: vec3<f32>,
    pad2: f32,
}

@group(1) @binding(0) var<uniform> view: View;

fn from_eye(p: vec3<f32>) -> vec3<f32> {
    return (p - view.eye_high) - view.eye_low;
}

fn project(p: vec3<f32>) -> vec4<f32> {
    return view.clip * vec4(from_eye(p), 1.0);
}
