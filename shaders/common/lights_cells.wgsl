// Cells of the view: tiles of the image times slices of depth, as crates/many-lights/src/clustered
// has them.
#import common/lights_frame.wgsl

// Mirrors CellParams.
struct CellParams {
    eye: vec3<f32>,
    // Of the logarithm of depth over near, or of depth less near, to slices.
    scale: f32,
    forward: vec3<f32>,
    near_m: f32,
    tile: u32,
    slices: u32,
    columns: u32,
    cells: u32,
    // Groups of lights.
    groups: u32,
    // Lights that have a reach.
    lights: u32,
    // Entries that lists may have.
    capacity: u32,
    // Whether slices grow by a constant factor.
    growing: u32,
}

// Words of a cell's box: lower corner, upper corner, as numbers in the order of the floats.
const BOX_WORDS = 6u;

fn slice_of(params: CellParams, position: vec3<f32>) -> u32 {
    let depth = dot(position - params.eye, params.forward);
    var along = depth - params.near_m;
    if params.growing != 0u {
        along = log(max(depth / params.near_m, 1.0));
    }
    return u32(clamp(along * params.scale, 0.0, f32(params.slices - 1u)));
}

fn cell_of(params: CellParams, pixel: vec2<u32>, position: vec3<f32>) -> u32 {
    let tile = pixel / params.tile;
    return (tile.y * params.columns + tile.x) * params.slices + slice_of(params, position);
}

// Floats as unsigned numbers in the same order.
fn ordered(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn from_ordered(bits: u32) -> f32 {
    return bitcast<f32>(select(~bits, bits & 0x7fffffffu, bits >= 0x80000000u));
}
