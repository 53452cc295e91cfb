// The objects of a scene as `camera::gpu::Scene` uploads them: group 0.

// Triangles that objects share.
struct Shape {
    // Its first triangle; three times that is an index into `corners`.
    first_triangle: u32,
    triangles: u32,
    // Its first corner's index into `positions`.
    first_corner: u32,
    // Its first corner's index into `uvs`; only where there is a mask.
    first_uv: u32,
    // Index of its mask's first word in `mask_words`.
    first_word: u32,
    // Size of its mask in texels, 0 without one.
    mask_width: u32,
    mask_height: u32,
    // Linear RGB.
    albedo: array<f32, 3>,
}

// One placement of a shape.
struct Object {
    // Shape to local space: columns of the linear part, then the translation.
    linear: array<f32, 9>,
    translation: array<f32, 3>,
    // Index into `shapes`.
    shape: u32,
    // Its box in local space.
    low: array<f32, 3>,
    high: array<f32, 3>,
}

// Corners in the shape's space, three numbers each.
@group(0) @binding(0) var<storage, read> positions: array<f32>;
// Two numbers a corner, of shapes with a mask alone.
@group(0) @binding(1) var<storage, read> uvs: array<f32>;
// Three indices into `positions` a triangle.
@group(0) @binding(2) var<storage, read> corners: array<u32>;
@group(0) @binding(3) var<storage, read> shapes: array<Shape>;
@group(0) @binding(4) var<storage, read> objects: array<Object>;
// One bit a texel, rows top to bottom.
@group(0) @binding(5) var<storage, read> mask_words: array<u32>;

fn column(object: u32, first: u32) -> vec3<f32> {
    return vec3(
        objects[object].linear[first],
        objects[object].linear[first + 1u],
        objects[object].linear[first + 2u],
    );
}

// A corner of an object in local space: the linear part's columns in order, then the translation.
fn placed(object: u32, corner: u32) -> vec3<f32> {
    let first = 3u * corner;
    let t = objects[object].translation;
    return column(object, 0u) * positions[first]
        + column(object, 3u) * positions[first + 1u]
        + column(object, 6u) * positions[first + 2u]
        + vec3(t[0], t[1], t[2]);
}
