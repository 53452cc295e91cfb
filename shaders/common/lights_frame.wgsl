// What kernels over the points of a frame read and write: one thread a pixel, one workgroup of 8 x 8
// a tile.
#import common/lights.wgsl

// Mirrors PackedLight.
struct Light {
    position: vec3<f32>,
    half_angle_rad: f32,
    intensity: vec3<f32>,
    kind: u32,
    axis: vec3<f32>,
    pad: u32,
}

// Mirrors FrameParams.
struct FrameParams {
    width: u32,
    height: u32,
    lights: u32,
    frame: u32,
    clamp_squared: f32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> frame: FrameParams;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read_write> radiance: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> counts: array<vec4<u32>>;

// Whether `counts` is written. A constant, so that frames which are timed pay nothing for it.
override COUNT: bool = false;

const NOTHING = 0xffffffffu;
const TILE = 8u;

fn is_inside(pixel: vec2<u32>) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
}

fn index_of(pixel: vec2<u32>) -> u32 {
    return pixel.y * frame.width + pixel.x;
}

// A light as the leaf that it is.
fn leaf_of(light: Light, index: u32) -> LightNode {
    return LightNode(
        light.position,
        0.0,
        light.intensity,
        1u,
        light.axis,
        light.half_angle_rad,
        light.position,
        index,
        light.position,
        light.kind,
    );
}
