// Lights drawn down a tree in proportion to what may come from them.
// Based on: A. Conty Estevez and C. Kulla, "Importance sampling of many lights with adaptive tree
// splitting", 2018; sources and deviations in sample/{light_bvh,walked}.rs.
#import common/lights_draw.wgsl

const MEASURES = 1u;

// Taken off every smallest angle, radians: walked.rs.
const SLACK_RAD = 1e-4;

fn cosine_least(angle_rad: f32) -> f32 {
    return cosine_or_none(max(angle_rad - SLACK_RAD, 0.0));
}

// packed_importance() of walked.rs, operation for operation.
fn importance(node: LightNode, point: Point) -> f32 {
    if node.size == 1u {
        return dot(estimate(node, point, frame.clamp_squared), LUMINANCE);
    }
    let energy = dot(point.albedo * node.intensity, LUMINANCE) * OVER_PI;
    if node.kind == KIND_DIRECTIONAL {
        return energy * cosine_least(angle_between(point.normal, -node.axis) - node.cone_rad);
    }
    let low = node.low - point.position;
    let high = node.high - point.position;
    let centre = 0.5 * (low + high);
    let reach = 0.5 * (high - low);
    let radius_squared = dot(reach, reach);
    let squared = dot(centre, centre);
    let over = max(max(squared, radius_squared), frame.clamp_squared);
    if squared <= radius_squared {
        return energy / over;
    }
    let direction = centre / sqrt(squared);
    let sine_squared = radius_squared / squared;
    let twice = 2.0 + 2.0 * sqrt(max(1.0 - sine_squared, 0.0));
    let spread = 2.0 * arc_sine(sqrt(sine_squared / twice));
    let incident = cosine_least(angle_between(point.normal, direction) - spread);
    if incident == 0.0 {
        return 0.0;
    }
    var leaving = 1.0;
    if node.kind != KIND_OMNI {
        let between = angle_between(node.axis, -direction);
        let least = max(between - node.cone_rad - spread - SLACK_RAD, 0.0);
        if node.kind == KIND_ORIENTED {
            leaving = cosine_or_none(least);
        } else {
            leaving = max(1.0 - least / node.half_angle_rad, 0.0);
        }
    }
    return energy * (incident * leaving / over);
}

fn worth(node: u32, point: Point) -> vec2<f32> {
    return vec2<f32>(importance(nodes[node], point), 0.0);
}

@compute @workgroup_size(TILE, TILE)
fn light(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    start_random(params.seed, frame.frame, pixel);
    var sum = no_sum();
    var drawn_lights = 0u;
    if point.object != NOTHING {
        for (var sample = 0u; sample < params.number; sample++) {
            let drawn = draw_below(choose_root(point), point);
            if drawn.chance > 0.0 {
                drawn_lights += 1u;
                let leaf = nodes[drawn.leaf];
                let given = estimate(leaf, point, frame.clamp_squared);
                sum = added(sum, seen(point, leaf.light, given) / drawn.chance);
            }
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum) / f32(params.number), f32(rays));
    if COUNT {
        counts[pixel] = vec4<u32>(visits, drawn_lights, drawn_lights, 0u);
    }
}
