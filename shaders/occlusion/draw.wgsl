// Draws objects to the G-buffer: ids, normal and albedo. Corners are pulled from storage buffers, so
// that a triangle's index within its object is known; an instance is an object of the list.
#import common/occlusion_scene.wgsl
#import common/occlusion_view.wgsl

// The objects drawn, in order.
@group(1) @binding(1) var<storage, read> drawn: array<u32>;

struct Varyings {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat, first) object: u32,
    @location(1) @interpolate(flat, first) triangle: u32,
    @location(2) uv: vec2<f32>,
}

@vertex
fn corner(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varyings {
    let object = drawn[instance];
    let shape = objects[object].shape;
    let index = corners[3u * shapes[shape].first_triangle + vertex];
    var uv = vec2(0.0);
    if shapes[shape].mask_width > 0u {
        let first = 2u * (shapes[shape].first_uv + index - shapes[shape].first_corner);
        uv = vec2(uvs[first], uvs[first + 1u]);
    }
    return Varyings(project(placed(object, index)), object, vertex / 3u, uv);
}

struct GBuffer {
    // Object + 1, triangle within it.
    @location(0) ids: vec2<u32>,
    @location(1) normal: vec4<f32>,
    @location(2) albedo: vec4<f32>,
}

// Unit normal of a triangle towards the eye, local space.
fn normal_of(object: u32, triangle: u32) -> vec3<f32> {
    let first = 3u * (shapes[objects[object].shape].first_triangle + triangle);
    let a = placed(object, corners[first]);
    let b = placed(object, corners[first + 1u]);
    let c = placed(object, corners[first + 2u]);
    let normal = normalize(cross(b - a, c - a));
    let away = select(a - view.eye, view.forward, view.parallel == 1u);
    return select(normal, -normal, dot(normal, away) > 0.0);
}

fn surface(in: Varyings) -> GBuffer {
    let albedo = shapes[objects[in.object].shape].albedo;
    return GBuffer(
        vec2(in.object + 1u, in.triangle),
        vec4(normal_of(in.object, in.triangle), 0.0),
        vec4(albedo[0], albedo[1], albedo[2], 1.0),
    );
}

@fragment
fn solid(in: Varyings) -> GBuffer {
    return surface(in);
}

// Texel along one axis, nearest, repeating.
fn wrapped(t: f32, size: u32) -> u32 {
    return min(u32((t - floor(t)) * f32(size)), size - 1u);
}

@fragment
fn masked(in: Varyings) -> GBuffer {
    let shape = objects[in.object].shape;
    let width = shapes[shape].mask_width;
    let row = wrapped(in.uv.y, shapes[shape].mask_height);
    let texel = row * width + wrapped(in.uv.x, width);
    if ((mask_words[shapes[shape].first_word + texel / 32u] >> (texel % 32u)) & 1u) == 0u {
        discard;
    }
    return surface(in);
}
