// Whether anything lies on a way: any-hit traversal of a tree in f32. Mirrors gpu::Occluders, where
// the numbers are argued.
// Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", 2013, section 3.
// Deviations: no second look in f64 at an edge function of 0. Drivers may fuse its two products, so
// the two triangles of an edge need not compute opposite numbers: both take what is nearer to their
// edge than rounding can tell, and nothing slips between them.

// Mirrors FlatNode.
struct ShadowNode {
    low: vec3<f32>,
    // Triangles of a leaf, 0 for a node with children.
    count: u32,
    high: vec3<f32>,
    // A leaf's first triangle, else the first of two children.
    first: u32,
}

// Mirrors FlatTriangle.
struct ShadowTriangle {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
}

// Mirrors ShadowParams.
struct ShadowParams {
    // Metres from a point, along its normal, to where rays start.
    lift: f32,
    // Metres from where rays end to a light.
    short: f32,
    nodes: u32,
    pad: u32,
}

@group(2) @binding(0) var<uniform> shadow: ShadowParams;
@group(2) @binding(1) var<storage, read> shadow_nodes: array<ShadowNode>;
@group(2) @binding(2) var<storage, read> shadow_triangles: array<ShadowTriangle>;

// Of the two products of an edge function: twice what their rounding and its own come to.
override EDGE_SLACK: f32 = 2.4e-7;

const SHADOW_STACK = 128u;
// Of the longest component: what is less is taken for this, so that nothing is divided by 0.
const LEAST_SLOPE = 1.1920929e-7;
const ENDLESS = 3e38;

// Components in turn, so that the one of that number comes last.
fn turned(v: vec3<f32>, last: u32) -> vec3<f32> {
    return select(select(v, v.zxy, last == 1u), v.yzx, last == 0u);
}

// Not 0, of the same sign.
fn safe_slope(slope: f32, least: f32) -> f32 {
    return select(slope, select(least, -least, slope < 0.0), abs(slope) < least);
}

// x: the edge function of p and q; y: how far it may be off.
fn edge(p: vec3<f32>, q: vec3<f32>) -> vec2<f32> {
    let first = p.x * q.y;
    let second = p.y * q.x;
    return vec2(first - second, EDGE_SLACK * (abs(first) + abs(second)));
}

// The ray sheared so that it runs along the last axis, in units of its direction there.
struct ShearedRay {
    origin: vec3<f32>,
    last: u32,
    shear: vec2<f32>,
    inverse: f32,
    reach: f32,
}

fn sheared(ray: ShearedRay, corner: vec4<f32>) -> vec3<f32> {
    let p = turned(corner.xyz - ray.origin, ray.last);
    return vec3(p.xy - ray.shear * p.z, p.z * ray.inverse);
}

fn meets(ray: ShearedRay, triangle: ShadowTriangle) -> bool {
    let a = sheared(ray, triangle.a);
    let b = sheared(ray, triangle.b);
    let c = sheared(ray, triangle.c);
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    // Edge-on, edge functions are noise; what covers the ray has it in the box of its corners.
    if any(low.xy > vec2(0.0)) || any(high.xy < vec2(0.0)) || high.z < 0.0 || low.z > ray.reach {
        return false;
    }
    let u = edge(c, b);
    let v = edge(a, c);
    let w = edge(b, a);
    let weights = vec3(u.x, v.x, w.x);
    let slack = vec3(u.y, v.y, w.y);
    let total = u.x + v.x + w.x;
    if (any(weights < -slack) && any(weights > slack)) || total == 0.0 {
        return false;
    }
    let at = clamp(dot(weights, vec3(a.z, b.z, c.z)) / total, low.z, high.z);
    return at >= 0.0 && at <= ray.reach;
}

// Whether a triangle meets `origin + t * direction` for a t in 0..=reach. The direction has any length
// but 0.
fn occluded(origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> bool {
    if shadow.nodes == 0u {
        return false;
    }
    let size = abs(direction);
    let last = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let slope = turned(direction, last);
    let ray = ShearedRay(origin, last, slope.xy / slope.z, 1.0 / slope.z, reach);
    let least = LEAST_SLOPE * max(size.x, max(size.y, size.z));
    let inverse = 1.0 / vec3(
        safe_slope(direction.x, least),
        safe_slope(direction.y, least),
        safe_slope(direction.z, least),
    );
    var waiting: array<u32, SHADOW_STACK>;
    var held = 1u;
    waiting[0] = 0u;
    while held > 0u {
        held -= 1u;
        let node = shadow_nodes[waiting[held]];
        let low = (node.low - origin) * inverse;
        let high = (node.high - origin) * inverse;
        let enter = min(low, high);
        let leave = max(low, high);
        let near = max(enter.x, max(enter.y, enter.z));
        let far = min(leave.x, min(leave.y, leave.z));
        if near > far || far < 0.0 || near > reach {
            continue;
        }
        if node.count == 0u {
            // Trees that need more are refused.
            waiting[held] = node.first;
            waiting[held + 1u] = node.first + 1u;
            held += 2u;
            continue;
        }
        for (var i = 0u; i < node.count; i++) {
            if meets(ray, shadow_triangles[node.first + i]) {
                return true;
            }
        }
    }
    return false;
}

// Whether anything lies between a point and a place.
fn is_hidden(position: vec3<f32>, normal: vec3<f32>, place: vec3<f32>) -> bool {
    let origin = position + normal * shadow.lift;
    let direction = place - origin;
    let distance = length(direction);
    return distance > shadow.short && occluded(origin, direction, 1.0 - shadow.short / distance);
}

// Whether anything lies between a point and parallel light that travels along `axis`.
fn is_hidden_from_afar(position: vec3<f32>, normal: vec3<f32>, axis: vec3<f32>) -> bool {
    return occluded(position + normal * shadow.lift, -axis, ENDLESS);
}
