// The nearest opaque surface, as linear depth.
#import common/opacity_surface.wgsl

@fragment
fn opaque(in: Varyings) -> @builtin(frag_depth) f32 {
    if !is_surface(in.z, in.uv) {
        discard;
    }
    return in.z;
}
