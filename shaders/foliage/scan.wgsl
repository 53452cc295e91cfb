// Exclusive prefix sum of kept leaves: the offset of each cell, the total, and the indirect
// arguments that follow from it.
// Based on: Gumbau Portales, PhD thesis, Universitat Jaume I, 2011, equation 3.6; Blelloch,
// Prefix sums and their applications, CMU-CS-90-190, 1990 (reduce, then scan).
// Deviations: the thesis increments a global counter for the total; here it is the last offset.
// A workgroup adds up the sums of the tiles before its own itself, which saves a pass: with 2048
// cells a tile there are few. Two levels of short serial sums need two barriers.
#import common/kept_counts.wgsl
#import common/index.wgsl

@group(0) @binding(3) var<storage, read> tile_sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> offsets: array<u32>;
// Five words of an indexed draw, three of the dispatch of thread per leaf.
@group(0) @binding(5) var<storage, read_write> arguments: array<u32>;

const ROW = 16u; // LANES = ROW * ROW

var<workgroup> lane_sums: array<u32, LANES>;
var<workgroup> lane_bases: array<u32, LANES>;
var<workgroup> row_sums: array<u32, ROW>;
var<workgroup> row_bases: array<u32, ROW>;

@compute @workgroup_size(LANES)
fn scan(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let tile = linear_group(group, groups);
    var base = 0u;
    for (var t = lane; t < min(tile, params.n_tiles); t += LANES) {
        base += tile_sums[t];
    }
    let first = tile * TILE + lane * ITEMS;
    var counts: array<u32, ITEMS>;
    var sum = 0u;
    for (var i = 0u; i < ITEMS; i++) {
        counts[i] = kept_of(first + i);
        sum += counts[i];
    }
    lane_sums[lane] = sum;
    lane_bases[lane] = base;
    workgroupBarrier();

    if lane < ROW {
        var row = 0u;
        var bases = 0u;
        for (var j = 0u; j < ROW; j++) {
            let k = lane * ROW + j;
            let own = lane_sums[k];
            lane_sums[k] = row;
            row += own;
            bases += lane_bases[k];
        }
        row_sums[lane] = row;
        row_bases[lane] = bases;
    }
    workgroupBarrier();

    var offset = lane_sums[lane];
    for (var r = 0u; r < ROW; r++) {
        offset += row_bases[r];
        if r < lane / ROW {
            offset += row_sums[r];
        }
    }
    for (var i = 0u; i < ITEMS; i++) {
        if first + i < params.n_cells {
            offsets[first + i] = offset;
        }
        offset += counts[i];
    }
    // Cells beyond the last count 0: the last lane of the last tile ends at the total.
    if lane == LANES - 1u && tile == params.n_tiles - 1u {
        offsets[params.n_cells] = offset;
        arguments[0] = 6u * offset;
        arguments[1] = 1u;
        arguments[2] = 0u;
        arguments[3] = 0u;
        arguments[4] = 0u;
        // One workgroup at least: an empty pass has no duration to measure.
        let needed = max((offset + LANES - 1u) / LANES, 1u);
        let rows = (needed + params.max_groups - 1u) / params.max_groups;
        arguments[5] = (needed + rows - 1u) / rows;
        arguments[6] = rows;
        arguments[7] = 1u;
    }
}
