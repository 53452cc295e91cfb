// What a cluster of lights gives by its representative, and the most that it can give: operation for
// operation crates/many-lights/src/bound/{angles,packed}.rs, where sources and reasons stand.

// Mirrors PackedNode.
struct LightNode {
    position: vec3<f32>,
    // Half the opening of the cone of axes, radians.
    cone_rad: f32,
    intensity: vec3<f32>,
    // Nodes of the subtree, this one included.
    size: u32,
    axis: vec3<f32>,
    // The lights' greatest half angle, radians.
    half_angle_rad: f32,
    low: vec3<f32>,
    light: u32,
    high: vec3<f32>,
    kind: u32,
}

// A receiver. Mirrors Point.
struct Point {
    position: vec3<f32>,
    object: u32,
    normal: vec3<f32>,
    pad: u32,
    // Diffuse reflectance.
    albedo: vec3<f32>,
    pad_behind: u32,
}

// Receivers of a tile. Mirrors PackedRegion.
struct Region {
    low: vec3<f32>,
    // The normals' greatest angle from their axis, radians.
    normal_spread_rad: f32,
    high: vec3<f32>,
    pad: u32,
    normal_axis: vec3<f32>,
    pad_behind: u32,
    albedo: vec3<f32>,
    pad_last: u32,
}

const KIND_OMNI = 0u;
const KIND_ORIENTED = 1u;
const KIND_SPOT = 2u;
const KIND_DIRECTIONAL = 3u;

const FORM_WALTER = 0u;
const FORM_CHEAP = 1u;

const HALF_PI = 1.5707964;
// Rounded up: cones of pi are, too.
const WHOLE_CONE = 3.1415927;
const OVER_PI = 0.31830987;
// Rec. 709.
const LUMINANCE = vec3<f32>(0.2126, 0.7152, 0.0722);
// What rounding could take away from a bound; reasons in bound/mod.rs.
const GUARD = 1.00001;
const ALONG_SLACK = 9.6e-7;
const ANGLE_SLACK_RAD = 2e-6;
const SQUARE_SLACK = 2e-6;
// Squared lengths below this have no direction.
const NOWHERE = 1e-30;
// The greatest half chord of an angle up to a right one, and what rounding adds.
const HALF_CHORD = 0.7072;

// The arc sine of a number in 0..=0.7072: drivers' own may be off by 1e-3.
fn arc_sine(s: f32) -> f32 {
    let t = s * s;
    var series = 0.10091153;
    series = -0.05472247 + t * series;
    series = 0.060530853 + t * series;
    series = 0.039009277 + t * series;
    series = 0.07547095 + t * series;
    series = 0.16665374 + t * series;
    return s + s * t * series;
}

// The cosine of an angle of at least 0, but 0 from a right angle on.
fn cosine_or_none(angle_rad: f32) -> f32 {
    let y = 0.5 * angle_rad;
    let t = y * y;
    let sine = y + y * t * (-0.16666655 + t * (0.00833216 + t * -0.00019515282));
    return select(max(1.0 - 2.0 * sine * sine, 0.0), 0.0, angle_rad >= HALF_PI);
}

fn from_half_chord(s: f32, flip: bool) -> f32 {
    let angle = 2.0 * arc_sine(s);
    return select(angle, WHOLE_CONE - angle, flip);
}

// The angle between two unit vectors, radians, by their distance: as exact near 0 as elsewhere.
fn angle_between(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let flip = dot(a, b) < 0.0;
    let chord = select(a - b, a + b, flip);
    return from_half_chord(min(0.5 * sqrt(dot(chord, chord)), HALF_CHORD), flip);
}

// Share of the intensity that leaves at the angle between `axis` and `away`.
fn falloff(kind: u32, half_angle_rad: f32, axis: vec3<f32>, away: vec3<f32>) -> f32 {
    if kind == KIND_ORIENTED {
        return max(dot(axis, away), 0.0);
    }
    if kind == KIND_SPOT {
        return max(1.0 - angle_between(axis, away) / half_angle_rad, 0.0);
    }
    return 1.0;
}

// What the cluster gives by its representative; of a leaf, its light's radiance.
fn estimate(node: LightNode, point: Point, clamp_squared: f32) -> vec3<f32> {
    let greatest = point.albedo * node.intensity * OVER_PI;
    if node.kind == KIND_DIRECTIONAL {
        return greatest * max(-dot(point.normal, node.axis), 0.0);
    }
    let to_light = node.position - point.position;
    let squared = dot(to_light, to_light);
    if squared == 0.0 {
        return vec3<f32>(0.0);
    }
    let direction = to_light / sqrt(squared);
    let cosine = max(dot(point.normal, direction), 0.0);
    if cosine == 0.0 {
        return vec3<f32>(0.0);
    }
    let kind = select(node.kind, KIND_OMNI, node.cone_rad >= WHOLE_CONE);
    let share = falloff(kind, node.half_angle_rad, node.axis, -direction);
    return greatest * (cosine * share / max(squared, clamp_squared));
}

