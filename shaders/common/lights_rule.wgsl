// The rules that look at one node alone: R3 and R4.
#import common/lights_tree.wgsl
#import common/lights_sum.wgsl

// Mirrors RuleParams.
struct RuleParams {
    // Share of the estimate (R3), or radiance (R4), that a bound may exceed it by, or reach.
    limit: f32,
    // From and to in `nodes`: trees of lights that move, walked whatever an object starts at.
    moving: u32,
    moving_end: u32,
    pad: u32,
}

@group(1) @binding(3) var<uniform> rule: RuleParams;

// R3 rather than R4.
override RELATIVE: bool = false;

// From and to in `nodes` of walk `s` of those before `last`, and of the one through the lights that move,
// which is `last`; none where the start is hidden from all points up to a height.
fn walk_of(s: u32, last: u32, height: f32) -> vec2<u32> {
    if s == last {
        return vec2<u32>(rule.moving, rule.moving_end);
    }
    if is_start_hidden(s, height) {
        return vec2<u32>(0u);
    }
    let start = start_of(s);
    return vec2<u32>(start, start + nodes[start].size);
}

// Whether a cluster stands for its lights, by its bound and, for R3, its estimate.
fn is_taken(bound: f32, estimated: f32) -> bool {
    if RELATIVE {
        return bound <= estimated + rule.limit * estimated;
    }
    return !(bound > rule.limit);
}
