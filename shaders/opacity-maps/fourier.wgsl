// Fragments into Fourier coefficients: a_0, then a_k and b_k in turn.
#import common/opacity_fourier.wgsl
#import common/opacity_surface.wgsl
#import common/opacity_targets.wgsl

@group(1) @binding(0) var<uniform> series: SeriesParams;
@group(1) @binding(1) var bounds_map: texture_2d<f32>;

@fragment
fn targets(in: Varyings) -> Targets {
    let texel = vec2<u32>(in.clip.xy);
    let z = taking_part(in.z, in.uv, texel);
    if z < 0.0 {
        discard;
    }
    let twice = 2.0 * surface.omega;
    var terms: array<vec4<f32>, 8>;
    terms[0].x = twice;
    let first = on_circle(share_of_way(z, ends_of(texel)));
    var harmonic = first;
    for (var i = 1u; i < series.numbers; i += 2u) {
        terms[i / 4u][i % 4u] = twice * harmonic.y;
        terms[(i + 1u) / 4u][(i + 1u) % 4u] = twice * harmonic.x;
        harmonic = next_harmonic(harmonic, first);
    }
    return Targets(
        terms[0], terms[1], terms[2], terms[3], terms[4], terms[5], terms[6], terms[7],
    );
}
