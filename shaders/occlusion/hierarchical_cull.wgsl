// Asks every object's box whether what has been drawn hides it, three times a frame: which objects
// of the last frame are on the screen, which others show behind them, and what shows in the end.
// Mirrors `camera::View` and `camera::hierarchical_depth` of the processor, in f32; the guard band
// of `camera/view/guard.rs` is four times what drawing may err, and f32 here errs less than drawing.
#import common/occlusion_cull.wgsl
#import common/index.wgsl

struct Box {
    low: array<f32, 3>,
    high: array<f32, 3>,
}

@group(0) @binding(1) var<storage, read> boxes: array<Box>;
@group(0) @binding(2) var<storage, read_write> state: array<u32>;
// Listed items of each workgroup.
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;
// All levels but the image itself.
@group(0) @binding(4) var<storage, read> texels: array<f32>;
@group(0) @binding(5) var depth: texture_depth_2d;

const UNIT = 5.9604645e-8; // 2^-24

// Where a box lies on the screen.
const OUTSIDE = 0u;
// The near plane touches it: it counts as visible.
const NEAR = 1u;
const INSIDE = 2u;

struct Place {
    kind: u32,
    // First and last pixel.
    first: vec2<u32>,
    last: vec2<u32>,
    // Its greatest reversed depth.
    nearest: f32,
}

fn along(p: vec3<f32>) -> f32 {
    return dot(params.forward.xyz, p) + params.forward.w;
}

// Metres along the view direction that depth may err, for a box as near as `near`.
fn depth_error(near: f32, far: f32) -> f32 {
    return 32.0 * UNIT * params.secant * far * (far / max(near, params.near));
}

// By how much a box grows, corners relative to the eye: `View::guard_m`.
fn guard(low: vec3<f32>, high: vec3<f32>, near: f32, distance: f32) -> f32 {
    let far = max(distance, params.near);
    let radius = length(max(abs(low), abs(high)));
    // sqrt(2) / 256 of a pixel.
    let snap = 0.0055242717 * select(params.pixel * far, params.pixel, params.parallel != 0u);
    let aside = 4.0 * (16.0 * UNIT * radius + snap);
    if params.parallel != 0u {
        return aside + 32.0 * UNIT * params.range;
    }
    let half = 0.5 * near;
    let growth = aside + depth_error(half, far);
    if growth <= half {
        return growth;
    }
    let error = depth_error(params.near, far);
    return select(aside + error, 4.0 * radius, error > far);
}

fn place(item: u32) -> Place {
    let outside = Place(OUTSIDE, vec2(0u), vec2(0u), 0.0);
    let bounds = boxes[item];
    var low = vec3(bounds.low[0], bounds.low[1], bounds.low[2]);
    var high = vec3(bounds.high[0], bounds.high[1], bounds.high[2]);
    if any(low > high) {
        return outside;
    }
    low -= params.eye;
    high -= params.eye;
    let ahead = params.forward.xyz >= vec3(0.0);
    // Evaluating the band rounds as well.
    let growth = 1.0001
        * guard(low, high, along(select(high, low, ahead)), along(select(low, high, ahead)));
    low -= growth;
    high += growth;
    for (var i = 0u; i < 5u; i++) {
        let plane = params.planes[i];
        if dot(plane.xyz, select(low, high, plane.xyz >= vec3(0.0))) + plane.w < 0.0 {
            return outside;
        }
    }
    let distance = along(select(high, low, ahead));
    let parallel = params.parallel != 0u;
    // What is no number counts as near.
    if !(distance > select(params.near, 0.0, parallel)) {
        return Place(NEAR, vec2(0u), vec2(0u), 1.0);
    }
    var first = vec2(3.4e38);
    var last = vec2(-3.4e38);
    for (var i = 0u; i < 8u; i++) {
        let corner = select(low, high, vec3((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u));
        let scale = select(along(corner), 1.0, parallel);
        let ndc = vec2(
            dot(params.right.xyz, corner) + params.right.w,
            -(dot(params.up.xyz, corner) + params.up.w),
        ) / scale;
        let pixel = (0.5 * ndc + 0.5) * vec2<f32>(params.size);
        first = min(first, pixel);
        last = max(last, pixel);
    }
    // Pixels whose centres are inside.
    first = max(ceil(first - 0.5), vec2(0.0));
    last = min(floor(last - 0.5), vec2<f32>(params.size) - 1.0);
    if any(first > last) {
        return outside;
    }
    let nearest = select(params.near / distance, 1.0 - distance / params.range, parallel);
    return Place(INSIDE, vec2<u32>(first), vec2<u32>(last), min(nearest, 1.0));
}

// The farthest depth drawn there, or a farther one: of the lowest level at which the rectangle is
// few enough texels across.
fn farthest(at: Place) -> f32 {
    var k = 0u;
    while k + 1u < params.levels
        && any((at.last >> vec2(k)) - (at.first >> vec2(k)) >= vec2(params.across)) {
        k++;
    }
    let first = at.first >> vec2(k);
    let last = at.last >> vec2(k);
    let level = params.level[k];
    var result = 1.0;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            var texel = 0.0;
            if k == 0u {
                texel = textureLoad(depth, vec2(x, y), 0);
            } else {
                texel = texels[level.z + y * level.x + x];
            }
            result = min(result, texel);
        }
    }
    return result;
}

fn shows(item: u32) -> bool {
    let at = place(item);
    if at.kind != INSIDE {
        return at.kind == NEAR;
    }
    return at.nearest >= farthest(at);
}

var<workgroup> listed: atomic<u32>;

// Counts the items of this workgroup that are listed.
fn book(list: bool, lane: u32, group: u32) {
    if list {
        atomicAdd(&listed, 1u);
    }
    workgroupBarrier();
    if lane == 0u && group < params.groups {
        sums[group] = atomicLoad(&listed);
    }
}

// What the last frame saw and is on the screen.
@compute @workgroup_size(ITEMS)
fn first(
    @builtin(local_invocation_index) lane: u32,
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let item = linear_index(id, groups, ITEMS);
    var list = false;
    if item < params.items {
        list = (state[item] & VISIBLE) != 0u && place(item).kind != OUTSIDE;
        state[item] = select(0u, DRAWN | LISTED, list);
    }
    book(list, lane, linear_group(group, groups));
}

// What else shows behind it.
@compute @workgroup_size(ITEMS)
fn second(
    @builtin(local_invocation_index) lane: u32,
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let item = linear_index(id, groups, ITEMS);
    var list = false;
    if item < params.items {
        let drawn = state[item] & DRAWN;
        list = drawn == 0u && shows(item);
        state[item] = drawn | select(0u, LISTED, list);
    }
    book(list, lane, linear_group(group, groups));
}

// What the next frame draws first.
@compute @workgroup_size(ITEMS)
fn last(
    @builtin(local_invocation_index) lane: u32,
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let item = linear_index(id, groups, ITEMS);
    var seen = false;
    if item < params.items {
        seen = shows(item);
        state[item] = select(0u, VISIBLE, seen);
    }
    book(seen, lane, linear_group(group, groups));
}
