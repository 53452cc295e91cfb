// What trial maps are judged by, one part of a tile a workgroup. The importer defines
// `stored_layer`, the number that a texel keeps for a layer.
#import common/opacity_number.wgsl
#import common/opacity_lanes.wgsl

struct ScoreParams {
    width: u32,
    height: u32,
    layers: u32,
    // Side of a tile.
    tile: u32,
    // Tiles in a row, tiles, parts of a tile.
    across: u32,
    tiles: u32,
    parts: u32,
    // Distance of texels that are looked at.
    step: u32,
    // Stored numbers per thickness.
    scale: f32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// CRITERION.
const ABSOLUTE_DIFFERENCES = 0u;
const CORRELATION = 1u;
const EQUAL_OPACITY = 2u;
const EQUAL_TRANSMITTANCE = 3u;
override CRITERION: u32 = 3u;
// Thicknesses as bytes: min(Ω, 1) in 255 parts.
override BYTES: bool = false;
// Whether texels without opacity are left out.
override MASKED: bool = false;

// Texels that a lane looks at.
const RUN = 16u;

// Beyond it nothing is dark enough to tell apart, and squares of it can be summed.
const MOST_SCORED = 1e9;

@group(0) @binding(0) var<uniform> scoring: ScoreParams;
// Of each part: its sum; or its number of texels, then of each layer the mean, the sum of squares
// about it, and the sum of products with the layer before about both.
@group(0) @binding(1) var<storage, read_write> partials: array<f32>;

// A layer of a texel as it is scored.
fn scored(texel: vec2<u32>, layer: u32) -> f32 {
    let thickness = thickness_of(stored_layer(texel, layer), scoring.scale);
    if BYTES {
        return floor(clamp(thickness * 255.0 + 0.5, 0.0, 255.0));
    }
    return min(thickness, MOST_SCORED);
}

// Texels of a tile that are looked at, in columns and rows.
fn tile_size(tile: u32) -> vec2<u32> {
    let size = vec2(scoring.width, scoring.height);
    let corner = min(tile_corner(tile), size);
    return (min(vec2(scoring.tile), size - corner) + scoring.step - 1u) / scoring.step;
}

fn tile_corner(tile: u32) -> vec2<u32> {
    return vec2(tile % scoring.across, tile / scoring.across) * scoring.tile;
}

fn texel_of(tile: u32, columns: u32, index: u32) -> vec2<u32> {
    return tile_corner(tile) + scoring.step * vec2(index % columns, index / columns);
}

fn counts(texel: vec2<u32>) -> bool {
    return !MASKED || stored_layer(texel, scoring.layers - 1u) > 0.0;
}

// A texel's sum over its layers.
fn differences(texel: vec2<u32>) -> f32 {
    // Bytes hold thickness in 255 parts.
    let unit = select(1.0, 1.0 / 255.0, BYTES);
    var before = select(0.0, 1.0, CRITERION == EQUAL_TRANSMITTANCE);
    var sum = 0.0;
    for (var layer = 0u; layer < scoring.layers; layer++) {
        var x = scored(texel, layer);
        if CRITERION == EQUAL_TRANSMITTANCE {
            x = exp(-unit * x);
        }
        let difference = x - before;
        before = x;
        if CRITERION != ABSOLUTE_DIFFERENCES {
            sum += difference * difference;
        } else if layer > 0u {
            sum += abs(difference);
        }
    }
    return sum;
}

fn score_differences(group: u32, lane: u32) {
    let tile = group / scoring.parts;
    let size = tile_size(tile);
    let first = group % scoring.parts * RUN * LANES + lane;
    var sum = 0.0;
    for (var i = 0u; i < RUN; i++) {
        let index = first + i * LANES;
        if tile < scoring.tiles && index < size.x * size.y {
            let texel = texel_of(tile, size.x, index);
            if counts(texel) {
                sum += differences(texel);
            }
        }
    }
    let all = sum_of_lanes(vec2(sum, 0.0), lane).x;
    if lane == 0u && tile < scoring.tiles {
        partials[group] = all;
    }
}

fn score_products(group: u32, lane: u32) {
    let tile = group / scoring.parts;
    let size = tile_size(tile);
    let start = group % scoring.parts * RUN * LANES;
    var texels: array<vec2<u32>, RUN>;
    var is_in: array<bool, RUN>;
    var n = 0.0;
    for (var i = 0u; i < RUN; i++) {
        let index = start + i * LANES + lane;
        texels[i] = vec2(0u);
        is_in[i] = false;
        if tile < scoring.tiles && index < size.x * size.y {
            texels[i] = texel_of(tile, size.x, index);
            is_in[i] = counts(texels[i]);
        }
        n += select(0.0, 1.0, is_in[i]);
    }
    n = sum_of_lanes(vec2(n, 0.0), lane).x;
    let base = group * (1u + 3u * scoring.layers);
    if lane == 0u && tile < scoring.tiles {
        partials[base] = n;
    }
    // Where all values are the same, each is exactly the point that sums are taken about.
    var about = vec2(0u);
    if tile < scoring.tiles && start < size.x * size.y {
        about = texel_of(tile, size.x, start);
    }
    var before: array<f32, RUN>;
    for (var layer = 0u; layer < scoring.layers; layer++) {
        let shift = scored(about, layer);
        var values: array<f32, RUN>;
        var sum = 0.0;
        for (var i = 0u; i < RUN; i++) {
            values[i] = select(0.0, scored(texels[i], layer) - shift, is_in[i]);
            sum += values[i];
        }
        let mean = sum_of_lanes(vec2(sum, 0.0), lane).x / max(n, 1.0);
        var products = vec2(0.0);
        for (var i = 0u; i < RUN; i++) {
            let x = select(0.0, values[i] - mean, is_in[i]);
            products += x * vec2(x, before[i]);
            before[i] = x;
        }
        products = sum_of_lanes(products, lane);
        if lane == 0u && tile < scoring.tiles {
            let at = base + 1u + 3u * layer;
            partials[at] = shift + mean;
            partials[at + 1u] = products.x;
            partials[at + 2u] = products.y;
        }
    }
}

fn score_part(group: u32, lane: u32) {
    if CRITERION == CORRELATION {
        score_products(group, lane);
    } else {
        score_differences(group, lane);
    }
}
