// One receiver an invocation, reading power moments.
#import common/index.wgsl
#import common/opacity_moments.wgsl
#import common/opacity_series.wgsl
#import common/opacity_series_read.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var<uniform> series: SeriesParams;
@group(0) @binding(5) var bounds_map: texture_2d<f32>;
@group(0) @binding(6) var maps: texture_2d_array<f32>;

// Even moments that biased ones are moved towards; the odd ones are 0.
const SAFE_4 = array<f32, 3>(0.375, 0.375, 0.0);
const SAFE_6 = array<f32, 3>(0.48, 0.451, 0.45);

fn transmittance_before(texel: vec2<u32>, depth: f32, mean: bool) -> f32 {
    let ends = ends_of(texel);
    let thin = ends.y - ends.x < THIN;
    let total = number(texel, 0u, mean);
    if total <= 0.0 || depth <= ends.x || (thin && depth <= ends.y) {
        return 1.0;
    }
    if depth > ends.y {
        return exp(-total);
    }
    var m: array<f32, 7>;
    m[0] = 1.0;
    var safe = SAFE_6;
    if series.numbers == 5u {
        safe = SAFE_4;
    }
    for (var j = 1u; j < series.numbers; j += 2u) {
        let odd = number(texel, j, mean) / total;
        let even = number(texel, j + 1u, mean) / total;
        m[j] = odd - series.bias * odd;
        m[j + 1u] = even + series.bias * (safe[j / 2u] - even);
    }
    let x = 2.0 * share_of_way(depth, ends) - 1.0;
    var share = 0.0;
    if series.numbers == 5u {
        share = share_from_four(m, x, series.bias, series.own);
    } else {
        share = share_from_six(m, x, series.bias, series.own);
    }
    return exp(-total * clamp(share, 0.0, 1.0));
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
