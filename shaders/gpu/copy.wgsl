// A plain copy, 16 bytes an invocation: the yardstick for the bandwidth of other kernels.
#import common/index.wgsl

@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> target_: array<vec4<u32>>;

@compute @workgroup_size(256)
fn copy(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let i = linear_index(id, groups, 256u);
    if i < arrayLength(&target_) {
        target_[i] = source[i];
    }
}
