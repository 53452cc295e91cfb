// Sums over all fragments of a ray, whatever they are sums of. The importer binds `series`,
// `bounds_map` and `opaque_map`.
#import common/opacity_bounds.wgsl

struct SeriesParams {
    // Numbers of a texel: 2 n + 1 coefficients, or moments with the zeroth.
    numbers: u32,
    // Share of the absorption at a receiver's own depth that counts as in front of it.
    own: f32,
    // Pull towards safe moments.
    bias: f32,
    pad0: u32,
}

// Whether depths are taken between each ray's bounds, or over the light's whole range.
override BOUNDED: bool = false;

fn ends_of(texel: vec2<u32>) -> vec2<f32> {
    if BOUNDED {
        return own_ends(texel);
    }
    return vec2(0.0, 1.0);
}

// Share of the way from a ray's first fragment to its last, 0..=1.
fn share_of_way(depth: f32, ends: vec2<f32>) -> f32 {
    let range = ends.y - ends.x;
    if range < THIN {
        return select(0.0, 1.0, depth > ends.y);
    }
    return clamp((depth - ends.x) / range, 0.0, 1.0);
}
