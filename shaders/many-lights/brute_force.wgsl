// R0: every light at every pixel. All lanes read the same light at once, so no workgroup memory is
// needed: caches hand it to all of them.
#import common/lights_shadow.wgsl
#import common/lights_sum.wgsl

@group(1) @binding(0) var<storage, read> lights: array<Light>;

@compute @workgroup_size(TILE, TILE)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    var total = vec3<f32>(0.0);
    let there = point.object != NOTHING;
    if there {
        for (var first = 0u; first < frame.lights; first += BLOCK) {
            let end = min(first + BLOCK, frame.lights);
            var block = vec3<f32>(0.0);
            for (var i = first; i < end; i++) {
                block += seen(point, i, estimate(leaf_of(lights[i], i), point, frame.clamp_squared));
            }
            total += block;
        }
    }
    radiance[pixel] = vec4<f32>(total, f32(rays));
    if COUNT {
        counts[pixel] = vec4<u32>(0u, 0u, select(0u, frame.lights, there), 0u);
    }
}
