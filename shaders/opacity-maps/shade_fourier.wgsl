// One receiver an invocation, reading Fourier coefficients.
#import common/index.wgsl
#import common/opacity_fourier.wgsl
#import common/opacity_series_read.wgsl
#import common/opacity_taps.wgsl

@group(0) @binding(4) var<uniform> series: SeriesParams;
@group(0) @binding(5) var bounds_map: texture_2d<f32>;
@group(0) @binding(6) var maps: texture_2d_array<f32>;

fn transmittance_before(texel: vec2<u32>, depth: f32, mean: bool) -> f32 {
    let ends = ends_of(texel);
    let thin = ends.y - ends.x < THIN;
    if depth <= ends.x || (thin && depth <= ends.y) {
        return 1.0;
    }
    let total = 0.5 * number(texel, 0u, mean);
    if depth > ends.y {
        return exp(-max(total, 0.0));
    }
    let share = share_of_way(depth, ends);
    let first = on_circle(share);
    var harmonic = first;
    var sum = 0.0;
    for (var i = 1u; i < series.numbers; i += 2u) {
        let cosine = number(texel, i, mean) * harmonic.x;
        let sine = number(texel, i + 1u, mean) * (1.0 - harmonic.y);
        sum += (cosine + sine) / f32((i + 1u) / 2u);
        harmonic = next_harmonic(harmonic, first);
    }
    return exp(-max(total * circle_place(share) + sum / TAU, 0.0));
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
