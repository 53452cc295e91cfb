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
    count: u32,
}

// M p of a light where it was drawn, and summed over all that are merged.
struct Could {
    did: f32,
    sum: f32,
}

// Takes the pixel's own reservoir first; `could` is ignored where merging is biased.
fn started(own: Reservoir, target_here: f32, could: Could) -> Merge {
    let weight = target_here * own.weight * part_of(own, could);
    return Merge(weight, own.light, target_here, own.count);
}

// How much a reservoir counts for.
fn part_of(reservoir: Reservoir, could: Could) -> f32 {
    if params.unbiased == 0u {
        return f32(reservoir.count);
    }
    return could.did / could.sum;
}

// Takes or leaves another's light, by chance.
fn offered(before: Merge, other: Reservoir, target_here: f32, could: Could, unit: f32) -> Merge {
    var merge = before;
    let weight = target_here * other.weight * part_of(other, could);
    merge.sum += weight;
    if unit * merge.sum < weight {
        merge.light = other.light;
        merge.kept = target_here;
    }
    return merge;
}

fn ended(merge: Merge) -> Reservoir {
    if merge.kept == 0.0 {
        return empty(merge.count);
    }
    var weight = merge.sum / merge.kept;
    if params.unbiased == 0u {
        weight /= f32(merge.count);
    }
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
    if COUNT {
        counted.y += 1u;
    }
    start_random(params.seed_temporal, frame.frame, pixel);
    let own = now[pixel];
    var merge = Merge(0.0, 0u, 0.0, own.count);
    if own.weight > 0.0 {
        let target_here = target_of(point, own.light);
        var could = Could(f32(own.count) * target_here, 0.0);
        if params.unbiased != 0u {
            could.sum = could.did + f32(other.count) * target_of(there, own.light);
        }
        merge = started(own, target_here, could);
    }
    merge.count += other.count;
    if other.weight > 0.0 {
        let target_here = target_of(point, other.light);
        if target_here != 0.0 {
            var could = Could(0.0, 0.0);
            if params.unbiased != 0u {
                could.did = f32(other.count) * target_of(there, other.light);
                could.sum = f32(own.count) * target_here + could.did;
            }
            merge = offered(merge, other, target_here, could, random_unit());
        }
    }
    now[pixel] = ended(merge);
    if COUNT {
        counts[pixel] += vec4<u32>(counted, 0u, 0u);
    }
}

// The next neighbour of the stream that is merged, if it is one.
fn next_merged(pixel: vec2<i32>, point: Point) -> u32 {
    let place = next_neighbour(pixel);
    if place == NONE || !is_alike(params.eye, point, points[place]) || !is_sound(now[place]) {
        return NONE;
    }
    return place;
}

// M p of a light at the neighbour of number `which`, or `own`, and summed over all neighbours of the
// stream, which goes on where it was.
fn could_of(pixel: vec2<i32>, point: Point, light: u32, own: f32, which: u32) -> Could {
    let resume = random_state;
    start_random(params.seed_spatial, frame.frame, index_of(vec2<u32>(pixel)));
    var could = Could(own, own);
    for (var i = 0u; i < params.neighbours; i++) {
        let place = next_merged(pixel, point);
        random_bits();
        if place == NONE {
            continue;
        }
        let part = f32(now[place].count) * target_of(points[place], light);
        could.sum += part;
        if i == which {
            could.did = part;
        }
    }
    random_state = resume;
    return could;
}

@compute @workgroup_size(TILE, TILE)
fn spatial(@builtin(global_invocation_id) id: vec3<u32>) {
    if !is_inside(id.xy) {
        return;
    }
    let pixel = index_of(id.xy);
    let place_here = vec2<i32>(id.xy);
    let point = points[pixel];
    let own = now[pixel];
    if point.object == NOTHING {
        last[pixel] = own;
        return;
    }
    var merge = Merge(0.0, 0u, 0.0, own.count);
    if own.weight > 0.0 {
        let target_here = target_of(point, own.light);
        var could = Could(0.0, 0.0);
        if params.unbiased != 0u {
            could = could_of(place_here, point, own.light, f32(own.count) * target_here, NONE);
        }
        merge = started(own, target_here, could);
    }
    start_random(params.seed_spatial, frame.frame, pixel);
    var others = 0u;
    for (var i = 0u; i < params.neighbours; i++) {
        let place = next_merged(place_here, point);
        let unit = random_unit();
        if place == NONE {
            continue;
        }
        others += 1u;
        let other = now[place];
        merge.count += other.count;
        if other.weight == 0.0 {
            continue;
        }
        let target_here = target_of(point, other.light);
        if target_here == 0.0 {
            continue;
        }
        var could = Could(0.0, 0.0);
        if params.unbiased != 0u {
            could = could_of(place_here, point, other.light, f32(own.count) * target_here, i);
        }
        merge = offered(merge, other, target_here, could, unit);
    }
    if others == 0u {
        last[pixel] = own;
        return;
    }
    last[pixel] = ended(merge);
    if COUNT {
        counts[pixel] += vec4<u32>(counted.x, others, 0u, 0u);
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
