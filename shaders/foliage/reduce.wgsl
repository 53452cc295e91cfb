// Sums of kept leaves, one for each tile of cells: first of the two passes of the prefix sum,
// needed only when there is more than one tile.
// Based on: Blelloch, Prefix sums and their applications, CMU-CS-90-190, 1990 (up-sweep); two
// levels of short serial sums in place of a tree need two barriers in place of eight.
#import common/kept_counts.wgsl
#import common/index.wgsl

@group(0) @binding(3) var<storage, read_write> tile_sums: array<u32>;

const ROW = 16u; // LANES = ROW * ROW

var<workgroup> lane_sums: array<u32, LANES>;
var<workgroup> row_sums: array<u32, ROW>;

@compute @workgroup_size(LANES)
fn reduce(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let tile = linear_group(group, groups);
    // The order does not matter to a sum: neighbouring lanes take neighbouring cells.
    var sum = 0u;
    for (var i = 0u; i < ITEMS; i++) {
        sum += kept_of(tile * TILE + i * LANES + lane);
    }
    lane_sums[lane] = sum;
    workgroupBarrier();
    if lane < ROW {
        var row = 0u;
        for (var j = 0u; j < ROW; j++) {
            row += lane_sums[lane * ROW + j];
        }
        row_sums[lane] = row;
    }
    workgroupBarrier();
    if lane == 0u && tile < params.n_tiles {
        var total = 0u;
        for (var r = 0u; r < ROW; r++) {
            total += row_sums[r];
        }
        tile_sums[tile] = total;
    }
}
