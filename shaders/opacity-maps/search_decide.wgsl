// The scores of tiles from those of their parts, one tile a workgroup; with a search's last step,
// the best λ of each.
#import common/index.wgsl
#import common/opacity_lanes.wgsl

struct DecideParams {
    layers: u32,
    tiles: u32,
    parts: u32,
    // The step whose maps were scored, and how many there are.
    step: u32,
    values: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// Whether partial scores are moments of layers, for their correlation.
override MOMENTS: bool = false;
// Whether the greatest score is best.
override GREATEST: bool = false;

@group(0) @binding(0) var<uniform> decision: DecideParams;
@group(0) @binding(1) var<storage, read> partials: array<f32>;
// Those of all tiles, step after step.
@group(0) @binding(2) var<storage, read_write> scores: array<f32>;
// The λ of each step.
@group(0) @binding(3) var<storage, read> lambdas: array<f32>;
// The λ that each tile is drawn with.
@group(0) @binding(4) var<storage, read_write> splits: array<f32>;

fn sum_of_parts(tile: u32, lane: u32) -> f32 {
    var sum = 0.0;
    if tile < decision.tiles {
        for (var part = lane; part < decision.parts; part += LANES) {
            sum += partials[tile * decision.parts + part];
        }
    }
    return sum_of_lanes(vec2(sum, 0.0), lane).x;
}

// E1 / sqrt(E2 E3). Two constant maps have 1 (the second tells nothing new), a constant and a
// varying one 0.
fn coefficient(ab: f32, aa: f32, bb: f32) -> f32 {
    if aa > 0.0 && bb > 0.0 {
        return clamp(ab / (sqrt(aa) * sqrt(bb)), -1.0, 1.0);
    }
    return select(0.0, 1.0, aa <= 0.0 && bb <= 0.0);
}

// Correlations of neighbouring layers together, from the moments of the parts about their own means.
fn correlations(tile: u32, lane: u32) -> f32 {
    let stride = 1u + 3u * decision.layers;
    let first = min(tile, decision.tiles - 1u) * decision.parts * stride;
    var count = 0.0;
    for (var part = lane; part < decision.parts; part += LANES) {
        count += partials[first + part * stride];
    }
    let n = max(sum_of_lanes(vec2(count, 0.0), lane).x, 1.0);
    var sum = 0.0;
    // Of the layer before: its first part's mean and the others' about it, its sum of squares.
    var shift_before = 0.0;
    var mean_before = 0.0;
    var squares_before = 0.0;
    for (var layer = 0u; layer < decision.layers; layer++) {
        let at = first + 1u + 3u * layer;
        let shift = partials[at];
        var means = 0.0;
        for (var part = lane; part < decision.parts; part += LANES) {
            let own = part * stride;
            means += partials[first + own] * (partials[at + own] - shift);
        }
        let mean = sum_of_lanes(vec2(means, 0.0), lane).x / n;
        var products = vec2(0.0);
        for (var part = lane; part < decision.parts; part += LANES) {
            let own = part * stride;
            let weight = partials[first + own];
            let x = partials[at + own] - shift - mean;
            products += vec2(partials[at + own + 1u] + weight * x * x, partials[at + own + 2u]);
            if layer > 0u {
                products.y += weight * x * (partials[at + own - 3u] - shift_before - mean_before);
            }
        }
        products = sum_of_lanes(products, lane);
        if layer > 0u {
            sum += coefficient(products.y, squares_before, products.x);
        }
        shift_before = shift;
        mean_before = mean;
        squares_before = products.x;
    }
    return sum;
}

fn adopt(tile: u32) {
    var best = scores[tile];
    var at = 0u;
    for (var step = 1u; step < decision.values; step++) {
        let score = scores[step * decision.tiles + tile];
        var gain = best - score;
        if GREATEST {
            gain = -gain;
        }
        // Of equal ones the first wins.
        if gain > 0.0 {
            best = score;
            at = step;
        }
    }
    splits[tile] = lambdas[at];
}

@compute @workgroup_size(64)
fn decide(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = linear_group(group, groups);
    var score = 0.0;
    if MOMENTS {
        score = correlations(tile, lane);
    } else {
        score = sum_of_parts(tile, lane);
    }
    if lane == 0u && tile < decision.tiles {
        scores[decision.step * decision.tiles + tile] = score;
        if decision.step + 1u == decision.values {
            adopt(tile);
        }
    }
}
