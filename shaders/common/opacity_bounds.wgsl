// A ray's own bounds. The importer binds `bounds_map` and `opaque_map`.

// Whether an opaque surface is a ray's bounds where nothing translucent lies.
override OPAQUE_ALONE: bool = false;

// Bounds nearer to each other than this are one.
const THIN = 1e-6;

// First and last depth of a texel, (1, 0) without any.
fn own_ends(texel: vec2<u32>) -> vec2<f32> {
    let stored = textureLoad(bounds_map, texel, 0).xy;
    let ends = vec2(-stored.x, stored.y);
    if OPAQUE_ALONE && ends.x >= 1.0 {
        let opaque = textureLoad(opaque_map, texel, 0);
        if opaque < 1.0 {
            return vec2(opaque);
        }
    }
    return ends;
}
