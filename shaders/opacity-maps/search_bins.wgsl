// Scores of trial maps in fixed-point sums.
#import common/index.wgsl
#import common/opacity_score.wgsl

// 20 binary digits after the point, one map after the other.
@group(0) @binding(2) var<storage, read> sums: array<u32>;

fn stored_layer(texel: vec2<u32>, layer: u32) -> f32 {
    let place = texel.y * scoring.width + texel.x;
    return f32(sums[layer * scoring.width * scoring.height + place]) / 1048576.0;
}

@compute @workgroup_size(64)
fn score(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    score_part(linear_group(group, groups), lane);
}
