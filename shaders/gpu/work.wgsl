// Probe: a workload of a length the host chooses, for comparing timestamps with the wall clock.
@group(0) @binding(0) var<storage, read_write> iterations: array<u32>;
@group(0) @binding(1) var<storage, read_write> result: array<u32>;

@compute @workgroup_size(64)
fn work(@builtin(global_invocation_id) id: vec3<u32>) {
    var x = id.x;
    for (var i = 0u; i < iterations[0]; i++) {
        x = x * 1664525u + 1013904223u;
    }
    result[id.x] = x;
}
