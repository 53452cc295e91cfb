// No copy: the kept leaves of a cell are a prefix, so one indirect draw a cell over an index
// buffer that never changes shows them. Needs no offsets.
#import common/kept_counts.wgsl
#import common/index.wgsl

// Mirrors `DrawArgs` of dapple-foliage.
struct DrawArgs {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    base_vertex: i32,
    first_instance: u32,
}

@group(0) @binding(3) var<storage, read_write> draws: array<DrawArgs>;

@compute @workgroup_size(LANES)
fn write_draws(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let c = linear_index(id, groups, LANES);
    if c >= params.n_cells {
        return;
    }
    draws[c] = DrawArgs(6u * kept_of(c), 1u, 6u * starts[c], 0, 0u);
}
