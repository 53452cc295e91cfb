// Reservoirs of lights, pass by pass; operation for operation
// crates/many-lights/src/sample/reservoirs/{cpu,packed,neighbours,alias}.rs, where reasons stand.
// Based on: B. Bitterli et al., "Spatiotemporal reservoir resampling for real-time ray tracing with
// dynamic direct lighting", 2020, algorithms 3 - 6.
#import common/lights_frame.wgsl
#import common/lights_random.wgsl

// Mirrors Slot.
struct Slot {
    own: u32,
    other: u32,
    inverse_own: f32,
    inverse_other: f32,
}

// Mirrors Reservoir.
struct Reservoir {
    light: u32,
    count: u32,
    weight: f32,
}

// Mirrors PackedEye.
struct ReservoirEye {
    position: vec3<f32>,
    perspective: u32,
    forward: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    up: vec3<f32>,
    pad: u32,
}

// Mirrors ReservoirParams.
struct ReservoirParams {
    candidates: u32,
    history: u32,
    neighbours: u32,
    radius: i32,
    radius_squared: i32,
    unbiased: u32,
    // Of the table; 0 where nothing can be drawn.
    slots: u32,
    shift: u32,
    // First numbers of the three streams.
    seed_candidates: u32,
    seed_temporal: u32,
    seed_spatial: u32,
    pad: u32,
    // Of this frame, and of the one before.
    eye: ReservoirEye,
    eye_before: ReservoirEye,
}

@group(1) @binding(0) var<uniform> params: ReservoirParams;
@group(1) @binding(1) var<storage, read> lights: array<Light>;
@group(1) @binding(2) var<storage, read> slots: array<Slot>;
// This frame's, before neighbours are merged.
@group(1) @binding(3) var<storage, read_write> now: array<Reservoir>;
// The frame before's, then this one's.
@group(1) @binding(4) var<storage, read_write> last: array<Reservoir>;
@group(2) @binding(0) var<storage, read> points_before: array<Point>;

const NONE = 0xffffffffu;
const LEAST_COSINE = 0.9063078;
const DEPTH_SHARE = 0.1;
const LUMINANCE = vec3<f32>(0.2126, 0.7152, 0.0722);

// Lights evaluated, reservoirs looked at.
var<private> counted: vec2<u32>;

// Neither negative nor infinite nor no number; by its bits, since compilers take floats for numbers.
fn is_sound_number(value: f32) -> bool {
    return bitcast<u32>(value) <= 0x7f7fffffu;
}

fn empty(count: u32) -> Reservoir {
    return Reservoir(NONE, count, 0.0);
}

fn reservoir_of(light: u32, count: u32, weight: f32) -> Reservoir {
    if is_sound_number(weight) {
        return Reservoir(light, count, weight);
    }
    return empty(count);
}

fn is_sound(reservoir: Reservoir) -> bool {
    return is_sound_number(reservoir.weight)
        && (reservoir.weight == 0.0 || reservoir.light < frame.lights);
}

fn radiance_of(point: Point, light: u32) -> vec3<f32> {
    return estimate(leaf_of(lights[light], light), point, frame.clamp_squared);
}

fn target_of(point: Point, light: u32) -> f32 {
    if COUNT {
        counted.x += 1u;
    }
    let value = dot(radiance_of(point, light), LUMINANCE);
    return select(0.0, value, is_sound_number(value));
}

fn is_alike(eye: ReservoirEye, point: Point, other: Point) -> bool {
    if other.object == NOTHING {
        return false;
    }
    let here = dot(point.position - eye.position, eye.forward);
    let there = dot(other.position - eye.position, eye.forward);
    return dot(point.normal, other.normal) >= LEAST_COSINE
        && abs(there - here) <= DEPTH_SHARE * abs(here);
}

// Where a point was in the image of the frame before, as the number of the pixel; or NONE.
fn pixel_before(point: Point) -> u32 {
    let eye = params.eye_before;
    let to_point = point.position - eye.position;
    let scale = select(1.0, dot(to_point, eye.forward), eye.perspective != 0u);
    if scale <= 0.0 {
        return NONE;
    }
    let x = 0.5 + 0.5 * (dot(to_point, eye.right) / scale);
    let y = 0.5 - 0.5 * (dot(to_point, eye.up) / scale);
    if !(x >= 0.0 && y >= 0.0 && x < 1.0 && y < 1.0) {
        return NONE;
    }
    let column = min(u32(x * f32(eye.width)), eye.width - 1u);
    let row = min(u32(y * f32(eye.height)), eye.height - 1u);
    return row * eye.width + column;
}

// The next neighbour of the stream, as the number of the pixel; NONE outside and for itself. A second
// number of the stream decides for or against it.
fn next_neighbour(pixel: vec2<i32>) -> u32 {
    let bits = random_bits();
    let side = u32(2 * params.radius + 1);
    var offset = vec2<i32>(
        i32(((bits >> 16u) * side) >> 16u),
        i32(((bits & 0xffffu) * side) >> 16u),
    ) - params.radius;
    if offset.x * offset.x + offset.y * offset.y > params.radius_squared {
        offset /= 2;
    }
    let place = pixel + offset;
    let inside = all(place >= vec2<i32>(0))
        && place.x < i32(frame.width) && place.y < i32(frame.height);
    if !inside || all(offset == vec2<i32>(0)) {
        return NONE;
    }
    return index_of(vec2<u32>(place));
}

// A merge that is under way.
struct Merge {
    sum: f32,
    light: u32,
    // The target of that light.
    kept: f32,
    // Which of the others it is from; NONE where it is the pixel's own.
    source: u32,
    count: u32,
    // Target of the light where it was drawn, and the sum of all that could have drawn it.
    did: f32,
    could: f32,
}

