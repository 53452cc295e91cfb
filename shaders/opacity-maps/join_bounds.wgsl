// Brings what the routes leave into one form: a texture of (-first, last).
struct JoinParams {
    width: u32,
    height: u32,
    // Whether the far map holds 1 - last.
    mirrored: u32,
    pad0: u32,
}

@group(0) @binding(0) var<uniform> join: JoinParams;
@group(0) @binding(1) var joined: texture_storage_2d<rg32float, write>;
@group(0) @binding(2) var near_map: texture_depth_2d;
@group(0) @binding(3) var far_map: texture_depth_2d;
@group(0) @binding(4) var<storage, read> ends: array<u32>;

@compute @workgroup_size(64)
fn join_depths(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= join.width || id.y >= join.height {
        return;
    }
    let far = textureLoad(far_map, id.xy, 0);
    let last = select(far, 1.0 - far, join.mirrored != 0u);
    textureStore(joined, id.xy, vec4(-textureLoad(near_map, id.xy, 0), last, 0.0, 0.0));
}

@compute @workgroup_size(64)
fn join_words(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= join.width || id.y >= join.height {
        return;
    }
    let at = 2u * (id.y * join.width + id.x);
    let first = bitcast<f32>(bitcast<u32>(1.0) - ends[at]);
    textureStore(joined, id.xy, vec4(-first, bitcast<f32>(ends[at + 1u]), 0.0, 0.0));
}
