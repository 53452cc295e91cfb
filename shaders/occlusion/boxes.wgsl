// Rasterises the boxes of a batch of occlusion queries, all six faces of each. An occlusion query
// needs no fragments; where those cannot count, `count` compares depths itself.
#import common/occlusion_view.wgsl

struct Box {
    // Corners in local space.
    low: array<f32, 3>,
    high: array<f32, 3>,
    // The query it belongs to.
    query: u32,
}

@group(1) @binding(1) var<storage, read> boxes: array<Box>;
// Samples that pass, one count a query.
@group(2) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;
// What has been drawn.
@group(2) @binding(1) var depth: texture_depth_2d;

// Whether a sample passes only behind what has been drawn: a deliberate fault.
override reversed: bool = false;

struct Varyings {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat, first) query: u32,
}

// Two triangles a face, 36 corners a box: axis of the face, its side, and a corner of a square.
@vertex
fn face(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> Varyings {
    let axis = vertex / 12u;
    let side = (vertex / 6u) & 1u;
    let k = vertex % 6u;
    // (0, 0), (1, 0), (0, 1), (0, 1), (1, 0), (1, 1).
    let u = u32(k == 1u || k >= 4u);
    let v = u32(k == 2u || k == 3u || k == 5u);
    var pick = vec3(0u);
    pick[axis] = side;
    pick[(axis + 1u) % 3u] = u;
    pick[(axis + 2u) % 3u] = v;
    let low = boxes[instance].low;
    let high = boxes[instance].high;
    let p = select(
        vec3(low[0], low[1], low[2]),
        vec3(high[0], high[1], high[2]),
        pick == vec3(1u),
    );
    return Varyings(project(p), boxes[instance].query);
}

@fragment
fn count(in: Varyings) {
    let there = textureLoad(depth, vec2<i32>(in.clip.xy), 0);
    if select(in.clip.z >= there, in.clip.z < there, reversed) {
        atomicAdd(&counts[in.query], 1u);
    }
}
