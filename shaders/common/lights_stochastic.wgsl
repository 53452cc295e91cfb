// Stochastic lightcuts, of a pixel or a tile: sample/stochastic.rs, where sources and deviations stand.
// Importers define REAL_TIME, and where the cut lies: `place(slot) -> u32` in `slots`, and
// `slot_count: u32`.
#import common/lights_draw.wgsl

const MEASURES = 2u;

const ENDED = 0x80000000u;

// A node and the bits of its error bound, 0 where it is not to be split: of the greatest number a cut,
// and two more while a node is split.
@group(1) @binding(4) var<storage, read_write> slots: array<vec2<u32>>;

// How much may come from a node were all its lights as near, and as far, as its box allows.
fn worth(index: u32, point: Point) -> vec2<f32> {
    let node = nodes[index];
    var near = 1.0;
    var far = 1.0;
    if node.kind != KIND_DIRECTIONAL {
        let low = node.low - point.position;
        let high = node.high - point.position;
        let outside = max(max(low, -high), vec3<f32>(0.0));
        let farthest = max(abs(low), abs(high));
        near = max(dot(outside, outside), frame.clamp_squared);
        far = max(dot(farthest, farthest), frame.clamp_squared);
    }
    var bound: f32;
    if node.size == 1u {
        bound = greatest(estimate(node, point, frame.clamp_squared));
    } else {
        bound = bound_point(FORM, node, point, frame.clamp_squared);
    }
    return vec2<f32>(bound, bound * (near / far));
}

// Adds a node that can give anything, in real time to any pixel; a light is exact, and not to be
// split.
fn add_slot(node: u32, point: Point) {
    visits += 1u;
    let error = worth(node, point).x;
    if error > 0.0 || (REAL_TIME && greatest(nodes[node].intensity) > 0.0) {
        let open = select(error, 0.0, nodes[node].size == 1u);
        slots[place(slot_count)] = vec2<u32>(node, bitcast<u32>(open));
        slot_count += 1u;
    }
}

// Fills the slots with the cut at a point. Whether it was its size that ended it.
fn make_cut(point: Point) -> bool {
    var ended = false;
    slot_count = 0u;
    let range = ranges[0];
    for (var s = range.x; s < range.y; s++) {
        add_slot(starts[s], point);
    }
    loop {
        var worst = 0u;
        var worst_error = 0.0;
        for (var k = 0u; k < slot_count; k++) {
            let error = bitcast<f32>(slots[place(k)].y);
            if error > worst_error {
                worst = k;
                worst_error = error;
            }
        }
        if worst_error == 0.0 {
            return ended;
        }
        if slot_count >= params.number {
            return true;
        }
        let before = slot_count;
        let parent = slots[place(worst)].x;
        let end = parent + nodes[parent].size;
        var child = parent + 1u;
        while child < end && slot_count <= params.number + 1u {
            add_slot(child, point);
            child += nodes[child].size;
        }
        if slot_count > params.number + 1u {
            slot_count = before;
            slots[place(worst)].y = 0u;
            ended = true;
        } else {
            slot_count -= 1u;
            slots[place(worst)] = slots[place(slot_count)];
        }
    }
    return ended;
}

// Lights a pixel: one light of every node of the cut, over its chance.
fn light_by_cut(pixel: u32, point: Point, ended: bool) {
    start_random(params.seed, frame.frame, pixel);
    rays = 0u;
    var sum = no_sum();
    var lights = 0u;
    var drawn_lights = 0u;
    for (var k = 0u; k < slot_count; k++) {
        var drawn = Drawn(slots[place(k)].x, 1.0);
        if nodes[drawn.leaf].size > 1u {
            drawn = draw_below(choose_child(drawn.leaf, point), point);
            drawn_lights += select(0u, 1u, drawn.chance > 0.0);
        }
        if drawn.chance > 0.0 {
            lights += 1u;
            let leaf = nodes[drawn.leaf];
            let given = estimate(leaf, point, frame.clamp_squared);
            sum = added(sum, seen(point, leaf.light, given) / drawn.chance);
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum), f32(rays));
    if COUNT {
        let last = slot_count | select(0u, ENDED, ended);
        counts[pixel] = vec4<u32>(visits, drawn_lights, lights, last);
    }
}
