// One receiver an invocation, against the nearest depth of anything.
#import common/index.wgsl
#import common/opacity_each.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var near_map: texture_depth_2d;

fn decode(texel: vec2<u32>, depth: f32) -> f32 {
    let stored = textureLoad(near_map, texel, 0);
    // Nothing lies at the cleared depth: it hides no receiver beyond the far plane.
    return select(1.0, 0.0, stored < 1.0 && stored < depth);
}

fn decode_mean(own: vec2<u32>, depth: f32) -> f32 {
    return decode_each(depth);
}

@compute @workgroup_size(64)
fn shade(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let receiver = linear_index(id, groups, 64u);
    if receiver < shading.receivers {
        transmittances[receiver] = transmittance(receivers[receiver]);
    }
}