fn started(point: Point, own: Reservoir) -> Merge {
    var merge = Merge(0.0, 0u, 0.0, NONE, own.count, 0.0, 0.0);
    if own.weight > 0.0 {
        merge.light = own.light;
        merge.kept = target_of(point, own.light);
        merge.sum = merge.kept * own.weight * f32(own.count);
    }
    return merge;
}

fn offered(before: Merge, point: Point, other: Reservoir, which: u32, unit: f32) -> Merge {
    var merge = before;
    if COUNT {
        counted.y += 1u;
    }
    merge.count += other.count;
    if other.weight == 0.0 {
        return merge;
    }
    let target_here = target_of(point, other.light);
    let weight = target_here * other.weight * f32(other.count);
    merge.sum += weight;
    if unit * merge.sum < weight {
        merge.light = other.light;
        merge.kept = target_here;
        merge.source = which;
    }
    return merge;
}

// Once all were offered: whether those that could have drawn the light have to be weighed.
fn is_weighed(merge: Merge) -> bool {
    return merge.kept != 0.0 && params.unbiased != 0u;
}

fn weighed(before: Merge, there: Point, other: Reservoir, which: u32) -> Merge {
    var merge = before;
    let target_there = target_of(there, merge.light);
    if merge.source == which {
        merge.did = target_there;
    }
    merge.could += f32(other.count) * target_there;
    return merge;
}

fn ended(merge: Merge) -> Reservoir {
    if merge.kept == 0.0 {
        return empty(merge.count);
    }
    if params.unbiased == 0u {
        let weight = merge.sum / (merge.kept * f32(merge.count));
        return reservoir_of(merge.light, merge.count, weight);
    }
    let weight = merge.sum / merge.kept * (merge.did / merge.could);
    return reservoir_of(merge.light, merge.count, weight);
}

fn candidates_of(point: Point, pixel: u32) -> Reservoir {
    let count = params.candidates;
    if params.slots == 0u {
        return empty(count);
    }
    start_random(params.seed_candidates, frame.frame, pixel);
    var sum = 0.0;
    var light = 0u;
    var kept = 0.0;
    for (var i = 0u; i < count; i++) {
        let place = random_bits() >> params.shift;
        let slot = slots[place];
        let own = random_bits() < slot.own;
        let drawn = select(slot.other, place, own);
        let target_of_drawn = target_of(point, drawn);
        let weight = target_of_drawn * select(slot.inverse_other, slot.inverse_own, own);
        sum += weight;
        if random_unit() * sum < weight {
            light = drawn;
            kept = target_of_drawn;
        }
    }
    if kept == 0.0 {
        return empty(count);
    }
    return reservoir_of(light, count, sum / (kept * f32(count)));
}

@compute @workgroup_size(TILE, TILE)
fn candidates(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    var own = empty(0u);
    if point.object != NOTHING {
        own = candidates_of(point, pixel);
    }
    now[pixel] = own;
    if COUNT {
        counts[pixel] = vec4<u32>(counted, 0u, 0u);
    }
}

@compute @workgroup_size(TILE, TILE)
fn temporal(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    if point.object == NOTHING {
        return;
    }
    let place = pixel_before(point);
    if place == NONE {
        return;
    }
    let there = points_before[place];
    var other = last[place];
    if !is_alike(params.eye_before, point, there) || !is_sound(other) {
        return;
    }
    other.count = min(other.count, params.history);
    start_random(params.seed_temporal, frame.frame, pixel);
    let own = now[pixel];
    var merge = started(point, own);
    merge = offered(merge, point, other, 0u, random_unit());
    if is_weighed(merge) {
        merge.did = merge.kept;
        merge.could = f32(own.count) * merge.kept;
        merge = weighed(merge, there, other, 0u);
    }
    now[pixel] = ended(merge);
    if COUNT {
        counts[pixel] += vec4<u32>(counted, 0u, 0u);
    }
}

@compute @workgroup_size(TILE, TILE)
fn spatial(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let point = points[pixel];
    let own = now[pixel];
    if point.object == NOTHING {
        last[pixel] = own;
        return;
    }
    start_random(params.seed_spatial, frame.frame, pixel);
    let beginning = random_state;
    var merge = started(point, own);
    var others = 0u;
    for (var i = 0u; i < params.neighbours; i++) {
        let place = next_neighbour(vec2<i32>(id.xy));
        let unit = random_unit();
        if place == NONE {
            continue;
        }
        let other = now[place];
        if is_alike(params.eye, point, points[place]) && is_sound(other) {
            merge = offered(merge, point, other, i, unit);
            others += 1u;
        }
    }
    if others == 0u {
        last[pixel] = own;
        return;
    }
    if is_weighed(merge) {
        merge.did = merge.kept;
        merge.could = f32(own.count) * merge.kept;
        // The same neighbours once more.
        random_state = beginning;
        for (var i = 0u; i < params.neighbours; i++) {
            let place = next_neighbour(vec2<i32>(id.xy));
            random_unit();
            if place == NONE {
                continue;
            }
            let there = points[place];
            let other = now[place];
            if is_alike(params.eye, point, there) && is_sound(other) {
                merge = weighed(merge, there, other, i);
            }
        }
    }
    last[pixel] = ended(merge);
    if COUNT {
        counts[pixel] += vec4<u32>(counted, 0u, 0u);
    }
}

@compute @workgroup_size(TILE, TILE)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let kept = last[pixel];
    var rgb = vec3<f32>(0.0);
    if kept.weight > 0.0 {
        rgb = radiance_of(points[pixel], kept.light) * kept.weight;
    }
    radiance[pixel] = vec4<f32>(rgb, 0.0);
}
