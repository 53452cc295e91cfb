// A light tree and where walks through it start; mirrors gpu::Tree.
#import common/lights_frame.wgsl

@group(1) @binding(0) var<storage, read> nodes: array<LightNode>;
// Nodes; with heights two words each, the second the bits of the height of points that the node is
// hidden from, and from all below.
@group(1) @binding(1) var<storage, read> starts: array<u32>;
// First and number in `starts`: of the roots, then of object 0, 1, ...
@group(1) @binding(2) var<storage, read> ranges: array<vec2<u32>>;

// Which form bounds have: 0 Walter's, 1 the cheap one.
override FORM: u32 = 1u;

// Whether starts have heights.
override HEIGHTS: bool = false;

// From and to in `starts` for an object; the roots' where it has no range of its own.
fn range_of(object: u32) -> vec2<u32> {
    let place = select(object + 1u, 0u, object >= arrayLength(&ranges) - 1u);
    let range = ranges[place];
    return vec2<u32>(range.x, range.x + range.y);
}

// The node of start `s`.
fn start_of(s: u32) -> u32 {
    return starts[select(s, 2u * s, HEIGHTS)];
}

// Whether start `s` is hidden from points at a height, metres.
fn is_start_hidden(s: u32, height: f32) -> bool {
    return HEIGHTS && height <= bitcast<f32>(starts[2u * s + 1u]);
}

fn greatest(colour: vec3<f32>) -> f32 {
    return max(colour.x, max(colour.y, colour.z));
}