// No vector of a box leans more towards an axis than `x` along and the root of `y` across it.
fn closest(
    form: u32,
    axis: vec3<f32>,
    low: vec3<f32>,
    high: vec3<f32>,
    squared: f32,
) -> vec2<f32> {
    let centre = 0.5 * (low + high);
    let reach = 0.5 * (high - low);
    let farthest = max(abs(low), abs(high));
    let slack = ALONG_SLACK * (farthest.x + farthest.y + farthest.z);
    let along = dot(axis, centre) + dot(abs(axis), reach) + slack;
    let by_distance = squared * (1.0 - SQUARE_SLACK) - along * along;
    if form == FORM_CHEAP {
        if along < 0.0 {
            return vec2(0.0, 1.0);
        }
        return vec2(along, max(by_distance, 0.0));
    }
    // Two unit vectors at right angles to the axis (Duff et al. 2017, listing 3).
    let sign = select(1.0, -1.0, axis.z < 0.0);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let u = vec3(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let v = vec3(b, sign + axis.y * axis.y * a, -axis.y);
    let middle = vec2(abs(dot(u, centre)), abs(dot(v, centre)));
    let across = vec2(dot(abs(u), reach), dot(abs(v), reach));
    if along < 0.0 {
        let far = middle + across + slack;
        return vec2(along, dot(far, far));
    }
    let near = max(middle - across - slack, vec2(0.0));
    return vec2(along, max(dot(near, near), by_distance));
}

// The greatest cosine of what `closest` found.
fn closest_cosine(found: vec2<f32>) -> f32 {
    let squared = found.x * found.x + found.y;
    if found.y <= 0.0 || squared < NOWHERE {
        return 1.0;
    }
    return found.x / sqrt(squared);
}

// The smallest angle of what `closest` found, radians.
fn closest_angle(found: vec2<f32>) -> f32 {
    let squared = found.x * found.x + found.y;
    if squared < NOWHERE {
        return 0.0;
    }
    let length = sqrt(squared);
    // 1 - cos without the difference.
    let twice = 2.0 * length * (length + abs(found.x));
    return from_half_chord(sqrt(max(found.y, 0.0) / twice), found.x < 0.0);
}

fn cosine_within(angle_rad: f32) -> f32 {
    return cosine_or_none(max(angle_rad - ANGLE_SLACK_RAD, 0.0));
}

// The most that any channel can get from the cluster at any point of a region.
fn bound_region(form: u32, node: LightNode, region: Region, clamp_squared: f32) -> f32 {
    let rgb = region.albedo * node.intensity;
    let greatest = GUARD * OVER_PI * max(rgb.x, max(rgb.y, rgb.z));
    if node.kind == KIND_DIRECTIONAL {
        let between = angle_between(region.normal_axis, -node.axis);
        return greatest * cosine_within(between - region.normal_spread_rad - node.cone_rad);
    }
    let low = node.low - region.high;
    let high = node.high - region.low;
    let outside = max(max(low, -high), vec3<f32>(0.0));
    let squared = dot(outside, outside);
    let to_normal = closest(form, region.normal_axis, low, high, squared);
    var cosine: f32;
    if region.normal_spread_rad == 0.0 {
        cosine = max(closest_cosine(to_normal), 0.0);
    } else {
        cosine = cosine_within(closest_angle(to_normal) - region.normal_spread_rad);
    }
    if cosine == 0.0 {
        return 0.0;
    }
    var share = 1.0;
    if node.kind != KIND_OMNI && node.cone_rad < WHOLE_CONE {
        let to_axis = closest(form, node.axis, -high, -low, squared);
        let least = max(closest_angle(to_axis) - node.cone_rad - ANGLE_SLACK_RAD, 0.0);
        if node.kind == KIND_ORIENTED {
            share = cosine_or_none(least);
        } else {
            share = max(1.0 - least / node.half_angle_rad, 0.0);
        }
    }
    return greatest * (cosine * share / max(squared, clamp_squared));
}

// The most that any channel can get from the cluster at a point.
fn bound_point(form: u32, node: LightNode, point: Point, clamp_squared: f32) -> f32 {
    let region = Region(
        point.position, 0.0, point.position, 0u, point.normal, 0u, point.albedo, 0u,
    );
    return bound_region(form, node, region, clamp_squared);
}
