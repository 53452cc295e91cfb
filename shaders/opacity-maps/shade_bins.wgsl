// One receiver an invocation, reading fixed-point sums.
#import common/index.wgsl
#import common/opacity_layers.wgsl
#import common/opacity_read.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var<uniform> layered: LayerParams;
@group(0) @binding(5) var bounds_map: texture_2d<f32>;
@group(0) @binding(6) var<storage, read> table: array<f32>;
// 20 binary digits after the point, one map after the other.
@group(0) @binding(7) var<storage, read> sums: array<u32>;

fn stored_layer(texel: vec2<u32>, layer: u32) -> f32 {
    let place = texel.y * shading.width + texel.x;
    return f32(sums[layer * shading.width * shading.height + place]) / 1048576.0;
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
