// One index for a dispatch in two dimensions: more than 65,535 workgroups do not fit in one.
// `id` is global_invocation_id, `groups` is num_workgroups, for @workgroup_size(size, 1, 1).
fn linear_index(id: vec3<u32>, groups: vec3<u32>, size: u32) -> u32 {
    return id.y * groups.x * size + id.x;
}

// The same for whole workgroups: `group` is workgroup_id.
fn linear_group(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}
