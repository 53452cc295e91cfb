// Fragments into power moments of their depths in -1..=1, the zeroth first.
#import common/opacity_series.wgsl
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
    let depth = 2.0 * share_of_way(z, ends_of(texel)) - 1.0;
    let square = depth * depth;
    let powers = surface.omega * vec4(1.0, depth, square, square * depth);
    let rest = powers * (square * square);
    let none = vec4(0.0);
    // With four moments the last two have a place, and are not read.
    return Targets(powers, rest, none, none, none, none, none, none);
}
