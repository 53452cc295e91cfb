// What the kernels of hierarchical depth know of a frame. Mirrors `Params` of
// `camera::hierarchical_depth::gpu`.
struct Params {
    // Image axes: `xyz . (p - eye) + w` is NDC x times the distance (parallel rays: NDC x itself).
    right: vec4<f32>,
    up: vec4<f32>,
    // The distance along the view direction, metres.
    forward: vec4<f32>,
    // The frustum's, inside where `xyz . (p - eye) + w >= 0`.
    planes: array<vec4<f32>, 5>,
    eye: vec3<f32>,
    // Distance of the near plane from the camera, metres.
    near: f32,
    // Side of a pixel, metres: at distance 1, or everywhere for parallel rays.
    pixel: f32,
    // Length of the ray to the image's corner at distance 1.
    secant: f32,
    // From the near to the far plane, metres, of parallel rays.
    range: f32,
    parallel: u32,
    size: vec2<u32>,
    // Most texels that a rectangle is wide and high where it is asked.
    across: u32,
    levels: u32,
    // Objects, in the order of their templates.
    items: u32,
    // Workgroups of items.
    groups: u32,
    // Templates.
    slots: u32,
    pad: u32,
    // Width, height and first texel of each level; the first level is the image itself and has none.
    level: array<vec4<u32>, 16>,
}

@group(0) @binding(0) var<uniform> params: Params;

// Items of a workgroup.
const ITEMS = 256u;

// The state of an item: what the last frame saw, what the first pass drew, what this pass draws.
const VISIBLE = 1u;
const DRAWN = 2u;
const LISTED = 4u;
