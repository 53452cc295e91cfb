// Shadow rays from points to lights of the world.
#import common/lights_frame.wgsl
#import common/shadow_rays.wgsl

@group(2) @binding(3) var<storage, read> shadow_lights: array<Light>;

// Whether anything casts shadows.
override SHADOWS: bool = false;

// Rays of this invocation, where they are counted.
var<private> rays: u32;

fn sees_light(point: Point, light: Light) -> bool {
    if light.kind == KIND_DIRECTIONAL {
        return !is_hidden_from_afar(point.position, point.normal, light.axis);
    }
    return !is_hidden(point.position, point.normal, light.position);
}

// Whether a point sees light `index`; of a cluster the one that stands for it.
fn sees(point: Point, index: u32) -> bool {
    return sees_light(point, shadow_lights[index]);
}

// What is left of what a light gives to a point.
fn seen_light(point: Point, light: Light, given: vec3<f32>) -> vec3<f32> {
    if !SHADOWS || all(given == vec3<f32>(0.0)) {
        return given;
    }
    if COUNT {
        rays += 1u;
    }
    return select(vec3<f32>(0.0), given, sees_light(point, light));
}

// What is left of what light `index`, or the cluster that it stands for, gives to a point.
fn seen(point: Point, index: u32, given: vec3<f32>) -> vec3<f32> {
    return seen_light(point, shadow_lights[index], given);
}
