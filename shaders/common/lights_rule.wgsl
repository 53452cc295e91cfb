// The rules that look at one node alone: R3 and R4.
#import common/lights_tree.wgsl
#import common/lights_sum.wgsl

// Mirrors RuleParams.
struct RuleParams {
    // Share of the estimate (R3), or radiance (R4), that a bound may exceed it by, or reach.
    limit: f32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(1) @binding(3) var<uniform> rule: RuleParams;

// R3 rather than R4.
override RELATIVE: bool = false;

// Whether a cluster stands for its lights, by its bound and, for R3, its estimate.
fn is_taken(bound: f32, estimated: f32) -> bool {
    if RELATIVE {
        return bound <= estimated + rule.limit * estimated;
    }
    return !(bound > rule.limit);
}
