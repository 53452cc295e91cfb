// Sums the lights that were chosen for each tile.
#import common/lights_shadow.wgsl
#import common/lights_sum.wgsl

@group(1) @binding(0) var<storage, read> lights: array<Light>;
// First entry and number, one a tile.
@group(1) @binding(1) var<storage, read> heads: array<vec2<u32>>;
@group(1) @binding(2) var<storage, read> list: array<u32>;

@compute @workgroup_size(TILE, TILE)
fn light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    var sum = no_sum();
    var head = vec2<u32>(0u);
    if point.object != NOTHING {
        head = heads[tile.y * tiles.x + tile.x];
        for (var i = head.x; i < head.x + head.y; i++) {
            let node = leaf_of(lights[list[i]], list[i]);
            let given = estimate(node, point, frame.clamp_squared);
            sum = added(sum, seen(point, node.light, given));
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum), f32(rays));
    if COUNT {
        counts[pixel] = vec4<u32>(0u, 0u, head.y, 0u);
    }
}
