// Places light-space triangles in the map: (u, v) is the position, z the linear depth.
#import common/opacity_surface.wgsl

// position: (u w, v w, w); w is 1 for parallel light, and the distance along the light's axis for
// perspective. Clip depth only has to stay inside: tests use z.
fn placed(position: vec3<f32>, z: f32, uv: vec2<f32>) -> Varyings {
    let w = position.z;
    let clip = vec4(2.0 * position.x - w, w - 2.0 * position.y, 0.5 * w, w);
    return Varyings(clip, z, uv);
}

@vertex
fn place(
    @location(0) position: vec3<f32>,
    @location(1) z: f32,
    @location(2) uv: vec2<f32>,
) -> Varyings {
    return placed(position, z, uv);
}

// Near and far plane change places, as in a projection that swaps them: that negates depths,
// without rounding. The range is put right after interpolation.
@vertex
fn place_swapped(
    @location(0) position: vec3<f32>,
    @location(1) z: f32,
    @location(2) uv: vec2<f32>,
) -> Varyings {
    return placed(position, -z, uv);
}

// One triangle over the whole map.
@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> Varyings {
    let x = select(-1.0, 3.0, vertex == 1u);
    let y = select(-1.0, 3.0, vertex == 2u);
    return Varyings(vec4(x, y, 0.5, 1.0), 0.0, vec2(0.0));
}
