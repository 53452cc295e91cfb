// Rasterises light-space triangles to linear depth: (u, v) is the position in the map, and z, 0 at
// the near plane and 1 at the far plane, is what the depth buffer tests and keeps.
struct DepthParams {
    // Alpha below this is a hole.
    cutoff: f32,
    // Size of the alpha texture in texels; unused without one.
    alpha_width: u32,
    alpha_height: u32,
    pad: u32,
}

// The square of the light's map that is drawn: (u, v) of its corner, and 1 / side. (0, 0, 1)
// is the whole, and leaves positions as they are to the bit.
struct Crop {
    offset_u: f32,
    offset_v: f32,
    per_side: f32,
    pad: f32,
}

@group(0) @binding(0) var<uniform> params: DepthParams;
// One f32 a texel, row-major from v = 0 down.
@group(0) @binding(1) var<storage, read> alpha: array<f32>;
@group(1) @binding(0) var<uniform> crop: Crop;

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) z: f32,
    @location(1) uv: vec2<f32>,
}

// position: (u w, v w, w); w is 1 for parallel light, and the distance along the light's axis for
// perspective. Clip depth only has to stay inside: the test uses z.
@vertex
fn place(
    @location(0) position: vec3<f32>,
    @location(1) z: f32,
    @location(2) uv: vec2<f32>,
) -> Varyings {
    let w = position.z;
    let x = (position.x - crop.offset_u * w) * crop.per_side;
    let y = (position.y - crop.offset_v * w) * crop.per_side;
    let clip = vec4(2.0 * x - w, w - 2.0 * y, 0.5 * w, w);
    return Varyings(clip, z, uv);
}

// Outside 0..=1 is outside the light's range.
fn within_range(z: f32) -> f32 {
    if z < 0.0 || z > 1.0 {
        discard;
    }
    return z;
}

@fragment
fn opaque(in: Varyings) -> @builtin(frag_depth) f32 {
    return within_range(in.z);
}

// Nearest texel, repeated in both directions.
@fragment
fn cut_out(in: Varyings) -> @builtin(frag_depth) f32 {
    let size = vec2(params.alpha_width, params.alpha_height);
    let wrapped = in.uv - floor(in.uv);
    let texel = min(vec2<u32>(wrapped * vec2<f32>(size)), size - 1u);
    if alpha[texel.y * size.x + texel.x] < params.cutoff {
        discard;
    }
    return within_range(in.z);
}
