// Filters columns: an invocation makes 16 texels of one column of one plane, its neighbours those
// of the next columns. The four strips of a workgroup lie above one another and share their
// overlap through the cache.
#import common/window.wgsl

const STRIP = 16u;

var<private> plane_base: u32;
var<private> x: u32;
var<private> y0: u32;

fn fetch(j: u32) -> vec2<f32> {
    let y = clamp(i32(y0 + j) - i32(params.taps / 2u), 0, i32(params.height) - 1);
    return decode(source_words[plane_base + u32(y) * params.width + x]);
}

fn emit(i: u32, v: vec2<f32>) {
    let y = y0 + i;
    if y < params.height {
        target_words[plane_base + y * params.width + x] = encode(v);
    }
}

@compute @workgroup_size(64, 4)
fn filter_y(@builtin(global_invocation_id) id: vec3<u32>) {
    x = id.x;
    y0 = id.y * STRIP;
    plane_base = id.z * params.width * params.height;
    if x < params.width && y0 < params.height {
        filter_strip(ops[id.z]);
    }
}
