// One receiver an invocation, reading layers from textures.
#import common/index.wgsl
#import common/opacity_layers.wgsl
#import common/opacity_read.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var<uniform> layered: LayerParams;
@group(0) @binding(5) var bounds_map: texture_2d<f32>;
@group(0) @binding(6) var<storage, read> table: array<f32>;
@group(0) @binding(7) var maps: texture_2d_array<f32>;

// Whether every layer has a texture of its own.
override SINGLE: bool = false;

fn stored_layer(texel: vec2<u32>, layer: u32) -> f32 {
    if SINGLE {
        return textureLoad(maps, texel, layer, 0).x;
    }
    return textureLoad(maps, texel, layer / 4u, 0)[layer % 4u];
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
