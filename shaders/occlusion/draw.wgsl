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
    // Towards the eye, local space.
    @location(2) @interpolate(flat, first) normal: vec3<f32>,
    @location(3) uv: vec2<f32>,
}

fn octahedron(packed: u32) -> vec3<f32> {
    let e = unpack2x16snorm(packed);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let xy = e - vec2(select(-fold, fold, e.x >= 0.0), select(-fold, fold, e.y >= 0.0));
    return normalize(vec3(xy, z));
}

// A normal is carried by the cofactors of the linear part; a mirrored object's is turned over, which
// does not matter here: it is made to look at `p`'s eye.
fn normal_at(object: u32, packed: u32, p: vec3<f32>) -> vec3<f32> {
    let n = octahedron(packed);
    let x = column(object, 0u);
    let y = column(object, 3u);
    let z = column(object, 6u);
    let local = normalize(cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z);
    let away = select(p - view.eye, view.forward, view.parallel == 1u);
    return select(local, -local, dot(local, away) > 0.0);
}

@vertex
fn corner(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varyings {
    let object = drawn[instance];
    let shape = objects[object].shape;
    let triangle = vertex / 3u;
    let packed = triangles[shapes[shape].first_triangle + triangle];
    let index = packed[vertex % 3u];
    let p = placed(object, index);
    var uv = vec2(0.0);
    if shapes[shape].mask_width > 0u {
        let first = 2u * (shapes[shape].first_uv + index - shapes[shape].first_corner);
        uv = vec2(uvs[first], uvs[first + 1u]);
    }
    return Varyings(project(p), object, triangle, normal_at(object, packed.w, p), uv);
}

struct GBuffer {
    // Object + 1, triangle within it.
    @location(0) ids: vec2<u32>,
    @location(1) normal: vec4<f32>,
    @location(2) albedo: vec4<f32>,
}

fn surface(in: Varyings) -> GBuffer {
    let albedo = shapes[objects[in.object].shape].albedo;
    return GBuffer(
        vec2(in.object + 1u, in.triangle),
        vec4(in.normal, 0.0),
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
