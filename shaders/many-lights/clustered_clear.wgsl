// Empties the cells before points are sorted into them.
#import common/lights_cells.wgsl
#import common/index.wgsl

@group(1) @binding(0) var<uniform> params: CellParams;
@group(1) @binding(1) var<storage, read_write> boxes: array<u32>;
@group(1) @binding(2) var<storage, read_write> total: array<u32>;

@compute @workgroup_size(64)
fn clear(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let cell = linear_index(id, groups, 64u);
    if cell == 0u {
        total[0] = 0u;
    }
    if cell < params.cells {
        for (var i = 0u; i < BOX_WORDS; i++) {
            boxes[BOX_WORDS * cell + i] = select(0u, 0xffffffffu, i < 3u);
        }
    }
}
