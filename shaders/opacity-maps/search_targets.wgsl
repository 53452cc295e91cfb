// Scores of trial maps in textures.
#import common/index.wgsl
#import common/opacity_score.wgsl

@group(0) @binding(2) var maps: texture_2d_array<f32>;

// Whether every layer has a texture of its own.
override SINGLE: bool = false;

fn stored_layer(texel: vec2<u32>, layer: u32) -> f32 {
    if SINGLE {
        return textureLoad(maps, texel, layer, 0).x;
    }
    return textureLoad(maps, texel, layer / 4u, 0)[layer % 4u];
}

@compute @workgroup_size(64)
fn score(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    score_part(linear_group(group, groups), lane);
}
