// Sums the lights of each point's cell, each to its reach.
#import common/lights_cells.wgsl
#import common/lights_shadow.wgsl
#import common/lights_sum.wgsl

@group(1) @binding(0) var<uniform> params: CellParams;
@group(1) @binding(1) var<storage, read> lights: array<Light>;
@group(1) @binding(2) var<storage, read> heads: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> list: array<u32>;

// Whether lights fade towards the end of their reach.
override FADED: bool = false;

fn share_of(squared: f32, reach_squared: f32) -> f32 {
    if squared > reach_squared {
        return 0.0;
    }
    let ratio = squared / reach_squared;
    let left = max(1.0 - ratio * ratio, 0.0);
    return select(1.0, left * left, FADED);
}

@compute @workgroup_size(TILE, TILE)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    var sum = no_sum();
    var head = vec2<u32>(0u);
    if point.object != NOTHING {
        head = heads[cell_of(params, id.xy, point.position)];
        for (var i = head.x; i < head.x + head.y; i++) {
            let light = lights[list[i]];
            var share = 1.0;
            if light.kind != KIND_DIRECTIONAL {
                let to_light = light.position - point.position;
                share = share_of(dot(to_light, to_light), bitcast<f32>(light.pad));
            }
            if share > 0.0 {
                let given = estimate(leaf_of(light, i), point, frame.clamp_squared);
                sum = added(sum, seen_light(point, light, given * share));
            }
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum), f32(rays));
    if COUNT {
        counts[pixel] = vec4<u32>(0u, 0u, head.y, 0u);
    }
}
