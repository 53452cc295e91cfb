// A light tree and where walks through it start; mirrors gpu::Tree.
#import common/lights_frame.wgsl

@group(1) @binding(0) var<storage, read> nodes: array<LightNode>;
@group(1) @binding(1) var<storage, read> starts: array<u32>;
// From and to in `starts`: of the roots, then of object 0, 1, ...
@group(1) @binding(2) var<storage, read> ranges: array<vec2<u32>>;

// Which form bounds have: 0 Walter's, 1 the cheap one.
override FORM: u32 = 1u;

// Where an object's walks start; at the roots where it has no range of its own.
fn range_of(object: u32) -> vec2<u32> {
    if object >= arrayLength(&ranges) - 1u {
        return ranges[0];
    }
    return ranges[object + 1u];
}

fn greatest(colour: vec3<f32>) -> f32 {
    return max(colour.x, max(colour.y, colour.z));
}
