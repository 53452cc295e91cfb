// Index generation, one workgroup a cell: its lanes stride over the pairs of words that the kept
// prefix makes, so that neighbouring lanes write neighbouring memory. Cells with fewer leaves
// than a third of the lanes leave lanes idle.
#import common/partition.wgsl
#import common/index.wgsl

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read> leaf_ids: array<u32>;
@group(0) @binding(4) var<storage, read_write> indices: array<vec2<u32>>;

// Small, because cells hold tens to hundreds of leaves.
const CELL_LANES = 64u;

@compute @workgroup_size(CELL_LANES)
fn emit(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let c = linear_group(group, groups);
    if c >= params.n_cells {
        return;
    }
    let begin = offsets[c];
    let pairs = 3u * (offsets[c + 1u] - begin);
    let start = starts[c];
    for (var p = lane; p < pairs; p += CELL_LANES) {
        let leaf = p / 3u;
        indices[3u * begin + p] = index_pair(leaf_ids[start + leaf], p - 3u * leaf);
    }
}
