// Sorts points into cells and bounds each cell's points by a box.
// Based on: O. Olsson, M. Billeter and U. Assarsson, "Clustered deferred and forward shading", 2012,
// sections 3.1 and 3.2 (explicit bounds).
// Deviations: smallest and largest by atomics instead of a sort of the points.
#import common/lights_cells.wgsl

@group(1) @binding(0) var<uniform> params: CellParams;
@group(1) @binding(1) var<storage, read_write> boxes: array<atomic<u32>>;

@compute @workgroup_size(TILE, TILE)
fn cells(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let point = points[index_of(id.xy)];
    if point.object == NOTHING {
        return;
    }
    let first = BOX_WORDS * cell_of(params, id.xy, point.position);
    for (var i = 0u; i < 3u; i++) {
        let at = ordered(point.position[i]);
        atomicMin(&boxes[first + i], at);
        atomicMax(&boxes[first + 3u + i], at);
    }
}
