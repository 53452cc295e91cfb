// R3 and R4: every pixel walks the tree, skipping what stands for its lights. No stack, no list.
// Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 3.1 and 3.2.
#import common/lights_rule.wgsl
#import common/lights_shadow.wgsl

@compute @workgroup_size(TILE, TILE)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    var sum = no_sum();
    // Visits, bounds, lights, nodes of the cut.
    var counted = vec4<u32>(0u);
    if point.object != NOTHING {
        let range = range_of(point.object);
        for (var s = range.x; s <= range.y; s++) {
            let walk = walk_of(s, range.y, point.position.y);
            var i = walk.x;
            while i < walk.y {
                let node = nodes[i];
                let leaf = node.size == 1u;
                var taken = leaf;
                if !leaf {
                    var estimated = 0.0;
                    if RELATIVE {
                        estimated = greatest(estimate(node, point, frame.clamp_squared));
                    }
                    taken = is_taken(bound_point(FORM, node, point, frame.clamp_squared), estimated);
                }
                if taken {
                    let given = estimate(node, point, frame.clamp_squared);
                    sum = added(sum, seen(point, node.light, given));
                }
                if COUNT {
                    counted += vec4<u32>(vec4<bool>(true, !leaf, leaf, taken));
                }
                i += select(1u, node.size, taken);
            }
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum), f32(rays));
    if COUNT {
        counts[pixel] = counted;
    }
}
