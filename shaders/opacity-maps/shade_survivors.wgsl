// One receiver an invocation, counting samples whose nearest survivor does not hide it.
#import common/index.wgsl
#import common/opacity_each.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var<storage, read> survivors: array<u32>;

// Samples of a texel.
override SAMPLES: u32 = 1u;

// Depth of a sample that nothing survived in.
const NOTHING = 2.0;

fn decode(texel: vec2<u32>, depth: f32) -> f32 {
    let place = texel.y * shading.width + texel.x;
    var lit = 0u;
    for (var sample = 0u; sample < SAMPLES; sample++) {
        let nearest = bitcast<f32>(0x40000000u - survivors[place * SAMPLES + sample]);
        lit += select(0u, 1u, nearest >= min(depth, NOTHING));
    }
    return f32(lit) / f32(SAMPLES);
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
