// One receiver an invocation, reading no opacity at all: the opaque map alone.
#import common/index.wgsl
#import common/opacity_taps.wgsl

fn decode(texel: vec2<u32>, depth: f32) -> f32 {
    return 1.0;
}

fn decode_mean(own: vec2<u32>, depth: f32) -> f32 {
    return 1.0;
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
