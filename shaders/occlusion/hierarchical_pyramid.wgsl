// Farthest depths under every texel, five levels a dispatch: a workgroup takes 32 x 32 texels of
// level `base` and keeps what it has joined in its own memory. Level k has ceil(size / 2^k) texels
// a side, so tiles never share a parent.
// Based on: Greene, Kass and Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.2.
#import common/occlusion_cull.wgsl

// All levels but the image itself.
@group(0) @binding(1) var<storage, read_write> texels: array<f32>;
@group(0) @binding(2) var depth: texture_depth_2d;

// The level read.
override base: u32 = 0u;

// Whether the nearest is taken: a deliberate fault.
override nearest: bool = false;

const SIDE = 16u;

// What lies beyond the image takes no part: depths are 0 to 1.
const NOTHING = 2.0;

fn two(a: f32, b: f32) -> f32 {
    if !nearest || max(a, b) == NOTHING {
        return min(a, b);
    }
    return max(a, b);
}

fn four(a: f32, b: f32, c: f32, d: f32) -> f32 {
    return two(two(a, b), two(c, d));
}

var<workgroup> tile: array<f32, 256>;

fn store(k: u32, x: u32, y: u32, value: f32) {
    if k < params.levels {
        let level = params.level[k];
        if x < level.x && y < level.y {
            texels[level.z + y * level.x + x] = value;
        }
    }
}

// Levels base + 1 to base + 5, from this lane's farthest of 2 x 2.
fn join(value: f32, lane: vec2<u32>, group: vec2<u32>) {
    let at = group * SIDE + lane;
    store(base + 1u, at.x, at.y, value);
    tile[lane.y * SIDE + lane.x] = value;
    for (var k = 1u; k < 5u; k++) {
        workgroupBarrier();
        let side = SIDE >> k;
        let within = all(lane < vec2(side));
        var joined = NOTHING;
        if within {
            let i = 2u * lane.y * SIDE + 2u * lane.x;
            joined = four(tile[i], tile[i + 1u], tile[i + SIDE], tile[i + SIDE + 1u]);
            store(base + 1u + k, group.x * side + lane.x, group.y * side + lane.y, joined);
        }
        workgroupBarrier();
        if within {
            tile[lane.y * SIDE + lane.x] = joined;
        }
    }
}

fn image_texel(x: u32, y: u32) -> f32 {
    if x >= params.size.x || y >= params.size.y {
        return NOTHING;
    }
    return textureLoad(depth, vec2(x, y), 0);
}

fn level_texel(x: u32, y: u32) -> f32 {
    let level = params.level[base];
    if x >= level.x || y >= level.y {
        return NOTHING;
    }
    return texels[level.z + y * level.x + x];
}

@compute @workgroup_size(SIDE, SIDE)
fn from_image(
    @builtin(local_invocation_id) lane: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    let x = 2u * id.x;
    let y = 2u * id.y;
    let value = four(
        image_texel(x, y),
        image_texel(x + 1u, y),
        image_texel(x, y + 1u),
        image_texel(x + 1u, y + 1u),
    );
    join(value, lane.xy, group.xy);
}

@compute @workgroup_size(SIDE, SIDE)
fn from_level(
    @builtin(local_invocation_id) lane: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    let x = 2u * id.x;
    let y = 2u * id.y;
    let value = four(
        level_texel(x, y),
        level_texel(x + 1u, y),
        level_texel(x, y + 1u),
        level_texel(x + 1u, y + 1u),
    );
    join(value, lane.xy, group.xy);
}
