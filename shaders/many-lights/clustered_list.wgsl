// Lists the lights whose reach and cone touch a cell's box: one workgroup a cell, its lanes share out the
// groups of lights. Counts first, takes so much room for the cell, then writes: within a list the
// order is always the same, only where lists lie is not.
// Based on: O. Olsson, M. Billeter and U. Assarsson, "Clustered deferred and forward shading", 2012,
// section 3.3.
// Deviations: one level of groups.
#import common/lights_cells.wgsl
#import common/index.wgsl

// Mirrors Group.
struct Group {
    low: vec3<f32>,
    reach_squared: f32,
    high: vec3<f32>,
    pad: u32,
}

@group(1) @binding(0) var<uniform> params: CellParams;
@group(1) @binding(1) var<storage, read> boxes: array<u32>;
@group(1) @binding(2) var<storage, read> lights: array<Light>;
@group(1) @binding(3) var<storage, read> light_groups: array<Group>;
@group(1) @binding(4) var<storage, read_write> total: array<atomic<u32>>;
// First entry and number, one a cell.
@group(1) @binding(5) var<storage, read_write> heads: array<vec2<u32>>;
@group(1) @binding(6) var<storage, read_write> list: array<u32>;

const LANES = 64u;
// Lights of a group.
const FAN = 32u;
// What the shading pass may find nearer: a compiler may round sums of products there otherwise.
const NEARER = 1.000001;

var<workgroup> firsts: array<u32, LANES>;

fn touches(low: vec3<f32>, high: vec3<f32>, box: array<vec3<f32>, 2>, reach_squared: f32) -> bool {
    let outside = max(max(low - box[1], box[0] - high), vec3<f32>(0.0));
    return dot(outside, outside) <= reach_squared * NEARER;
}

// Whether the light leaves it towards any place of the box: as bound/packed.rs has it.
fn shines_into(light: Light, box: array<vec3<f32>, 2>) -> bool {
    if light.kind == KIND_OMNI || light.kind == KIND_DIRECTIONAL {
        return true;
    }
    let low = box[0] - light.position;
    let high = box[1] - light.position;
    let outside = max(max(low, -high), vec3<f32>(0.0));
    let found = closest(FORM_WALTER, light.axis, low, high, dot(outside, outside));
    return closest_angle(found) - ANGLE_SLACK_RAD < light.half_angle_rad;
}

fn light_touches(light: Light, box: array<vec3<f32>, 2>) -> bool {
    // Where other kernels have nothing, these lights have the square of their reach.
    return touches(light.position, light.position, box, bitcast<f32>(light.pad))
        && shines_into(light, box);
}

@compute @workgroup_size(LANES)
fn lists(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let cell = linear_group(group, groups);
    if cell >= params.cells {
        return;
    }
    let first = BOX_WORDS * cell;
    if boxes[first] > boxes[first + 3u] {
        if lane == 0u {
            heads[cell] = vec2<u32>(0u);
        }
        return;
    }
    var box: array<vec3<f32>, 2>;
    for (var i = 0u; i < 3u; i++) {
        box[0][i] = from_ordered(boxes[first + i]);
        box[1][i] = from_ordered(boxes[first + 3u + i]);
    }
    var count = 0u;
    for (var g = lane; g < params.groups; g += LANES) {
        let near = light_groups[g];
        if touches(near.low, near.high, box, near.reach_squared) {
            for (var i = g * FAN; i < min((g + 1u) * FAN, params.lights); i++) {
                count += select(0u, 1u, light_touches(lights[i], box));
            }
        }
    }
    firsts[lane] = count;
    workgroupBarrier();
    if lane == 0u {
        var sum = 0u;
        for (var i = 0u; i < LANES; i++) {
            sum += firsts[i];
        }
        var at = atomicAdd(&total[0], sum);
        heads[cell] = vec2<u32>(at, sum);
        for (var i = 0u; i < LANES; i++) {
            let own = firsts[i];
            firsts[i] = at;
            at += own;
        }
    }
    workgroupBarrier();
    var at = firsts[lane];
    for (var g = lane; g < params.groups; g += LANES) {
        let near = light_groups[g];
        if touches(near.low, near.high, box, near.reach_squared) {
            for (var i = g * FAN; i < min((g + 1u) * FAN, params.lights); i++) {
                if light_touches(lights[i], box) {
                    // Always so but when lists are measured: there is no room yet.
                    if at < params.capacity {
                        list[at] = i;
                    }
                    at++;
                }
            }
        }
    }
}
