// All translucent fragments of each texel: counted, then written from where their texel starts.
#import common/opacity_surface.wgsl

struct ListParams {
    width: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(1) @binding(0) var<uniform> list: ListParams;
// Fragments of each texel so far; when they are written, the place of the next one.
@group(1) @binding(1) var<storage, read_write> places: array<atomic<u32>>;
// (depth, thickness).
@group(1) @binding(2) var<storage, read_write> items: array<vec2<f32>>;

fn texel_index(clip: vec4<f32>) -> u32 {
    let texel = vec2<u32>(clip.xy);
    return texel.y * list.width + texel.x;
}

@fragment
fn count(in: Varyings) {
    let z = taking_part(in.z, in.uv, vec2<u32>(in.clip.xy));
    if z < 0.0 {
        discard;
    }
    atomicAdd(&places[texel_index(in.clip)], 1u);
}

@fragment
fn write(in: Varyings) {
    let z = taking_part(in.z, in.uv, vec2<u32>(in.clip.xy));
    if z < 0.0 {
        discard;
    }
    let place = atomicAdd(&places[texel_index(in.clip)], 1u);
    if place < arrayLength(&items) {
        items[place] = vec2(z, surface.omega);
    }
}
