// Index generation, one thread an output leaf: each finds its cell by binary search in the
// offsets. Balanced whatever the sizes of cells. Two lanes search all cells for those of the
// workgroup's first and last leaf; the others search between them, mostly one or two cells. Ids
// go through workgroup memory, so that the lanes can write the workgroup's words in the order
// they have in memory.
#import common/partition.wgsl
#import common/index.wgsl

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read> leaf_ids: array<u32>;
@group(0) @binding(4) var<storage, read_write> indices: array<vec2<u32>>;

var<workgroup> ids: array<u32, LANES>;
var<workgroup> ends: array<u32, 2>;

// The last of `count` cells from `from` on with offsets[c] <= leaf, in ceil(log2(count)) steps.
// Empty cells share their offset with the next one, so the last is the one that holds the leaf.
fn cell_of(leaf: u32, from_cell: u32, count: u32) -> u32 {
    var first = from_cell;
    var length = count;
    while length > 1u {
        let half_length = length / 2u;
        if offsets[first + half_length] <= leaf {
            first += half_length;
        }
        length -= half_length;
    }
    return first;
}

@compute @workgroup_size(LANES)
fn emit(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let first = linear_group(group, groups) * LANES;
    let total = offsets[params.n_cells];
    let here = min(LANES, total - min(first, total));
    if lane < min(2u, here) {
        ends[lane] = cell_of(first + lane * (here - 1u), 0u, params.n_cells);
    }
    workgroupBarrier();
    if lane < here {
        let leaf = first + lane;
        // A single leaf has only its first end.
        let low = ends[0];
        let high = ends[min(1u, here - 1u)];
        let c = cell_of(leaf, low, high - low + 1u);
        ids[lane] = leaf_ids[starts[c] + (leaf - offsets[c])];
    }
    workgroupBarrier();
    for (var i = 0u; i < 3u; i++) {
        let p = i * LANES + lane;
        if p < 3u * here {
            let leaf = p / 3u;
            indices[3u * first + p] = index_pair(ids[leaf], p - 3u * leaf);
        }
    }
}
