// From flags to draws: the listed items of every template side by side, in their order, and an
// indirect draw a template. A prefix sum rather than a counter: what is drawn first does not change
// from run to run.
#import common/occlusion_cull.wgsl
#import common/index.wgsl

// One template.
struct Slot {
    // Its items.
    first: u32,
    end: u32,
    // Vertices of one.
    vertices: u32,
}

// Mirrors wgpu's `DrawIndirectArgs`.
struct DrawArgs {
    vertex_count: u32,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
}

// Listed items of each workgroup, then those of all workgroups before it.
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
// Objects in the list after the first pass, and after the second.
@group(0) @binding(2) var<storage, read_write> totals: array<u32>;

@group(0) @binding(3) var<storage, read> state: array<u32>;
// The object of each item.
@group(0) @binding(4) var<storage, read> order: array<u32>;
@group(0) @binding(5) var<storage, read_write> list: array<u32>;
// Places of the list that items before each item take, and at the end all.
@group(0) @binding(6) var<storage, read_write> offsets: array<u32>;

@group(0) @binding(7) var<storage, read> slots: array<Slot>;
@group(0) @binding(8) var<storage, read_write> draws: array<DrawArgs>;

// Whether this is the second pass, whose list follows that of the first.
override second: bool = false;

var<workgroup> lanes: array<u32, ITEMS>;

// Sum of `value` over all lanes before this one.
fn before(value: u32, lane: u32) -> u32 {
    lanes[lane] = value;
    workgroupBarrier();
    for (var step = 1u; step < ITEMS; step *= 2u) {
        var sum = lanes[lane];
        if lane >= step {
            sum += lanes[lane - step];
        }
        workgroupBarrier();
        lanes[lane] = sum;
        workgroupBarrier();
    }
    return lanes[lane] - value;
}

// One workgroup.
@compute @workgroup_size(ITEMS)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let each = (params.groups + ITEMS - 1u) / ITEMS;
    let first = min(lane * each, params.groups);
    let end = min(first + each, params.groups);
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += sums[i];
    }
    var offset = before(sum, lane);
    if second {
        offset += totals[0];
    }
    for (var i = first; i < end; i++) {
        let own = sums[i];
        sums[i] = offset;
        offset += own;
    }
    if lane == ITEMS - 1u {
        totals[u32(second)] = offset;
    }
}

@compute @workgroup_size(ITEMS)
fn scatter(
    @builtin(local_invocation_index) lane: u32,
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let item = linear_index(id, groups, ITEMS);
    var listed = 0u;
    if item < params.items {
        listed = u32((state[item] & LISTED) != 0u);
    }
    let inside = before(listed, lane);
    if item < params.items {
        let offset = sums[linear_group(group, groups)] + inside;
        offsets[item] = offset;
        if listed == 1u {
            list[offset] = order[item];
        }
        if item == params.items - 1u {
            offsets[params.items] = offset + listed;
        }
    }
}

@compute @workgroup_size(ITEMS)
fn arguments(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let slot = linear_index(id, groups, ITEMS);
    if slot >= params.slots {
        return;
    }
    let begin = offsets[slots[slot].first];
    let end = offsets[slots[slot].end];
    draws[slot] = DrawArgs(slots[slot].vertices, end - begin, 0u, begin);
}
