// Index generation, one thread a cell: each copies the kept prefix of its cell.
// Based on: Gumbau Portales, PhD thesis, Universitat Jaume I, 2011, Algorithm 2 (KernelDoLoD).
// Neighbouring threads write far apart, and a workgroup waits for its largest cell: the thesis
// takes this for an advantage (no bank conflicts), which holds for shared memory only.
#import common/partition.wgsl
#import common/index.wgsl

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> offsets: array<u32>;
@group(0) @binding(3) var<storage, read> leaf_ids: array<u32>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

@compute @workgroup_size(LANES)
fn emit(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let c = linear_index(id, groups, LANES);
    if c >= params.n_cells {
        return;
    }
    let begin = offsets[c];
    let count = offsets[c + 1u] - begin;
    let start = starts[c];
    for (var leaf = 0u; leaf < count; leaf++) {
        let vertex = 4u * leaf_ids[start + leaf];
        let word = 6u * (begin + leaf);
        indices[word] = vertex;
        indices[word + 1u] = vertex + 1u;
        indices[word + 2u] = vertex + 2u;
        indices[word + 3u] = vertex;
        indices[word + 4u] = vertex + 2u;
        indices[word + 5u] = vertex + 3u;
    }
}
