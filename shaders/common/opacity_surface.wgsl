// A fragment of the light's view: where a surface is there, and how thick it is.
struct SurfaceParams {
    // Alpha below this is a hole.
    cutoff: f32,
    // Size of the alpha texture in texels.
    alpha_width: u32,
    alpha_height: u32,
    // ALPHA_TESTED, FROM_OPAQUE_MAP.
    flags: u32,
    // Optical thickness of a fragment.
    omega: f32,
    // 1 - e^-omega.
    opacity: f32,
    pad0: u32,
    pad1: u32,
}

const ALPHA_TESTED = 1u;
// The fragment stands for the nearest opaque surface of its texel.
const FROM_OPAQUE_MAP = 2u;
// Depth of an opaque map's texel that nothing covers.
const NO_OPAQUE = 1.0;

@group(0) @binding(0) var<uniform> surface: SurfaceParams;
// One f32 a texel, row-major from v = 0 down.
@group(0) @binding(1) var<storage, read> alpha: array<f32>;
// Nearest opaque depths, not bound while they are drawn.
@group(0) @binding(2) var opaque_map: texture_depth_2d;

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) z: f32,
    @location(1) uv: vec2<f32>,
}

// Whether there is a surface: inside the light's range and no hole. Textures are read at the
// nearest texel and repeat.
fn is_surface(z: f32, uv: vec2<f32>) -> bool {
    if !(z >= 0.0 && z <= 1.0) {
        return false;
    }
    if (surface.flags & ALPHA_TESTED) == 0u {
        return true;
    }
    let size = vec2(surface.alpha_width, surface.alpha_height);
    let wrapped = uv - floor(uv);
    let texel = min(vec2<u32>(wrapped * vec2<f32>(size)), size - 1u);
    return alpha[texel.y * size.x + texel.x] >= surface.cutoff;
}

// Depth of what takes part in the opacity maps, or a negative number for nothing: translucent
// surfaces in front of the nearest opaque one, or that one itself.
fn taking_part(z: f32, uv: vec2<f32>, texel: vec2<u32>) -> f32 {
    let nearest = textureLoad(opaque_map, texel, 0);
    if (surface.flags & FROM_OPAQUE_MAP) != 0u {
        return select(-1.0, nearest, nearest < NO_OPAQUE);
    }
    if !is_surface(z, uv) || (nearest < NO_OPAQUE && z >= nearest) {
        return -1.0;
    }
    // Not -0: its bits are those of a large number.
    return abs(z);
}
