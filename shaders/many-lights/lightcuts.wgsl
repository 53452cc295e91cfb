// R2: the cluster with the largest bound is split until none exceeds its share of the whole, found by
// looking at every cluster of the cut.
// Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 3, and
// Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.2 (the scan).
#import common/lights_tree.wgsl
#import common/lights_shadow.wgsl
#import common/lights_sum.wgsl

// Mirrors LightcutsParams.
struct LightcutsParams {
    epsilon: f32,
    most: u32,
    // Invocations that have a column of `open_clusters` each.
    threads: u32,
    // From and to in `nodes`: trees of lights that move, in every cut.
    moving: u32,
    moving_end: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(1) @binding(3) var<uniform> params: LightcutsParams;
// Clusters that may still be split, node and bits of its bound, whose sign says that what stands for
// it is hidden; row k holds the k-th of every thread,
// so that neighbours read neighbouring words.
@group(1) @binding(4) var<storage, read_write> open_clusters: array<vec2<u32>>;

const HIDDEN = 0x80000000u;
// The bit of the number of the cut's nodes that says that the greatest size ended the cut.
const ENDED = 0x80000000u;
// A running sum keeps what a large estimate hid, when that is gone, only to its own rounding: it is
// made anew when it falls to this share of its largest.
const FALLEN = 0.25;

// The cut of one point, as it is made.
struct Cut {
    // Estimates of its single lights.
    leaves: Sum,
    // How many they are.
    single: u32,
    // Clusters that may still be split.
    open: u32,
    // Visits, bounds, lights evaluated.
    counted: vec3<u32>,
}

var<private> cut: Cut;
var<private> point: Point;
var<private> thread: u32;

fn place(k: u32) -> u32 {
    return k * params.threads + thread;
}

// Puts a node into the cut; its estimate.
fn put(i: u32) -> vec3<f32> {
    let node = nodes[i];
    let given = estimate(node, point, frame.clamp_squared);
    let estimated = seen(point, node.light, given);
    if node.size == 1u {
        cut.leaves = added(cut.leaves, estimated);
        cut.single += 1u;
    } else {
        let bound = bound_point(FORM, node, point, frame.clamp_squared);
        let hidden = select(0u, HIDDEN, any(estimated != given));
        open_clusters[place(cut.open)] = vec2<u32>(i, bitcast<u32>(bound) | hidden);
        cut.open += 1u;
    }
    if COUNT {
        cut.counted += vec3<u32>(vec3<bool>(true, node.size != 1u, node.size == 1u));
    }
    return estimated;
}

// What a cluster that may still be split gives.
fn given_by(cluster: vec2<u32>) -> vec3<f32> {
    if (cluster.y & HIDDEN) != 0u {
        return vec3<f32>(0.0);
    }
    return estimate(nodes[cluster.x], point, frame.clamp_squared);
}

// The whole estimate, from what the cut holds.
fn whole() -> vec3<f32> {
    var sum = no_sum();
    for (var k = 0u; k < cut.open; k++) {
        sum = added(sum, given_by(open_clusters[place(k)]));
    }
    return result_of(sum) + result_of(cut.leaves);
}

// Whether a node has at most so many children.
fn has_at_most(i: u32, most: u32) -> bool {
    let end = i + nodes[i].size;
    var child = i + 1u;
    for (var count = 0u; child < end; count++) {
        if count == most {
            return false;
        }
        child += nodes[child].size;
    }
    return true;
}

// Makes the cut; whether its greatest size ended it.
fn make_cut() -> bool {
    var total = vec3<f32>(0.0);
    let range = range_of(point.object);
    for (var s = range.x; s < range.y; s++) {
        if !is_start_hidden(s, point.position.y) {
            total += put(start_of(s));
        }
    }
    for (var root = params.moving; root < params.moving_end; root += nodes[root].size) {
        total += put(root);
    }
    var largest = greatest(total);
    while cut.open > 0u {
        // The largest bound; of equal ones the first node.
        var worst = 0u;
        var worst_node = 0u;
        var worst_bound = -1.0;
        for (var k = 0u; k < cut.open; k++) {
            let cluster = open_clusters[place(k)];
            let bound = bitcast<f32>(cluster.y & ~HIDDEN);
            if bound > worst_bound || (bound == worst_bound && cluster.x < worst_node) {
                worst = k;
                worst_node = cluster.x;
                worst_bound = bound;
            }
        }
        if worst_bound <= params.epsilon * greatest(total) {
            return false;
        }
        let others = cut.single + cut.open - 1u;
        if others >= params.most || !has_at_most(worst_node, params.most - others) {
            return true;
        }
        cut.open -= 1u;
        total -= given_by(open_clusters[place(worst)]);
        open_clusters[place(worst)] = open_clusters[place(cut.open)];
        let end = worst_node + nodes[worst_node].size;
        for (var child = worst_node + 1u; child < end; child += nodes[child].size) {
            total += put(child);
        }
        if greatest(total) <= FALLEN * largest {
            total = whole();
            largest = greatest(total);
        }
        largest = max(largest, greatest(total));
    }
    return false;
}

fn light_pixel(pixel: u32) {
    point = points[pixel];
    cut = Cut(no_sum(), 0u, 0u, vec3<u32>(0u));
    rays = 0u;
    var ended = false;
    if point.object != NOTHING {
        ended = make_cut();
    }
    radiance[pixel] = vec4<f32>(whole(), f32(rays));
    if COUNT {
        counts[pixel] = vec4<u32>(cut.counted, (cut.single + cut.open) | select(0u, ENDED, ended));
    }
}

@compute @workgroup_size(TILE, TILE)
fn light(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) lane: vec3<u32>,
) {
    thread = (group.x * TILE + lane.y) * TILE + lane.x;
    let columns = (frame.width + TILE - 1u) / TILE;
    let rows = (frame.height + TILE - 1u) / TILE;
    for (var tile = group.x; tile < columns * rows; tile += groups.x) {
        let pixel = vec2<u32>(tile % columns, tile / columns) * TILE + lane.xy;
        if is_inside(pixel) {
            light_pixel(index_of(pixel));
        }
    }
}
