// Stochastic lightcuts in real time: a tile shares a cut, made at one of its pixels by chance.
// Based on: D. Lin and C. Yuksel, "Real-time stochastic lightcuts", 2020.
#import common/lights_stochastic.wgsl

const REAL_TIME = true;

const LANES = TILE * TILE;
// Added to the seed: sample/form.rs.
const PIVOT_SEED = 0x9e3779b9u;

var<workgroup> slot_count: u32;
var<workgroup> is_ended: u32;
var<workgroup> is_there: array<u32, LANES>;
// The pixel at which the cut was made, and the nodes that were looked at.
var<workgroup> pivot: u32;
var<workgroup> pivot_visits: u32;
// The tile's number.
var<private> tile: u32;

fn place(slot: u32) -> u32 {
    return tile * params.stride + slot;
}

// The first pixel that shows anything, from a place by chance on and round; LANES without any.
fn find_pivot() -> u32 {
    start_random(params.seed + PIVOT_SEED, frame.frame, tile);
    let first = random_bits() >> 26u;
    for (var step = 0u; step < LANES; step++) {
        let lane = (first + step) % LANES;
        if is_there[lane] != 0u {
            return lane;
        }
    }
    return LANES;
}

@compute @workgroup_size(TILE, TILE)
fn light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let inside = is_inside(id.xy);
    let pixel = index_of(id.xy);
    var point: Point;
    point.object = NOTHING;
    if inside {
        point = points[pixel];
    }
    tile = group.y * groups.x + group.x;
    is_there[lane] = select(0u, 1u, point.object != NOTHING);
    workgroupBarrier();
    if lane == 0u {
        pivot = find_pivot();
        if pivot < LANES {
            let at = group.xy * TILE + vec2<u32>(pivot % TILE, pivot / TILE);
            is_ended = select(0u, 1u, make_cut(points[index_of(at)]));
        }
        pivot_visits = visits;
        visits = 0u;
    }
    workgroupBarrier();
    storageBarrier();
    if !inside {
        return;
    }
    if point.object == NOTHING {
        radiance[pixel] = vec4<f32>(0.0);
        if COUNT {
            counts[pixel] = vec4<u32>(0u);
        }
        return;
    }
    // The tile's cut is that pixel's work.
    if lane == pivot {
        visits = pivot_visits;
    }
    light_by_cut(pixel, point, is_ended != 0u);
}
