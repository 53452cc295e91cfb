// Stochastic lightcuts: every pixel has a cut of its own.
// Based on: C. Yuksel, "Stochastic lightcuts", 2019.
// Workgroups share out the tiles, so that there are few columns of slots.
#import common/lights_stochastic.wgsl

const REAL_TIME = false;

var<private> slot_count: u32;
// The thread's column.
var<private> column: u32;

fn place(slot: u32) -> u32 {
    return slot * params.stride + column;
}

@compute @workgroup_size(TILE, TILE)
fn light(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) lane: vec3<u32>,
) {
    column = (group.x * TILE + lane.y) * TILE + lane.x;
    let columns = (frame.width + TILE - 1u) / TILE;
    let rows = (frame.height + TILE - 1u) / TILE;
    for (var tile = group.x; tile < columns * rows; tile += groups.x) {
        let id = vec2<u32>(tile % columns, tile / columns) * TILE + lane.xy;
        if !is_inside(id) {
            continue;
        }
        let pixel = index_of(id);
        let point = points[pixel];
        visits = 0u;
        slot_count = 0u;
        var ended = false;
        if point.object != NOTHING {
            ended = make_cut(point);
        }
        light_by_cut(pixel, point, ended);
    }
}
