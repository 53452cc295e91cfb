// Sums over the lanes of a workgroup, always in the same order.
const LANES = 64u;

var<workgroup> lane_sums: array<vec2<f32>, LANES>;

// All lanes must call it, and all get the sum.
fn sum_of_lanes(x: vec2<f32>, lane: u32) -> vec2<f32> {
    // Nobody may still read the sum before.
    workgroupBarrier();
    lane_sums[lane] = x;
    workgroupBarrier();
    for (var reach = LANES / 2u; reach > 0u; reach /= 2u) {
        if lane < reach {
            lane_sums[lane] += lane_sums[lane + reach];
        }
        workgroupBarrier();
    }
    return lane_sums[0];
}
