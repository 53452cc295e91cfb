// Shadow rays from points to lights of the world.
#import common/lights_frame.wgsl
#import common/shadow_rays.wgsl

@group(2) @binding(3) var<storage, read> shadow_lights: array<Light>;

// Whether a point sees light `index`; of a cluster the one that stands for it.
fn sees(point: Point, index: u32) -> bool {
    let light = shadow_lights[index];
    if light.kind == KIND_DIRECTIONAL {
        return !is_hidden_from_afar(point.position, point.normal, light.axis);
    }
    return !is_hidden(point.position, point.normal, light.position);
}
