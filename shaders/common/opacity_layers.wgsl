// Where layers lie along a ray. The importer binds `layered`, `table`, `bounds_map` and
// `opaque_map`.
#import common/opacity_bounds.wgsl

struct LayerParams {
    // Layers of the maps, and the range of them that a pass draws.
    layers: u32,
    first: u32,
    end: u32,
    width: u32,
    // Depth of all layers together (DEEP).
    span: f32,
    // 0 uniform, 1 logarithmic.
    lambda: f32,
    // N - 2 and log2(N - 1) of the split's logarithm.
    stretch: f32,
    octaves: f32,
    // Taken from a fragment's depth before it is put into a layer.
    write_bias: f32,
    // Stored numbers per thickness.
    scale: f32,
    // Entries of the table less one.
    last_entry: u32,
    // Texels of a map.
    texels: u32,
}

// LAYOUT.
const PLANES_UNIFORM = 0u;
// Boundaries are in the table, for all rays or from each ray's first fragment on.
const PLANES = 1u;
const DEEP_UNIFORM = 2u;
const DEEP = 3u;
const BOUNDED = 4u;
// SPLIT.
const UNIFORM = 0u;
const NORMALISED = 1u;
// Texels of the table stand for t = 0 ..= 1.
const TABLE = 2u;
// Texels of the table are read as a texture's, their centres half a texel in.
const LISTING_TABLE = 3u;
// Positions are mixed instead of coordinates.
const POSITIONS = 4u;

override LAYOUT: u32 = 4u;
override SPLIT: u32 = 0u;
// H(t) (K - 1) instead of H(t) K.
override THESIS_BINS: bool = false;
// Side of the tiles that have a λ of their own, in the table; 0: there is one for all.
override TILE: u32 = 0u;

// First and last depth of a texel, (1, 0) without any.
fn ends_of(texel: vec2<u32>) -> vec2<f32> {
    if LAYOUT == PLANES_UNIFORM || LAYOUT == PLANES {
        return vec2(table[0], table[layered.layers]);
    }
    return own_ends(texel);
}

// λ of a texel.
fn lambda_of(texel: vec2<u32>) -> f32 {
    if TILE == 0u {
        return layered.lambda;
    }
    // Divisions by the constant are checked even where they are not reached.
    let side = max(TILE, 1u);
    let tile = texel / side;
    return table[tile.y * ((layered.width + side - 1u) / side) + tile.x];
}

// Place of x between the rising entries 0..=last of the table, 0..=last: an entry belongs to what
// comes behind it, and gaps of no width are stepped over.
fn place_in_table(x: f32, last: u32) -> f32 {
    if !(x >= table[0]) {
        return 0.0;
    }
    if x >= table[last] {
        return f32(last);
    }
    var low = 0u;
    var high = last;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if table[middle] <= x {
            low = middle;
        } else {
            high = middle;
        }
    }
    return f32(low) + (x - table[low]) / (table[low + 1u] - table[low]);
}

fn logarithmic(t: f32) -> f32 {
    return log2(1.0 + layered.stretch * t) / layered.octaves;
}

// The table between its texels; x in texels, 0 at the middle of the first.
fn between_texels(x: f32) -> f32 {
    let last = layered.last_entry;
    let within = clamp(x, 0.0, f32(last));
    let low = u32(within);
    let here = table[low];
    return here + (table[min(low + 1u, last)] - here) * (within - f32(low));
}

// Halvings that locate a mixed position to the last bit of an f32 in 0..=1.
const HALVINGS = 24;

// The u whose mixed position is t.
fn of_position(t: f32, lambda: f32) -> f32 {
    if lambda == 0.0 {
        return t;
    }
    if lambda == 1.0 {
        return logarithmic(t);
    }
    var low = 0.0;
    var high = 1.0;
    for (var i = 0; i < HALVINGS; i++) {
        let u = 0.5 * (low + high);
        let position = (exp2(u * layered.octaves) - 1.0) / layered.stretch;
        if (1.0 - lambda) * u + lambda * position <= t {
            low = u;
        } else {
            high = u;
        }
    }
    return low;
}

// H: local depth to layer coordinate 0..=1.
fn split_function(local: f32, lambda: f32) -> f32 {
    if SPLIT == UNIFORM {
        return clamp(local, 0.0, 1.0);
    }
    if local >= 1.0 && SPLIT != LISTING_TABLE {
        return 1.0;
    }
    let t = max(local, 0.0);
    var u = t;
    switch SPLIT {
        case NORMALISED: {
            u = (1.0 - lambda) * t + lambda * logarithmic(t);
        }
        case TABLE: {
            u = between_texels(t * f32(layered.last_entry));
        }
        case LISTING_TABLE: {
            u = between_texels(min(t, 0.9999) * f32(layered.last_entry + 1u) - 0.5);
        }
        default: {
            u = of_position(t, lambda);
        }
    }
    return min(u, 1.0);
}

// Layer coordinate 0..=K of a depth at or behind a ray's first.
fn layer_coordinate(depth: f32, ends: vec2<f32>, lambda: f32) -> f32 {
    let layers = f32(layered.layers);
    switch LAYOUT {
        case PLANES_UNIFORM: {
            let range = ends.y - ends.x;
            if range < THIN {
                return select(0.0, layers, depth > ends.y);
            }
            return clamp((depth - ends.x) / range * layers, 0.0, layers);
        }
        case PLANES: {
            return place_in_table(depth, layered.layers);
        }
        case DEEP_UNIFORM: {
            return clamp((depth - ends.x) / layered.span * layers, 0.0, layers);
        }
        case DEEP: {
            return place_in_table(depth - ends.x, layered.layers);
        }
        default: {
            var t = select(0.0, 1.0, depth > ends.y);
            let range = ends.y - ends.x;
            if range >= THIN {
                t = (depth - ends.x) / range;
            }
            return split_function(t, lambda) * select(layers, layers - 1.0, THESIS_BINS);
        }
    }
}

// The layer of a coordinate: what lies beyond the end belongs to the last.
fn layer_of(coordinate: f32) -> u32 {
    return min(u32(max(coordinate, 0.0)), layered.layers - 1u);
}
