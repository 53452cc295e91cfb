// What every stage of the partition of leaves knows. Mirrors `Params` of dapple-foliage.
struct Params {
    n_cells: u32,
    // Workgroups of the prefix sum, at least 1.
    n_tiles: u32,
    // max_compute_workgroups_per_dimension.
    max_groups: u32,
    unused: u32,
}

// Invocations a workgroup, and leaves a workgroup of thread per leaf.
const LANES = 256u;

// Two of the three pairs of words that a leaf's six indices make are written as they stand here:
// (0, 1), (2, 0), (2, 3), each plus four times the leaf's id. Pairs keep the last leaf whole
// where quadruples would not, and neighbouring lanes write neighbouring 8 bytes.
fn index_pair(id: u32, pair: u32) -> vec2<u32> {
    let corners = select(select(vec2(2u, 3u), vec2(2u, 0u), pair == 1u), vec2(0u, 1u), pair == 0u);
    return vec2(4u * id) + corners;
}
