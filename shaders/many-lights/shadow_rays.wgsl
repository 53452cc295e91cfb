// Shadow rays alone, so many a pixel: what hides how many lights. To hold rays in f32 against those
// in f64, and to time them.
#import common/lights_shadow.wgsl

// Lights that rays go to, as many for each pixel.
@group(1) @binding(0) var<storage, read> targets: array<u32>;

// Rays of a pixel.
override RAYS: u32 = 1u;

@compute @workgroup_size(TILE, TILE)
fn trace(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    // A bit for each of the first 32.
    var found = 0u;
    var many = 0u;
    if point.object != NOTHING {
        for (var ray = 0u; ray < RAYS; ray++) {
            if sees(point, targets[pixel * RAYS + ray]) {
                found |= select(0u, 1u << (ray & 31u), ray < 32u);
                many++;
            }
        }
    }
    radiance[pixel] = vec4<f32>(f32(many));
    counts[pixel] = vec4<u32>(found, many, 0u, 0u);
}
